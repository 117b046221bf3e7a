"""Random trees of 1 to 12 bodies: the energy account closes, M is symmetric and positive, two ways to its inverse and all solvers
agree. LAGRANGIA_TREES=10000 asks for that many; a number, a seed and what is wrong are told of each tree that fails."""

import os

import numpy as np
import pytest

from lagrangia.native.build import find_compiler
from stress.forest import look_at, look_at_all

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
FEW, MANY = 12, int(os.environ.get("LAGRANGIA_TREES", "16"))


def test_a_few_trees() -> None:
    trees = [look_at(seed) for seed in range(FEW)]
    assert sorted({tree.bodies for tree in trees}) == list(range(1, 13))
    assert [fault for tree in trees for fault in tree.faults()] == []


@pytest.mark.slow
def test_many_trees() -> None:
    trees = look_at_all(range(FEW, FEW + MANY))
    assert [fault for tree in trees for fault in tree.faults()] == []
    assert sum(tree.warned for tree in trees) == 0
    errors = np.array([tree.errors["auto"] for tree in trees])
    assert np.median(errors) < 1  # in tolerances: what was asked for is what most get
