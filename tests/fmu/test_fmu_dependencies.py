"""dependenciesKind of FMUs: what is constant or tunable stays so, and all that does is said to."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

pytest.importorskip("fmpy")

from helpers.fmus import VERSIONS, fmu_of, instance_of
from lagrangia.fmu.factors import factor_kinds

SCENE = """
model Mixed
  parameter Stiffness k0 = 5, k = 2*k0, k3 = k0^2/1[N/m];
  parameter Mass m = 4;
  final parameter Real eight = 8;
  input Force F = 0, G = 0;
  Block a(m = m, base = world, along = {1, 0}, s(start = 1)), b(m = 1, base = world, along = {1, 0});
  Spring sa(k = k, stretch = a.s), sb(k = k3, stretch = b.s - a.s);
  AppliedForce pa(at = a.center, force = {F*cos(b.s/1[m]) + G, 0});
  GeneralSpring bent(stretch = b.s, V = 3[N/m2]*b.s^3);
  output Length mean = (a.s + 3*b.s)/4;
  output Force pull = k*a.s + F/4 + 2*G + eight*1[N]*time/1[s];
  output Length far = a.s + (if b.s > 0.3 then 1 else 0);
  output Energy both = a.s*F;
  annotation(experiment(StopTime = 1));
end Mixed;
"""
# Of each unknown: its knowns by kind. Parameters are no knowns in FMI 2.
KINDS = {
    "mean": {"a.s": "constant", "b.s": "constant"},
    "pull": {"a.s": "tunable", "F": "constant", "G": "constant", "time": "constant", "k0": "dependent"},
    "far": {"a.s": "constant", "b.s": "dependent"},
    "both": {"a.s": "dependent", "F": "dependent"},
    "der(a.s)": {"a.v": "constant"},
    "der(b.s)": {"b.v": "constant"},
    "der(a.v)": {"a.s": "tunable", "b.s": "dependent", "F": "dependent", "G": "tunable", "k0": "dependent", "m": "dependent"},
    "der(b.v)": {"a.s": "tunable", "b.s": "dependent", "k0": "dependent", "b.m": "dependent"},
}


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("dependencies") / "mixed.lag"
    path.write_text(SCENE)
    return path


def test_the_kinds_of_all_sorts_of_expressions() -> None:
    x, y, p = ca.SX.sym("x"), ca.SX.sym("y"), ca.SX.sym("p", 2)
    for expression, expected in [
        (3 * x - y / 4 + 2, "constant constant"), (p[0] * x + y, "tunable constant"),
        (x / p[1] + p[0] * p[0] * y, "tunable tunable"),
        (x * y, "dependent dependent"), (x * x + y, "dependent constant"), (x / y, "dependent dependent"),
        (x + ca.sign(x) + y, "dependent constant"), (ca.if_else(p[0] > 1, x, 0) + y, "tunable constant"),
        (ca.if_else(x > 1, y, 0), "dependent dependent"), (ca.sin(x) + 2 * ca.fabs(y), "dependent dependent"),
        (p[0] * (x + p[1] * y) - -y, "tunable tunable"), (2 * (x + y) + ca.floor(y), "constant dependent"),
    ]:
        (found,) = factor_kinds(expression, [ca.vertcat(x, y)], p)
        assert [found.kind(0), found.kind(1)] == expected.split(), expression
    (product,) = factor_kinds(p[0] * p[1] + 2 * p[0] + p[0] * x, [x], p)
    assert [product.kind(0), product.kind_of_parameter(0), product.kind_of_parameter(1)] == ["tunable", "dependent", "tunable"]


@pytest.mark.parametrize("version", VERSIONS)
def test_the_description_names_them(scene: Path, version: str) -> None:
    import fmpy

    description = fmpy.read_model_description(str(fmu_of(scene, version)))
    unknowns = [*description.outputs, *description.derivatives]
    found = {u.variable.name: dict(zip((v.name for v in u.dependencies), u.dependenciesKind, strict=True)) for u in unknowns}
    parameters = () if version == "3" else ("k0", "m", "b.m")
    expected = {name: {known: kind for known, kind in row.items() if known not in parameters} for name, row in KINDS.items()}
    assert found == expected
    initial = {u.variable.name: set(u.dependenciesKind) for u in description.initialUnknowns}
    assert set.union(*initial.values()) == {"constant", "dependent"}
    assert initial["k"] == {"constant"} and initial["k3"] == {"dependent"} and initial["eight"] == set()
    assert {v.name: v.causality for v in description.modelVariables}["eight"] == "calculatedParameter"


def test_what_is_constant_is_so_in_any_state_and_for_any_parameters(scene: Path) -> None:
    numbers = np.random.default_rng(5)
    seen: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for k0, m in ((5.0, 4.0), (11.0, 0.7)):
        instance = instance_of(scene, "3", "ModelExchange").start({"k0": k0, "m": m})
        for _ in range(3):
            instance.set_states(list(numbers.uniform(0.4, 2, 4)))
            instance.set({"F": numbers.uniform(), "G": numbers.uniform()})
            for name, row in KINDS.items():
                for known in row:
                    (slope,) = instance.forward([name], [known], [1.0])
                    seen.setdefault((name, known), []).append((k0, slope))
        instance.free()
    for (name, known), slopes in seen.items():
        kind = KINDS[name][known]
        if kind == "constant":
            np.testing.assert_allclose([slope for _, slope in slopes], slopes[0][1], rtol=1e-14, err_msg=f"{name} by {known}")
        if kind == "tunable":
            each = [[slope for k0, slope in slopes if k0 == value] for value in (5.0, 11.0)]
            np.testing.assert_allclose(each, [[row[0]] * 3 for row in each], rtol=1e-14, err_msg=f"{name} by {known}")
            assert each[0][0] != each[1][0]
