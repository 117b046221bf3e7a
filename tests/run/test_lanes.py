"""Runs in lanes: eight runs of a batch at once, each with its own steps, as good as alone and the same in any company."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.lanes import DRIVER, advanced, one_by_one
from helpers.register_widths import in_registers
from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.base.folders import data_folder
from lagrangia.native.build import find_compiler
from lagrangia.native.c_code import write_c
from lagrangia.native.prebuilt import FLAGS, flags_of, kind_here
from lagrangia.run.batch import Batch, Ending, Lanes
from lagrangia.run.engines import load_engine
from lagrangia.run.library import start_runtime
from lagrangia.run.request import Request
from lagrangia.study.sweep.measures import quantities, read_measures
from lagrangia.study.sweep.plan import Design, Job

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
MEASURES = ("final(elbow.phi), max(elbow.phi), time_of_max(elbow.phi), mean(lower.b.y), first_time(elbow.phi < 0), "
            "at(0.7, der(elbow.phi))")
ENDS = "final(elbow.phi), final(der(elbow.phi))"  # of which nothing but states is known
DAMPED = """model Damped
  parameter Real d = 1;
  Revolute hinge(a = world, phi(start = 1));
  Bar      bar(m = 1, L = 1, a = hinge.b);
  TorsionDamper damper(a = hinge.a, b = hinge.b, c = d);
end Damped;
"""


def prepared(model: lag.Model, outputs: str, runs: int = 37, **asked: object) -> tuple[lag.Model, Job]:
    measures = read_measures(outputs)
    initial = {"elbow.phi": np.linspace(0.1, 1, runs)}
    request = Request(**{"stop": 2.0, "tolerance": 1e-8, "initial": initial, **asked})
    return model.reporting(quantities(measures)).prepared_for(measures, request, Design())


@pytest.fixture(scope="module")
def pendulum() -> lag.Model:
    return lag.load(EXAMPLES / "double_pendulum.lag")


def test_results_are_those_of_the_motion(pendulum: lag.Model) -> None:
    """Against the same measures of runs made one by one with another method, at a smaller tolerance."""
    suited, job = prepared(pendulum, MEASURES)
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    assert lanes.runs == job.runs and lanes.alone == 0 and (outcomes["kind"] == 0).all()
    assert lanes.steps > 0.75 * lanes.room
    other, reference = prepared(pendulum, MEASURES, tolerance=1e-12, solver="erk")
    exact, _, none = advanced(other, one_by_one(reference), values)
    assert none == Lanes()
    assert found == pytest.approx(exact, abs=2e-7)
    assert (outcomes["energy"] < 1e-8).all()


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_what_is_compiled_first_goes_in_lanes_too() -> None:
    """Bit by bit as otherwise. Lanes ask for tapes of what stands under roots, too, where code for eight at once is no good."""
    found = {}
    for native in (None, True, False):
        model = lag.load(EXAMPLES / "spring_pendulum.lag")
        model.native = native
        sweep = model.simulate_many(initial={"bob.center.x": np.linspace(0.1, 0.6, 9)}, outputs=["final(bob.center.x)"],
                                    stop=1.0, jobs=1)
        found[native] = sweep.ledger.results.tobytes()
        assert sweep.ledger.lanes.runs == 9 and sweep.ledger.lanes.alone == 0
    assert found[True] == found[None] == found[False]


@pytest.mark.parametrize(("outputs", "stop"), [(MEASURES, 2.0), (ENDS, 2.0), (ENDS, 30.0)])
def test_a_run_does_not_depend_on_its_company(pendulum: lag.Model, outputs: str, stop: float) -> None:
    """Bit by bit: fewer runs, another order, one after another in the same lane. After many steps more than states is
    looked at."""
    suited, job = prepared(pendulum, outputs, stop=stop)
    values = job.variations.values(0, job.runs)
    all_of_them, outcomes, _ = advanced(suited, job, values)
    backward, others, _ = advanced(suited, job, values[::-1])
    assert all_of_them.tobytes() == np.ascontiguousarray(backward[::-1]).tobytes()
    assert outcomes.tobytes() == np.ascontiguousarray(others[::-1]).tobytes()
    for first, last in ((0, 1), (5, 8), (20, 36)):
        assert advanced(suited, job, values[first:last])[0].tobytes() == all_of_them[first:last].tobytes()


def test_a_run_that_fails_leaves_the_others_alone(pendulum: lag.Model) -> None:
    suited, job = prepared(pendulum, "final(elbow.phi)")
    values = job.variations.values(0, job.runs)
    whole = advanced(suited, job, values)[0]
    values[7] = 1e300
    found, outcomes, _ = advanced(suited, job, values)
    keep = np.arange(job.runs) != 7
    assert outcomes["kind"][7] != 0 or np.isfinite(found[7]).all()
    assert found[keep].tobytes() == whole[keep].tobytes()


def test_what_is_stiff_is_made_alone() -> None:
    """Where stability rules a run, it is the run that it would be without lanes, byte for byte."""
    model = lag.loads(DAMPED)
    measures = read_measures("final(hinge.phi)")
    request = Request(stop=20.0, tolerance=1e-6, parameters={"d": np.linspace(0.1, 3e3, 9)})
    suited, job = model.prepared_for(measures, request, Design())
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    assert lanes.alone > 0 and lanes.runs > 0 and (outcomes["kind"] == 0).all()
    apart = one_by_one(job)
    alone = advanced(suited, apart, values)[0]
    assert alone[-1].tobytes() == found[-1].tobytes()
    assert alone == pytest.approx(found, abs=1e-6)


GUARDED = """model Guarded
  parameter Angle most = 1.5;
  Revolute hinge(a = world, phi(start = 1));
  Bar      bar(m = 1, L = 1, a = hinge.b);
  TorsionDamper damper(a = hinge.a, b = hinge.b, c = 0.01);
