"""The Python interface: lag.load, simulate, the trajectory, and the CasADi functions of every example."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from matplotlib.image import imread
from scipy.linalg import null_space

import lagrangia as lag
from lagrangia.run.request import Experiment

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "models" / "examples").glob("*.lag"))
FOLDER = EXAMPLES[0].parent
SAMPLED = ("crane", "satellite", "top", "rolling_disc_space", "spatial_four_bar", "hexapod")
# of whose accelerations q and v alone do not tell: held values, attitudes
STATES = 20
CONSTRAINED = {"Phi", "J", "bias", "lambda"}

Scene = Callable[[str], lag.Model]


def load(example: str, **structural: object) -> lag.Model:
    return lag.load(FOLDER / f"{example}.lag", **structural)


# ---------------------------------------------------------------- runs


def test_the_example_of_the_issue() -> None:
    model = load("chain", n=20)
    run = model.simulate(stop=1, tolerance=1e-10, parameters={"link[1].m": 2.0})
    assert model.coordinate_names == tuple(f"hinge[{k}].phi" for k in range(1, 21))
    for values in (run.time, run["hinge[1].phi"], run.energy.total):
        assert values.dtype == np.float64
        assert values.shape == (501,)
    assert run["hinge[1].phi"][0] == 1
    assert np.ptp(run.energy.total) < 1e-8 * np.abs(run.energy.total).max()


def test_a_model_is_loaded_from_its_text() -> None:
    text = "model A Block b(m = 1, base = world, along = {1, 0}, v(start = 2)); end A;"
    model = lag.loads(text)
    assert model.simulate(stop=3)["b.s"][-1] == pytest.approx(6)
    assert lag.loads(text).is_cached
    with pytest.raises(lag.Error, match="did you mean 'Block'"):
        lag.loads(text.replace("Block", "Blok"))
    with pytest.raises(lag.Error, match="not supported yet: imports"):
        lag.loads('import "other.lag";' + text)
    with pytest.raises(lag.Error, match="a scene is a text"):
        lag.loads(Path("x.lag"))  # type: ignore[arg-type]


def test_a_scene_is_remembered_by_what_the_cache_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    text, file = "model A Block b(m = 1, base = world, along = {1, 0}, v(start = 2)); end A;", tmp_path / "a.lag"
    file.write_text(text, encoding="utf-8")
    lag.load(file)
    first, again = lag.load(file), lag.load(file)
    assert first.is_cached and again.scene is first.scene
    for kept in (tmp_path / "cache" / "scenes").iterdir():
        kept.write_bytes(b"damaged")
    assert not lag.load(file).is_cached
    file.write_text(text.replace("= 2", "= 3"), encoding="utf-8")
    assert [lag.load(file).simulate(stop=1)["b.s"][-1] for _ in range(2)] == pytest.approx([3, 3])


def test_a_sweep_is_a_table_in_a_notebook() -> None:
    scene = EXAMPLES[0].with_name("quarter_car.lag")
    sweep = lag.load(scene).simulate_many(parameters={"m1": range(1, 31)}, outputs=["max(car.s)"])
    shown = sweep._repr_html_()
    assert shown.count("<tr>") == 21 and "<th>max(car.s) [m]</th>" in shown and "20 of 30 runs" in shown


def test_names_of_a_trajectory() -> None:
    run = load("disc_and_block").simulate(stop=1)
    assert run.names[:3] == ["time", "block.s", "axle.phi"]
    np.testing.assert_array_equal(run["time"], run.time)
    np.testing.assert_array_equal(run["der(block.s)"], run["block.v"])
    np.testing.assert_allclose(run["s2.stretch"], 0.2 * run["axle.phi"] - run["block.s"], atol=1e-15)
    with pytest.raises(lag.LagError, match=r"axle.phi|axel"):
        run["axel.phi"]


def test_a_run_says_in_a_line_what_it_is() -> None:
    said = repr(load("double_pendulum").simulate(stop=1))
    assert said.startswith("<DoublePendulum: 501 rows, t = 0 to 1 s: ")
    assert len(said) < 200 and "\n" not in said


def test_rates_are_shown_per_second_of_what_is_shown() -> None:
    """A coordinate that is shown in its own unit has a rate that is shown in its own unit."""
    shown = {column.name: (column.unit, column.display_unit) for column in load("cart_pole").scene.rates}
    assert set(shown.values()) == {("m/s", ""), ("rad/s", "deg/s")}


def test_a_quantity_that_was_not_asked_for_is_what_it_would_have_been() -> None:
    """Accelerations too, and vectors as arrays of shape (rows, 2)."""
    late = load("double_pendulum").simulate(stop=1)
    early = lag.Model(FOLDER / "double_pendulum.lag", outputs=("der(elbow.w)", "elbow.b.r")).simulate(stop=1)
    np.testing.assert_allclose(late["der(elbow.w)"], early["der(elbow.w)"], rtol=1e-11)
    assert late["elbow.b.r"].shape == (501, 2)
    np.testing.assert_allclose(late["elbow.b.r"][:, 1], early["elbow.b.r[2]"], rtol=1e-11)


def test_tables_have_all_digits(tmp_path: Path) -> None:
    run = load("pendulum").simulate(stop=1, interval=0.25)
    run.to_csv(tmp_path / "run.csv")
    kept = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True, deletechars="")
    np.testing.assert_array_equal(kept["hinge.phi"], run["hinge.phi"])
    frame = pytest.importorskip("pandas") and run.to_pandas()
    assert list(frame.columns) == run.names[1:]
    assert frame.index.name == "time"
    np.testing.assert_array_equal(frame["hinge.phi"], run["hinge.phi"])
    np.testing.assert_array_equal(frame.index, [0, 0.25, 0.5, 0.75, 1])


def test_a_picture_shows_the_curve(tmp_path: Path) -> None:
    run = load("pendulum").simulate(stop=3)
    figure = run.plot("hinge.phi", path=tmp_path / "phi.png")
    assert imread(tmp_path / "phi.png").std() > 0.05
    (line,) = figure.axes[0].lines
    np.testing.assert_allclose(line.get_ydata(), np.degrees(run["hinge.phi"]))
    assert "deg" in figure.axes[0].get_ylabel()
    assert len(run.plot().axes) == 1
    assert len(run.plot("hinge.phi", "bob.center.x").axes) == 2, "a panel a unit"


def test_the_energy_account_of_a_driven_and_damped_scene() -> None:
    run = load("suspended_bar").simulate(tolerance=1e-10)
    energy = run.energy
    assert energy.dissipated[-1] > 1
    assert np.all(np.diff(energy.dissipated) >= 0)
    np.testing.assert_allclose(energy.total - energy.total[0], energy.work - energy.dissipated, atol=1e-8)
    assert np.abs(energy.residual).max() < 1e-8


def test_inputs_by_constant_and_by_table(scene: Scene) -> None:
    """s'' = F/2: a constant, and a ramp F = 6 t up to 1 s, then nothing."""
    model = scene("model M input Force F; Block b(m = 2, base = world); AppliedForce p(at = b.center, force = {F, 0}); end M;")
    assert model.simulate(at=[2], inputs={"F": 3})["b.s"][-1] == pytest.approx(3, rel=1e-12)
    run = model.simulate(at=[0, 1, 2], inputs=([0, 1, 1, 2], {"F": [0, 6, 0, 0]}), tolerance=1e-12)
    np.testing.assert_allclose(run["b.s"], [0, 0.5, 2], atol=1e-12)


def test_a_run_that_fails_keeps_what_it_computed(scene: Scene) -> None:
    """s'' = 6 s^2 from s = 1, s' = 2 is s = 1/(1 - t)^2, which ends at t = 1."""
    model = scene("""model M Block b(m = 1, base = world, s(start = 1), v(start = 2));
        GeneralSpring pull(stretch = b.s, V = -2*b.s^3); annotation(experiment(StopTime = 2)); end M;""")
    with pytest.raises(lag.RunError, match="cannot be continued") as caught:
        model.simulate(tolerance=1e-10, interval=0.03)
    run = caught.value.trajectory
    assert 0.9 < run.time[-1] < 1
    early = run.time < 0.9
    np.testing.assert_allclose(run["b.s"][early], 1 / (1 - run.time[early]) ** 2, rtol=1e-7)


