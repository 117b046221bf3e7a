"""Closed loops in independent coordinates, beside M and J factored as a whole: the same motion, chosen where it holds well."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.random_linkages import random_linkage
from helpers.rounding import needs_longer_numbers, noise
from lagrangia.compile.pipeline import Compilation, compile_file
from lagrangia.constraints import partition as partition_module
from lagrangia.constraints.assembly import begin
from lagrangia.constraints.parameters import at_declared_values
from lagrangia.constraints.partition import Partition, find_partition
from lagrangia.constraints.positions import Positions
from lagrangia.dynamics.motion import build_motion

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
ROCKER_FIRST = """model Linkage
  Revolute C(a = world, phi(start = 75[deg])), B(a = rocker.b), A(a = coupler.b, b = crank.b),
           O(a = shift(world, {-1, 0}), phi(start = 40[deg], fixed = true), w(start = 4));
  Bar rocker(m = 1.5, L = 0.8, a = C.b), coupler(m = 2, L = 1, a = B.b), crank(m = 1, L = 0.4, a = O.b);
end Linkage;
"""
BESIDE = """model Linkage
  Revolute O(a = world, phi(start = 40[deg])), A(a = crank.b), B(a = coupler.b, b = rocker.b),
           C(a = shift(world, {1 + 0.05*sin(3*time), 0}), phi(start = 75[deg]));
  Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
  Spring spring(k = 20, s_rel0 = 0.3, a = coupler.b, b = world); TorsionDamper damper(c = 0.1, a = world, b = rocker.a);
  AppliedForce push(at = rocker.b, force = {2*sin(3*time), 1});
  Revolute hang(a = coupler.b, phi(start = -1)); Bar tail(m = 0.3, L = 0.2, a = hang.b);
end Linkage;
"""


def compiled(text: str, folder: Path) -> Compilation:
    path = folder / "scene.lag"
    path.write_text(text, encoding="utf-8")
    return compile_file(path)


def names(compilation: Compilation, partition: Partition | None) -> list[str]:
    assert partition is not None
    return [compilation.kinematics.graph.coordinates[k].name for k in partition.independent]


def check_same_motion(compilation: Compilation, count: int = 15) -> float:
    """At positions near the start, on the constraints and a little off. Returns the share where the short way is in doubt."""
    mine = compilation.motion
    other = build_motion(compilation.kinematics, compilation.energies, compilation.constraints)
    held, plain = mine.constrained, other.constrained
    assert held is not None and held.regular is not None and held.partition is not None
    assert plain is not None and plain.regular is not None and plain.partition is None
    n, random = mine.q.numel(), np.random.default_rng(4)
    found = [[x.acceleration, x.source_power, x.place, x.steer, x.doubt] for x in (held.regular, plain.regular)]
    functions = [ca.Function("f", [mine.q, mine.v], [ca.densify(x) for x in at_declared_values(compilation.kinematics, results)])
                 for results in found]
    positions = Positions(compilation.kinematics, held.rows.phi, held.J)
    start, doubts = begin(compilation.kinematics, compilation.initial, compilation.functions.table).assemble()[0][:n], 0
    for _ in range(count):
        q = positions.onto(start + random.normal(0, 0.1, n)) + random.normal(0, 1e-3, n)
        v = random.normal(0, 2, n)
        short, whole = ([x.full().ravel() for x in function(q, v)] for function in functions)
        doubts += short[-1][0] > 0
        if not short[-1][0] and not whole[-1][0]:
            for a, b in zip(short[:-1], whole[:-1], strict=True):
                assert a == pytest.approx(b, rel=1e-7, abs=1e-8 * np.abs(b).max(initial=1e-3))
    return doubts / count


@pytest.mark.parametrize("seed", [0, 2, 4, 9, 14, 17, 19, 29, 38, 49])
def test_random_linkages(seed: int, tmp_path: Path) -> None:
    compilation = compiled(random_linkage(seed, 1 + seed % 5), tmp_path)
    assert compilation.motion.way == "independent coordinates"
    assert check_same_motion(compilation) < 0.5


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "andrews_squeezer", "n_four_bars"])
def test_examples(name: str) -> None:
    """With fewer operations by a tenth at least, and no reason to doubt near the start."""
    compilation = compile_file(EXAMPLES / f"{name}.lag")
    counted = compilation.motion.counted
    assert counted["independent coordinates"] < 0.85 * counted["constrained"]
    assert check_same_motion(compilation) < 0.3


def test_what_stands_beside_loops(tmp_path: Path) -> None:
    """A support that moves, whose power needs multipliers, a spring, a damper, a load, an open chain."""
    compilation = compiled(BESIDE, tmp_path)
    partition = find_partition(compilation.kinematics, compilation.constraints, compilation.initial)
    assert partition is not None
    assert len(partition.independent) == 2
    assert "hang.phi" in names(compilation, partition)
    check_same_motion(compilation)


def test_a_prescribed_crank_leaves_nothing_to_solve_for(tmp_path: Path) -> None:
    """Its accelerations take half the operations; the work of the drive still needs multipliers."""
    text = ROCKER_FIRST.replace(", fixed = true), w(start = 4)", ")")
    text = text.replace("end Linkage", "equation O.phi = 0.7 + 5*time; end Linkage")
    compilation = compiled(text, tmp_path)
    assert names(compilation, compilation.motion.constrained.partition) == []
    assert compilation.motion.counted["independent coordinates"] < 0.6 * compilation.motion.counted["constrained"]
    check_same_motion(compilation)
    run = lag.load(tmp_path / "scene.lag").simulate(stop=2, tolerance=1e-10)
    assert run.statistics.constraint_residual < 1e-13
    assert np.abs(run.energy.residual).max() < 1e-8 * np.abs(run.energy.work).max()


def test_the_coordinate_that_turns_all_round_is_chosen(tmp_path: Path) -> None:
    """From the rocker's side a crank rocker has dead points. A chain of loops is begun in its middle."""
    linkage = compiled(ROCKER_FIRST, tmp_path)
    assert "C.phi" not in names(linkage, linkage.motion.constrained.partition)
    chain = compile_file(EXAMPLES / "n_four_bars.lag", None, {"n": 8})
    assert names(chain, chain.motion.constrained.partition) in (["foot[4].phi"], ["foot[5].phi"])


