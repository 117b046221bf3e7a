"""`lag explain`: what it says is needed is, and what it says a thing costs is what leaving it out saves."""

import json
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.cli import main
from lagrangia.needs import Need, find_needs
from lagrangia.pipeline import Compilation, compile_file
from lagrangia.solvers import name_of

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "models" / "examples"


def needs_of(compilation: Compilation) -> dict[str, Need]:
    c = compilation
    return {n.what: n for n in find_needs(c.kinematics, c.constraints, c.energies, c.motion, c.initial, c.scene)}


def example(name: str) -> dict[str, Need]:
    return needs_of(compile_file(EXAMPLES / f"{name}.lag"))


def operations(compilation: Compilation) -> int:
    return int(needs_of(compilation)["dissipation"].cost.split(" of ")[1].split()[0])


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
    assert gears["linear loops"].place.endswith("gear_train.lag:4:12")
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
    assert needs_of(compile_file(path))["islands"].why.startswith("2 groups")
    assert not example("double_pendulum")["islands"].is_needed


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


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar", "vibration_absorber", "free_bar", "chain"])
def test_the_solver_told_is_the_one_that_runs(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", str(EXAMPLES / f"{name}.lag"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    model = lag.load(EXAMPLES / f"{name}.lag")
    assert told["solver"] == name_of(model.simulate(stop=model.scene.stop / 100).statistics.solver)
    assert told["tolerance"] == model.scene.tolerance


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.lag")), ids=lambda path: path.stem)
def test_explain_says_why(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", str(path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["solver"] in told["solvers"]
    assert len(told["needs"]) > 20
    assert all(need["why"] for need in told["needs"])
    assert main(["explain", str(path)]) == 0
    text = capsys.readouterr().out
    assert all(need["what"] in text for need in told["needs"])
    assert max(map(len, text.splitlines())) <= 118