# ---------------------------------------------------------------- parameters


def test_dependents_follow_and_given_values_stay() -> None:
    """I = md r^2/2 follows md, unless I itself is given."""
    model = load("disc_and_block")
    place = model.parameter_names.index
    names = [place("md"), place("I"), place("disc.I")]
    assert model.parameter_values()[names].tolist() == pytest.approx([5, 0.1, 0.1])
    assert model.parameter_values({"md": 10})[names].tolist() == pytest.approx([10, 0.2, 0.2])
    assert model.parameter_values({"md": 10, "I": 0.7})[names].tolist() == pytest.approx([10, 0.7, 0.7])
    assert model.parameter_values({"disc.I": 0.3})[names].tolist() == pytest.approx([5, 0.1, 0.3])


DEALT = """model Dealt
  parameter Length L[3] = {1, 2, 3}, P[3, 2] = {{0, 0}, {1, 2}, {3, 4}};
  parameter Real rho(unit = "kg/m") = 2;
  PointMass p[3](m = rho*L + 2*rho*L/4, center(r(start = -2*P)));
  PointMass q[2](m = (if rho > 1 then rho*L[2:3] else rho*L[1:2]), center(x(start = rotate({1, 2}, pi/2))));
  Spring s[5](each k = 1, a = {p[1].center, p[2].center, p[3].center, q[1].center, q[2].center}, each b = world);
end Dealt;
"""


