"""`lag explain`: what it says is needed is, and what it says a thing costs is what leaving it out saves."""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import pytest

import lagrangia as lag
from helpers.derived_once import once
from lagrangia.command.cli import main
from lagrangia.compile import pipeline
from lagrangia.compile.pipeline import Compilation, compile_file
from lagrangia.needs import table
from lagrangia.needs.table import Need, find_needs
from lagrangia.needs.waves import Waves
from lagrangia.run.solvers import name_of

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "models" / "examples"


def needs_of(compilation: Compilation) -> dict[str, Need]:
    c = compilation
    return {n.what: n for n in find_needs(c.kinematics, c.constraints, c.energies, c.motion, c.initial, c.scene)}


def example(name: str) -> dict[str, Need]:
    return needs_of(compile_file(EXAMPLES / f"{name}.lag"))


@pytest.mark.parametrize(("name", "needed", "skipped"), [
    ("suspended_bar", {"dissipation", "sources", "integrator", "energy quadrature"},
     {"Coriolis terms", "refactorising M", "constraints", "projection", "time events", "implicit steps", "assembly"}),
    ("disc_and_block", {"sources"}, {"integrator", "Coriolis terms", "refactorising M"}),
    ("double_pendulum", {"gravity", "Coriolis terms", "refactorising M"},
     {"dissipation", "sources", "constraints", "explicit time", "energy quadrature", "outputs"}),
    ("four_bar", {"constraints", "projection", "assembly"}, {"dissipation", "linear loops", "prescribed coordinates"}),
    ("quarter_car", {"moving supports", "time events"}, {"Coriolis terms", "constraints"}),
    ("free_bar", {"floating coordinates"}, {"constraints"}),
])
def test_what_a_scene_needs(name: str, needed: set[str], skipped: set[str]) -> None:
    found = example(name)
    assert {what for what in needed | skipped if found[what].is_needed} == needed


def test_substituted_coordinates_are_named() -> None:
    gears, press = example("gear_train"), example("crank_press")
    assert "shaft[2].phi, shaft[3].phi" in gears["linear loops"].why
    assert gears["linear loops"].place.endswith("gear_train.lag:5:12")
    assert "O.phi" in press["prescribed coordinates"].why


def test_a_cost_is_what_leaving_out_saves(tmp_path: Path) -> None:
    """The scene without its dampers has as many operations fewer as its dampers are said to cost."""
    text = (EXAMPLES / "suspended_bar.lag").read_text()
    damped = compile_file(EXAMPLES / "suspended_bar.lag")
    lines = [line for line in text.splitlines() if "AxialDamper" not in line]
    assert len(lines) == len(text.splitlines()) - 1
    path = tmp_path / "undamped.lag"
    path.write_text("\n".join(lines))
    cost, whole = (int(word) for word in needs_of(damped)["dissipation"].cost.split() if word.isdigit())
    rest = needs_of(compile_file(path))
    assert not rest["dissipation"].is_needed
    assert int(rest["sources"].cost.split()[2]) == whole - cost


def test_islands_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "two.lag"
    path.write_text("""model Two
  Revolute a(a = world, phi(start = 1)), b(a = world, phi(start = 1));
  Bar x(m = 1, L = 1, a = a.b), y(m = 1, L = 1, a = b.b);
end Two;""")
    alike = needs_of(compile_file(path))["islands"]
    assert alike.why.startswith("2 groups") and not alike.is_needed
    assert example("double_pendulum")["islands"].why == "all its coordinates interact"


def test_a_stiff_damper_is_seen(tmp_path: Path) -> None:
    text = """model Damped
  Prismatic x(a = world, along = {1, 0}, s(start = 1));
  PointMass m(m = 1, center = x.b);
  Spring k(k = 1, stretch = x.s);
  Damper c(c = %s, a = world, b = x.b);
  annotation(experiment(StopTime = 100));
end Damped;"""
    for c, is_stiff in (("1", False), ("1e6", True)):
        path = tmp_path / f"c{c}.lag"
        path.write_text(text % c)
        assert needs_of(compile_file(path))["implicit steps"].is_needed is is_stiff


