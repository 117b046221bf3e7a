"""Parameters of FMUs that follow from others: they are told so, cannot be set, and change with those that they follow from."""

from math import cos, sin, sqrt
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

import fmpy

import lagrangia as lag
from helpers.fmus import KINDS, VERSIONS, Instance

SCENE = """
model Follows
  parameter Mass m0 = 1, m = 2*m0;
  parameter Stiffness k0 = 4, k = 2*k0, kk = k*m/m0;
  final parameter Real share = 0.5;
  Block b(m = m, base = world, along = {1, 0}, s(start = x0, fixed = true)); parameter Length x0 = share*1[m];
  Spring s(k = kk, stretch = b.s);
  output Force pull = kk*b.s;
  annotation(experiment(StopTime = 1, Tolerance = 1e-10));
end Follows;
"""


@pytest.fixture(scope="module")
def follows(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("parameters") / "follows.lag"
    path.write_text(SCENE)
    return path


def spring_holds(one: Instance, k0: float, m0: float, start: float) -> None:
    """kk = 4 k0, m = 2 m0 from x0 = 0.5: x = x0 cos(sqrt(2 k0/m0) t)."""
    assert one.get("k", "kk", "m", "b.m", "s.k") == [2 * k0, 4 * k0, 2 * m0, 2 * m0, 4 * k0]
    x = 0.5 * cos(sqrt(2 * k0 / m0) * start)
    assert one.get("pull") == pytest.approx([4 * k0 * x], rel=1e-8)
    if one.kind == "ModelExchange":
        assert one.slopes()[1] == pytest.approx(-2 * k0 / m0 * x, rel=1e-12)
    else:
        one.step(start, 0.3)
        assert one.get("b.s") == pytest.approx([0.5 * cos(sqrt(2 * k0 / m0) * (start + 0.3))], rel=1e-8)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_follows_from_a_parameter_is_set_with_it(kind: str, version: str, follows: Path) -> None:
    from fmpy.fmi1 import FMICallException

    one = Instance(follows, version, kind)
    causality = {v.name: v.causality for v in one.description.modelVariables}
    assert {causality[name] for name in ("m0", "k0")} == {"parameter"}
    assert {causality[name] for name in ("m", "k", "kk", "share", "x0", "b.m", "s.k")} == {"calculatedParameter"}
    for name in ("k", "kk", "share"):
        with pytest.raises(FMICallException):
            one.set({name: 3.0})
    one.set({"k0": 9.0})
    one.start({"m0": 0.5})
    spring_holds(one, 9, 0.5, 0)
    one.fmu.reset()
    one.start()
    spring_holds(one, 4, 1, 0)
    one.fmu.reset()
    one.start({"k0": 1.0})
    spring_holds(one, 1, 1, 0)
    one.free()


@pytest.mark.parametrize("version", VERSIONS)
def test_tunable_parameters_take_what_follows_with_them(version: str, follows: Path) -> None:
    """From 0.3 s on with another stiffness; the state is kept."""
    one = Instance(follows, version, "CoSimulation").start(tolerance=1e-10)
    one.step(0, 0.3)
    x, v = one.get("b.s", "b.v")
    one.set({"k0": 16.0})
    assert one.get("k", "kk", "pull") == pytest.approx([32, 64, 64 * x], rel=1e-12)
    one.step(0.3, 0.3)
    w = sqrt(32)
    assert one.get("b.s") == pytest.approx([x * cos(w * 0.3) + v / w * sin(w * 0.3)], rel=1e-8)
    one.free()


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_exported_with_a_value_is_a_parameter_of_its_own(version: str, follows: Path, tmp_path: Path) -> None:
    """As `lag simulate -p m=3`: m says 3 until it is set, whatever m0 is, and kk = k m/m0 goes on following."""
    (path,) = lag.load(follows).export_fmu(tmp_path / "x.fmu", fmi=version, parameters={"m": 3.0})
    description = fmpy.read_model_description(str(path))
    own = {v.name: v for v in description.modelVariables}
    assert (own["m"].causality, float(own["m"].start)) == ("parameter", 3.0)
    assert own["k"].causality == "calculatedParameter" and own["k"].start is None
    for given, m, kk in (({}, 3.0, 24.0), ({"m": 5.0}, 5.0, 40.0), ({"m": 5.0, "m0": 2.0, "k0": 1.0}, 5.0, 5.0)):
        rows = fmpy.simulate_fmu(str(path), start_values=given, output=["m", "kk", "pull", "b.s"], stop_time=0.3,
                                 step_size=0.3, output_interval=0.3, relative_tolerance=1e-10, fmi_type="CoSimulation")
        last = rows[-1]
        assert (last["m"], last["kk"]) == pytest.approx((m, kk), rel=1e-14)
        assert last["b.s"] == pytest.approx(0.5 * cos(sqrt(kk / m) * 0.3), rel=1e-8)
