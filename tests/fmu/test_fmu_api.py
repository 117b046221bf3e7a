"""What an importer can do with an instance beside simulating: derivatives, states to come back to, events, threads."""

import ctypes
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")

from helpers.fmus import EXAMPLES, EXPORTED, KINDS, VERSIONS, Instance, fmu_of, model_of, reported, unpacked

FILES = EXPORTED
DRIVEN = """
model Driven "A mass on a spring, pushed from outside"
  parameter Mass m = 2 "of the block"; parameter Stiffness k = 50; parameter Damping c = 0.4; parameter Frequency f = sqrt(k/m)/6;
  input Force F(start = 0) "push"; input Velocity wind;
  Block block(m = m, base = world, along = {1, 0}, s(start = 0.3));
  SpringDamper spring(k = k, c = c, stretch = block.s);
  AppliedForce push(at = block.center, force = {F - 0.3*wind + (if time < 0.5 then 0 else 2), 0});
  output Acceleration felt = der(block.v);
  output Force sum = F + k*block.s + wind*{weight};
  annotation(experiment(StopTime = 2, Tolerance = 1e-10));
end Driven;
"""


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("driven") / "driven.lag"
    path.write_text(DRIVEN.replace("{weight}", "1[N.s/m]"))
    return path


@pytest.fixture(scope="module")
def nonlinear(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same without a constant matrix: the general solver steps past communication points."""
    path = tmp_path_factory.mktemp("nonlinear") / "nonlinear.lag"
    path.write_text(DRIVEN.replace("{weight}", "1[N.s/m]").replace("Driven", "Nonlinear").replace(
        "SpringDamper spring(k = k, c = c, stretch = block.s);",
        "Spring spring(k = k, stretch = block.s + block.s^3/1[m2]); SpringDamper damper(k = 0, c = c, stretch = block.s);"))
    return path


# ---------------------------------------------------------------- derivatives


def names_of(instance: Instance) -> tuple[list[str], list[str], list[str]]:
    """States, all unknowns, all knowns but time."""
    states = instance.state_names()
    return states, instance.unknown_names(), states + instance.input_names()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_derivatives_are_those_of_differences(path: Path) -> None:
    """Along every state and input at five states of the motion, and the adjoint ones are their transposes."""
    scene = model_of(path).scene
    # Constraints that repeat each other do so on the motion alone: their derivatives hold in its close neighbourhood.
    reach, error = (2e-8, 1e-5) if model_of(path).freedom["repeated"] else (1e-4, 1e-7)
    instance = Instance(path, "3", "ModelExchange").start()
    states, unknowns, knowns = names_of(instance)
    run = model_of(path).simulate(at=np.linspace(scene.start, scene.stop, 7)[1:-1])
    rows = np.array([run[column.name] for column in (*scene.told_positions, *scene.rates)]).T
    for time, x in zip(run["time"], rows, strict=True):
        instance.fmu.setTime(time)
        instance.set_states(x)
        exact = np.array([instance.forward(unknowns, [name], [1.0]) for name in knowns]).T
        adjoint = np.array([instance.adjoint([name], knowns, [1.0]) for name in unknowns])
        size = np.abs(exact).max()
        np.testing.assert_allclose(adjoint, exact, atol=1e-11 * size, rtol=1e-9)
        for k in range(len(states)):
            h = reach * max(1e-2, abs(x[k]))
            values = []
            for step in (-2, -1, 1, 2):
                instance.set_states(x + step * h * (np.arange(len(x)) == k))
                values.append(np.array(instance.get(*unknowns)))
            numeric = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)
            scale = max(np.abs(exact[:, k]).max(), 1e-3 * size, np.abs(values[0]).max() * 1e-3)
            assert np.abs(numeric - exact[:, k]).max() < error * scale, states[k]
    instance.free()


def test_derivatives_by_parameters_inputs_and_time(nonlinear: Path) -> None:
    instance = Instance(nonlinear, "3", "CoSimulation").start({"m": 2.5})
    _states, unknowns, _knowns = names_of(instance)
    instance.step(0, 0.8)
    knowns = ["m", "k", "c", "F", "wind"]
    for name in knowns:
        exact = np.array(instance.forward(unknowns, [name], [1.0]))
        value, h = instance.get(name)[0], 1e-3
        differences = []
        for step in (-1, 1):
            instance.set({name: value + step * h})
            differences.append(np.array(instance.get(*unknowns)))
        instance.set({name: value})
        np.testing.assert_allclose((differences[1] - differences[0]) / (2 * h), exact, rtol=1e-5, atol=1e-6)
    weights = np.arange(1.0, 1 + len(unknowns))
    along = np.array([instance.forward(unknowns, [name], [1.0]) for name in knowns])
    np.testing.assert_allclose(instance.adjoint(unknowns, knowns, list(weights)), along @ weights, rtol=1e-12)
    # A state depends on itself, whatever else.
    assert instance.forward(["block.s", "block.v"], ["block.s"], [3.0]) == [3.0, 0.0]
    assert instance.fmu.getOutputDerivatives([instance.reference["block.s"]], [1]) == instance.get("block.v")
    instance.free()


def test_dependencies_are_all_that_there_are_and_no_more(driven: Path) -> None:
    import fmpy

    found = {}
    for version in VERSIONS:
        description = fmpy.read_model_description(str(fmu_of(driven, version)))
        unknowns = [*description.outputs, *description.derivatives]
        found[version] = {u.variable.name: {v.name for v in u.dependencies} for u in unknowns}
        assert found[version]["der(block.s)"] == {"block.v"}
        kinds = {u.variable.name: dict(zip((v.name for v in u.dependencies), u.dependenciesKind, strict=True)) for u in unknowns}
        assert kinds["der(block.s)"] == {"block.v": "constant"}
        assert kinds["sum"].items() >= {"block.s": "tunable", "F": "constant", "wind": "constant"}.items()
    assert found["2"]["sum"] == {"block.s", "F", "wind"}
    assert found["3"]["sum"] == {"block.s", "F", "wind", "k"}
    assert found["2"]["der(block.v)"] == {"block.s", "block.v", "F", "wind"}  # the switch at 0.5 s is a mode, not a slope in time


def test_casadi_imports_it_and_has_the_same_jacobian() -> None:
    ca = pytest.importorskip("casadi")
    path = EXAMPLES / "double_pendulum.lag"
    dae = ca.DaeBuilder("model", str(unpacked(path, "3", arrays=False)), {"debug": False})  # which knows no arrays
    states = dae.x()
    assert set(states) == {"shoulder.phi", "elbow.phi", "shoulder.w", "elbow.w"}
    f = dae.create("f", ["t", "x", "u", "p"], ["ode"])
    x = np.array([{"shoulder.phi": 0.3, "elbow.phi": -0.7, "shoulder.w": 1.1, "elbow.w": -0.4}[name] for name in states])
    arguments = [0.0, x, np.zeros(dae.nu()), [dae.get(name) for name in dae.p()]]
    jacobian = np.array(f.factory("J", f.name_in(), ["jac:ode:x"])(*arguments)).reshape(4, 4)
    model = model_of(path)
    order = [states.index(name) for name in ("shoulder.phi", "elbow.phi", "shoulder.w", "elbow.w")]
    expected = np.array(model.functions()["jacobian"](0, x[order[:2]], x[order[2:]], [], model.parameter_values()))
    np.testing.assert_allclose(jacobian[np.ix_(order, order)][2:], expected, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(jacobian[np.ix_(order, order)][:2], np.eye(4)[2:], atol=1e-15)


# ---------------------------------------------------------------- states to come back to


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_saved_state_goes_on_bit_for_bit(path: Path, version: str) -> None:
    """In the instance it was saved from, written out and read by a fresh one, and beside one that was never saved."""
    scene = model_of(path).scene
    h = (scene.stop - scene.start) / 50
    one, never, other = (Instance(path, version, "CoSimulation", name) for name in ("one", "never", "other"))
    names = [*reported(path), "energy.residual"]

    def run(instance: Instance, first: int, last: int) -> list[list[float]]:
        rows = []
        for k in range(first, last):
            instance.step(scene.start + k * h, h)
            rows.append(instance.get(*names))
        return rows

    one.start(begin=scene.start)
    never.start(begin=scene.start)
    run(one, 0, 7)
    state = one.fmu.getFMUState()
    after = run(one, 7, 12)
    run(never, 0, 7)
    assert run(never, 7, 12) == after
    one.fmu.setFMUState(state)
    assert run(one, 7, 12) == after
    written = one.fmu.serializeFMUState(state)
    read = (other.fmu.deSerializeFMUstate if version == "2" else other.fmu.deserializeFMUState)(written)
    other.fmu.setFMUState(read)
    assert run(other, 7, 12) == after
    one.fmu.freeFMUState(state)
    one.fmu.reset()
    one.start(begin=scene.start)
    run(one, 0, 7)
    assert run(one, 7, 12) == after, "reset gives a fresh instance"
    for instance in (one, never, other):
        instance.free()


def test_a_written_state_is_read_in_another_process(tmp_path: Path) -> None:
    path = EXAMPLES / "suspended_bar.lag"
    one = Instance(path, "2", "CoSimulation").start()
    one.step(0, 0.5)
    (tmp_path / "state").write_bytes(one.fmu.serializeFMUState(one.fmu.getFMUstate()))
    one.step(0.5, 0.5)
    program = f"""
import sys; sys.path.insert(0, {str(Path(__file__).parents[1])!r})
from helpers import fmus; from pathlib import Path
fmus.unpacked = lambda *a: Path({str(unpacked(path, "2"))!r}); fmus.fmu_of = fmus.unpacked
i = fmus.Instance(Path({str(path)!r}), "2", "CoSimulation")
i.fmu.setFMUstate(i.fmu.deSerializeFMUstate(Path({str(tmp_path / "state")!r}).read_bytes()))
i.step(0.5, 0.5); print(*[x.hex() for x in i.get("guide.s", "tilt.phi", "y")])
"""
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert told.split() == [x.hex() for x in one.get("guide.s", "tilt.phi", "y")]


def test_spoilt_bytes_are_refused() -> None:
    one = Instance(EXAMPLES / "pendulum.lag", "2", "CoSimulation").start()
    written = bytearray(one.fmu.serializeFMUState(one.fmu.getFMUstate()))
    for spoilt in (bytes(written[:-1]), bytes(written[:10]), bytes(written[:200]) + b"x" + bytes(written[201:]), b""):
        with pytest.raises(Exception, match="fmi2DeSerializeFMUstate"):
            one.fmu.deSerializeFMUstate(spoilt)
    one.free()


# ---------------------------------------------------------------- parameters, inputs, events, threads


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("which", ["driven", "nonlinear"])
def test_inputs_and_parameters_take_effect_at_once(which: str, version: str, request: pytest.FixtureRequest) -> None:
    """Held inputs that change at communication points are the native run's table with jumps; so are parameters' new values."""
    path = request.getfixturevalue(which)
    instance = Instance(path, version, "CoSimulation").start({"m": 3.0}, tolerance=1e-11)
    rows = []
    for k in range(20):
        instance.set({"F": float(k % 3), "wind": 0.1 * k})
        assert instance.get("F", "f") == [k % 3, pytest.approx(np.sqrt(50 / 3) / 6, rel=1e-15)]
        instance.step(0.1 * k, 0.1)
        rows.append(instance.get("block.s", "block.v"))
    times = np.repeat(0.1 * np.arange(21), 2)[1:-1]
    table = {"F": np.repeat([float(k % 3) for k in range(20)], 2), "wind": np.repeat(0.1 * np.arange(20), 2)}
    native = model_of(path).simulate(stop=2, at=0.1 * np.arange(1, 21), tolerance=1e-11, parameters={"m": 3.0},
                                     inputs=(times, table))
    np.testing.assert_allclose(rows, np.array([native["block.s"], native["block.v"]]).T, rtol=1e-8, atol=1e-9)
    before = instance.get("der(block.v)")[0]
    mass = 3.0 * before
    if version == "3":
        instance.set({"m": 6.0})
    else:
        instance.set({"m": 6.0})
    assert instance.get("der(block.v)")[0] == pytest.approx(mass / 6.0, rel=1e-12)
    instance.free()


def test_interpolated_inputs_are_exact(driven: Path) -> None:
    instance = Instance(driven, "2", "CoSimulation").start(tolerance=1e-10)
    for k in range(10):
        instance.set({"F": k * k / 10})
        instance.fmu.setRealInputDerivatives([instance.reference["F"]], [1], [((k + 1) ** 2 - k * k) / 10 / 0.2])
        instance.step(0.2 * k, 0.2)
    native = model_of(driven).simulate(stop=2, at=[2.0], inputs=(0.2 * np.arange(11), {"F": np.arange(11) ** 2 / 10}))
    assert instance.get("block.s")[0] == pytest.approx(native["block.s"][0], rel=1e-12)
    instance.free()


@pytest.mark.parametrize("version", VERSIONS)
def test_linear_scenes_are_exact_whatever_the_tolerance(version: str, driven: Path) -> None:
    """Steps of any length, inputs held, a parameter that changes in between."""
    instance = Instance(driven, version, "CoSimulation").start(tolerance=1e-2)
    ends, values, rows = np.cumsum([0.3, 0.001, 0.45, 0.249, 0.7, 0.3]), [1.0, -2.0, 0.5, 3.0, 0.0, 1.0], []
    begins = [0.0, *ends[:-1]]
    for begin, end, value in zip(begins, ends, values, strict=True):
        instance.set({"F": value})
        instance.step(begin, end - begin)
        rows.append(instance.get("block.s", "block.v"))
    table = {"F": np.repeat(values, 2)}
    native = model_of(driven).simulate(stop=ends[-1], at=ends, solver="linear",
                                       inputs=(np.ravel(np.column_stack([begins, ends])), table))
    np.testing.assert_allclose(rows, np.array([native["block.s"], native["block.v"]]).T, rtol=1e-12, atol=1e-13)
    instance.free()


def test_a_step_returns_early_at_a_time_event(nonlinear: Path) -> None:
    instance = Instance(nonlinear, "3", "CoSimulation", eventModeUsed=True, earlyReturnAllowed=True).start()
    assert instance.update()[4:] == (True, 0.5)
    instance.fmu.enterStepMode()
    is_event, terminates, is_early, reached = instance.step(0, 0.8)
    assert (is_event, terminates, is_early, reached) == (True, False, True, 0.5)
    before = instance.get("der(block.v)")[0]
    instance.fmu.enterEventMode()
    assert instance.update()[4] is False
    assert instance.get("der(block.v)")[0] == pytest.approx(before + 2 / 2, rel=1e-12), "2 N on 2 kg"
    instance.fmu.enterStepMode()
    assert instance.step(0.5, 0.3)[2:] == (False, 0.8)
    native = model_of(nonlinear).simulate(stop=2, at=[0.8])
    assert instance.get("block.s")[0] == pytest.approx(native["block.s"][0], rel=1e-7)
    instance.free()


def test_eight_instances_in_eight_threads_are_one() -> None:
    path = EXAMPLES / "double_pendulum.lag"

    def run(name: str) -> list[float]:
        instance = Instance(path, "2", "CoSimulation", name).start()
        for k in range(200):
            instance.step(0.01 * k, 0.01)
        found = instance.get("shoulder.phi", "elbow.phi", "energy.residual")
        instance.free()
        return found

    expected = run("alone")
    with ThreadPoolExecutor(8) as pool:
        assert all(found == expected for found in pool.map(run, "abcdefgh"))


Update = Callable[[float], bool]


def test_intermediate_updates_see_each_step_and_may_end_it() -> None:
    from fmpy import fmi3

    path = EXAMPLES / "double_pendulum.lag"
    instance = Instance(path, "3", "CoSimulation")
    seen: list[float] = []
    instance.fmu.fmi3FreeInstance(instance.fmu.component)
    token = (instance.description.instantiationToken or instance.description.guid).encode()

    def update(environment: object, t: float, to_set: bool, may_get: bool, is_finished: bool, may_return: bool,
               wants_return: "ctypes._Pointer", early: "ctypes._Pointer") -> None:
        seen.append(t)
        assert may_get and is_finished and may_return and not to_set
        if t > 0.3:
            wants_return[0] = True
            early[0] = t

    callback = fmi3.fmi3IntermediateUpdateCallback(update)
    log = fmi3.fmi3LogMessageCallback(lambda *rest: None)
    instance.fmu.component = instance.fmu.fmi3InstantiateCoSimulation(
        b"one", token, bytes(unpacked(path, "3") / "resources"), False, False, False, True, None, 0, None, log, callback)
    instance.start()
    _event, _terminates, is_early, reached = instance.step(0, 1.0)
    assert is_early and 0.3 < reached < 1 and seen == sorted(seen) and seen[-1] == reached
    assert instance.get("time") == [reached]
    instance.free()


@pytest.mark.parametrize("kind", KINDS)
def test_the_energy_account_is_among_the_variables(kind: str) -> None:
    from helpers.fmus import simulated

    path = EXAMPLES / "suspended_bar.lag"
    names = [f"energy.{part}" for part in ("kinetic", "potential", "total", "dissipated", "work", "residual")]
    found = simulated(path, "2", kind, names)
    native = model_of(path).simulate(at=found["time"]).energy
    size = np.abs(native.total).max()
    expected = (native.kinetic, native.potential, native.total, native.dissipated, native.work)
    for name, values in zip(names, expected, strict=False):
        np.testing.assert_allclose(found[name], values, atol=1e-5 * size)
    assert np.abs(found["energy.residual"]).max() < 1e-5 * size