equation
  assert(hinge.phi < most, "too far");
  assert(hinge.w > -6.5, "fast", level = AssertionLevel.warning);
  when hinge.w > 7.2 then terminate("fast enough"); end when;
end Guarded;
"""


def test_a_run_whose_parameter_is_none_has_no_warning_of_another() -> None:
    """It had those of the run that was in its place before, and so depended on its company."""
    model = lag.loads(GUARDED.replace("parameter Angle most = 1.5;", "parameter Angle most = 9; parameter Mass m(min = 0) = 1;")
                      .replace("Bar      bar(m = 1", "Bar      bar(m = m"))
    masses = np.where(np.arange(40) % 4 == 3, -1.0, 1.0)
    for in_lanes in (True, False):
        request = Request(stop=3.0, tolerance=1e-6, parameters={"m": masses})
        suited, job = model.prepared_for(read_measures("final(hinge.phi)"), request, Design())
        values = job.variations.values(0, job.runs)
        apart = replace(job, sweep=replace(job.sweep, in_lanes=in_lanes))
        _, outcomes, _ = advanced(suited, apart, values)
        assert ((outcomes["kind"] == Ending.PARAMETER) == (masses < 0)).all()
        assert ((outcomes["warned"] != 0) == (masses > 0)).all()


def test_runs_that_a_guard_ends_are_made_alone() -> None:
    """With the outcomes, warnings and digits that they would have without lanes; the others stay in theirs."""
    suited, job = lag.loads(GUARDED).prepared_for(
        read_measures("final(hinge.phi), max(der(hinge.phi))"),
        Request(stop=3.0, tolerance=1e-8, initial={"hinge.phi": np.linspace(0.2, 1.7, 16)}), Design())
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    alone, others, none = advanced(suited, one_by_one(job), values)
    ended = np.array([k for k in range(16) if others["kind"][k] or found[k].tobytes() == alone[k].tobytes()])
    assert none == Lanes() and lanes.runs + lanes.alone == 16 and lanes.runs > 5 and lanes.alone == len(ended) > 3
    assert outcomes["kind"].tolist() == others["kind"].tolist() and outcomes["warned"].tolist() == others["warned"].tolist()
    assert others["warned"].any() and others["kind"].any() and not others["kind"].all()
    assert found == pytest.approx(alone, abs=1e-7, nan_ok=True)


@pytest.mark.parametrize("name", ["stick_slip", "bouncing_ball", "four_bar", "pendulum"])
def test_what_lanes_do_not_serve_is_as_it_was(name: str) -> None:
    """Events, friction, loops, and what swings back the way it came."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    measures = read_measures(f"final({model.coordinate_names[0]})")
    suited, job = model.prepared_for(measures, Request(stop=0.5, initial={}), Design())
    assert advanced(suited, job, np.empty((9, 0)))[2] == Lanes()