def test_what_is_computed_of_arrays_is_dealt_out_to_the_elements(tmp_path: Path) -> None:
    (tmp_path / "dealt.lag").write_text(DEALT)
    model = lag.load(tmp_path / "dealt.lag")
    masses = dict(zip(model.parameter_names, model.parameter_values({"L[2]": 4}), strict=True))
    found = [masses[f"{name}.m"] for name in ("p[1]", "p[2]", "p[3]", "q[1]", "q[2]")]
    assert found == pytest.approx([3, 12, 9, 8, 6])
    run = model.simulate(at=[0])
    starts = [run[f"{name}"][0] for name in ("p[2].center.x", "p[3].center.y", "q[1].center.x", "q[2].center.x")]
    assert starts == pytest.approx([-2, -8, -2, 1])


def test_a_run_uses_the_dependents() -> None:
    model = load("disc_and_block")
    both = model.simulate(stop=2, tolerance=1e-12, parameters={"md": 10, "I": 0.2})["axle.phi"]
    follows = model.simulate(stop=2, tolerance=1e-12, parameters={"md": 10})["axle.phi"]
    stays = model.simulate(stop=2, tolerance=1e-12, parameters={"md": 10, "I": 0.1})["axle.phi"]
    np.testing.assert_allclose(follows, both, rtol=1e-9)
    assert np.abs(stays - both).max() > 1e-3 * np.abs(both).max()


def test_one_model_serves_runs_with_other_numbers() -> None:
    model = load("pendulum")
    first = model.simulate(at=[1])["hinge.phi"][0]
    other = model.simulate(at=[1], parameters={"L": 3}, initial={"hinge.phi": 0.2})["hinge.phi"][0]
    assert model.simulate(at=[1])["hinge.phi"][0] == first != other


# ---------------------------------------------------------------- functions


