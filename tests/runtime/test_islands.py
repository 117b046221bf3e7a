"""Islands: coordinates that do not interact, each group run by its own method and steps."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.base.diagnostics import LagError, RunError
from lagrangia.native.build import find_compiler
from lagrangia.native.c_code import write_c
from lagrangia.run.request import Values, check_values
from lagrangia.run.runtime import Run, Settings, Solver, Status
from lagrangia.run.scene import from_json, to_json

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

Scene = Callable[[str], lag.Model]

UNLIKE = """model Unlike "a slow pendulum, a stiff oscillator, and a damped mass on a hardening spring"
  parameter Stiffness k = 1e6;
  input Force F;
  Revolute hinge(a = world, phi(start = 1)); Bar bar(m = 1, L = 2, a = hinge.b);
  Block block(m = 0.3, base = world, along = {1, 0}, s(start = 0.01));
  SpringDamper spring(k = k, c = 0.1, stretch = block.s);
  AppliedForce P(at = block.center, force = {F + 3*pulse(time, 1, 0.5), 0});
  Prismatic rail(a = world, along = {0, 1}, s(start = 0.2)); PointMass mass(m = 1, center = rail.b);
  DuffingSpring duffing(k = 10, k3 = 5, stretch = rail.s);
  Damper damper(c = 0.1, rate = der(rail.s));
  output Length x = block.s + bar.b.x;
  annotation(experiment(StopTime = 4, Tolerance = 1e-9));
end Unlike;"""
INPUTS = ([0.0, 2.0, 2.0, 4.0], {"F": [0.0, 1.0, -1.0, 3.0]})


def test_islands_agree_with_the_whole_at_a_fraction_of_the_work(scene: Scene) -> None:
    model = scene(UNLIKE)
    assert [places for places, _ in model.scene.islands] == [(0,), (1,), (2,)]
    apart = model.simulate(tolerance=1e-11, inputs=INPUTS)
    whole = model.simulate(tolerance=1e-11, inputs=INPUTS, solver="erk")
    assert apart.statistics.solver is Solver.ISLANDS
    for name in (*model.coordinate_names, "der(hinge.phi)", "der(rail.s)", "x"):
        assert apart[name] == pytest.approx(whole[name], abs=1e-10)
    for name in ("kinetic", "potential", "dissipated", "work"):
        assert getattr(apart.energy, name) == pytest.approx(getattr(whole.energy, name), abs=2e-8)
    assert np.abs(apart.energy.residual).max() < 1e-9
    assert apart.statistics.events == whole.statistics.events
    assert apart.statistics.rhs_evaluations * 20 < whole.statistics.rhs_evaluations


@contextmanager
def started(model: lag.Model, settings: Settings, inputs: list[float] | None = None) -> Iterator[Run]:
    """A run at its start with all values as declared, inputs constant."""
    values, engine = check_values(model.scene), model.engine_for("islands")
    assert engine is not None
    with engine.runtime.run(engine.model, settings) as run:
        run.set_parameters(values.parameters, values.mask)
        if inputs is not None:
            run.set_inputs([0.0], inputs)
        assert run.start(values.q, values.v) is Status.OK
        yield run


def test_rows_one_at_a_time_are_the_same_rows(scene: Scene) -> None:
    model = scene(UNLIKE)
    times, found = [0.0, 0.3, 1.0, 1.2, 2.5, 4.0], []
    for portions in ([times], [[t] for t in times]):
        with started(model, Settings(0, 4, 1e-9)) as run:
            rows = [run.advance(part) for part in portions]
            found.append([list(some[i]) for some in rows for i in range(some.count)])
    assert found[0] == found[1]
    assert len(found[0]) == len(times)


def driven(model: lag.Model, stop: float, drive: Callable[[Run, Values, bool], np.ndarray]) -> list[np.ndarray]:
    """What `drive` makes of a started run with inputs of 0: of the islands, and of the whole by one solver."""
    found = []
    for solver in (Solver.ISLANDS, Solver.ERK):
        with started(model, Settings(0, stop, 1e-11, solver=solver), inputs=[0.0]) as run:
            found.append(drive(run, check_values(model.scene), solver is Solver.ERK))
    return found


def test_portions_with_inputs_and_parameters_in_between(scene: Scene) -> None:
    """The islands are ahead of the time of the whole when something changes; they come back to it."""
    model = scene(UNLIKE)

    def drive(run: Run, values: Values, is_whole: bool) -> np.ndarray:
        rows, parameters = [], list(values.parameters)
        for i, stop in enumerate(np.arange(1, 21) * 0.1):
            if i in (5, 11):
                run.set_inputs([0.0], [1.0 + i])
            if i == 8:
                parameters[model.parameter_names.index("k")] = 2e5
                run.set_parameters(parameters, values.mask)
            run.set_stop(stop if is_whole or i % 2 else 4.0)
            rows.append(list(run.advance([stop])[0]))
        return np.array(rows)

    results = driven(model, 4, drive)
    n = model.scene.n
    assert results[0][:, 1 : 1 + n] == pytest.approx(results[1][:, 1 : 1 + n], abs=3e-10)
    assert results[0][:, -2:] == pytest.approx(results[1][:, -2:], abs=3e-8)


@pytest.mark.parametrize("tie", [
    "Spring tie(a = bar.b, b = block.center, k = 1e-3);", "Damper tie(a = bar.b, b = block.center, c = 1e-3);",
    "AppliedForce tie(at = block.center, force = {1[N]*hinge.phi, 0});",
    "AppliedForce tie(at = block.center, force = {1[N.s]*der(hinge.phi), 0});",
], ids=["spring", "damper", "force", "force of a rate"])
def test_what_interacts_stays_together(tie: str, scene: Scene) -> None:
    model = scene(f"""model Tied
  Revolute hinge(a = world, phi(start = 1)); Bar bar(m = 1, L = 2, a = hinge.b);
  Block block(m = 0.3, base = world, along = {{1, 0}}, s(start = 3));
  Spring spring(k = 1e4, stretch = block.s);
  {tie}