Scene = Callable[..., dict[str, Need]]


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    """The needs of a scene with these lines, of which the first is line 2; there is no gravity unless it is asked for."""
    def needs(text: str, gravity: str = "World world(gravity = {0, 0});") -> dict[str, Need]:
        path = tmp_path / "scene.lag"
        path.write_text(f"model Scene {gravity}\n{text}\nend Scene;")
        return needs_of(compile_file(path))

    return needs


def line(need: Need) -> int:
    return int(need.place.split(":")[-2])


MASS = """Prismatic x(a = world, along = {1, 0}, s(start = 1));
PointMass b(m = 1, center = x.b);
"""


@pytest.mark.parametrize("n", [20, 70])
def test_many_coordinates_are_judged_as_few_are(n: int) -> None:
    """Also more than are looked at one by one."""
    links = needs_of(compile_file(EXAMPLES / "chain.lag", structural={"n": n}))
    assert links["integrator"].is_needed and links["Coriolis terms"].is_needed and links["refactorising M"].is_needed
    assert line(links["Coriolis terms"]) == line(links["refactorising M"]) == 3


@pytest.mark.parametrize("n", [20, 70])
def test_a_long_row_of_masses_is_linear(scene: Scene, n: int) -> None:
    found = scene(f"""parameter Integer n = {n};
Block mass[n](each m = 1, each base = world, each along = {{0, 1}});
Spring left(k = 1, stretch = mass[1].s);
SpringDamper spring[n - 1](each k = 1, each c = 0.1, stretch = {{mass[j + 1].s - mass[j].s for j in 1:n - 1}});""", "")
    assert found["dissipation"].is_needed and found["gravity"].is_needed
    assert not any(found[what].is_needed for what in ("integrator", "Coriolis terms", "refactorising M"))
    assert "solver linear" in found["integrator"].saving


@pytest.mark.parametrize("n", [3, 8, 70])
def test_hinges_on_the_ground_have_no_coriolis_terms(scene: Scene, n: int) -> None:
    """sin^2 + cos^2 of their angles stands in T, and is 1."""
    found = scene(f"""parameter Integer n = {n};
Revolute h[n](each a = world, each phi(start = 1));
Bar bar[n](each m = 1, each L = 1, a = h.b);""", "")
    assert not found["Coriolis terms"].is_needed and not found["refactorising M"].is_needed


def test_what_turns_freely_keeps_its_mass_matrix(scene: Scene) -> None:
    """In its own axes; any four numbers in the place of the reference would not: they are no attitude."""
    found = scene("Spherical s(a = world); Body b(m = 1, I = {1, 2, 2.5}, center = shift(s.b, {0, 0, 0.1}));",
                  "World world(gravity = {0, 0, -9.81});")
    assert not found["refactorising M"].is_needed and found["refactorising M"].why == "M is constant"
    assert found["Coriolis terms"].why == "the axes of 's.S' turn along: w x dT/dw"


def test_a_carriage_that_is_turned_feels_the_rotation(scene: Scene) -> None:
    """s'' = -(k/m - 9) s: nothing depends on time or rates, but T on position, and power flows in."""
    found = scene("""Revolute h(a = world);
Motion drive(of = h.phi, to = 3*time);
Prismatic x(a = h.b, along = {1, 0}, s(start = 0.1));
PointMass b(m = 1, center = x.b);
Spring k(k = 100, stretch = x.s);""")
    for what in ("Coriolis terms", "moving supports", "prescribed coordinates", "energy quadrature", "integrator"):
        assert line(found[what]) == 3, what
    assert found["Coriolis terms"].is_needed and "position" in found["Coriolis terms"].why
    assert found["moving supports"].is_needed and not found["explicit time"].is_needed
    assert found["integrator"].why.startswith("not supported yet: the powers of its energy account")


