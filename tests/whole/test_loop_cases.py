"""Known problems with closed loops and constraints, in tests/cases, and mechanisms that are hard on a solver."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import yaml
from numpy import cos, sin

import lagrangia as lag
from helpers.mechanisms import four_bar, g
from helpers.reference import Array, integrate
from whole import test_cases as trees
from whole.test_cases import FOLDER, TOLERANCES, Case, columns, scene

SINGULAR = "at 1e-12 rounding rules near the singular positions: 4e-12 to 2e-11 were seen"
UNIFORM = "evenly accelerated: exact at any tolerance"

CASES = [
    Case("atwood_machines", "HeavyPulley", constant=2e-11, tolerances=TOLERANCES[:1], why=UNIFORM),
    Case("atwood_machines", "Swinging3", constant=0.2),
    Case("atwood_machines", "Swinging15", constant=0.1),
    Case("ifto_a02_n_fourbar", "TwoFourBars", constant=4, tolerances=TOLERANCES[:4], why=SINGULAR),
    Case("ifto_a02_n_fourbar", "FortyFourBars", constant=12, tolerances=TOLERANCES[:4], why=SINGULAR, slow=True),
    Case("msl_planar_fourbar", "PlanarFourbar", constant=0.3),
    Case("parallelogram_redundant", "ThreeCranks", constant=0.08),
    Case("planarmechanics_piston_engine", "PistonEngine", constant=0.03),
    Case("rolling_disc_problems", "Trough", constant=0.04),
    Case("rolling_disc_problems", "SolidDisc", constant=2e-11, tolerances=TOLERANCES[:1], why=UNIFORM),
    Case("rolling_disc_problems", "Ring", constant=2e-11, tolerances=TOLERANCES[:1], why=UNIFORM),
    Case("rolling_disc_problems", "Sphere", constant=2e-11, tolerances=TOLERANCES[:1], why=UNIFORM),
    Case("testset_andrews_squeezer", "Andrews", constant=0.15),
]  # fmt: skip


@trees.for_every(CASES)
def test_the_finest_tolerance_gives_nine_digits(case: Case) -> None:
    trees.test_the_finest_tolerance_gives_nine_digits(case)


@trees.for_every(CASES)
def test_the_error_falls_in_step_with_the_tolerance(case: Case) -> None:
    trees.test_the_error_falls_in_step_with_the_tolerance(case)


def test_every_case_has_its_file_and_its_reason() -> None:
    known = {(case.file, case.model) for case in (*trees.CASES, *CASES)}
    stored = {file.stem: yaml.safe_load(file.read_text(encoding="utf-8")) for file in FOLDER.glob("*.yaml")}
    runs = {file: case.get("runs", ()) for file, case in stored.items()}  # some tell accelerations alone
    assert known == {(file, model) for file, models in runs.items() for model in models}
    assert all(case.why for case in CASES if (case.tolerances, case.finest) != (TOLERANCES, 1e-9))


@trees.for_every(CASES)
def test_stays_on_its_constraints(case: Case) -> None:
    """To rounding in every row, at a loose tolerance too: in m and rad, and in m/s and rad/s."""
    run = scene(case).simulate(at=columns(case)["t"], tolerance=1e-6)
    speed = max(1, *(np.abs(run[column.name]).max() for column in run.scene.rates))
    assert run.statistics.constraint_residual < 1e-12
    assert run.statistics.constraint_rate_residual < 1e-12 * speed


@pytest.mark.parametrize(
    ("model", "stop", "rows"), [("TwoFourBars", 10, 200), pytest.param("FortyFourBars", 20, 400, marks=pytest.mark.slow)]
)
def test_all_cranks_stay_parallel_through_the_singular_positions(model: str, stop: float, rows: int) -> None:
    run = lag.load(FOLDER / "ifto_a02_n_fourbar.lag", model=model).simulate(stop=stop, interval=stop / rows)
    cranks = [run[column.name] for column in run.scene.coordinates if column.name.startswith("foot[")]
    turned = cranks[0].max() - cranks[0].min()
    assert len(cranks) == (3 if model == "TwoFourBars" else 41)
    assert turned > 4 * 2 * np.pi
    assert max(np.abs(crank - cranks[0]).max() for crank in cranks) < 1e-6


# ---------------------------------------------------------------- four-bars that are hard on a solver

HARD = FOLDER / "hard_loops.lag"
LENGTHS = (0.4, 1, 0.8, 1)
TIMES = np.linspace(0, 2, 41)
DEAD_CENTRE = np.arccos((1.4**2 + 1 - 0.8**2) / (2 * 1.4))


@cache
def hard(model: str) -> lag.Model:
    return lag.load(HARD, model=model)


@cache
def on_paper(masses: tuple[float, ...], start: float = np.radians(40), rate: float = 0, gravity: float = g) -> Array:
    """The crank's angle at TIMES."""
    mechanism, _ = four_bar(masses, LENGTHS, gravity)
    return mechanism.motion(TIMES, start, rate)[0]


