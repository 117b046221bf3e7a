"""QR factors of equations of long rows of loops: as NumPy solves them, by a number of operations that grows as the row does."""

import ctypes

import numpy as np
import pytest

from helpers.native_models import FOLDER
from lagrangia.native.build import build, find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

NEAREST = """
#include <stdlib.h>
#include "numbers/heap.c"
#include "numbers/sparse_qr.c"
static void lay(LagSparseQr *qr, size_t rows, size_t cols)
{
    LagArena arena = {0};
    lag_sparse_qr_layout(qr, rows, cols, &arena);
    arena.base = calloc(arena.used + 1, sizeof(double));
    arena.used = 0;
    lag_sparse_qr_layout(qr, rows, cols, &arena);
}
__attribute__((visibility("default"))) int nearest(int rows, int cols, const double *a, const double *b, const double *weight,
    double *x, int *entries)
{
    LagSparseQr qr, dependent;
    lay(&qr, rows, cols);
    lay(&dependent, cols, cols);
    lag_sparse_qr_begin(&qr, rows, cols);
    for (int j = 0; j < cols; ++j)
        for (int i = 0; i < rows; ++i)
            lag_sparse_qr_add(&qr, i, j, a[i + j * rows]);
    lag_sparse_qr(&qr, cols, 1e-10);
    lag_sparse_qr_nearest(&qr, b, weight, &dependent, calloc(cols, sizeof *x), calloc(cols, sizeof *x), x);
    for (int j = 0; j < cols; ++j)
        *entries += qr.n_entries[j];
    return qr.rank;
}
"""


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    return ctypes.CDLL(str(build("sparse_qr", NEAREST, include=[FOLDER])))


def row_of_loops(n: int, redundant: int) -> np.ndarray:
    """Gradients, (equations, values): of each loop 3 by its 5 values and 2 of the next, and so many sums of these."""
    random = np.random.default_rng(n)
    rows = []
    for k in range(n):
        own = np.zeros((3, 5 * n + 2))
        own[:, 5 * k : 5 * k + 7] = random.normal(size=(3, 7))
        rows += [*own, *(random.normal(size=(redundant, 3)) @ own)]
    return np.array(rows)


def nearest(library: ctypes.CDLL, gradients: np.ndarray, b: np.ndarray, weight: np.ndarray, x: np.ndarray) -> tuple[int, int]:
    """Moves x. Returns the rank and how many entries are kept account of."""
    entries = ctypes.c_int(0)
    cols, rows = gradients.shape
    given = [np.ascontiguousarray(z) for z in (gradients, b, weight)]
    rank = library.nearest(rows, cols, *(z.ctypes.data_as(ctypes.c_void_p) for z in given), x.ctypes.data_as(ctypes.c_void_p),
                           ctypes.byref(entries))
    return rank, entries.value


@pytest.mark.parametrize("redundant", [0, 2])
def test_the_nearest_place(library: ctypes.CDLL, redundant: int) -> None:
    gradients, random = row_of_loops(12, redundant), np.random.default_rng(1)
    x, b = random.normal(size=gradients.shape[1]), random.normal(size=len(gradients))
    weight = 0.5 + random.random(len(b))
    expected = x + np.linalg.pinv(gradients * weight[:, None], 1e-10) @ (weight * (b - gradients @ x))
    rank, _ = nearest(library, gradients, b, weight, x)
    assert rank == 36
    assert x == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("redundant", [0, 3])
def test_what_is_not_zero_grows_as_the_row_does(library: ctypes.CDLL, redundant: int) -> None:
    """The reflectors of a row of 160 loops have at most 3 times as many entries as those of 80; full ones have four times."""
    sizes = []
    for n in (80, 160):
        gradients = row_of_loops(n, redundant)
        ones = np.ones(len(gradients))
        sizes.append(nearest(library, gradients, ones, ones, np.zeros(gradients.shape[1]))[1])
    assert sizes[1] < 3 * sizes[0] < 100_000