def test_what_keeps_no_energy_is_named(tmp_path: Path) -> None:
    path = tmp_path / "driven.lag"
    path.write_text(f"model Driven\n{MASS}Revolute h(a = world);\nDisc d(m = 1, r = 1, center = h.b);\n"
                    "Motion drive(of = h.phi, to = 3*time);\nend Driven;")
    refusal = compile_file(path).scene.refused["conservative"]
    assert refusal.startswith("h.phi is moved in time (") and ":6:8)" in refusal


@pytest.mark.parametrize(("user", "is_needed", "why"), [
    ("GeneralDamper k(a = world, b = x.b, D = (1 + u/1[N])*1[N.s/m]*x.v^2/2);", True, "the motion depends on u"),
    ("AppliedForce F(at = x.b, force = {u, 0});", True, "the motion depends on u"),
    ("output Force f = 2*u;", True, "outputs alone depend on u"),
    ("", False, "nothing depends on u"),
])
def test_inputs_are_found_where_they_stand(scene: Scene, user: str, is_needed: bool, why: str) -> None:
    row = scene(f"input Force u;\n{MASS}{user}")["inputs"]
    assert (row.is_needed, row.why, line(row)) == (is_needed, why, 2)


DISCS = """Revolute h1(a = world), h2(a = world), h3(a = world);
Disc d1(m = 1, r = 1, center = h1.b), d2(m = 1, r = 1, center = h2.b), d3(m = 1, r = 1, center = h3.b);
"""
GEAR, GEAR_TOO = (f"Gear {name}(r_a = 1, r_b = 1, a = h2.b, b = h3.b, carrier = world);\n" for name in ("g", "twice"))
DRIVE = "Motion drive(of = h1.phi, to = 3*time);\n"


@pytest.mark.parametrize(("lines", "gear", "drive", "again"), [
    (GEAR + DRIVE, 4, 5, None), (DRIVE + GEAR, 5, 4, None), (GEAR + GEAR_TOO + DRIVE, 4, 6, 5),
    (DRIVE + GEAR + GEAR_TOO, 5, 4, 6),
])
def test_each_given_coordinate_has_its_own_line(scene: Scene, lines: str, gear: int, drive: int, again: int | None) -> None:
    found = scene(DISCS + lines)
    assert (line(found["linear loops"]), line(found["prescribed coordinates"])) == (gear, drive)
    assert (line(found["repeated equations"]) if found["repeated equations"].place else None) == again


def test_a_coordinate_that_is_driven_through_a_gear_is_prescribed(scene: Scene) -> None:
    """The Motion decides, not the Gear that hands it on."""
    found = scene(DISCS + GEAR + "Motion drive(of = h2.phi, to = 3*time);")
    assert line(found["moving supports"]) == 5 and "h3.phi" in found["prescribed coordinates"].why
    held = scene(DISCS + "Motion still(of = h1.phi, to = 0.5);")
    assert "held in place: h1.phi" in held["prescribed coordinates"].why and not held["moving supports"].is_needed


@pytest.mark.parametrize(("count", "k", "is_needed", "why"), [
    (2, "{1, 1e6}", True, "each is run with its own solver"), (2, "{1, 1}", False, "would hardly pay"),
    (9, "{10^j for j in 1:9}", False, "more than 8 islands"),
])
def test_islands_are_needed_where_they_are_used(scene: Scene, count: int, k: str, is_needed: bool, why: str) -> None:
    found = scene(f"""Block b[{count}](each m = 1, each base = world);
Spring s[{count}](k = {k}, stretch = {{b[j].s for j in 1:{count}}});""")
    row = found["islands"]
    assert row.is_needed is is_needed and row.why.startswith(f"{count} groups") and why in row.why


