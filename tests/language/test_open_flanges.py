"""Ends that are connected to nothing, and variables of functions that no result follows from, are told."""

from collections.abc import Callable

import pytest

import lagrangia as lag

SHAFT = "Rotational.Inertia j(J = 1, w(start = 1)), k(J = 2);"
SCENES = {  # with what changes nothing
    "Rotational.Spring s(c = 2, flange_a = j.flange_b);": "s",
    "Rotational.IdealGear g(ratio = 2, flange_a = j.flange_b);": "g",
    "Rotational.IdealPlanetary p(ratio = 2, sun = j.flange_b, carrier = k.flange_a);": "p",
    "Rotational.Spring s(c = 2, flange_a = j.flange_b); Rotational.Damper d(d = 3, flange_a = s.flange_b);": "s d",
    "Rotational.Fixed f;": "f",
    "Rotational.Flange a; Rotational.Spring s(c = 2, flange_a = j.flange_b); equation connect(s.flange_b, a);": "s",
    "Rotational.Flange a; Rotational.Spring s(c = 2, flange_a = j.flange_b, flange_b = a); Angle y = a.phi;": "",
    "Rotational.Spring s(c = 2, flange_a = j.flange_b); "
    "Rotational.Damper d(d = 3, flange_a = s.flange_b, flange_b = k.flange_a);": "",
    "Rotational.Spring s(c = 2, flange_a = j.flange_b); equation s.flange_b.phi = 0.1;": "",
    "Rotational.Fixed f(phi0 = 1); output Angle y = f.flange.phi;": "",
    "Rotational.IdealGear g(ratio = 2, flange_a = j.flange_b); Angle y = g.flange_b.phi;": "",
}


@pytest.mark.parametrize(("scene_text", "idle"), SCENES.items())
def test_open_flanges(scene_text: str, idle: str, scene: Callable[[str], lag.Model]) -> None:
    told = scene(f"model M {SHAFT} {scene_text} end M;").compilation.flat.warnings
    assert [(d.code, d.message.split("'")[1]) for d in told] == [("L0224", name) for name in idle.split()]


@pytest.mark.parametrize(("body", "idle"), [
    ("z := 3*x; y := x;", "k z"), ("z := k; y := x;", "k z"), ("for i in 1:2 loop z := k; end for; y := x*z;", ""),
    ("z := k; if z > 1 then y := x; else y := 0; end if;", ""), ("z := 1; y := z*x; assert(k > 1, \"small\");", ""),
])
def test_variables_of_functions_that_no_result_follows_from(body: str, idle: str, scene: Callable[[str], lag.Model]) -> None:
    told = scene(f"""function f input Real x; input Real k; output Real y; protected Real z; algorithm {body} end f;
      model M Block b(m = 1, base = world); output Real y = f(2, 3); end M;""").compilation.flat.warnings
    assert [d.message.split("'")[1] for d in told] == idle.split()