class States:
    """States of a scene, random ones or, on its constraints, those of a run: t, q, v, u as columns, and its parameters."""

    def __init__(self, model: lag.Model) -> None:
        random = np.random.default_rng(7)
        n = model.scene.n
        self.t = random.uniform(0, 3, (1, STATES))
        self.q, self.v = random.normal(size=(2, n, STATES))
        self.u = random.normal(size=(len(model.scene.inputs), STATES))
        self.p = model.parameter_values().reshape(-1, 1)
        self.mechanical = np.array([column in model.scene.moving for column in model.scene.coordinates])
        self.repeats = bool(model.freedom["repeated"])
        if model.scene.sizes["n_multipliers"]:
            run = model.simulate(at=np.linspace(model.scene.start, model.scene.stop, STATES), tolerance=1e-10)
            self.t = run.time.reshape(1, -1)
            self.q, self.v = (np.array([run[c.name] for c in names]) for names in (model.scene.coordinates, model.scene.rates))

    def __call__(self, function: ca.Function) -> np.ndarray:
        """Values of the first output, of shape (rows, columns, STATES)."""
        values = [np.array(function(self.t[:, k], self.q[:, k], self.v[:, k], self.u[:, k], self.p)) for k in range(STATES)]
        return np.stack(values, axis=-1)


@pytest.fixture(scope="module", params=[path for path in EXAMPLES if path.stem not in SAMPLED], ids=lambda path: path.stem)
def example(request: pytest.FixtureRequest) -> tuple[dict[str, ca.Function], States]:
    model = lag.load(request.param)
    return model.functions(), States(model)


def test_functions_have_named_inputs_and_outputs(example: tuple[dict[str, ca.Function], States]) -> None:
    functions, _ = example
    assert set(functions) - CONSTRAINED == {"M", "h", "rhs", "energies", "outputs", "jacobian"}
    assert set(functions) & CONSTRAINED in (set(), CONSTRAINED)
    for function in functions.values():
        assert function.name_in() == ["t", "q", "v", "u", "p"]
    assert functions["energies"].name_out() == ["T", "V", "D"]


def test_the_mass_matrix_is_symmetric_and_positive(example: tuple[dict[str, ca.Function], States]) -> None:
    functions, states = example
    M = states(functions["M"]).transpose(2, 0, 1)
    np.testing.assert_allclose(M, M.transpose(0, 2, 1), rtol=0, atol=1e-14 * np.abs(M).max())
    if "J" in functions:
        ways = [null_space(J, rcond=1e-9) for J in states(functions["J"]).transpose(2, 0, 1)]
        M = [way.T @ each @ way for way, each in zip(ways, M, strict=True)]
    assert min(np.linalg.eigvalsh(each).min() for each in M) > 0, "on the motions that the constraints allow"


def test_the_accelerations_balance_the_forces(example: tuple[dict[str, ca.Function], States]) -> None:
    """M a + h + J^T lambda = 0."""
    functions, states = example
    M, h, a = (states(functions[name]) for name in ("M", "h", "rhs"))
    size = np.abs(M).max() * np.abs(a).max() + np.abs(h).max()
    assert size > 0
    force = np.einsum("ijk,jlk->ilk", M, a) + h
    if "J" in functions:
        J, multipliers = states(functions["J"]), states(functions["lambda"])
        force += np.einsum("jik,jlk->ilk", J, multipliers)
        size += np.abs(J).max() * np.abs(multipliers).max()
    np.testing.assert_allclose(force, 0, atol=1e-12 * size)


def test_the_accelerations_keep_the_constraints(example: tuple[dict[str, ca.Function], States]) -> None:
    """J a + bias = 0, and Phi = 0 along a run."""
    functions, states = example
    if "J" not in functions:
        pytest.skip("no constraint is left")
    J, bias, a = (states(functions[name]) for name in ("J", "bias", "rhs"))
    size = np.abs(J).max() * np.abs(a).max() + np.abs(bias).max()
    np.testing.assert_allclose(np.einsum("ijk,jlk->ilk", J, a) + bias, 0, atol=1e-9 * size)
    np.testing.assert_allclose(states(functions["Phi"]), 0, atol=1e-12)


