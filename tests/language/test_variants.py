"""Packages and classes that are redeclared: what is inherited is as it is in the heir, as Modelica's specification says."""

from collections.abc import Callable
from math import cos

import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import Source
from lagrangia.editor.formatting import formatted

Write = Callable[[str], lag.Model]

MEDIA = """
package Media "as Modelica.Media is built"
  partial package PartialMedium
    constant Density rho = 1;
    constant Integer nX = 1;
    constant Real X0[nX] = fill(1/nX, nX);
    constant Density rho0 = density(0.5);
    replaceable partial function density input Real T; output Real y; end density;
    replaceable partial model BaseProperties parameter Real T = 0.5; Real d; Real d2 = 2*d; end BaseProperties;
    replaceable function twice input Real T; output Real y; algorithm y := 2*density(T); end twice;
  end PartialMedium;
  package Water
    extends PartialMedium(rho = 1000, nX = 2);
    redeclare function extends density algorithm y := rho*(1 - T); end density;
    redeclare replaceable model extends BaseProperties(T = 0.25) equation d = density(T); end BaseProperties;
  end Water;
  package Salty = Water(rho = 1100);
  package Cold
    extends Water(rho = 999);
    redeclare model extends BaseProperties(T = 0) Real more = X0[2]; end BaseProperties;
  end Cold;
end Media;
partial model PartialTank
  replaceable package Medium = Media.PartialMedium constrainedby Media.PartialMedium "what is in it";
  Medium.BaseProperties props;
  Real q = Medium.twice(0.5); Real n = size(Medium.X0, 1); Real r = Medium.rho0;
  replaceable function f = Medium.density;
  Real v = f(0.1);
end PartialTank;
model Tank extends PartialTank; Real z = Medium.rho; end Tank;
model WaterTank extends Tank(redeclare package Medium = Media.Water); Real zz = Medium.rho; end WaterTank;
model Plant
  replaceable package Medium = Media.Cold constrainedby Media.PartialMedium;
  Tank a(redeclare package Medium = Medium), b[2](redeclare package Medium = Media.Salty, props(T = {0.1, 0.2}));
  WaterTank w;
end Plant;
model Scene
  Block block(m = 1, base = world);
  parameter Integer k = 7;
  Plant p, q(redeclare package Medium = Media.Water(rho = k));
  Tank t(redeclare package Medium = Media.Water, redeclare function f = Media.Salty.density);
  %s
end Scene;
"""

TANKS = {  # by hand: density(T) = rho*(1 - T)
    "p.a.props.d": 999.0, "p.a.props.d2": 1998.0, "p.a.q": 999.0, "p.a.n": 2.0, "p.a.r": 499.5, "p.b[2].props.d": 880.0,
    "p.w.zz": 1000.0, "p.w.props.d": 750.0, "q.a.props.d": 5.25, "q.a.z": 7.0, "t.v": 990.0,
    "p.a.props.more": 0.5, "p.b[1].v": 990.0}


def outputs(names: dict[str, float]) -> str:
    return " ".join(f"output Real y{k} = {name};" for k, name in enumerate(names))


def test_media(scene: Write) -> None:
    text = MEDIA % outputs(TANKS)
    run = scene(text).simulate(at=[0.0])
    found = {name: run[f"y{k}"][0] for k, name in enumerate(TANKS)}
    assert found == pytest.approx(TANKS, abs=1e-12)
    tidy = formatted(Source("scene.lag", text))
    assert tidy == formatted(Source("scene.lag", tidy))
    run = scene(tidy).simulate(at=[0.0])
    assert found == {name: run[f"y{k}"][0] for k, name in enumerate(TANKS)}