@pytest.mark.parametrize("text", [
    # a bar too many: one row says nothing new
    """Revolute O(a = world, phi(start = 1)), A(a = one.b, phi(start = -1)), B(a = across.b, b = two.b),
                C(a = shift(world, {1, 0}), phi(start = 1)), D(a = shift(world, {0.5, 0}), phi(start = 1)),
                E(a = shift(across.a, {0.5, 0}), b = three.b);
       Bar across(m = 2, L = 1, a = A.b), one(m = 1, L = 0.5, a = O.b), two(m = 1, L = 0.5, a = C.b);
       Bar three(m = 1, L = 0.5, a = D.b);
    """,
    # more freedom than the loop takes
    """Revolute h[5], last(a = shift(world, {0.8, 0}), b = bar[5].b); Bar bar[5](each m = 1, each L = 0.3);
       equation connect(world, h[1].a); for i in 1:5 loop connect(h[i].b, bar[i].a); end for;
       for i in 1:4 loop connect(bar[i].b, h[i+1].a); end for;""",
    # a plate on three cranks that each turn by themselves: four coordinates follow together
    """Revolute O(a = world, phi(start = 1)), A(a = one.b, phi(start = -1)), C(a = shift(world, {1, 0}), phi(start = 1.2)),
                D(a = shift(world, {0.4, -0.6}), phi(start = 0.9)), P(a = plate.b, b = two.b),
                Q(a = shift(plate.a, {0.5, -0.4}), b = three.b);
       Bar plate(m = 2, L = 0.9, a = A.b), one(m = 1, L = 0.5, a = O.b), two(m = 1, L = 0.6, a = C.b);
       Bar three(m = 1, L = 0.7, a = D.b);
    """,
], ids=["redundant", "free", "class III"])
def test_other_mechanisms_keep_their_multipliers(text: str, tmp_path: Path) -> None:
    compilation = compiled(f"model Linkage {text} end Linkage;", tmp_path)
    assert compilation.motion.way.startswith("constrained")


@needs_longer_numbers
def test_rounding_stays_small(tmp_path: Path) -> None:
    """Without M^-1 there is less to lose: Andrews' mechanism 5e-15 with it."""
    model = lag.load(EXAMPLES / "andrews_squeezer.lag")
    motion, rows = model.compilation.motion, np.array(model.simulate(at=np.linspace(0, 0.03, 20), tolerance=1e-8).rows)
    rhs = ca.Function("rhs", [motion.t, motion.q, motion.v, motion.u, motion.p], [motion.constrained.regular.acceleration])
    n = motion.q.numel()
    states = [(row[:1], row[1 : n + 1], row[n + 1 : 2 * n + 1], np.zeros(0)) for row in rows[1:]]
    assert noise(model, states, rhs) < 2e-15


def test_dead_points_are_passed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lengths given for a run make a rocker of the crank: its dead points are left to the other way, where nothing is lost."""
    text = ROCKER_FIRST.replace("model Linkage", "model Linkage parameter Length l = 0.4;").replace("L = 0.4", "L = l")
    for name in ("one", "other"):
        (tmp_path / f"{name}.lag").write_text(f"// {name}\n{text}", encoding="utf-8")
    model = lag.load(tmp_path / "one.lag")
    monkeypatch.setattr(partition_module, "find_partition", lambda *_: None)
    whole = lag.load(tmp_path / "other.lag")
    assert "independent" in model.scene.notes["way"]
    assert "independent" not in whole.scene.notes["way"]
    times = np.linspace(0, 3, 31)
    found, wanted = (x.simulate(at=times, tolerance=1e-11, parameters={"l": 1.1}) for x in (model, whole))
    assert np.ptp(found["O.phi"]) < 2 * np.pi
    for name in model.coordinate_names:
        assert found[name] == pytest.approx(wanted[name], abs=1e-9)
    assert found.statistics.rhs_evaluations < 1.5 * wanted.statistics.rhs_evaluations


def test_islands_have_their_own(tmp_path: Path) -> None:
    """Linkages of very different size beside each other."""
    inside = ROCKER_FIRST.replace("model Linkage", "").replace("end Linkage;", "").replace("world", "base")
    text = f"""model Linkage parameter Real size = 1; Frame base; {inside} end Linkage;
               model Both Linkage slow(base = world), quick(base = shift(world, {{3, 0}}), size = 0.01); end Both;"""
    for length in ("L = 0.8", "L = 1,", "L = 0.4", "{-1, 0}"):
        text = text.replace(length, length.replace("{-1", "{-1[m]*size").replace("L = ", "L = size*1[m]*"))
    compilation = compiled(text, tmp_path)
    assert compilation.motion.way == "independent coordinates"
    model = lag.load(tmp_path / "scene.lag")
    assert len(model.scene.islands) == 2
    apart, whole = (model.simulate(at=np.linspace(0, 0.5, 11), tolerance=1e-10, solver=solver) for solver in ("islands", "erk"))
    for name in model.coordinate_names:
        assert apart[name] == pytest.approx(whole[name], abs=1e-7)
