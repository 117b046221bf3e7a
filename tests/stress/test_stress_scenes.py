"""Random scenes of all kinds by every solver, held against bodies in maximal coordinates: no run is silently wrong.

`pytest --scenes 10000 tests/stress/test_stress_scenes.py` looks at that many, as before a release, in some hours; each wrong
run is told with its seed, solver and tolerance.
"""

import numpy as np
import pytest

from helpers.random_scenes import drawn, random_scene
from lagrangia.native.build import find_compiler
from stress.references import DRAWS, KEPT, LONG, compute, expected
from stress.verdicts import Verdict, look_at_all

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
PARTS = 4


def _told(verdicts: list[Verdict]) -> list[str]:
    return [str(verdict) for verdict in verdicts if verdict.word == "wrong"]


@pytest.mark.parametrize("part", range(PARTS))
def test_two_hundred_scenes(part: int) -> None:
    """Each that is compiled, which is most of the cost, is run with several sets of masses and weights."""
    verdicts = look_at_all(KEPT[part::PARTS], DRAWS)
    assert len({verdict.scene for verdict in verdicts}) == 200 // PARTS
    assert len({verdict.family for verdict in verdicts}) >= 3
    assert _told(verdicts) == []
    assert sum(verdict.word == "right" for verdict in verdicts) > 0.9 * len(verdicts)


def test_references_that_are_kept_are_those_that_are_computed() -> None:
    scene = drawn(random_scene(9), 9, 1)
    kept, anew = expected(9, 1, scene), compute(scene)
    assert kept is not anew and kept.count == anew.count
    np.testing.assert_allclose(kept.rows, anew.rows, rtol=1e-9, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("half", [0, 1])
def test_many_scenes(half: int, pytestconfig: pytest.Config) -> None:
    many, first = pytestconfig.getoption("--scenes"), KEPT[-1] + 1
    if many == 0:
        pytest.skip("--scenes N looks at N more, whose references are computed")
    seeds = range(first + half, first + many, 2)
    verdicts = look_at_all([LONG, *seeds] if many > len(KEPT) and half == 0 else seeds)
    assert _told(verdicts) == []
    assert sum(verdict.word == "right" for verdict in verdicts) > 0.95 * len(verdicts)