def test_the_line_that_decides(scene: Scene) -> None:
    found = scene(MASS + """GeneralSpring k(a = world, b = x.b, V = 1[N/m^3]*x.s^4);
AppliedForce P(at = x.b, force = {if time < 0.5 then 1 else 0, 0});
AppliedForce Q(at = x.b, force = {5*sin(2*time), 0});
output Length far = 2*x.s;""")
    lines = {"integrator": 4, "explicit time": 5, "time events": 5, "energy quadrature": 5, "outputs": 7, "gravity": 1}
    assert {what: line(found[what]) for what in lines} == lines
    heavy = "Prismatic x(a = world, along = {0, 1});\nPointMass b(m = 1, center = x.b);"
    assert line(scene(heavy, "World world(gravity = {0, -1.62});")["gravity"]) == 1
    assert line(scene(heavy, "")["gravity"]) == 3
    late = MASS + "AppliedForce Q(at = x.b, force = {5*sin(2*time), 0});\n"
    late += "AppliedForce P(at = x.b, force = {5*step(time - 1), 0});"
    assert (line(scene(late)["explicit time"]), line(scene(late)["time events"])) == (4, 5)


PENDULUM = """model Pendulum
  World world(gravity = {0, 0});
  Revolute h(a = world, phi(start = 1));
  Bar bar(m = 1, L = 1, a = h.b);
  TorsionDamper d(c = 0.1, a = world, b = h.b);
  annotation(experiment(StopTime = 100));
end Pendulum;"""


def explained(capsys: pytest.CaptureFixture[str], path: Path, *options: str) -> dict[str, dict[str, object]]:
    assert main(["explain", str(path), "--json", *options]) == 0
    return {need["what"]: need for need in json.loads(capsys.readouterr().out)["needs"]}


