"""Arrays whose elements follow from one another, in any order."""

from collections.abc import Callable
from math import sin
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import DONE, main

Write = Callable[[str], lag.Model]
SCENE = """model A
  parameter Integer n = 5;
  parameter Real p[3] = {{3*p[3], 2*p[1], 0.5}}, M[2, 2] = {{{{2, 3}}, {{M[1, 1]*5, M[2, 1] + M[1, 2]}}}};
  Real v[n], w[3] = {{w[2] + 1, a, sin(time/1[s])}};
  Real a = w[3]^2 + M[2, 2];
  Block b(m = 1, base = world);
  AppliedForce f(at = b.center, force = {{v[n]*p[2]*1[N], 0}});
  output Real y = v[n], z = w[1];
equation
  {order}
end A;"""
UP, DOWN = "v[1] = sin(time/1[s]); for i in 2:n loop v[i] = 2*v[i - 1]; end for;", \
           "v[n] = 16*sin(time/1[s]); for i in 1:n - 1 loop v[i] = v[i + 1]/2; end for;"


@pytest.mark.parametrize("order", [UP, DOWN])
def test_elements_are_found_in_order_of_their_dependence(order: str, scene: Write) -> None:
    model = scene(SCENE.format(order=order))
    run = model.simulate(at=[0, 1])
    assert run["y"][1] == pytest.approx(16 * sin(1), rel=1e-15)
    assert run["z"][1] == pytest.approx(sin(1) ** 2 + 14, rel=1e-15)
    assert run["b.s"][1] == pytest.approx(48 * (1 - sin(1)), rel=1e-9)
    assert model.simulate(at=[0, 1], parameters={"p[3]": 1.0})["b.s"][1] == pytest.approx(96 * (1 - sin(1)), rel=1e-9)
    assert model.simulate(at=[0, 1], parameters={"p[1]": 3.0})["b.s"][1] == pytest.approx(96 * (1 - sin(1)), rel=1e-9)


def test_long_arrays_in_falling_order(scene: Write) -> None:
    order = "v[n] = 1; for i in 1:n - 1 loop v[i] = v[i + 1]; end for;"
    assert scene(SCENE.format(order=order).replace("n = 5", "n = 1000")).simulate(at=[0, 1])["y"][1] == 1


@pytest.mark.parametrize(("text", "chain"), [
    ("parameter Real p[2] = {p[2], p[1]};", "p[1] > p[2] > p[1]"), ("Real v[2] = {v[2]*time/1[s], v[1]};", "v[1] > v[2] > v[1]"),
    ("Real v[2] = {v[1], 2};", "v[1] > v[1]"), ("Real v[2] = {1, sum(v)};", "v > v"),
    ("Real v[2] = {1, a}; Real a = 2*v[2];", "v[2] > v[2]"),
])
def test_circles_are_told(text: str, chain: str, scene: Write) -> None:
    name = text.split("[", maxsplit=1)[0].rsplit(maxsplit=1)[-1]
    with pytest.raises(LagError, match="L0212") as told:
        scene(f"model B Block b(m = 1, base = world); {text} output Real y = {name}[1]; end B;").simulate()
    assert chain in str(told.value)


def test_pages_read_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.lag"
    file.write_text(SCENE.format(order=UP))
    assert main(["equations", str(file)]) == DONE
    assert "96 p₃ sin t" in capsys.readouterr().out