def test_the_kinetic_energy_is_that_of_the_mass_matrix(example: tuple[dict[str, ca.Function], States]) -> None:
    """T(v) + T(-v) - 2 T(0) = v . M v, also where supports move with time; first-order states have none."""
    functions, states = example
    T = [states(functions["energies"].slice("T", range(5), [0]))]
    ahead = states.v
    for v in (-ahead, 0 * ahead):
        states.v = v
        T.append(states(functions["energies"].slice("T", range(5), [0])))
    states.v = ahead
    moving = ahead * states.mechanical[:, None]
    twice = np.einsum("ik,ijk,jk->k", moving, states(functions["M"]), moving)
    np.testing.assert_allclose((T[0] + T[1] - 2 * T[2]).ravel(), twice, rtol=1e-11)


def test_the_jacobian_is_the_slope_of_the_accelerations(example: tuple[dict[str, ca.Function], States]) -> None:
    """Against central differences of order 4."""
    functions, states = example
    if "J" in functions and states.repeats:
        pytest.skip("off the constraints, where the differences lead, rows that repeat each other contradict each other")
    exact = states(functions["jacobian"])
    y = np.vstack([states.q, states.v])
    step = 1e-3
    for column, at in enumerate(np.eye(len(y))[:, :, None]):
        slope = 0
        for weight, reach in ((8, 1), (-8, -1), (-1, 2), (1, -2)):
            states.q, states.v = np.split(y + reach * step * at, 2)
            slope = slope + weight * states(functions["rhs"])[:, 0] / (12 * step)
        np.testing.assert_allclose(slope, exact[:, column], rtol=0, atol=1e-7 * np.abs(exact).max())
    states.q, states.v = np.split(y, 2)


@pytest.mark.parametrize(("span", "interval", "rows"), [
    (1.0, 0.001, 1001), (10.0, 0.01, 1001), (100.0, 0.1, 1001), (1.0, 1e-4, 10001), (0.3, 0.1, 4), (3.0, 1e-3, 3001),
    (1.0, 0.3, 5), (1.0, 2.0, 2), (1000.1, 1.0, 1002), (1.0, 1 / 3, 4), (7e5, 0.7, 1000001), (1.0005, 1e-3, 1002),
])
def test_rows_are_an_interval_apart_and_the_last_is_the_stop(span: float, interval: float, rows: int) -> None:
    experiment = Experiment(2.0, 2.0 + span, 1e-8, interval)
    times = np.concatenate([np.array(portion) for portion in experiment.times()])
    assert len(times) == experiment.count() == rows
    assert times[-1] == 2.0 + span
    gaps = np.diff(times)
    assert gaps.min() > 1e-4 * interval
    assert gaps[:-1] == pytest.approx(interval, rel=1e-6)


# ---------------------------------------------------------------- what cannot be meant

WRONG_RUNS = [{"at": 5}, {"at": "abc"}, {"at": [0, "1"]}, {"inputs": 5}, {"inputs": {"F": "1"}}, {"inputs": {"F": [1, 2]}},
              {"inputs": ([0, 1], [1, 2])}, {"inputs": (0, {"F": [1]})}, {"inputs": ([0, 1],)}]
WRONG_RESPONSES = [{"span": (0, 1)}, {"span": (10, 1)}, {"span": (math.nan, 1)}, {"span": (1,)}, {"span": 5}, {"points": -5},
                   {"points": 0}, {"points": 2.5}, {"frequencies": 1.0}, {"frequencies": [1e300]}, {"frequencies": [math.nan]},
                   {"frequencies": [-1]}, {"frequencies": "12"}, {"time": "a"}, {"excitations": 5}, {"outputs": [5]}]


