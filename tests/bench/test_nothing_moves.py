"""A scene that only computes has no motion to be measured."""

from collections.abc import Callable

import pytest

import lagrangia as lag
from lagrangia.bench.problem import build_problem


def test_it_is_told(scene: Callable[[str], lag.Model]) -> None:
    with pytest.raises(lag.LagError, match=r"L0505.*nothing moves"):
        build_problem(scene("model M output Real q = sin(2*time); end M;"))
