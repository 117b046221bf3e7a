"""Closed loops solved along the tree of bodies, beside M and J factored as a whole, and how their cost and rounding grow."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.rounding import needs_longer_numbers, noise
from lagrangia.compile.pipeline import Compilation, compile_file
from lagrangia.dynamics import motion as motion_module
from lagrangia.dynamics.loops_in_tree import _Bonds
from lagrangia.dynamics.motion import Motion, build_motion, count_nodes
from lagrangia.native.build import find_compiler

ROPE = """
  parameter Integer n = {n};
  Revolute hinge[n]; Bar link[n](each m = 0.1, each L = 0.1);
  Revolute last(a = shift(world, {{0.08*n, 0}}));
  {more}
equation
  connect(world, hinge[1].a);
  for i in 1:n loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:n-1 loop connect(link[i].b, hinge[i+1].a); end for;
  connect(last.b, link[n].b);
  {equations}
"""
RING = """
  World world(gravity = {0.3, -2});
  Bar link[6](m = {1, 2, 1, 0.5, 1, 3}, each L = 0.4); Revolute hinge[6];
equation
  for i in 1:5 loop connect(hinge[i].a, link[i].b); connect(hinge[i].b, link[i+1].a); end for;
  connect(hinge[6].a, link[6].b); connect(hinge[6].b, link[1].a);
"""
SLIDER = """
  Revolute hinge[5]; Bar link[5](each m = 0.4, each L = 0.5);
  Prismatic guide(along = {1, 0.3}, a = shift(world, {0.7, 0.1})); Block mass(m = 2, base = guide.a); Revolute pin(b = link[5].b);
  Spring spring(k = 30, s_rel0 = 0.2, a = link[2].b, b = world);
equation
  connect(world, hinge[1].a); connect(pin.a, guide.b);
  for i in 1:5 loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:4 loop connect(link[i].b, hinge[i+1].a); end for;
"""
PARALLELOGRAM = """
  Revolute O(a = world, phi(start = 40[deg])), A(a = crank.b, phi(start = -40[deg])),
           B(a = coupler.b, b = rocker.b), C(a = shift(world, {1, 0}), phi(start = 40[deg]));
  Bar crank(m = 1, L = 0.5, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1, L = 0.5, a = C.b);
"""


HUNG = """
  Revolute f{k}(a = {base}, phi(start = 1.2)), g{k}(a = shift({base}, {{0.7, 0.1}}), phi(start = 1)), p{k}(a = k{k}.b),
           q{k}(a = r{k}.b, b = h{k}.b);
  Bar k{k}(m = 1, L = 0.3, a = f{k}.b), h{k}(m = 0.5, L = 0.4, a = g{k}.b), r{k}(m = 1, L = 0.8, a = p{k}.b);
"""
IN_SPACE = """
  Revolute f{k}(a = {base}, axis = {{0, 0.2, 1}}, phi(start = 1.2)), g{k}(a = shift({base}, {{1, 0, 0}}), axis = {{0, -0.2, 1}});
  Body k{k}(m = 1, I = {{0.01, 0.02, 0.02}}, center = shift(f{k}.b, {{0.15, 0, 0}})),
       h{k}(m = 1, I = {{0.01, 0.02, 0.02}}, center = shift(g{k}.b, {{0.15, 0, 0}})),
       r{k}(m = 1, I = {{0.01, 0.05, 0.05}}, center = shift(p{k}.b, {{0.5, 0, 0}}));
  Universal p{k}(a = shift(f{k}.b, {{0.3, 0, 0}}), axis_a = {{0, 1, 0}}, axis_b = {{0, 0, 1}});
  Spherical q{k}(a = shift(p{k}.b, {{1, 0, 0}}), b = shift(g{k}.b, {{0.3, 0, 0}}));