LONG = """model Long "Too long for series"
  parameter Integer n = 5; parameter Real c = 0.1; input Torque M;
  Revolute hinge[n]; Bar link[n](each m = 1, each L = 0.5);
  TorsionDamper damper(a = world, b = hinge[1].b, c = c);
  AppliedTorque push(on = link[n].center, torque = M);
equation
  connect(world, hinge[1].a);
  for i in 1:n loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:n-1 loop connect(link[i].b, hinge[i+1].a); end for;
initial equation
  hinge[1].phi = 1;
end Long;
"""


@pytest.mark.parametrize("outputs", ["final(hinge[1].phi), at(0.7, der(hinge[3].phi)), final(link[5].b.y)",
                                     "final(hinge[1].phi), max(hinge[2].phi), time_of_max(hinge[2].phi), mean(link[5].b.y)"])
def test_long_equations_go_by_runge_kutta_pairs(outputs: str) -> None:
    """Parameters differ, inputs have corners and a jump, power is lost: errors no larger than those of runs made alone, whatever
    the company; what measures ask for inside steps comes from the pair that tells it."""
    measures, stop = read_measures(outputs), 1.5
    model = lag.loads(LONG).reporting(quantities(measures))
    inputs = np.array([0.0, 0.5, 0.5, stop]), {"M": [0.0, 2.0, -1.0, 1.0]}
    found = {}
    for tolerance, in_lanes in ((1e-7, True), (1e-7, False), (1e-11, False)):
        request = Request(stop=stop, tolerance=tolerance, initial={"hinge[2].phi": np.linspace(0.1, 0.6, 13)},
                          parameters={"c": np.linspace(0.1, 0.5, 13)}, inputs=inputs)
        suited, job = model.prepared_for(measures, request, Design(together=True))
        job = replace(job, sweep=replace(job.sweep, in_lanes=in_lanes))
        values = job.variations.values(0, job.runs)
        found[tolerance, in_lanes], outcomes, lanes = advanced(suited, job, values)
        assert (outcomes["kind"] == 0).all() and (outcomes["energy"] < 1e-7).all()
        assert (lanes.runs, lanes.alone) == (job.runs if in_lanes else 0, 0)
        if in_lanes:
            assert advanced(suited, job, values[4:7])[0].tobytes() == found[tolerance, True][4:7].tobytes()
    exact = found[1e-11, False]
    errors = [np.median(np.abs(found[1e-7, in_lanes] - exact), axis=0) for in_lanes in (True, False)]
    assert (errors[0] < 1e-6).all() and np.median(errors[0]) < 2 * max(np.median(errors[1]), 1e-9)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["double_pendulum", "spring_pendulum", "chain"])
def test_compiled_series_have_the_digits_of_interpreted_ones(name: str) -> None:
    """Also where engines change over in the middle of a sweep; and of Runge-Kutta pairs."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    measures = read_measures(", ".join(f"final({c})" for c in model.coordinate_names))
    request = Request(stop=2.0 if name != "chain" else 0.3, initial={model.coordinate_names[-1]: np.linspace(0.3, 0.9, 11)})
    suited, job = model.prepared_for(measures, request, Design())
    values = job.variations.values(0, job.runs)
    results = []
    tape = load_engine(suited.scene, native=False)
    assert tape is not None
    with Batch(tape.runtime, tape.model, job.sweep) as batch:
        results.append(batch.advance(values)[0])
        native = load_engine(suited.scene, native=True)
        assert native is not None and (native.model.struct.wide_taylor or native.model.struct.wide_each)
        assert bool(native.model.struct.wide_roots) == (name == "spring_pendulum")
        tape.model.adopt(native.model)
        results.append(batch.advance(values)[0])
        assert batch.lanes.runs == 2 * job.runs
    assert np.isfinite(results[0]).all() and results[0].tobytes() == results[1].tobytes()


PUSHED = """model Pushed
  input Force F; input Real G;
  Block    cart(m = 1, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, 90[deg]), phi(start = 0.1));
  Bar      pole(m = 0.1, L = 1, a = hinge.b);
  energy potential (5 + G)*1[N/m]*cart.s^2/2;
  AppliedForce push(at = cart.center, force = {F, 0});