CLASSES = """
package P
  constant Real rho = 1;
  model Part Real m = rho; end Part;
  record R Real a = 1; Real b = 2; end R;
  record S extends R(a = 5); end S;
  record T = R(a = 6);
  function g input Real x; output Real y; protected Real k = 3; algorithm y := k*rho*x; end g;
  partial function Face input Real x; output Real y; end Face;
  function h extends Face; input Real z = 10; algorithm y := x + z; end h;
  function h2 = h(z = 20);
  function count input Integer n; output Integer m; algorithm m := 0; for i in 1:n loop m := m + i; end for; end count;
end P;
package W = P(rho = 1000);
package V extends P(rho = 7); end V;
type Gears = enumeration(low, high);
model A
  replaceable type Q = Real;
  replaceable type E = enumeration(:);
  replaceable record R = P.R;
  replaceable function f = P.g;
  R r;
  parameter Q q = 1;
  parameter E e;
  Real y = f(2) + r.a;
end A;
model Stiff parameter Real k = 1; end Stiff;
model Soft extends Stiff; parameter Real more = 2; end Soft;
model Car replaceable model Tyre = Stiff; Tyre t; Real z = t.k; end Car;
model Sport extends Car; redeclare model Tyre = Soft(k = 5, more = 3); end Sport;
model Racer extends Sport(t(k = 9)); end Racer;
model Truck extends Car; redeclare replaceable model Tyre parameter Real k = 7; Real extra = 2*k; end Tyre; end Truck;
model M
  Block b(m = 1, base = world);
  W.Part w;
  V.Part v;
  P.S s;
  P.T t;
  P.S s2 = P.S();
  A c(redeclare type Q = Angle, redeclare type E = Gears, redeclare record R = P.S, redeclare function f = P.h2, e = Gears.high);
  Sport sport;
  Racer racer;
  Truck truck, other(redeclare model Tyre = Soft(k = 11));
  parameter Real many[P.count(3)] = {1, 2, 3, 4, 5, 6};
  %s
end M;
"""

VALUES = {  # as the specification has them, by hand
    "W.rho": 1000.0, "W.g(2)": 6000.0, "V.g(2)": 42.0, "P.g(2)": 6.0, "w.m": 1000.0, "v.m": 7.0, "s.a": 5.0, "t.a": 6.0,
    "s2.a": 5.0,
    "c.y": 27.0, "if c.e == Gears.high then c.q else 0": 1.0, "sum(many)": 21.0, "P.h2(1)": 21.0, "P.h2(1, 2)": 3.0,
    "sport.z + sport.t.more": 8.0, "racer.z": 9.0, "truck.t.extra": 14.0, "other.z": 11.0}


def test_classes(scene: Write) -> None:
    run = scene(CLASSES % outputs(VALUES)).simulate(at=[0.0])
    assert {name: run[f"y{k}"][0] for k, name in enumerate(VALUES)} == pytest.approx(VALUES, abs=1e-12)


def test_connections_are_left_out(scene: Write) -> None:
    """break connect(a, b) of Modelica 3.6: the rest of what is inherited stays."""
    text = """model A
      Block p(m = 1, base = world, s(start = 1)), q(m = 1, base = world, s(start = 1));
      Spring spring(a = world, k = 4);
    equation
      connect(spring.b, p.center);
    end A;
    model M extends A(break connect(spring.b, p.center)); equation connect(spring.b, q.center); end M;"""
    run = scene(text).simulate(at=[1.0])
    assert run["p.s"][0] == 1.0
    assert run["q.s"][0] == pytest.approx(cos(2.0), abs=1e-7)


def test_several_connections_are_left_out(scene: Write) -> None:
    text = """model A Block p(m = 1, base = world, s(start = 1)), q(m = 1, base = world, s(start = 1)); Spring spring(k = 4);
    equation connect(world, spring.a); connect(spring.b, p.center); end A;
    model M extends A(break connect(world, spring.a), break connect(spring.b, p.center));
    equation connect(p.center, spring.a); connect(spring.b, q.center); end M;"""
    run = scene(text).simulate(at=[1.0])
    assert [run["p.s"][0], run["q.s"][0]] == [1.0, 1.0]
    with pytest.raises(lag.LagError, match="given twice"):
        scene(text.replace("connect(world, spring.a), break", "connect(spring.b, p.center), break"))