@pytest.mark.parametrize(
    ("model", "masses", "start", "rate"),
    [
        ("MasslessCoupler", (1, 0, 1), np.radians(40), 0),
        ("MasslessButCoupler", (0, 1, 0), np.radians(40), 0),
        ("HeavyCoupler", (1, 1e9, 1), np.radians(40), 0),
        ("LightCoupler", (1, 1e-9, 1), np.radians(40), 0),
        ("HeavyCrank", (1e9, 1, 1), np.radians(40), 0),
        ("LightCrank", (1e-9, 1, 1), np.radians(40), 0),
        ("DeadCentre", (1, 2, 1.5), DEAD_CENTRE, 3),
    ],
)
def test_masses_of_any_ratio_and_none_and_a_start_at_dead_centre(
    model: str, masses: tuple[float, ...], start: float, rate: float
) -> None:
    run = hard(model).simulate(at=TIMES, tolerance=1e-12, max_steps=5000)
    expected = on_paper(masses, start, rate)
    np.testing.assert_allclose(run["O.phi"], expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_sizes_twelve_decades_apart_in_one_scene() -> None:
    run = hard("Sizes").simulate(at=TIMES, tolerance=1e-12, max_steps=5000)
    expected = on_paper((1, 2, 1.5), rate=5, gravity=0)
    for name in ("small", "middle", "large"):
        np.testing.assert_allclose(run[f"{name}.O.phi"], expected, rtol=0, atol=1e-9 * np.abs(expected).max(), err_msg=name)


def test_guesses_choose_between_the_two_assemblies() -> None:
    """Mirror images in the line from the crank's end to the rocker's bearing."""
    one, other = (hard(model).simulate(stop=0.1, tolerance=1e-12) for model in ("FourBar", "OtherAssembly"))
    crank = LENGTHS[0] * np.exp(1j * np.radians(40))
    places = [complex(run["coupler.b.x"][0], run["coupler.b.y"][0]) for run in (one, other)]
    mirrored = 1 + (crank - 1) * np.conj((places[0] - 1) / (crank - 1))
    assert one["O.phi"][0] == other["O.phi"][0] == np.radians(40)
    assert abs(places[0] - places[1]) > 0.5
    assert abs(places[1] - mirrored) < 1e-12


def test_projection_keeps_the_order_of_the_method() -> None:
    """Fixed steps, the tolerance too loose to matter: the error falls with the eighth power of the step."""
    steps = np.array([1 / 10, 1 / 15, 1 / 20, 1 / 30, 1 / 40])
    at_one_second = on_paper((1, 2, 1.5))[20]
    assert TIMES[20] == 1
    runs = [hard("FourBar").simulate(at=[0, 1], tolerance=0.9, max_step=h) for h in steps]
    errors = [abs(run["O.phi"][-1] - at_one_second) for run in runs]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert all(run.statistics.rejected == 0 for run in runs)
    assert 7.5 < order < 12, errors


# ---------------------------------------------------------------- components that no example uses


def bead_on_parabola(t: Array) -> dict[str, Array]:
    """y = x^2:  (1 + 4 x^2) x'' + 4 x x'^2 + 2 g x = 0."""
    (x,), _ = integrate(lambda t, q, v: -(4 * q * v**2 + 2 * g * q) / (1 + 4 * q**2), [1], [0], t)
    return {"bead.center.x": x, "bead.center.y": x**2}


def bead_on_circle(t: Array) -> dict[str, Array]:
    (angle,), _ = integrate(lambda t, q, v: -g * cos(q), [0], [0], t)
    return {"bead.center.x": cos(angle), "bead.center.y": sin(angle)}


def disc_on_disc(t: Array) -> dict[str, Array]:
    """(3/2)(R + r) alpha'' = -g cos alpha, and r beta = R alpha."""
    (alpha,), _ = integrate(lambda t, q, v: -g * cos(q) / (1.5 * 1.2), [np.pi / 3], [0], t)
    return {"roll.alpha": alpha, "roll.beta": alpha / 0.2}


def belted(t: Array) -> dict[str, Array]:
    """(I1 + 4 I2) phi1'' = T and phi2 = 2 phi1."""
    angle = 1 / (0.2**2 / 2 + 4 * 0.1**2 / 2) * t**2 / 2
    return {"axle[1].phi": angle, "axle[2].phi": 2 * angle}


@pytest.mark.parametrize(
    ("model", "on_paper"),
    [("BeadOnParabola", bead_on_parabola), ("BeadOnCircle", bead_on_circle), ("DiscOnDisc", disc_on_disc), ("Belted", belted)],
)
def test_component(model: str, on_paper: Callable[[Array], dict[str, Array]]) -> None:
    t = np.linspace(0, 1, 21)
    run = lag.load(FOLDER / "constraint_library.lag", model=model).simulate(at=t, tolerance=1e-12)
    for name, values in on_paper(t).items():
        np.testing.assert_allclose(run[name], values, rtol=0, atol=1e-11 * np.abs(values).max(), err_msg=name)


def test_a_rope_over_a_pulley_is_the_swinging_atwood_machine() -> None:
    reference = columns(Case("atwood_machines", "Swinging3", constant=0, until=1))
    run = lag.load(FOLDER / "constraint_library.lag", model="Roped").simulate(at=reference["t"], tolerance=1e-12)
    np.testing.assert_allclose(run["r"], reference["r"], rtol=1e-12)