end Tied;""")
    assert not model.scene.islands
    with pytest.raises(LagError, match="L0704"):
        model.simulate(stop=1, solver="islands")


def test_islands_of_like_rates_run_apart_only_when_asked(scene: Scene) -> None:
    model = scene("""model Alike
  Revolute a(a = world, phi(start = 1)), b(a = world, phi(start = 2)); Bar x(m = 1, L = 2, a = a.b), y(m = 1, L = 1.5, a = b.b);
end Alike;""")
    whole, apart = (model.simulate(stop=5, tolerance=1e-11, solver=solver) for solver in ("auto", "islands"))
    assert whole.statistics.solver is Solver.TAYLOR
    assert apart.statistics.solver is Solver.ISLANDS
    for name in model.coordinate_names:
        assert apart[name] == pytest.approx(whole[name], abs=1e-9)


def test_a_failure_names_the_coordinate_of_the_whole(scene: Scene) -> None:
    model = scene("""model Falls
  coordinate Real x(start = 1), y(start = 1);
energy
  kinetic der(x)^2/2 + der(y)^2/2; potential 1e4*x^2 - 1/y;
end Falls;""")
    with pytest.raises(RunError, match=r"1\.1107.*y"):
        model.simulate(stop=5, solver="islands")


def test_a_stored_scene_keeps_its_islands(scene: Scene) -> None:
    before = scene(UNLIKE).scene
    assert from_json(to_json(before)) == before


LOOPS = """model Loops "a four-bar on a support that is shaken, a redundantly held pair, and a stiff mass on a damped spring"
  parameter Stiffness k = 1e6;
  parameter Length lift = 0.1;
  input Torque M;
  Revolute A(a = shift(world, {0, lift*sin(3*time)}), phi(start = 1.2)); Bar crank(m = 1, L = 1, a = A.b);
  Revolute B(a = crank.b); Bar coupler(m = 1, L = 2, a = B.b);
  Revolute C(a = shift(world, {2, 0})); Bar rocker(m = 1, L = 1.5, a = C.b);
  Revolute D(a = coupler.b, b = rocker.b);
  AppliedTorque drive(on = crank.a, torque = M + 2*pulse(time, 0.5, 0.3));
  Revolute E(a = shift(world, {5, 0}), phi(start = 0.3)); Bar left(m = 1, L = 1, a = E.b);
  Revolute F(a = shift(world, {7, 0})); Bar right(m = 1, L = 1, a = F.b);
  Revolute G(a = left.b); Bar link(m = 0.5, L = 2, a = G.b);
  Revolute H(a = link.b, b = right.b);
  Block block(m = 0.3, base = world, along = {1, 0}, s(start = 0.01));
  DuffingSpring spring(k = k, k3 = 1e8, stretch = block.s); Damper damper(c = 0.1, rate = der(block.s));
  output Length x = block.s + coupler.b.x;
  annotation(experiment(StopTime = 1.5, Tolerance = 1e-9));
