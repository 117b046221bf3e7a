"""Assertions and terminate in FMUs: where they end a simulation, and what is said."""

from math import pi, sqrt
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

import fmpy
from fmpy.fmi1 import FMICallException

from helpers.fmus import KINDS, VERSIONS, Instance, fmu_of, simulated

SCENE = """
model Guarded
  parameter Length h = 1;
  Prismatic a(a = world, along = {0, 1}, s(start = h)); PointMass m(m = 1, center = a.b);
  output Length y = a.s;
equation
  assert(h < 3, "too high");
  assert(a.v > -4, "quick", AssertionLevel.warning);
  assert(h > 0.5 or a.s > 0.1, "deep");
  when a.s < 0 then terminate("down"); end when;
  annotation(experiment(StopTime = 2));
end Guarded;
"""
FALL = sqrt(2 / 9.81)


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("guards") / "guarded.lag"
    path.write_text(SCENE)
    return path


@pytest.mark.parametrize("version", VERSIONS)
def test_a_step_ends_where_the_run_is_terminated(guarded: Path, version: str) -> None:
    one = Instance(guarded, version, "CoSimulation").start(tolerance=1e-10)
    one.step(0, 0.3)
    if version == "2":
        with pytest.raises(FMICallException) as told:
            one.step(0.3, 0.3)
        assert told.value.status == 2  # fmi2Discard
        assert one.fmu.getBooleanStatus(3)  # fmi2Terminated
        assert one.fmu.getRealStatus(2) == pytest.approx(FALL, abs=1e-9)  # fmi2LastSuccessfulTime
    else:
        _event, terminates, early, reached = one.step(0.3, 0.3)
        assert terminates and not early and reached == pytest.approx(FALL, abs=1e-9)
    assert one.get("y") == pytest.approx([0], abs=1e-9)
    one.free()


