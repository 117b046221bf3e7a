"""Random scenes of all kinds by every solver, held against bodies in maximal coordinates: no run is silently wrong.

`pytest --scenes 10000 tests/stress/test_stress_scenes.py` looks at that many, as before a release, in some hours; each wrong
run is told with its seed, solver and tolerance.
"""

import numpy as np
import pytest

from helpers.random_scenes import random_scene
from lagrangia.native.build import find_compiler
from stress.references import compute, expected
from stress.verdicts import Verdict, look_at_all

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
FEW = 60
LONG = 26  # 90 s in its reference, and long in its runs


def _told(verdicts: list[Verdict]) -> list[str]:
    return [str(verdict) for verdict in verdicts if verdict.word == "wrong"]


@pytest.mark.parametrize("first", range(0, FEW, 12))
def test_a_few_scenes(first: int) -> None:
    verdicts = look_at_all(seed for seed in range(first, first + 12) if seed != LONG)
    assert {verdict.family for verdict in verdicts} == {"tree", "loop", "rods", "kinks", "contacts", "friction"}
    assert _told(verdicts) == []
    assert sum(verdict.word == "right" for verdict in verdicts) > 0.9 * len(verdicts)


def test_references_that_are_kept_are_those_that_are_computed() -> None:
    scene = random_scene(9)
    kept, anew = expected(9, scene), compute(scene)
    assert kept is not anew and kept.count == anew.count
    np.testing.assert_allclose(kept.rows, anew.rows, rtol=1e-9, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("half", [0, 1])
def test_many_scenes(half: int, pytestconfig: pytest.Config) -> None:
    many = pytestconfig.getoption("--scenes")
    if many == 0:
        pytest.skip("--scenes N looks at N more, whose references are computed")
    verdicts = look_at_all([seed for seed in range(FEW + half, FEW + many, 2) if seed != LONG or many > 48])
    assert _told(verdicts) == []
    assert sum(verdict.word == "right" for verdict in verdicts) > 0.95 * len(verdicts)