end Loops;"""


def test_closed_loops_are_islands(scene: Scene) -> None:
    """Each with the projections and steps it needs; a shaken support puts power in through the constraints of one."""
    model = scene(LOOPS)
    assert [len(places) for places, _ in model.scene.islands] == [3, 3, 1]
    assert [island.sizes["n_multipliers"] for _, island in model.scene.islands] == [2, 2, 0]
    inputs = ([0.0, 1.5], {"M": [0.0, 1.0]})
    apart = model.simulate(tolerance=1e-11, inputs=inputs)
    whole = model.simulate(tolerance=1e-11, inputs=inputs, solver="erk")
    assert apart.statistics.solver is Solver.ISLANDS
    for name in (*model.coordinate_names, "der(A.phi)", "der(H.phi)", "x"):
        assert apart[name] == pytest.approx(whole[name], abs=2e-9), name
    for name in ("kinetic", "potential", "dissipated", "work"):
        assert getattr(apart.energy, name) == pytest.approx(getattr(whole.energy, name), abs=2e-7), name
    assert np.abs(apart.energy.residual).max() < 1e-8
    assert apart.statistics.events == whole.statistics.events > 0
    assert apart.statistics.constraint_residual < 1e-14
    assert apart.statistics.rhs_evaluations * 5 < whole.statistics.rhs_evaluations
    assert apart.statistics.projections > 0
    assert model.coordinate_names[apart.statistics.worst % model.scene.n] == "block.s"


def test_islands_know_how_far_rows_are_apart(scene: Scene) -> None:
    """Collocation left an island after one step as if rows were no time apart; loops that repeat each other were not written
    abreast for one."""
    bricard = Path("models/examples/bricard.lag").read_text().split("drawing")[0].replace("model Bricard", "model Two")
    rod = Path("models/examples/bricard.lag").read_text().split("Tolerance = 1e-9));")[1].split("end Bricard;")[0]
    model = scene(bricard + """  Revolute hinge(a = shift(world, {5, 0, 0}), axis = {1, 0, 0}, phi(start = 1));
      Body bob(m = 1, I = {1e-5, 1e-5, 1e-5}, center = shift(hinge.b, {0, -0.05, 0}));""" + rod + "end Two;")
    run = model.simulate(at=[0, 2], tolerance=1e-6)
    assert run.statistics.solver is Solver.ISLANDS
    assert run.statistics.steps_by[Solver.PIRK] > 3 and run.statistics.steps_by[Solver.ERK] == 0
    assert model.scene.islands[0][1].sizes["may_repeat"] == 1


def test_loops_whose_parameters_change_under_way(scene: Scene) -> None:
    """A step that went too far is taken back onto the constraints as they are."""
    model = scene(LOOPS)

    def drive(run: Run, values: Values, is_whole: bool) -> np.ndarray:
        rows, parameters = [], list(values.parameters)
        for stop in (0.33, 0.66, 1.0):
            run.set_stop(stop if is_whole else 1.0)  # nothing takes a single solver's step back
            rows.append(list(run.advance([stop])[0]))
            run.set_inputs([0.0], [5.0])
            parameters[model.parameter_names.index("k")] = 2e5 if stop > 0.5 else 1e6
            run.set_parameters(parameters, values.mask)
        assert run.statistics.constraint_residual < 1e-14
        return np.array(rows)

    found = driven(model, 1, drive)
    n = model.scene.n
    assert found[0][:, 1 : 1 + n] == pytest.approx(found[1][:, 1 : 1 + n], abs=2e-9)
    assert found[0][:, -2:] == pytest.approx(found[1][:, -2:], abs=2e-7)


def test_a_run_without_a_limit_of_time_does_not_pause(scene: Scene) -> None:
    """However long an island takes to the next row: 240 000 steps here, more than 0.05 s, after which islands once answered."""
    with started(scene(LOOPS), Settings(0, 500, 1e-9, solver=Solver.ISLANDS)) as run:
        rows = run.advance([500.0])
        assert (rows.status, rows.count) == (Status.OK, 1)
        assert run.statistics.steps > 200_000


def test_a_first_step_that_takes_several_calls_begins_once(scene: Scene) -> None:
    """Each call began the islands again, and a first row far away was never reached."""
    with started(scene(LOOPS), Settings(0, 20, 1e-9, solver=Solver.ISLANDS)) as run:
        calls = [run.advance([20.0], seconds=1e-3).status for _ in range(200)]
        assert calls[0] is Status.PAUSED
        assert calls[-1] is Status.OK


def test_one_constraint_is_one_island(scene: Scene) -> None:
    """Two masses that a rope over a pulley ties together move as one, whatever else is there."""
    model = scene("""model Tied
  Block a(m = 1, base = world, along = {1, 0}), b(m = 2, base = world, along = {0, 1}), c(m = 1, base = world, along = {1, 0});
  Spring s(k = 1e6, stretch = c.s); Spring r(k = 1, stretch = a.s);