@pytest.mark.parametrize("events", [True, False])
def test_it_returns_early_where_that_is_allowed(guarded: Path, events: bool) -> None:
    one = Instance(guarded, "3", "CoSimulation", eventModeUsed=events, earlyReturnAllowed=True).start(tolerance=1e-10)
    if events:
        one.update()
        one.fmu.enterStepMode()
    _event, terminates, early, reached = one.step(0, 0.6)
    assert terminates and early and reached == pytest.approx(FALL, abs=1e-9)
    one.free()


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_importers_are_told_to_end(guarded: Path, version: str, kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    rows = simulated(guarded, version, kind, ["y"], output_interval=0.01)
    assert FALL - 0.02 < rows["time"][-1] < FALL + 0.01 and abs(rows["y"][-1]) < 0.1
    told = capfd.readouterr().out
    assert "the simulation ends: down" in told and "(quick)" in told


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_assertions_are_errors(guarded: Path, version: str, kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(FMICallException):
        simulated(guarded, version, kind, ["y"], start_values={"h": 4})
    assert "too high" in capfd.readouterr().out
    with pytest.raises(FMICallException):
        simulated(guarded, version, kind, ["y"], start_values={"h": 0.4})
    assert "deep" in capfd.readouterr().out


def test_a_state_that_is_restored_goes_on(guarded: Path) -> None:
    one = Instance(guarded, "3", "CoSimulation").start(tolerance=1e-10)
    one.step(0, 0.3)
    state = one.fmu.getFMUState()
    assert one.step(0.3, 0.3)[1]
    one.fmu.setFMUState(state)
    assert not one.step(0.3, 0.1)[1]
    assert one.get("y") == pytest.approx([1 - 9.81 * 0.4**2 / 2], abs=1e-9)
    one.fmu.freeFMUState(state)
    one.free()


BRANCHES = """
model Branches
  Block b(m = 1, base = world, along = {1, 0}, s(start = 1)); Spring k(k = 4, stretch = b.s);
  output Length y = b.s;
equation
  when b.s < 0 then terminate("first"); elsewhen -2*b.s > 0 then terminate("second"); end when;
  when b.s > 5 then terminate("far"); elsewhen time > 1/2 then terminate("late"); end when;
  annotation(experiment(StopTime = 2));
end Branches;
"""


@pytest.mark.parametrize("version", VERSIONS)
def test_branches_end_simulations_and_nothing_else_tells_of_them(version: str, tmp_path: Path,
                                                                   capfd: pytest.CaptureFixture[str]) -> None:
    """The first of those that come at one instant, pi/4, and the second where it comes alone, after 0.5 s."""
    for text, end in ((BRANCHES, 0.5), (BRANCHES.replace("1/2", "1"), pi / 4)):
        path = tmp_path / f"until_{end:.1f}.lag"
        path.write_text(text)
        for kind in KINDS:
            rows = simulated(path, version, kind, ["y"], output_interval=0.01)
            assert end - 0.02 < rows["time"][-1] < end + 0.011
            assert f"the simulation ends: {'late' if end == 0.5 else 'first'}" in capfd.readouterr().out
    told = fmpy.read_model_description(str(fmu_of(path, version)))
    assert len(told.derivatives) == 2 and not [x.name for x in told.modelVariables if "terminate" in x.name]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_parameters_that_end_contacts_together_are_refused(tmp_path: Path, version: str, kind: str,
                                                           capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bounces.lag"
    path.write_text("""model Bounces parameter Real k1 = 2, k2 = 1;
        World world(gravity = {-10, 0}); Block b(m = 1, base = world, s(start = 1));
        equation when b.s < 0 then reinit(b.v, -0.5*(k1 - k2)*b.v); end when; end Bounces;""")
    one = Instance(path, version, kind).start({"k1": 3.0, "k2": 2.5})
    one.free()
    other = Instance(path, version, kind)
    with pytest.raises(FMICallException):
        other.start({"k1": 1.6, "k2": 1.8})
    assert "the event at 'b.s < 0' ceases to be a contact" in capfd.readouterr().out


@pytest.mark.parametrize(("parameters", "said"), [
    ({"I[1,2]": 0.1}, "'b.I' is not symmetric"), ({"I[1,2]": 0.4, "I[2,1]": 0.4}, "'b.I' is negative about an axis"),
    ({"h.axis[3]": 0.0}, "'h.axis' has no length"), ({"I[1,2]": 0.1, "I[2,1]": 0.1}, ""),
])
def test_inertias_and_directions_of_instances_are_looked_at(tmp_path: Path, capfd: pytest.CaptureFixture[str],
                                                            parameters: dict[str, float], said: str) -> None:
    path = tmp_path / "turns.lag"
    path.write_text("""model Turns parameter Inertia I[3,3] = {{0.1, 0, 0}, {0, 0.2, 0}, {0, 0, 0.25}};
        Revolute h(a = world, axis = {0, 0, 1}); Spherical j(a = shift(h.b, {0.5, 0, 0}));
        Body b(m = 1, I = I, center = j.b); end Turns;""")
    instance = Instance(path, "2", "CoSimulation")
    if said:
        with pytest.raises(FMICallException):
            instance.start(parameters)
        assert said in capfd.readouterr().out
    else:
        instance.start(parameters).free()


@pytest.mark.parametrize(("kind", "version", "shape", "usual", "odd"), [
    ("CoSimulation", "2", "I[3] = {1, 1, 1.5}", {"I[3]": 2.0}, {"I[3]": 3.0}),
    ("ModelExchange", "3", "I[3,3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 3}}", {"I[1,2]": 0.5, "I[2,1]": 0.5},
     {"I[1,2]": 1.8, "I[2,1]": 1.8}),  # moments 0.2, 3.8 and 3; of the usual one 1.5, 2.5 and 3
    ("ModelExchange", "2", "I[3,3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 2}}", {"I[3,3]": 0.5}, {"I[3,3]": 2.00001}),
])
def test_inertias_of_no_rigid_body_are_told(tmp_path: Path, capfd: pytest.CaptureFixture[str], kind: str, version: str,
                                            shape: str, usual: dict[str, float], odd: dict[str, float]) -> None:
    """As runs tell them (L0746); an importer that set them was told nothing."""
    path = tmp_path / "odd.lag"
    path.write_text(f"model Odd parameter Inertia {shape}; Spherical j(a = world); Body b(m = 1, I = I, center = j.b); end Odd;")
    said = "one moment is more than the other two together"
    for given in ({}, usual, odd):
        Instance(path, version, kind).start(given).free()
        assert (said in capfd.readouterr().out) == (given is odd), given
