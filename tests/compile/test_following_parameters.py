"""Parameters of model.functions() and of exports: what is bound to declared ones follows them, in values and in derivatives."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.symbolic_scenes import EXAMPLES
from lagrangia.command.cli import main

Write = Callable[[str], lag.Model]

BOUND = """model Bound
  parameter Mass m = 2; parameter Length L = 1.5[m]; input Torque drive(start = 3);
  Revolute hinge(a = world, phi(start = 30[deg])); Bar bar(m = m, L = L, a = hinge.b);
  AppliedTorque motor(on = hinge.b, torque = drive);
end Bound;"""

TRAIN = """model Train  // arrays, a branch, what follows from what follows, a constraint and corners in time
  parameter Mass m = 3; parameter Real share = 0.25; parameter Length L[2] = {1, 1.3[m]}; parameter Stiffness k = 40*pi;
  parameter Mass heavy = if share > 0.5 then 2*m else m + 1[kg], both = heavy + m;
  parameter Time period = 0.7; input Force push, pull;
  Block cart(m = both, base = world, s(start = 0.2));
  Revolute hinge[2](a = {cart.center, upper.b}, phi(start = {0.4, -0.3}));
  Bar upper(m = heavy*share, L = L[1], a = hinge[1].b), lower(m = m*share, L = L[2], a = hinge[2].b);
  Spring spring(k = k*share, a = world, b = lower.b, s_rel0 = L[1] + L[2] - 0.4[m]);
  AppliedForce f(at = cart.center, force = {push + 2[N]*mod(time, period)/1[s], 0}), g(at = lower.b, force = {0, pull*share});
  output Energy e = both*cart.v^2/2;
end Train;"""


def functions_of(model: lag.Model, given: Any = ()) -> dict[str, ca.Function]:
    return model.functions(given=given) | model.derivatives(given=given)


def point(model: lag.Model) -> list[Any]:
    """t, q, v, u, p, away from what is declared; p as a vector in which what follows has any values."""
    random = np.random.default_rng(7)
    n, p = model.scene.n, model.parameter_values()
    return [0.31, random.uniform(0.1, 0.9, n), random.uniform(-1, 1, n), random.uniform(1, 2, len(model.input_names)),
            p * random.uniform(0.9, 1.1, p.size)]


def differences(function: Callable[..., Any], at: list[Any], k: int, h: float = 1e-3) -> np.ndarray:
    """Central, of the fourth order, by the k-th argument: one column an entry."""
    def value(entry: int, step: float) -> np.ndarray:
        moved = [*at]
        moved[k] = np.array(at[k], float)
        moved[k][entry] += step
        return np.array(function(*moved), float).ravel(order="F")

    columns = [(8*(value(i, h) - value(i, -h)) - value(i, 2*h) + value(i, -2*h)) / (12*h) for i in range(len(at[k]))]
    return np.array(columns).T if columns else np.zeros((function(*at).numel(), 0))


def test_a_bar_in_closed_form(scene: Write) -> None:
    """M = m L^2/3, dv/dt = (u - m g L cos(phi)/2)/M; the bar's own m, L and I follow."""
    model = scene(BOUND)
    functions, names = functions_of(model), list(model.parameter_names)
    t, q, v, u, p = (ca.SX.sym(name, functions["M"].size1_in(i)) for i, name in enumerate("tqvup"))
    slope = ca.Function("slope", [t, q, v, u, p], [ca.jacobian(functions["M"](t, q, v, u, p), p)])
    m, L, phi, drive, g = 20.0, 1.1, 0.5, 3.0, 9.81
    at = model.parameter_values()
    at[[names.index("m"), names.index("L")]] = m, L
    state = 0, phi, 0, drive, at
    expected = dict.fromkeys(names, 0.0) | {"m": L**2/3, "L": 2*m*L/3}
    assert dict(zip(names, slope(*state).full().ravel(), strict=True)) == pytest.approx(expected, rel=1e-14)
    M, a = m*L**2/3, (drive - m*g*L*np.cos(phi)/2)*3/(m*L**2)
    assert float(functions["rhs"](*state)) == pytest.approx(a, rel=1e-14)
    assert float(functions["jacobian_u"](*state)) == pytest.approx(1/M, rel=1e-14)
    by_p = dict(zip(names, functions["jacobian_p"](*state).full().ravel(), strict=True))
    assert by_p["m"] == pytest.approx(-drive/M/m, rel=1e-13)
    assert by_p["L"] == pytest.approx(-2*drive/M/L + 1.5*g*np.cos(phi)/L**2, rel=1e-13)
    assert by_p["bar.m"] == by_p["bar.L"] == by_p["bar.I"] == 0
    assert functions["parameters"](at).full().ravel() == pytest.approx(model.parameter_values({"m": m, "L": L}), rel=1e-15)