equation
  a.s^2 + b.s^2 = 1;
end Tied;""")
    assert [places for places, _ in model.scene.islands] == [(0, 1), (2,)]


DRIVER = """
#include "run/run.h"
#include <stdlib.h>
extern const LagModel whole, part0, part1, part2;
int main(void)
{
    const LagSettings settings = {.t_stop = 4, .tolerance = 1e-9, .solver = LAG_SOLVER_ISLANDS};
    const double times[] = {0, 0.5, 1.2, 4}, corners[] = {2, 3, 3}, values[] = {0, 1, 2};
    const LagModel *const parts[] = {&part0, &part1, &part2};
    const int island[] = {ISLAND};
    LagModel model = whole;
    model.n_islands = 3;
    model.island = island;
    model.islands = parts;
    double *rows = malloc(4 * (size_t)lag_run_row_width(&model) * sizeof *rows);
    LagRun *run = lag_run_new(&model, &settings);
    int done = 0;
    lag_run_set_parameters(run, NULL, NULL);
    lag_run_set_inputs(run, corners, values, 3);
    for (int i = 0; i < 2; ++i)
        if (lag_run_start(run, NULL, NULL) != LAG_OK || lag_run_advance(run, times, 4, rows, &done, 0) != LAG_OK || done != 4)
            return 1;
    lag_run_free(run);
    free(rows);
    return 0;
}
"""


@needs_sanitizers
@pytest.mark.slow
@pytest.mark.parametrize("text", [UNLIKE, LOOPS], ids=["free", "loops"])
def test_sanitizers_find_nothing(text: str, scene: Scene, tmp_path: Path) -> None:
    plain = scene(text).scene
    places = ", ".join(str(k) for places, _ in plain.islands for k in places)
    names = {"whole": plain, **{f"part{k}": island for k, (_, island) in enumerate(plain.islands)}}
    files = {"driver.c": DRIVER.replace("ISLAND}", places + "}")}
    for name, one in names.items():
        code = write_c(one.name, one.sizes, one.tapes, one.coordinate_kind, one.fixed, one.event_kind, one.patterns)
        files[f"{name}.c"] = code.replace("lag_model", name)
    run_sanitized(tmp_path, files)


def test_events_of_islands_are_those_of_the_whole(scene) -> None:
    """Two blocks that rub apart from each other: all their turns are counted, and have times."""
    model = scene("""model Rubbing
      Block a(m = 1, base = world, s(start = 1)), b(m = 1, base = world, s(start = 2));
      Spring ka(k = 100, stretch = a.s), kb(k = 1e4, stretch = b.s);
      Friction fa(mu = 0.1, normal = 10, rate = der(a.s)), fb(mu = 0.3, normal = 10, rate = der(b.s));
      annotation(experiment(StopTime = 1));
    end Rubbing;""")
    apart, whole = (model.simulate(solver=solver) for solver in ("islands", "erk"))
    assert apart.statistics.events == whole.statistics.events > 30
    assert np.allclose(apart.events, whole.events, atol=1e-6)