"""
OBLIQUE = """
  World world(gravity = {0.3, -1, -9.81}); parameter Real along[3] = {1, 1, 0.5};
  Revolute h1(a = world, axis = {1, 2, 3}, phi(start = 0.2));
  Universal h2(a = shift(h1.b, {0.5, 0.2, 0.1}), axis_a = {1, 0, 0}, axis_b = {0, 1, 0}, phi_a(start = 0.3));
  Universal h3(a = shift(h2.b, {0.4, 0.1, -0.2}), axis_a = {1, 0, 0}, axis_b = {0, 0, 1}, phi_b(start = 0.4));
  Body b1(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h1.b, {0.3, 0.1, 0})), b3(m = 1, I = {0.1, 0.2, 0.15}, center = h3.b),
       b2(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h2.b, {0.2, -0.1, 0.3}));
"""
SPRUNG_CYLINDER = """
  Cylindrical cut(a = shift(h3.b, {0.2, 0, 0.1}), axis = along, b = shift(world, {1, 0.3, 0.2}));
  energy potential 50[N/m]*(cut.s - 0.3[m])^2 + 20[N]*cut.s*cut.phi; work 5[N]*sin(3*time) on cut.s;
"""
SLIDER_IN_SPACE = """
  Revolute h4(a = shift(world, {1, -0.3, 0.2}), axis = {0, 1, 1}, phi(start = 0.1));
  Body b4(m = 1, I = {0.1, 0.2, 0.15}, center = shift(h4.b, {0.2, 0.2, 0.1}));
  Prismatic cut(a = shift(h3.b, {0.2, 0, 0.1}), along = {1, 1, 0.5}, b = shift(h4.b, {0.1, 0.3, 0.1}));
"""
# Like joints that could be cut instead.
ODD = """model Crossed
  parameter Real axis_a[3], axis_b[3] annotation(Evaluate = true); Frame a, b; coordinate Angle phi_a, phi_b;
equation
  b = turn(turn(a, 1*phi_a, axis_a), 1*phi_b, axis_b);
end Crossed;
model Odd
  parameter Real axis[3] annotation(Evaluate = true); Frame a, b; coordinate Angle phi;
equation
  b = turn(a, 1*phi, axis);
end Odd;
"""


def hung(n: int, text: str) -> str:
    """Loops, each on a crank of the one before it."""
    gravity = "World world(gravity = {0.3, -1, -9.81});" if text is IN_SPACE else ""
    return gravity + "".join(text.format(k=k, base=f"g{k - 1}.b" if k else "world") for k in range(n))


def rope(n: int, more: str = "", equations: str = "") -> str:
    return ROPE.format(n=n, more=more, equations=equations)


SCENES = {
    "rope": rope(7),
    "loads and dampers": rope(6, "AppliedForce push(at = link[3].b, force = {2*sin(3*time), 1}); "
                                 "TorsionDamper stiff(c = 0.3, a = link[2].a, b = link[3].a);"),
    "a torsion spring on the joint that is cut": rope(5, "TorsionSpring s(k = 2, a = last.a, b = last.b);"),
    "an energy of the coordinate that is cut": rope(5, equations="energy potential 3[N.m]*(1 - cos(last.phi - 0.3[rad]));"),
    "an equation beside the loop": rope(6, equations="sin(hinge[3].phi) = 0.4*hinge[4].phi;"),
    "two loops, one in the other": rope(8, "Link brace(L = 0.25, a = link[2].a, b = link[6].b);"),
    "a ring that floats": RING,
    "a slider": SLIDER,
    "loops hung on each other": hung(3, HUNG),
    "loops hung on each other, driven": hung(2, HUNG) + "equation f0.phi = 1.2 + 0.5*sin(3*time);",
    "a support that moves": rope(6, "Frame hand; Link string(L = 0.5, a = hand, b = link[3].b);",
                                 "hand = shift(world, {0.1*sin(4*time), 0.3});"),
}


def compiled(text: str, path: Path, models: str = "") -> Compilation:
    path.write_text(f"{models}model Scene\n{text}\nend Scene;", encoding="utf-8")
    return compile_file(path)


def both(compilation: Compilation, monkeypatch: pytest.MonkeyPatch) -> tuple[Motion, Motion]:
    """Along the tree, and by M."""
    found = []
    for along in (True, False):
        monkeypatch.setattr(motion_module, "prefers", lambda *_, along=along: along)
        found.append(build_motion(compilation.kinematics, compilation.energies, compilation.constraints))
    return found[0], found[1]


def results(motion: Motion) -> list[ca.SX]:
    held = motion.constrained
    assert held is not None and held.regular is not None
    regular = held.regular
    return [motion.acceleration, held.multipliers, held.place, held.steer, motion.source_power, regular.acceleration,
            regular.place, regular.steer, regular.source_power, regular.doubt]


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES)
def test_both_ways_agree(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At any state: the equations hold off the constraints, too."""
    compilation = compiled(text, tmp_path / "scene.lag")
    along, whole = both(compilation, monkeypatch)
    assert along.way == "constrained along the tree"
    assert whole.way == "constrained"
    found, wanted = (ca.Function("f", [x.t, x.q, x.v, x.u, x.p], results(x)) for x in (along, whole))
    p, n, random = lag.load(tmp_path / "scene.lag").parameter_values(), along.q.numel(), np.random.default_rng(3)
    for _ in range(20):
        state = random.uniform(0, 2), random.uniform(-2, 2, n), random.uniform(-3, 3, n), []
        mine, other = ([np.array(x).ravel() for x in f(*state, p)] for f in (found, wanted))
        for a, b in zip(mine, other, strict=True):
            assert a == pytest.approx(b, rel=1e-8, abs=1e-9 * np.abs(b).max(initial=1e-3))


