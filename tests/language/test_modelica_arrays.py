"""Arrays, enumerations and loops of Modelica: components as wholes, ranges of all kinds, slices in equations and connections."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]

CLASSES = """
type E = enumeration(a, b, c);
record R Real a; Real b = 1; end R;
record S R r[2]; Real c = 0; end S;
model A parameter Real k = 1; end A;
model C A a[2]; end C;
model D C c; end D;
function square input Real x; output Real y; algorithm y := x^2; end square;
function weighed input Real x; input Real v[:]; output Real y; algorithm y := x*sum(v); end weighed;
function later "the elements are those of the beginning"
  input Real u[:]; output Real y;
protected
  Real w[size(u, 1)] = u;
algorithm
  y := 0;
  for v in w loop w[3] := 100; w := 2*w; y := y + v; end for;
end later;
function all_of input R r[:]; output Real y; algorithm y := 0; for i loop y := y + r[i].a*r[i].b; end for; y := y + size(r, 1);
end all_of;
function by_name input Real v[E]; output Real y;
algorithm y := 0; for e in E loop y := y + v[e]; end for; y := y + v[E.b]; end by_name;
function parts input S s[:]; output Real y; algorithm y := 10*size(s, 1) + size(s[1].r, 1); end parts;
function chosen input E e; input String s = "x"; output Real y;
algorithm y := if e == E.a then 7 else if s == "x" then 8 else 9; end chosen;
"""
DECLARED = """
  parameter Real u[:] = {1, 2, 3}, w[2, 3] = [1, 2, 3; 4, 5, 6], v[E] = {1, 2, 3}, t[Boolean] = {1, 2};
  parameter Integer pick[2, 2] = [1, 3; 2, 1];
  A p[3], q[2, 4];
  C each_one[3](a(each k = 4)), rows[3](a(k = {{1, 2}, {3, 4}, {5, 6}}));
  D deep[3](c(a(each k = 4)));
  R r[3](a = {1, 2, 3}), filled[2] = fill(R(5), 2);
  constant Length reach = 4;
  Real far[2], near, z[4], m[2, 2], none[0], jump, jumps[2], where_it_is[2];
  Block b[2](each m = 1, each base = world, s(start = {1, 2}));
"""
EQUATIONS = """
  z[1:2] = {1, 2}; z[3:end] = {3, 4};
  m[1, :] = {1, 2}; m[2, :] = {3, 4};
  where_it_is[:] = b[:].s/1[m];
  if time > -1 then jump = 3; jumps[2] = 4; if u[1] > 5 then jumps[1] = 1; else jumps[1] = 5; end if;
  else jumps[1] = 1; jump = 1; jumps[2] = 2; end if;
  if time > -1 then for i in 1:2 loop far[i] = 2*i; end for; 8 = near;
  else near = 1; for i in 1:2 loop 0 = far[i]; end for; end if;
