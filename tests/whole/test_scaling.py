"""Work grows with the number of bodies, not faster."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia import LagError
from lagrangia.compile.pipeline import compile_file
from lagrangia.dynamics import jacobians
from lagrangia.run.library import find_runtime

CHAIN = Path(__file__).parents[2] / "models" / "examples" / "chain.lag"


def test_a_link_costs_the_same_in_any_chain() -> None:
    short, long = (compile_file(CHAIN, None, {"n": n}).scene for n in (40, 160))
    for name in ("rhs", "energies", "hoist", "parameters", "start"):
        ratio = len(long.tapes[name].code) / 160 / (len(short.tapes[name].code) / 40)
        assert 0.7 < ratio < 1.1, name  # factors are drawn together in short functions and not in long ones
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


def table(n: int) -> str:
    xs, ys = (", ".join(f"{x:.3f}" for x in row) for row in ([k / n for k in range(n)], [k % 3 for k in range(n)]))
    push = f"AppliedForce push(at = block.center, force = {{table(time, {{{xs}}}, {{{ys}}}), 0}});"
    return f"Block block(m = 1, base = world); {push}"


def supports(n: int) -> str:
    pair = "Prismatic p{k}(a = world, s(fixed = true)); Motion m{k}(of = p{k}.s, to = 0.1*sin({k}*time));"
    return "Block block(m = 1, base = world);" + "".join(pair.format(k=k) for k in range(n))


def followers(n: int) -> str:
    blocks = "".join(f"Block block{k}(m = 1, base = world);" for k in range(n + 1))
    return f"{blocks} equation " + "".join(f"block{k}.s = {k}*block0.s;" for k in range(1, n + 1))


def counted(work: Callable[[], object], is_counted: Callable[[str, object], bool]) -> int:
    """How many calls of functions are of this kind."""
    count = 0

    def look(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += is_counted(event, argument)

    sys.setprofile(look)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def calls(text: str, path: Path) -> int:
    """How many functions of CasADi a compilation calls."""
    path.write_text(f"model Scene\n{text}\nend Scene;", encoding="utf-8")
    return counted(lambda: compile_file(path),
                   lambda event, argument: event == "c_call" and getattr(argument, "__module__", "") == "casadi._casadi")


@pytest.mark.parametrize("scene_of", [table, supports, followers])
def test_each_more_costs_as_much_as_those_before(scene_of: Callable[[int], str], tmp_path: Path) -> None:
    compile_file(CHAIN)  # reads the library
    few, some, many = (calls(scene_of(n), tmp_path / "scene.lag") for n in (20, 60, 100))
    assert many - some < 1.1 * (some - few)


@pytest.mark.slow
def test_each_more_link_asks_for_as_many_calls_as_those_before() -> None:
    """Of all functions, Python's and CasADi's: where one is called over all links for each of them, differences grow."""
    find_runtime()
    compile_file(CHAIN)  # reads the library
    few, some, many = (counted(lambda n=n: compile_file(CHAIN, None, {"n": n}), lambda event, _: event in ("call", "c_call"))
                       for n in (220, 240, 260))
    assert many - some < 1.05 * (some - few)