end Pushed;
"""


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_energies_of_one_angle_have_the_same_digits_compiled() -> None:
    """And errors of work, which are weighed by them: sines of one angle are those of eight runs, whoever makes them."""
    request = Request(stop=2.0, tolerance=1e-6, initial={"hinge.phi": np.linspace(0.1, 1, 29)},
                      inputs=(np.array([0.0, 2.0]), {"F": [0.0, 1.0], "G": [0.0, 2.0]}))
    suited, job = lag.loads(PUSHED).prepared_for(read_measures("final(hinge.phi)"), request, Design())
    told = []
    for is_native in (False, True):
        engine = load_engine(suited.scene, native=is_native)
        assert engine is not None and bool(engine.model.struct.wide_energies) == is_native
        with Batch(engine.runtime, engine.model, job.sweep) as batch:
            results, outcomes, _ = batch.advance(job.variations.values(0, job.runs))
            assert batch.lanes.runs == job.runs
        told.append(results.tobytes() + outcomes.tobytes())
    assert told[0] == told[1]


@pytest.mark.parametrize("rows", [2, 3])
@pytest.mark.parametrize("varied", [{"initial": {"hinge.phi": np.linspace(0.1, 1, 29)}},
                                    {"parameters": {"c": np.linspace(0, 2, 29)}}])
def test_starts_from_the_state_alone_are_whole_ones(varied: dict[str, dict[str, np.ndarray]], rows: int) -> None:
    """Where nothing happens, a run in a lane begins with what the one before has left there: bit by bit as in a new batch, whose
    starts are whole."""
    model = lag.loads(PUSHED.replace("Pushed\n", "Pushed\n  parameter Real c = 1;\n", 1).replace("5 + G", "5 + c + G"))
    times, forces, stiffer = np.array([0.0, 2.0, 0.7]), [0.0, -1.0, 2.0], [0.0, 3.0, 1.0]
    order = np.argsort(times[:rows])
    table = times[order], {"F": [forces[k] for k in order], "G": [stiffer[k] for k in order]}
    request = Request(stop=2.0, tolerance=1e-6, inputs=table, **varied)
    suited, job = model.prepared_for(read_measures("final(hinge.phi), final(der(cart.s))"), request, Design())
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    assert lanes.runs == job.runs and (outcomes["kind"] == 0).all()
    for k in range(0, job.runs, 8):
        results, endings, _ = advanced(suited, job, values[k : k + 8])
        assert results.tobytes() == found[k : k + 8].tobytes() and endings.tobytes() == outcomes[k : k + 8].tobytes()


def test_inputs_are_linear_in_pieces() -> None:
    """Corners, jumps and what changes energies; measures look inside steps. Against runs made alone at a smaller tolerance."""
    times = [0.0, 0.3, 0.3, 0.9, 2.0]
    table = np.array(times), {"F": [0.0, 2.0, -1.0, 1.0, 1.0], "G": [0.0, 0.0, 1.0, 1.0, 3.0]}
    outputs = "final(hinge.phi), max(cart.s), time_of_max(cart.s), mean(hinge.phi), at(0.7, der(hinge.phi)), rms(der(cart.s))"
    model, measures = lag.loads(PUSHED), read_measures(outputs)
    model = model.reporting(quantities(measures))
    found = {}
    for tolerance in (1e-8, 1e-12):
        request = Request(stop=2.0, tolerance=tolerance, initial={"hinge.phi": np.linspace(0.1, 0.9, 13)}, inputs=table)
        suited, job = model.prepared_for(measures, request, Design())
        job = replace(job, sweep=replace(job.sweep, in_lanes=tolerance == 1e-8))
        values = job.variations.values(0, job.runs)
        found[tolerance], outcomes, lanes = advanced(suited, job, values)
        assert (outcomes["kind"] == 0).all() and (outcomes["energy"] < 1e-7).all()
        assert lanes.runs == (job.runs if tolerance == 1e-8 else 0)
        if lanes.runs:
            assert advanced(suited, job, values[4:7])[0].tobytes() == found[tolerance][4:7].tobytes()
    assert found[1e-8] == pytest.approx(found[1e-12], abs=2e-7)


@pytest.mark.slow
@pytest.mark.skipif(kind_here() != "avx512" or find_compiler() is None, reason="needs a processor with registers of both widths")
def test_digits_do_not_depend_on_the_width_of_registers(pendulum: lag.Model, built: Path, tmp_path: Path) -> None:
    suited, _ = prepared(pendulum, MEASURES)
    scene, compiler, runtime = suited.scene, find_compiler(), data_folder("runtime")
    assert compiler is not None
    source = write_c(scene.name, scene.sizes, scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                     tuple(scene.tapes))
    told = 'for (int i = 0; i < 3 * RUNS; ++i) printf("%a\\n", results[i]);\n    return failed;'
    (tmp_path / "driver.c").write_text(DRIVER.replace("return failed;", told))
    (tmp_path / "scene.c").write_text(source)
    printed = set()
    for kind in ("avx2", "avx512"):
        program = str(tmp_path / kind)
        with in_registers(kind, built):
            files = [str(tmp_path / "driver.c"), str(tmp_path / "scene.c"), str(start_runtime().path())]
        flags = [*FLAGS, "-O1", *flags_of(kind), f"-I{runtime}"]
        subprocess.run([*compiler.command, *flags, *files, "-o", program, "-lm"], check=True)
        printed.add(subprocess.run([program], capture_output=True, text=True, check=True).stdout)
    assert len(printed) == 1


@pytest.mark.slow
@needs_sanitizers
def test_lanes_under_sanitizers(pendulum: lag.Model, tmp_path: Path) -> None:
    suited, _ = prepared(pendulum, MEASURES)
    scene = suited.scene
    source = write_c(scene.name, scene.sizes, scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                     tuple(scene.tapes))
    run_sanitized(tmp_path, {"driver.c": DRIVER, "scene.c": source})


PASSING = """model Passing
  input Length X;
  PointMass bob(m = 1, center(y(start = -1.5)));
  energy potential 15[N/m]*(sqrt((bob.center.x - X)^2 + bob.center.y^2) - 1[mm])^2;