"""
VALUES = {
    "size(p, 1) + size(q, 2)": 7.0, "sum(size(q)) + ndims(q)": 8.0, "size(r, 1)": 3.0, "sum(each_one.a.k)": 24.0,
    "sum(rows.a.k)": 21.0, "sum(deep.c.a.k)": 24.0, "sum(filled.a)": 10.0,
    "sum(x^2 for x in u)": 14.0, "sum(x for x in {0.5, 1, 2})": 3.5, "sum(x for x in 0:0.1:0.3)": 0.6, "sum(0:0.5:1.5)": 3.0,
    "sum(w[i, j]*u[j] for i, j)": 46.0, "sum(v[e] for e in E.b:E.c) + sum(v[E.a:E.b])": 8.0,
    "sum(if e == E.b then 3 else Integer(e) for e in E)": 7.0, "sum(t[c] for c in Boolean) + t[true]": 5.0,
    "sum(sum(u[j] for j in pick[i, :]) for i in 1:2)": 7.0, "Integer(E(3))": 3.0, "sum(v[{E.a, E.c}])": 4.0,
    "v[E(3)] + v[if size(u, 1) > 2 then E.b else E.a]": 5.0,
    "sum(square(w))": 91.0, "sum(weighed(u, {1, 2}))": 18.0, "later(u)": 6.0, "all_of(r)": 9.0,
    "by_name({1, 2, 4})": 9.0,
    "parts({S({R(i), R(2)}) for i in 1:4})": 42.0, "chosen(E.a) + chosen(E.b) + chosen(E.b, \"y\")": 24.0,
    "sum(x for x in 0[deg]:90[deg]:180[deg])/270[deg]": 1.0, "sum(x for x in -1[m]:2[m])/1[m]": 2.0,
    "sum(x for x in 0:reach/2:reach)/1[m]": 6.0, "sum(x for x in 0[mm]:3[mm])/1[mm]": 6.0,
    "sum(x for x in 0:0.5:reach)/1[m]": 18.0, "sum(x for x in 1[m]:-50[cm]:0)/1[m]": 1.5,
    "sum(u[i]*sum(z[i] for i) for i)": 60.0,
    "sum(far) + near": 14.0,
    "sum(z[i]*i for i)": 30.0, "sum(m)": 10.0, "sum(none)": 0.0, "jump + jumps[1]*jumps[2]": 23.0, "sum(where_it_is)": 3.0,
}


def test_values(scene: Write) -> None:
    outputs = "\n".join(f"output Real y{k} = {text};" for k, text in enumerate(VALUES))
    run = scene(f"{CLASSES} model M {DECLARED} {outputs} equation {EQUATIONS} end M;").simulate(at=[0.0])
    assert {text: run[f"y{k}"][0] for k, text in enumerate(VALUES)} == pytest.approx(VALUES, abs=1e-13)


def test_arrays_are_connected_as_wholes(scene: Write) -> None:
    """Three shafts between springs, and in arrays of what has arrays; frames and signals likewise."""
    shafts = "Rotational.Inertia j[3](each J = 1, phi(start = {0.1, 0.2, 0.3})); Rotational.Spring s[2](each c = 4);"
    whole = scene(f"model M {shafts} equation connect(j[1:2].flange_b, s.flange_a); "
                  "connect(s.flange_b, j[2:end].flange_a); end M;")
    single = scene(f"model M {shafts} equation for i in 1:2 loop connect(j[i].flange_b, s[i].flange_a); "
                   "connect(s[i].flange_b, j[i + 1].flange_a); end for; end M;")
    assert whole.simulate(stop=2, interval=2)["j[3].phi"][-1] == single.simulate(stop=2, interval=2)["j[3].phi"][-1]
    chain = scene("""connector In = input Real; connector Out = output Real;
      block Source parameter Real k; Out y = k; end Source; block Sum In u[3]; Out y = sum(u); end Sum;
      model M Revolute h[3]; Bar l[3](each m = 1, each L = 1); Source source[3](k = {1, 2, 3}); Sum total;
        output Real y = total.y; output Length end_of_it = l[3].b.x;
      equation connect(source.y, total.u); connect(world, h[1].a); connect(h.b, l.a); connect(l[1:2].b, h[2:3].a); end M;""")
    run = chain.simulate(at=[0.0])
    assert (run["y"][0], run["end_of_it"][0]) == (6, pytest.approx(3))


@pytest.mark.parametrize(("expression", "message"), [
    ("sum(x for x in w)", r"L0214.*one dimension"), ("sum(2*i for i)", r"L0214.*range of 'i' is missing"),
    ("sum(u[i]*w[i, 1] for i)", r"L0214.*arrays of 2 and 3"),
    ("sum(Integer(e) for e in E.a:F.y)", r"L0214.*begins with a value of E"),
    ("Integer(E(4))", r"L0214.*E has 3 values"), ("sum(u[{0.5*i for i in 2:3}])", r"L0210.*not 1\.5"),
    ("sum(x for x in 0[mm]:2[m])", r"L0210.*one unit"), ("sum(x for x in 0[mm]:1:2*3[mm])", r"L0210.*one unit"),
    ("chosen(F.y)", r"L0302.*value of E"), ("sum(weighed(u, 2))", r"L0303"), ("size(w, 3)", r"L0303.*no dimension 3"),
])
def test_refused(expression: str, message: str, scene: Write) -> None:
    with pytest.raises(lag.LagError, match=message):
        scene(f"{CLASSES} type F = enumeration(x, y); model M parameter Real u[3] = {{1, 2, 3}}, w[2, 3] = [1, 2, 3; 4, 5, 6];"
              f"Block b(m = 1, base = world); output Real y = {expression}; end M;")