def test_constants_that_are_records(scene: Write) -> None:
    """Their fields are parameters, or variables, and no constants by themselves."""
    values = {"P.small.k": 3.0, "P.big.l": 6.0, "P.more[2].k": 8.0, "P.w": 4.0, "m.y": 6.0, "n.y": 30.0, "P.v.u[2]": 4.0,
              "P.vs[2].u[1]": 5.0, "Q.small.k": 3.0, "P.deep.d.k": 9.0}
    text = """package P
      record Data parameter Real k = 1; parameter Real l = 2; end Data;
      record V Real u[2]; end V;
      record Deep Data d; end Deep;
      constant Data small(k = 3), big = Data(k = 5, l = 6), more[2](k = {7, 8});
      constant Deep deep(d(k = 9));
      constant V v = V({3, 4}), vs[2] = {V({3, 4}), V({5, 6})};
      constant Real w = small.k + 1;
      model Motor parameter Data d = small; Real y = d.k*d.l; end Motor;
    end P;
    package Q = P(w = 1);
    model M Block b(m = 1, base = world); P.Motor m, n(d = P.big); %s end M;"""
    run = scene(text % outputs(values)).simulate(at=[0.0])
    assert {name: run[f"y{k}"][0] for k, name in enumerate(values)} == values


RECORDS = """record R parameter Real k = 1; parameter Real l = 2*k; end R;
  record Less parameter Real k = 1; end Less;
  model A replaceable record Q = R; Q r; Q s[2](k = {3, 4}); Real y = r.l + s[2].l; end A;
  model F replaceable record Q = R; Q r; function f input Q q; output Real y; algorithm y := q.l; end f; Real y = f(r); end F;
  model B extends A; Q t; Real z = t.k; end B;
  model M Block b(m = 1, base = world); parameter Real u = 6; %s end M;"""


def test_records_of_components_take_parameters(scene: Write) -> None:
    """u may be changed after it is compiled; what functions name has to be known then."""
    model = scene(RECORDS % """A a(redeclare record Q = R(k = u)); B b2(redeclare record Q = R(k = u));
        A c[2](redeclare record Q = R(each k = u)); F f(redeclare record Q = R(k = 5));
        output Real ya = a.y, yb = b2.y, zb = b2.z, yc = c[2].y, yf = f.y;""")
    run = model.simulate(at=[0.0], parameters={"u": 7})
    assert {name: run[name][0] for name in ("ya", "yb", "zb", "yc", "yf")} == {"ya": 22, "yb": 22, "zb": 7, "yc": 22, "yf": 10}


@pytest.mark.parametrize(("given", "code"), [
    ("A a(redeclare record Q = Less);", "L0235"), ("A a(redeclare record Q = A);", "L0235"),
    ("F a(redeclare record Q = R(k = u));", "L0210")])
def test_records_that_cannot_take_the_place(given: str, code: str, scene: Write) -> None:
    with pytest.raises(lag.LagError, match=code):
        scene(RECORDS % f"{given} output Real y = a.y;")


@pytest.mark.parametrize("classes", [
    "package A extends A(k = 2); end A;", "package A extends B(k = 2); end A; package B extends A; end B;",
    "package A extends B(k = 2); end A; package B extends C(k = 3); end B; package C extends B(k = 4); end C;"])
def test_packages_in_a_circle_with_other_constants(classes: str, scene: Write) -> None:
    with pytest.raises(lag.LagError, match=r"L0206.*extends itself"):
        scene(f"package Q {classes} end Q; model M Block b(m = 1, base = world); output Real y = Q.A.k; end M;")


def test_variables_with_conditions(scene: Write) -> None:
    """What is not there has no value, and nothing is connected to it; its condition may name what stands further down."""
    model = scene("""model Part Real u if uses; Real y = if uses then u else 2; parameter Boolean uses = false; end Part;
      model M Part a(uses = true), b; Blocks.Constant k(k = 4); output Real y = a.y, z = b.y; coordinate Length x;
      equation connect(k.y, a.u); connect(k.y, b.u); energy kinetic 1[kg]*der(x)^2/2; end M;""")
    found = model.simulate(at=[1.0])
    assert [found["y"][0], found["z"][0]] == [4, 2]
    with pytest.raises(lag.LagError, match="its condition is false"):
        scene("model M parameter Boolean p = false; Real x = 1 if p; output Real y = x; end M;")