end Passing;
"""


def test_a_run_that_passes_by_what_is_under_a_root_is_made_alone() -> None:
    """Forces turn so quickly where a spring has next to no length that series see nothing of it: inputs tell where that is."""
    model, measures, place = lag.loads(PASSING), read_measures("final(bob.center.x), final(bob.center.y)"), 0.5
    starts = place + np.concatenate([np.linspace(1e-4, 0.02, 5), np.linspace(1.2, 2, 7)])
    inputs = np.array([0.0, 1.0, 2.0]), {"X": [place] * 3}
    request = Request(stop=2.0, tolerance=1e-3, initial={"bob.center.x": starts}, inputs=inputs)
    suited, job = model.prepared_for(measures, request, Design())
    values = job.variations.values(0, job.runs)
    found, _, lanes = advanced(suited, job, values)
    assert lanes.runs + lanes.alone == 12 and 1 <= lanes.alone <= 5
    alone = advanced(suited, one_by_one(job), values)[0]
    are_same = [one.tobytes() == other.tobytes() for one, other in zip(found, alone, strict=True)]
    assert are_same[0] and sum(are_same) == lanes.alone and not any(are_same[5:])


def test_runs_that_miss_energies_are_as_strict_in_lanes_as_alone() -> None:
    """Narrow wells over a chain: all errors of steps have one sign, which makes steps stricter. Lanes have one tolerance."""
    blocks = "".join(f" Block b{i}(m = 1, base = world, s(start = {1 + i / 10}));" for i in range(6))
    springs = "".join(f" Spring k{i}(k = 4, stretch = b{i}.s{f' - b{i - 1}.s' if i else ''});" for i in range(6))
    wells = "".join(f" energy potential -0.001[J]/(1.01 + cos((b{i}.s - 0.3[m])/0.003[m]));" for i in range(6))
    model = lag.loads(f"model Wells World world(gravity = {{0, 0}});{blocks}{springs}{wells} end Wells;")
    model.native = False
    few, many = (model.simulate_many(outputs="final(b0.s)", parameters={"b0.m": [1.0] * runs}, tolerance=1e-3, stop=3)
                 for runs in (2, 8))
    assert many["final(b0.s)"][0] == few["final(b0.s)"][0] == pytest.approx(0.229695966, abs=0.01)