@pytest.mark.parametrize(("text", "kept"), [
    (hung(2, IN_SPACE), ""), (hung(1, IN_SPACE) + "equation f0.phi = 1.2 + 0.5*sin(3*time);", ""),
    (OBLIQUE + SPRUNG_CYLINDER, "cut.s"),
    ((OBLIQUE + SLIDER_IN_SPACE).replace("Universal", "Crossed").replace("Revolute", "Odd"), "cut.s"),
], ids=["hung on each other", "driven", "a cylinder along an oblique axis", "a slider along one"])
def test_both_ways_agree_where_loops_in_space_are_shut(text: str, kept: str, tmp_path: Path,
                                                       monkeypatch: pytest.MonkeyPatch) -> None:
    """Elsewhere the axes in which gaps are written, which turn, make a difference. What cut joints keep moves freely."""
    compilation = compiled(text, tmp_path / "scene.lag", ODD)
    assert not kept or kept in compilation.graph.kept_coordinates
    along, whole = both(compilation, monkeypatch)
    assert along.way == "constrained along the tree" and whole.way == "constrained"
    assert whole.constrained is not None and whole.constrained.tree is None
    model = lag.load(tmp_path / "scene.lag")
    names, run = [str(x) for x in along.q.elements()], model.simulate(stop=0.3, interval=0.1, tolerance=1e-11)
    kinds = [(name, f"der({name})") for name in names if ".s[" not in name]
    for k in range(run.time.size):
        values = {name: float(run[name][k]) for pair in kinds for name in pair}
        q, v = ([values.get(text.format(name), 0.0) for name in names] for text in ("{}", "der({})"))
        accelerations = []
        for motion in (along, whole):
            held = motion.constrained
            assert held is not None and held.regular is not None
            found = ca.veccat(motion.acceleration, held.regular.acceleration)
            references = [x for x in ca.symvar(found) if x.name().startswith("d_")]
            f = ca.Function("f", [motion.t, motion.q, motion.v, motion.u, motion.p, *references], [found])
            turned = [float(int(x.name()[2:]) % 4 == 0) for x in references]
            accelerations.append(f(run.time[k], q, v, [], model.parameter_values(), *turned).full().ravel())
        assert accelerations[0] == pytest.approx(accelerations[1], abs=1e-8 * np.abs(accelerations[1]).max())