def test_what_follows_can_be_given_by_name(scene: Write) -> None:
    """As a run can: the inertia alone, and the mass, which the inertia then follows."""
    model = scene(BOUND.replace("input Torque", "final parameter Mass twice = 2*m; input Torque"))
    for changes, M in (({"bar.I": 0.7}, 0.7 + 2*0.75**2), ({"bar.m": 5.0, "m": 1.0}, 5*1.5**2/3), ({"m": 4.0}, 4*1.5**2/3)):
        functions, p = functions_of(model, changes), model.parameter_values(changes)
        assert float(functions["M"](0, 0.5, 0, 0, p)) == pytest.approx(M, rel=1e-14)
        assert functions["parameters"](p).full().ravel() == pytest.approx(p, rel=1e-15)
    slopes = dict(zip(model.parameter_names, functions_of(model, "bar.m")["jacobian_p"](0, 0.5, 0, 3, model.parameter_values())
                      .full().ravel(), strict=True))
    assert slopes["m"] == 0 and slopes["bar.m"] == pytest.approx(-3/1.5/2, rel=1e-13)
    for wrong, code in (("bar.mass", "L0701"), (["m", "Bar"], "L0701"), (3, "L0702"), ("twice", "final")):
        with pytest.raises(lag.LagError, match=code):
            model.functions(given=wrong)


@pytest.mark.parametrize("what", ["train", "disc_and_block", "four_bar", "double_pendulum"])
def test_derivatives_agree_with_differences(what: str, scene: Write) -> None:
    """Of M, dv/dt and the outputs by p, and of dv/dt by u, at values that are not those declared."""
    model = scene(TRAIN) if what == "train" else lag.load(EXAMPLES / f"{what}.lag")
    functions, at = functions_of(model), point(model)
    symbols = [ca.SX.sym(name, functions["M"].size1_in(i)) for i, name in enumerate("tqvup")]
    for name in ("M", "rhs", "outputs"):
        by_p = ca.Function("by_p", symbols, [ca.jacobian(ca.vec(functions[name](*symbols)), symbols[4])])(*at).full()
        np.testing.assert_allclose(by_p, differences(functions[name], at, 4), rtol=1e-7, atol=1e-8 * np.abs(by_p).max(initial=1))
        if name == "rhs":
            np.testing.assert_allclose(functions["jacobian_p"](*at).full(), by_p, rtol=1e-9, atol=1e-9 * np.abs(by_p).max())
            assert np.abs(by_p).max() > 0.01
    np.testing.assert_allclose(functions["jacobian_u"](*at).full(), differences(functions["rhs"], at, 3), rtol=1e-9, atol=1e-10)
    followed = functions["parameters"](at[4]).full().ravel()
    all_given = functions_of(model, model.parameter_names)
    np.testing.assert_allclose(all_given["rhs"](*at[:4], followed).full(), functions["rhs"](*at).full(), rtol=1e-13)


def test_a_change_moves_functions_as_it_moves_runs(scene: Write) -> None:
    """The energy that a run begins with is that of the functions with one entry of p changed."""
    model = scene(TRAIN)
    model.native = False
    energies = functions_of(model)["energies"]
    for name, value in (("m", 8.0), ("share", 0.6), ("L[2]", 0.9), ("k", 10.0)):
        p = model.parameter_values()
        p[model.parameter_names.index(name)] = value
        run = model.simulate(at=[0.0], parameters={name: value})
        q, v = ([run[c.name][0] for c in columns] for columns in (model.scene.coordinates, model.scene.rates))
        T, V, _ = (float(x) for x in energies(0, q, v, [0, 0], p))
        assert run.energy.total[0] == pytest.approx(T + V, rel=1e-13)


@pytest.mark.parametrize("text", [BOUND, TRAIN])
def test_exports_follow_alike(text: str, scene: Write, tmp_path: Path) -> None:
    """The module and the CasADi file have the values and derivatives of model.functions(), and say what each entry is."""
    model = scene(text)
    for target, file in (("python", "x.py"), ("casadi", "x.casadi")):
        assert main(["export", str(model.path), "--to", target, "-o", str(tmp_path / file)]) == 0
    module: dict[str, Any] = {}
    exec((tmp_path / "x.py").read_text(encoding="utf-8"), module)
    reader = ca.FileDeserializer(str(tmp_path / "x.casadi"))
    file, names = {f.name(): f for f in reader.unpack()}, reader.unpack()
    assert names["q"] == module["COORDINATES"] == list(model.coordinate_names)
    assert names["u"] == list(module["INPUTS"]) == list(model.input_names)
    assert names["p"] == list(module["PARAMETERS"]) == list(model.parameter_names)
    assert names["y"] == module["OUTPUTS"] == list(model.output_names)
    at, functions = point(model), functions_of(model)
    for name in ("M", "rhs", "outputs", "jacobian", "jacobian_u", "jacobian_p"):
        expected = functions[name](*at).full()
        np.testing.assert_allclose(file[name](*at).full(), expected, rtol=1e-14)
        np.testing.assert_allclose(module[name](*at).reshape(expected.shape), expected, rtol=1e-12, atol=1e-13)
    everything = model.parameter_values({"m": 7})
    np.testing.assert_allclose(module["parameters"]({"m": 7}), everything, rtol=1e-15)
    changed = [*module["PARAMETERS"].values()]
    changed[names["p"].index("m")] = 7
    np.testing.assert_allclose(module["parameters"](changed), everything, rtol=1e-15)
    np.testing.assert_allclose(file["all_parameters"](changed).full().ravel(), everything, rtol=1e-15)
    slopes = dict(zip(names["p"], np.abs(module["jacobian_p"](*at)).max(axis=0), strict=True))
    assert names["follow"] == module["FOLLOWING"] and not any(slopes[name] for name in names["follow"]) and slopes["m"] > 0
    for wrong in (names["follow"][-1], "no such"):
        with pytest.raises(ValueError, match="no parameters that can be given"):
            module["parameters"]({wrong: 1.0})