def test_parameters_given_are_explained(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also one whose value is compiled in."""
    path = tmp_path / "pendulum.lag"
    path.write_text(PENDULUM)
    as_declared = explained(capsys, path)
    assert not as_declared["gravity"]["is_needed"] and not as_declared["implicit steps"]["is_needed"]
    assert explained(capsys, path, "-p", "world.gravity={0,-9.81}")["gravity"]["is_needed"]
    assert explained(capsys, path, "-p", "d.c=1e6")["implicit steps"]["is_needed"]


@pytest.mark.parametrize("given", ["nonsense=1", "bar.m=heavy", "bar.m"])
def test_wrong_parameters_are_refused(given: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "pendulum.lag"
    path.write_text(PENDULUM)
    assert main(["explain", str(path), "-p", given]) == 2
    assert "error[L070" in capsys.readouterr().err


def test_without_a_run_time_only_casadi_can_run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    monkeypatch.setattr("lagrangia.native.prebuilt.find", lambda *_, **__: None)
    for name, solver, can in (("vibration_absorber", "casadi:cvodes", True), ("four_bar", "none", False)):
        assert main(["explain", str(EXAMPLES / f"{name}.lag"), "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["solver"] == solver
        assert all(way["can_run"] is (can and key.startswith("casadi")) for key, way in told["solvers"].items())
        assert not any("exponential" in need["saving"] for need in told["needs"])
        assert main(["explain", str(EXAMPLES / f"{name}.lag")]) == 0
        assert max(map(len, capsys.readouterr().out.splitlines())) <= 118


def test_friction_that_sticks_is_refused_to_casadi(tmp_path: Path) -> None:
    """Their steps would get shorter without end; a damper without a jump is taken."""
    for law, is_taken in (("DryFriction f(F = 5, rate = b.v);", False), ("QuadraticDamper f(c = 5, rate = b.v);", True)):
        file = tmp_path / f"rubbed_{is_taken}.lag"
        file.write_text(f"model Rubbed Block b(m = 2, base = world, v(start = 1)); {law} end Rubbed;")
        if is_taken:
            run = lag.load(file).simulate(at=[1.0], solver="casadi:cvodes")
            assert run["b.s"][0] == pytest.approx(0.4 * math.log(3.5), rel=1e-5)  # m/c ln(1 + c v0 t/m)
        else:
            with pytest.raises(lag.LagError, match="dry friction, which sticks"):
                lag.load(file).simulate(at=[1.0], solver="casadi:cvodes")


def test_statistics_without_a_compiler_tell_of_no_native_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    monkeypatch.setattr("lagrangia.native.prebuilt.find", lambda *_, **__: None)
    target = str(tmp_path / "rows.csv")
    assert main(["simulate", str(EXAMPLES / "pendulum.lag"), "--stop", "0.1", "--stats", "-o", target]) == 0
    said = capsys.readouterr().out
    assert "no native code" in said and "natively" not in said and "compiled at once" not in said


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar", "vibration_absorber", "free_bar", "chain"])
def test_the_solver_told_is_the_one_that_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", str(EXAMPLES / f"{name}.lag"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    model = lag.load(EXAMPLES / f"{name}.lag")
    assert told["solver"] == name_of(model.simulate(at=[model.scene.stop / 100]).statistics.solver)
    assert told["tolerance"] == model.scene.tolerance


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.lag")), ids=lambda path: path.stem)
def test_explain_says_why(path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """In both formats, of one compilation and one table; and the exponential is promised where it can be had."""
    for module, made in ((pipeline, "compile_file"), (table, "find_needs")):
        monkeypatch.setattr(module, made, once(getattr(module, made)))
    assert main(["explain", str(path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["solver"] in told["solvers"]
    assert len(told["needs"]) > 20
    assert all(need["why"] for need in told["needs"])
    scene, row = lag.load(path).scene, next(need for need in told["needs"] if need["what"] == "integrator")
    if scene.n:
        assert row["is_needed"] is ("linear" in scene.refused)
    saves = row["saving"].startswith("every step: the matrix exponential")
    assert row["why"] == scene.refused["linear"] if row["is_needed"] else saves
    assert main(["explain", str(path)]) == 0
    text = capsys.readouterr().out
    assert all(need["what"] in text for need in told["needs"])
    assert max(map(len, text.splitlines())) <= 118


@pytest.mark.parametrize("loop", ["", "Link rod(a = shift(world, {2, 0}), b = c.b, L = 1);"])
def test_stops_are_explained(loop: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Several of them, with friction and in loops: what their contact forces would do is no part of the spectrum."""
    file = tmp_path / "stops.lag"
    file.write_text(f"""model Stops
        Revolute i(a = world, phi(start = 1)), j(a = b.b, phi(start = -1));
        Bar b(m = 1, L = 1, a = i.b), c(m = 1, L = 2, a = j.b); {loop}
        RoughStop s(a = world, b = c.center, mu = 0.3); TorsionStop t(a = world, b = i.b);
    end Stops;""")
    assert main(["explain", str(file)]) == 0
    assert "2 events at which rates are reset" in capsys.readouterr().out


CORNERS = {
    "Spring p(a = world, b = b.center, k = 1, s_rel0 = 0.5);": "p: a length passes through 0",
    "DryFriction p(F = 1, rate = b.v);": "p: a rate turns",
    "AppliedForce p(at = b.center, force = {if b.s > 0.3 then 1[N] else 2[N], 0});": "p: a place decides",
    "energy potential 1[N]*abs(b.s);": "a force of its own: a place decides",
}


@pytest.mark.parametrize("text", CORNERS)
def test_where_forces_bend_is_said(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bends.lag"
    file.write_text(f"model M Block b(m = 1, base = world, s(start = 1)); {text} end M;")
    assert main(["explain", str(file)]) == 0
    assert f"({CORNERS[text]}), held in each step" in " ".join(capsys.readouterr().out.split())


ARM = """
model Arm
  parameter Real e[3] = {0, 0, 1}, d[3] = {1, 0, 0};
  World world(gravity = {0, 0, -9.81});
  Revolute one(a = world, axis = AXIS);
  Revolute two(a = shift(one.b, {0, 0.3, 0}), axis = AXIS2);
  Revolute three(a = two.b, axis = AXIS);
  Body b1(m = 1, I = MOMENTS, center = one.b);
  Body b3(m = 1, I = MOMENTS, center = shift(three.b, {0.1, 0, 0}));
end Arm;
"""


def test_what_special_axes_save_is_counted(tmp_path: Path) -> None:
    """As many operations as the same scene with parameters has more: axes in space, and products of inertia."""
    def needs(*changes: str) -> dict[str, Need]:
        text = ARM
        for before, after in zip(("AXIS2", "AXIS", "MOMENTS"), changes, strict=True):
            text = text.replace(before, after)
        path = tmp_path / "arm.lag"
        path.write_text(text, encoding="utf-8")
        return needs_of(compile_file(path))

    def operations(found: dict[str, Need]) -> int:
        return int(re.findall(r"tree (\d+)", found["M as a matrix"].why)[0])

    special = needs("{1, 0, 0}", "{0, 0, 1}", "{0.1, 0.2, 0.25}")
    skipped = special["tilted axes"]
    assert not skipped.is_needed and special["centres beside axes"].place.endswith("arm.lag:7:12")
    assert "two.phi" in special["offsets of joints"].why and "2 of 3 are without" in special["offsets of joints"].why
    any_axes = needs("d", "e", "{0.1, 0.2, 0.25}")
    assert any_axes["tilted axes"].is_needed and any_axes["tilted axes"].why == "one.phi, two.phi, three.phi"
    special_count = operations(special)
    saved, whole = map(int, re.findall(r"\d+", skipped.saving))
    assert saved == whole - special_count and saved > 100
    matrix = "{{0.1, 0.01, 0.01}, {0.01, 0.2, 0.01}, {0.01, 0.01, 0.25}}"
    whole_matrix = operations(needs("{1, 0, 0}", "{0, 0, 1}", matrix))
    saved, whole = map(int, re.findall(r"\d+ of \d+", special["products of inertia"].saving)[0].split(" of "))
    assert whole == whole_matrix and saved == whole - special_count


def test_references_of_attitudes_are_no_time() -> None:
    found = example("top")
    assert not found["explicit time"].is_needed and not found["time events"].is_needed
    assert not found["products of inertia"].is_needed


@pytest.mark.parametrize(("name", "told"), [
    ("free_bar", "constant are those of 'bar.center.x', of 'bar.center.phi'"),
    ("bouncing_ball", "constant between events is that of 'x.s'"),
    ("gyroscope", "constant are those of 'outer.phi', of 'spinning.phi'"),
    ("top", "constant are those of 'tip.S' about the z axis of what carries it, of 'tip.S' about its own z axis"),
])
def test_momenta_that_nothing_changes_are_named(name: str, told: str) -> None:
    assert example(name)["changing momenta"].why == told


def test_momenta_that_change_are_not_named() -> None:
    assert all("changing momenta" not in example(name) for name in ("double_pendulum", "rolling_disc", "four_bar"))


def test_time_that_cancels_in_loads_is_in_none_of_their_factors() -> None:
    """A massless slider behind a spring whose end is prescribed: the spring's force, 0, was "constant", with time in it."""
    t, k = ca.SX.sym("t"), ca.SX.sym("k")
    force = k * (0.196 * ca.sin(3 * t) - (0.5 * (k * (0.392 * ca.sin(3 * t)))) / k)
    one = ca.sin(3 * t) ** 2 + ca.cos(3 * t) ** 2
    sums = Waves(t).decompose(ca.vertcat(ca.cos(3 * t) * force, ca.cos(3 * t) / one), [k])
    factors = [x for one in sums for pair in one.values() for x in pair]
    assert factors and not ca.depends_on(ca.vertcat(*factors), t)
