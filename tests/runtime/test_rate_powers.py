"""Friction with powers, roots and logarithms of a speed comes to rest and turns back, whatever their exponents are."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
Law = Callable[[float], float]


def sliding(scene: Write, force: str, more: str = "") -> lag.Model:
    return scene(f"""model M World world(gravity = {{0, 0}}); Block b(m = 1, base = world, v(start = 1)); {more}
      energy work -({force})*1[N] on b.s; end M;""")


def slides(law: Law) -> float:
    """x = integral of v/F(v)."""
    return float(quad(lambda v: v / law(v), 0, 1, epsabs=1e-13, epsrel=1e-13, limit=200)[0])


def comes_to_rest(model: lag.Model, way: float, **given: float) -> None:
    for solver in ("auto", "erk5", "implicit", "pirk"):
        for tolerance in (1e-4, 1e-9):
            run = model.simulate(at=[0.0, 5.0], tolerance=tolerance, solver=solver, max_steps=500, parameters=given)
            assert run["b.s"][-1] == pytest.approx(way, abs=5 * tolerance), (solver, tolerance, given)
            assert run["b.v"][-1] == 0


def test_the_exponent_of_stribeck_is_a_parameter(scene: Write) -> None:
    """Runs ended at the limit of steps at their first stop, unless it was whole."""
    model = sliding(scene, "(1 + exp(-(abs(b.v)/v0)^alpha))*sign(b.v)", "parameter Velocity v0 = 0.3; parameter Real alpha = 2;")
    for alpha in (0.0, 0.1, 0.5, 1.0, 1.5, 2.0, 3.0):
        comes_to_rest(model, slides(lambda v, a=alpha: 1 + np.exp(-((v / 0.3)**a))), alpha=alpha)


@pytest.mark.parametrize("drag", ["b.v*abs(b.v/1[m/s])^(n - 1)*1[s/m]", "b.v/abs(b.v/1[m/s])^(1 - n)*1[s/m]",
                                  "abs(b.v/1[m/s])^n*sign(b.v)"])
def test_the_exponent_of_drag_is_a_parameter(drag: str, scene: Write) -> None:
    model = sliding(scene, f"{drag} + 0.5*sign(b.v)", "parameter Real n = 1;")
    for n in (0.3, 1.0, 1.5, 2.0):
        comes_to_rest(model, slides(lambda v, n=n: 0.5 + v**n), n=n)


LAWS: dict[str, Law] = {
    "sqrt(2*abs(w) + 3*abs(w))": lambda v: np.sqrt(5 * v), "sqrt(2*abs(w) + w^2)": lambda v: np.sqrt(2 * v + v**2),
    "sqrt(max(w, -w))": np.sqrt, "exp(1.5*log(abs(w)))": lambda v: v**1.5, "sqrt(sqrt(abs(w)))": lambda v: v**0.25,
    "w*abs(w)^(-0.5)*sign(w)": np.sqrt, "abs(w)^(1.5 + 0*time/1[s])": lambda v: v**1.5,
}


@pytest.mark.parametrize("law", LAWS)
def test_roots_of_what_is_nothing_at_rest(law: str, scene: Write) -> None:
    comes_to_rest(sliding(scene, f"(0.5 + {law})*sign(w)", "Real w = b.v/1[m/s];"), slides(lambda v: 0.5 + LAWS[law](v)))


@pytest.mark.parametrize(("law", "places"), [
    ("(w^2)^0.25", [0.545264392, 0.148616967, 0.286450435]),
    ("sqrt(2*w^2 + 3*w^2)", [0.461311342, 0.243981761, 0.305607745]),
    ("exp(0.3*log(abs(w)))", [0.548969974, 0.14639514, 0.300001432]),
    ("(abs(w) + w^2)^0.5", [0.512374616, 0.192675752, 0.312840792]),
])
def test_even_powers_bend_where_a_rate_turns(law: str, places: list[float], scene: Write) -> None:
    """Series went on with sqrt(5 v^2) as if it were 2.2 v (auto 127 to 3 200 tolerances off, in silence), and implicit steps had
    slopes beyond v = 0 (50 to 700 tolerances off); x by SciPy."""
    model = sliding(scene, f"(0.5 + {law})*sign(w)", "Real w = b.v/1[m/s]; Spring k(k = 30, stretch = b.s - 0.3);")
    for solver in ("auto", "implicit"):
        for tolerance in (1e-4, 1e-6, 1e-9):
            run = model.simulate(at=[0.5, 1.0, 5.0], solver=solver, tolerance=tolerance)
            assert run["b.s"] == pytest.approx(places, abs=5 * tolerance), (solver, tolerance)


def test_a_rate_and_its_multiple_turn_together(scene: Write) -> None:
    """abs(v/vs) and sign(v) had two switches: 0.225 for 0.250 at 1e-4 by implicit steps, in silence; x by SciPy."""
    model = sliding(scene, "(1 + exp(-sqrt(abs(b.v/vs))))*sign(b.v)",
                    "parameter Velocity vs = 0.2; Spring k(k = 30, stretch = b.s - 0.3);")
    for solver in ("auto", "implicit"):
        for tolerance in (1e-4, 1e-6):
            for vs in (0.2, -0.2):
                run = model.simulate(at=[2.0, 5.0], solver=solver, tolerance=tolerance, parameters={"vs": vs})
                assert run["b.s"] == pytest.approx([0.29594748, 0.25000661], abs=tolerance)


def test_a_power_of_a_rate_has_no_series(scene: Write) -> None:
    """Taylor series of |v|^n v were 1000 tolerances off in silence where n was a parameter, 0.5 here."""
    model = sliding(scene, "b.v*abs(b.v/1[m/s])^n*1[s/m]", "parameter Real n = 0.5; Spring k(k = 30, stretch = b.s - 0.3);")
    with pytest.raises(lag.LagError, match="taylor"):
        model.simulate(at=[5.0], solver="taylor", tolerance=1e-9)


FACTORS: dict[str, Callable[[float, float], float]] = {  # of v > 0 and c
    "0.4*sign(w) + 0.3*sign(c*w)*sign(c)": lambda v, c: 0.4 + 0.3 * abs(np.sign(c)),
    "0.4*sign(w) + 0.1*(if c*w > 0 then 1 else -1)": lambda v, c: 0.3 if c == 0 else 0.5,
    "0.5*sign(w) + (1 + sqrt(abs(c*w)))*c*w/abs(c*w)*sign(c)": lambda v, c: 1.5 + np.sqrt(abs(c) * v),
    "(1 + exp(-abs(c*w)))*sign(w)": lambda v, c: 1 + np.exp(-abs(c) * v),
    "0.4*sign(w) + 0.3*sign(c*w + 3*w)*sign(c + 3)": lambda v, c: 0.4 + 0.3 * abs(np.sign(c + 3)),
    "0.4*sign(w) + 0.1*(if 2*w - c*w > 0 then 1 else -1)": lambda v, c: 0.5 if c < 2 else 0.3,
}


@pytest.mark.parametrize("law", FACTORS)
def test_factors_that_are_parameters(law: str, scene: Write) -> None:
    """sign(c v) counted as 1 where c is 0 (0.714 for 1.25 m), |c v| had a switch of its own, and c v/|c v| had no
    value at rest."""
    model = sliding(scene, law, "Real w = b.v/1[m/s]; parameter Real c = 2;")
    for c in (2.0, -3.0, 0.0):
        if (c or "/" not in law) and (c >= 0 or "if" not in law):
            comes_to_rest(model, slides(lambda v, c=c: FACTORS[law](v, c)), c=c)


def test_a_factor_that_events_set_to_0(scene: Write) -> None:
    """v falls by 0.5 m/s^2 until t = 0.5, stays, and falls again from t = 1 on."""
    model = sliding(scene, "0.5*sign(n*b.v)", """discrete Real n(start = 2);
      equation when time > 0.5 then n = 0; elsewhen time > 1 then n = 0.5; end when;""")
    for solver in ("auto", "erk5", "implicit"):
        run = model.simulate(at=[0.0, 0.5, 1.0, 5.0], solver=solver, tolerance=1e-6)
        assert run["b.s"][1:] == pytest.approx([0.4375, 0.8125, 1.375], abs=1e-5), solver