@pytest.mark.parametrize("given", WRONG_RUNS, ids=str)
def test_what_no_run_can_have_is_told(given: dict[str, Any]) -> None:
    model = load("cart_pole")
    with pytest.raises(lag.LagError, match=r"L070[23]"):
        model.simulate(**given)
    if "inputs" in given:
        with pytest.raises(lag.LagError, match=r"L070[23]"):
            model.simulate_many(**given, parameters={"M": [1, 2]})


@pytest.mark.parametrize("given", WRONG_RESPONSES, ids=str)
def test_what_no_response_can_have_is_told(given: dict[str, Any]) -> None:
    with pytest.raises(lag.LagError, match="L0702"):
        load("vibration_absorber").response(**given)


@pytest.mark.parametrize("starts", [0, 1.5, -1, "2", 10**6])
def test_equilibria_are_searched_from_a_number_of_places(starts: Any) -> None:
    with pytest.raises(lag.LagError, match="number of starts"):
        load("vibration_absorber").equilibrium(starts=starts)


def test_a_name_alone_is_one_name() -> None:
    linear = load("quarter_car").linearize(excitations="road.y", outputs="car.s")
    assert (linear.excitations, linear.outputs) == (("road.y",), ("car.s",))


WRONG_FMUS = [{"fmi": 4}, {"kind": 5}, {"platforms": 5}, {"info": {"zz": "x"}}, {"info": {"author": 5}}]


@pytest.mark.parametrize("given", WRONG_FMUS, ids=str)
def test_what_no_fmu_can_have_is_told(given: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(lag.LagError, match="L0706"):
        load("pendulum").export_fmu(tmp_path / "x.fmu", **given)


def test_the_version_of_fmi_may_be_a_number(tmp_path: Path) -> None:
    assert load("pendulum").export_fmu(tmp_path / "x.fmu", fmi=3, platforms="") == [tmp_path / "x.fmu"]


def test_a_quantity_is_asked_for_by_its_name() -> None:
    with pytest.raises(lag.LagError, match="L0701"):
        load("pendulum").simulate(stop=0.1)[5]  # type: ignore[index]


def test_a_structural_parameter_needs_a_value() -> None:
    with pytest.raises(lag.LagError, match="value given for n must be a number"):
        load("chain", n=None)


def test_a_mechanism_without_any_mass_is_told() -> None:
    """Nothing determines its motion; it was said to be at rest."""
    massless = {"crank.m": 0.0, "coupler.m": 0.0, "rocker.m": 0.0}
    with pytest.raises(lag.LagError, match=r"L0504.*moves no mass"):
        lag.load(EXAMPLES[0].with_name("four_bar.lag")).simulate(stop=1, parameters=massless)


def test_turns_taken_for_radians_are_warned_of(tmp_path: Path) -> None:
    """SI takes Hz and rad/s for the same unit, and rpm for radians a second."""
    file = tmp_path / "scene.lag"
    file.write_text("""model M
      parameter AngularFrequency a = 50[Hz], b = 3000[rpm], c = 2*pi*50[Hz]; parameter Frequency f = 3000[rpm], g = 50[Hz];
      Block m(m = 1, base = world); AppliedForce x(at = m.center, force = {1[N]*sin((a + b + c + f + g)*time), 0}); end M;""")
    first, second = lag.load(file).warnings
    assert "'a' is in rad/s: 50[Hz] is taken for that many radians a second" in first
    assert "'f' is in Hz: 3000[rpm] is taken in radians a second, 6.28 times its turns" in second


@pytest.mark.filterwarnings("error")
def test_a_masked_number_is_refused_without_words_of_numpy() -> None:
    """It became nan, with a warning of NumPy's on the way."""
    for masked in (np.ma.masked, np.ma.array(3.0, mask=True)):
        with pytest.raises(lag.LagError, match="must be a number, and it is masked"):
            load("pendulum").simulate(stop=0.1, parameters={"bob.m": masked})
