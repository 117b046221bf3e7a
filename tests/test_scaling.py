"""Work grows with the number of bodies, not faster."""

from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia import LagError, jacobians
from lagrangia.pipeline import compile_file

CHAIN = Path(__file__).parent.parent / "models" / "examples" / "chain.lag"


def test_a_link_costs_the_same_in_any_chain() -> None:
    short, long = (compile_file(CHAIN, None, {"n": n}).scene for n in (40, 160))
    for name in ("rhs", "energies", "hoist", "parameters", "start"):
        ratio = len(long.tapes[name].code) / 160 / (len(short.tapes[name].code) / 40)
        assert 0.75 < ratio < 1.1, name  # factors are drawn together in short functions and not in long ones
    assert long.notes["nodes_per_coordinate"] < 80


def test_a_matrix_that_would_be_too_large_is_not_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(jacobians, "_MOST_ENTRIES", 200)
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path))
    few, many = lag.load(CHAIN, n=14), lag.load(CHAIN, n=15)
    assert "jacobian" in few.scene.tapes or "tangent" in few.scene.tapes
    assert not {"jacobian", "tangent"} & many.scene.tapes.keys()
    few.simulate(stop=0.01, solver="implicit")
    assert many.simulate(stop=0.01)["hinge[1].phi"][-1] == pytest.approx(few.simulate(stop=0.01)["hinge[1].phi"][-1], rel=1e-2)
    with pytest.raises(LagError, match="L0704"):
        many.simulate(stop=0.01, solver="implicit")
