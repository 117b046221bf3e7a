"""Sines four at a time (runtime/numbers/sines.h): their last digit, in every build, and their order in tapes."""

import ctypes as c
import math

import casadi as ca
import numpy as np
import pytest
from mpmath import mp, mpf

from lagrangia.base.folders import data_folder
from lagrangia.compile.instructions import count_operations, tape_of
from lagrangia.native.build import build, find_compiler
from lagrangia.native.tapes import Op, Tape
from lagrangia.run.interpret import evaluate

SOURCE = """#include "numbers/sines.h"
__attribute__((visibility("default"))) void of_all(const double *x, double *s, double *c, int n)
{
    for (int i = 0; i < n; i += 4)
        lag_four_sines(x[i], x[i + 1], x[i + 2], x[i + 3], s + i, c + i);
}
"""
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="needs a C compiler")


def sines(angles: np.ndarray, prefix: str = "", level: str = "-O2") -> tuple[np.ndarray, np.ndarray]:
    library = c.CDLL(str(build("sines", prefix + SOURCE, include=[data_folder("runtime")], level=level)))
    sine, cosine = np.empty_like(angles), np.empty_like(angles)
    library.of_all(*(c.c_void_p(x.ctypes.data) for x in (angles, sine, cosine)), angles.size)
    return sine, cosine


def angles() -> np.ndarray:
    random = np.random.default_rng(5)
    quarters = np.arange(-500, 500) * math.pi / 2
    tiny = 10.0 ** random.uniform(-300, -1, 500)
    usual = random.uniform(-3.2, 3.2, 1500), random.uniform(-1e6, 1e6, 1500)
    return np.concatenate([*usual, quarters, tiny, [0.0, 1e6, -1e6, 0.5]])


@needs_compiler
def test_the_last_digit_is_off_by_one_at_most() -> None:
    """Below 0.9 units of the last place; below 1e-24 where they are nearly zero, at multiples of a quarter turn."""
    given = angles()
    with mp.workdps(50):
        for found, exact in zip(sines(given), (mp.sin, mp.cos), strict=True):
            true = [exact(mpf(float(x))) for x in given]
            error = np.array([float(abs(mpf(float(y)) - z)) for y, z in zip(found, true, strict=True)])
            unit = np.spacing(np.abs(np.array([float(z) for z in true])))
            assert (error[:3000] < 0.9 * unit[:3000]).all()
            assert (error < np.maximum(0.9 * unit, 1e-24)).all()


@needs_compiler
def test_every_build_has_the_same_digits() -> None:
    compiler, given = find_compiler(), angles()
    assert compiler is not None
    usual = sines(given)
    assert np.array_equal(usual, sines(given, level="-O0"))
    if not compiler.is_zig:
        assert np.array_equal(usual, sines(given, "#undef __GNUC__\n#define __GNUC__ 11\n"))


@needs_compiler
def test_what_is_no_usual_angle_goes_to_the_library() -> None:
    given = np.array([1.1e6, -3e7, 1e22, 1e300, math.inf, -math.inf, math.nan, 2.0])
    sine, cosine = sines(given)
    assert sine[:4] == pytest.approx([math.sin(x) for x in given[:4]], rel=1e-15)
    assert cosine[:4] == pytest.approx([math.cos(x) for x in given[:4]], rel=1e-15)
    assert np.isnan(sine[4:7]).all()
    assert np.isnan(cosine[4:7]).all()
    assert sine[7] == pytest.approx(math.sin(2), rel=1e-15)


def groups(tape: Tape) -> list[int]:
    """How many sines and cosines are computed together each time; those alone as 0."""
    found, k = [], 0
    while k < len(tape.code):
        op, _, _, b = tape.code[k : k + 4]
        if op in (Op.SIN, Op.COS):
            found.append(b)
            assert [tape.code[k + 4 * i + 3] for i in range(b)] == list(range(b, 0, -1))
        k += 4 * max(1, b if op in (Op.SIN, Op.COS) else 1)
    return found


X = ca.SX.sym("x", 8)


@pytest.mark.parametrize(("results", "wanted"), [
    ([ca.sin(X[0])], [0]),
    ([ca.sin(X[0]) * ca.cos(X[0])], [0, 0]),
    ([ca.sin(X[k]) + ca.cos(X[k]) for k in range(8)], [16]),
    ([ca.sin(X[0] * ca.sin(X[1]) + ca.cos(X[2] + ca.cos(X[3] ** 2)))], [0, 0, 0, 0]),
    ([ca.sin(X[0]), ca.cos(X[0]), ca.sin(X[1]), ca.cos(X[1] * ca.sin(X[1]))], [0, 0, 0, 0]),
    ([ca.sin(ca.sin(X[k]) + ca.cos(X[k])) for k in range(5)], [10, 5]),
    ([ca.sin(ca.sin(X[k])) for k in range(4)] + [ca.cos(ca.cos(X[5]))], [5, 5]),
])
def test_tapes_have_sines_together(results: list[ca.SX], wanted: list[int]) -> None:
    function = ca.Function("f", [X], [ca.vertcat(*results)])
    tape = tape_of(function)
    assert groups(tape) == wanted
    place = [0.3, -0.7, 1.1, 2.0, -3.0, 0.01, 40.0, 1.0]
    assert evaluate(tape, place)[0] == pytest.approx(np.array(function(place)).ravel(), rel=1e-14)


@pytest.mark.parametrize("seed", range(10))
def test_random_expressions_keep_their_values(seed: int) -> None:
    random = np.random.default_rng(seed)
    known = ca.vertsplit(X)
    for _ in range(80):
        a, b = (known[k] for k in random.integers(len(known), size=2))
        known.append([a + b, a * b, ca.sin(a), ca.cos(b), a - b][random.integers(5)])
    function = ca.Function("f", [X], [ca.vertcat(*known[-9:]), known[20]])
    tape = tape_of(function)
    place = list(random.uniform(-2, 2, 8))
    for got, wanted in zip(evaluate(tape, place), function(place), strict=True):
        assert got == pytest.approx(np.array(wanted).ravel(), rel=1e-12, abs=1e-12)
    assert count_operations(tape) == len(tape.code) // 4 - sum(tape.code[k] in (0, 1, 2) for k in range(0, len(tape.code), 4))