def test_masses_are_judged_alike(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Which parameters the formulas bear: by the pivots along the tree as by those of M."""
    text = "parameter Mass light = 1e-3;" + rope(5).replace("each m = 0.1", "m = {1, 1, light, 1, 1}")
    compilation = compiled(text, tmp_path / "scene.lag")
    along, whole = both(compilation, monkeypatch)
    model = lag.load(tmp_path / "scene.lag")
    for mass, is_even in ((1.0, True), (1e-3, True), (1e-30, False), (0.0, False)):
        values = model.parameter_values({"light": mass})
        for motion in (along, whole):
            assert motion.constrained is not None
            look = ca.Function("look", [motion.p], [motion.constrained.evenness])
            assert bool(np.all(np.array(look(values)) > 1)) == is_even, (mass, motion.way)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_constraints_that_repeat_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A third crank of a parallelogram: multipliers are not determined, the motion is."""
    monkeypatch.setattr(motion_module, "prefers", lambda *_: True)
    ends, sizes = [], []
    for more in ("", "Link third(L = 0.5, a = shift(world, {0.3, 0}), b = shift(coupler.a, {0.3, 0}));"):
        compilation = compiled(PARALLELOGRAM + more, tmp_path / "scene.lag")
        held = compilation.motion.constrained
        assert held is not None and held.tree is not None
        sizes.append(held.J.size1())
        result = lag.load(tmp_path / "scene.lag").simulate(stop=2, tolerance=1e-11)
        assert result.statistics.constraint_residual < 1e-13
        ends.append([result["O.phi"][-1], result["der(O.phi)"][-1]])
    assert sizes == [2, 3]
    assert ends[1] == pytest.approx(ends[0], abs=1e-9)


def test_a_bar_costs_the_same_in_any_rope(tmp_path: Path) -> None:
    nodes = []
    for n in (30, 120):
        motion = compiled(rope(n), tmp_path / "scene.lag").motion
        assert motion.constrained is not None and motion.constrained.regular is not None
        nodes.append(count_nodes([motion.constrained.regular.acceleration], [motion.q, motion.v]) / n)
    assert nodes[1] == pytest.approx(nodes[0], rel=0.1)
    assert nodes[1] < 140


@needs_longer_numbers
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("n", "most"), [(20, 2e-14), (40, 2e-13)])
def test_rounding_stays_small(n: int, most: float, tmp_path: Path) -> None:
    """In swing, on the constraints. By factors of M it was 3e-12 of the largest acceleration with 20 bars."""
    assert compiled(rope(n), tmp_path / "scene.lag").motion.way == "constrained along the tree"
    model = lag.load(tmp_path / "scene.lag")
    result = model.simulate(at=[0.1, 0.3, 0.6], tolerance=1e-9, initial={"hinge[1].phi": -0.9}, stop=0.6)
    states = [[np.array([0.0]), *(np.array([result[c.name][k] for c in x]) for x in (model.scene.coordinates, model.scene.rates)),
               np.zeros(0)] for k in range(3)]
    assert noise(model, states) < most


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_what_rests_at_its_origin_takes_few_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the tree would do and constraints take back leaves rounding: no motion for series, which auto would take here."""
    monkeypatch.setattr(motion_module, "prefers", lambda *_: True)
    beam = "Bar beam(m = 20, L = 4); PointOnLine r(line = world, point = beam.a), s(line = world, point = beam.b);"
    held = compiled(beam, tmp_path / "scene.lag").motion.constrained
    assert held is not None and held.tree is not None
    model = lag.load(tmp_path / "scene.lag")
    assert "taylor" not in model.scene.refused
    for tolerance in (1e-6, 1e-12):
        assert model.simulate(at=[10.0], tolerance=tolerance).statistics.steps < 200


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_light_body_at_the_root(tmp_path: Path) -> None:
    """Next to nothing would move the tree alone: constraints take nearly all of that back, and nine digits with it."""
    ring = RING + "connect(hold.b, link[1].a);"
    ring = "Spring hold(k = 15, s_rel0 = 0.1, a = shift(world, {0, 2}));" + ring
    compiled(ring, tmp_path / "ring.lag")
    compilation = compiled(ring.replace("{1, 2, 1", "{1e-9, 2, 1"), tmp_path / "light.lag")
    assert compilation.motion.way == "constrained"
    results = [lag.load(tmp_path / f"{name}.lag").simulate(stop=0.5, tolerance=1e-10, parameters=changed)
               for name, changed in (("ring", {"link[1].m": 1e-9}), ("light", {}))]
    for result in results:
        assert result.statistics.steps < 400 and result.statistics.energy_residual < 1e-8
    for name in ("link[2].center.x", "hinge[3].phi"):
        assert results[0][name][-1] == pytest.approx(results[1][name][-1], abs=1e-7)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_islands_of_ropes(tmp_path: Path) -> None:
    """Apart and together, with a free pendulum beside them."""
    one = f"model One {rope(14)} end One;\n"
    arm = "Revolute pin(a = world, phi(start = 1)); Bar bar(m = 1, L = 2, a = pin.b);"
    text = one + f"model Scene One a, b(n = 13); {arm} end Scene;"
    (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
    model = lag.load(tmp_path / "scene.lag")
    assert model.compilation.motion.way == "constrained along the tree"
    ends = [model.simulate(stop=0.3, tolerance=1e-10, solver=solver) for solver in ("islands", "erk")]
    for name in model.coordinate_names:
        assert ends[0][name][-1] == pytest.approx(ends[1][name][-1], abs=1e-7), name


@pytest.mark.parametrize(("text", "n", "most"), [(HUNG, 8, 370), (IN_SPACE, 4, 1850)], ids=["in the plane", "in space"])
def test_loops_hung_on_each_other(text: str, n: int, most: int, tmp_path: Path) -> None:
    """Each moves all that hang on it: with J M^-1 J^T as a whole they took 838 and 2 684 operations each, the more the longer."""
    assert compiled(hung(n, text), tmp_path / "scene.lag").scene.notes["rhs_operations"] <= most * n


def test_the_size_of_all_constraints_is_summed_once() -> None:
    """It stands beside that of each, was summed anew for each, and took half of the operations of 80 four-bars in a row."""
    def all_of(n: int) -> tuple[_Bonds, ca.SX]:
        bonds = _Bonds(may_vanish=True)
        for i in range(n):
            bonds.add(i, i, ca.SX.sym(f"N{i}"))
        return bonds, ca.vertcat(*[bonds.beside(bonds.plain[i], 1.0) for i in range(n)])

    ten, twenty, forty = (ca.n_nodes(all_of(n)[1]) for n in (10, 20, 40))
    assert forty - twenty == 2 * (twenty - ten)
    bonds, _ = all_of(3)
    bonds.add(1, 1, 4e13)  # what changes is summed anew
    found = bonds.beside(1.0, 1.0)
    assert float(ca.substitute(found, ca.vertcat(*ca.symvar(found)), ca.SX.ones(3))) == pytest.approx(5.0)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_starts_of_a_row_of_loops(tmp_path: Path) -> None:
    """Of many loops beside each other each begins as one alone, and the equations cost what they do alone."""
    rows = []
    for n in (1, 25):
        text = "".join(HUNG.format(k=k, base="world") for k in range(n))
        (tmp_path / f"row{n}.lag").write_text(f"model Row {text} end Row;", encoding="utf-8")
        model = lag.load(tmp_path / f"row{n}.lag")
        rows.append((model.scene, model.simulate(at=[0.0], stop=0.1)))
    (one, first), (many, last) = rows
    assert many.sizes["n_initial"] == 25 * one.sizes["n_initial"] >= 100  # from so many on zeros are kept account of
    assert len(many.tapes["initial"].code) < 26 * len(one.tapes["initial"].code)
    assert len(set(many.patterns["mass_blocks"])) == 25 * len(set(one.patterns["mass_blocks"]))
    for name in ("f0.phi", "g0.phi", "p0.phi"):
        for k in range(25):
            assert last[name.replace("0", str(k))][0] == pytest.approx(first[name][0], abs=1e-7)
