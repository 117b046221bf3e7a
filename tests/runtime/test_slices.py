"""Slices of tapes: each set of outputs alone has the digits of the whole tape, by fewer instructions."""

from pathlib import Path

import pytest

from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.native.build import find_compiler

# 40 angles x0 k + x1, sines and cosines of which are computed together, in places of w that are taken again; output i of the
# first vector is sin * cos of angle i; those of the second its sine, 0, and what an angle alone makes.
DRIVER = r"""
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "model/slice.h"

enum { ANGLES = 40, PADDING = 2000, MOST = 4000 };
static int32_t code[4 * MOST];
static int32_t count;

static void add(int32_t op, int32_t out, int32_t a, int32_t b)
{
    const int32_t instruction[] = {op, out, a, b};
    memcpy(code + 4 * count++, instruction, sizeof instruction);
}

static void write_tape(void)
{
    enum { SINES = 2 + ANGLES, COSINES = SINES + ANGLES };
    add(LAG_OP_INPUT, 0, 0, 0);
    add(LAG_OP_INPUT, 1, 0, 1);
    for (int i = 0; i < ANGLES; ++i) {
        add(LAG_OP_CONST, 2 + i, 1 + i, 0);
        add(LAG_OP_MUL, 2 + i, 0, 2 + i);
        add(LAG_OP_ADD, 2 + i, 2 + i, 1);
    }
    for (int i = 0; i < ANGLES; ++i) { /* two by two of an angle: the first beside it, the second in its place */
        add(LAG_OP_COS, COSINES + i, 2 + i, 2 * ANGLES - 2 * i);
        add(LAG_OP_SIN, 2 + i, 2 + i, 2 * ANGLES - 2 * i - 1);
    }
    add(LAG_OP_SIN, 0, 0, 0);
    add(LAG_OP_CONST, 1, 0, 0);
    for (int i = 0; i < ANGLES; ++i) {
        add(LAG_OP_MUL, COSINES + i, 2 + i, COSINES + i);
        add(LAG_OP_OUTPUT, 0, COSINES + i, i);
        add(LAG_OP_OUTPUT, 1, i % 4 == 3 ? 1 : i % 4 == 2 ? 0 : 2 + i, i);
    }
    for (int i = 0; i < PADDING; ++i)
        add(LAG_OP_ASSIGN, SINES, 0, 0);
}

int main(void)
{
    static double constants[1 + ANGLES], whole[2][ANGLES], part[2][ANGLES], work[2 + 3 * ANGLES], block[100000];
    const int sizes[] = {2, ANGLES, ANGLES};
    const double x[] = {0.37, -1.2}, *in[] = {x};
    double *all[] = {whole[0], whole[1]}, *some[] = {part[0], part[1]};
    for (int i = 1; i <= ANGLES; ++i)
        constants[i] = i;
    write_tape();
    const LagTape tape = {count, 1 + ANGLES, code, constants};
    const LagFunction function = {1, 2, sizes, sizes + 1, 2 + 3 * ANGLES, NULL, &tape};
    LagArena arena = {block, 0};
    LagSlicer slicer;
    LagSlice slice;
    if (!lag_tape_valid(&function) || !lag_has_slices(&function))
        return 1;
    lag_slicer_layout(&slicer, &function, &arena);
    lag_slice_layout(&slice, &function, &arena);
    lag_slicer_begin(&slicer);
    lag_tape_run(&tape, in, all, work);
    for (int step = 1; step <= ANGLES; ++step) {
        int asked = 0;
        lag_slice_begin(&slicer, &slice);
        for (int i = step - 1; i < ANGLES; i += step, ++asked)
            for (int k = 0; k < 2; ++k)
                lag_slice_add(&slicer, &slice, k, i);
        lag_slice_end(&slicer, &slice);
        memset(part, 0, sizeof part);
        lag_tape_run(&slice.tape, in, some, work);
        for (int i = 0; i < ANGLES; ++i)
            for (int k = 0; k < 2; ++k)
                if (part[k][i] != ((i + 1) % step == 0 ? whole[k][i] : 0))
                    return 3;
        if (slice.tape.n_instructions > 4 + 8 * asked)
            return 4;
    }
    return 0;
}
"""


@needs_sanitizers
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_slice_has_the_digits_of_the_whole_tape(tmp_path: Path) -> None:
    run_sanitized(tmp_path, {"driver.c": DRIVER})
