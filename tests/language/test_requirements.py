"""Assertions in functions, texts that are put together, names of Modelica's library, and what is both inner and outer."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]

CALLS = """
function inner
  input Real u;
  output Real v;
algorithm
  assert(u < 2 and u > -3 or u > 50, "u = " + String(u) + " is not in the table");
  v := 2*u;
end inner;
function f
  input Length x;
  input Integer n;
  output Real y;
  output Real z;
algorithm
  assert(n > 0, "no links");
  if x > 1 then
    y := inner(x/1[m]);
  elseif x > 0.5 then
    assert(x < 0.3, "between", AssertionLevel.warning);
    y := 3;
  else
    y := 2;
  end if;
  y := y + 1;
  z := y;
end f;
model M
  parameter Length begin = 0;
  parameter Length far = if begin > 30 then begin*inner(begin/1[m]) else 0;
  Real p, q;
  Block b(m = 1, base = world, along = {1, 0}, s(start = begin), v(start = 1));
  output Real w = p + q + far/1[m];
equation
  (p, q) = f(b.s, 1);
  annotation(experiment(StopTime = 4));
end M;
"""


def test_assertions_hold_for_each_call(scene: Write) -> None:
    """In branches that are taken alone, in functions that functions call, of parameters and of what moves."""
    model = scene(CALLS)
    with pytest.raises(lag.RunError, match=r"t = 2: u = u is not in the table \(u < 2 and .*b.s = 2"):
        model.simulate()
    run = model.simulate(stop=1.9)
    assert [text for text in run.warnings if "between" in text and "t = 0.5" in text]
    assert run["w"][-1] == pytest.approx(2*(2*1.9 + 1))
    assert model.simulate(parameters={"begin": 51.0}, stop=0.1).warnings == []
    with pytest.raises(lag.LagError, match=r"u = u is not in the table .*begin = 40"):
        model.simulate(parameters={"begin": 40.0}, stop=0.1)


def test_assertions_of_what_is_known(scene: Write) -> None:
    """They are decided when the scene is compiled."""
    for call, wrong in (("f(b.s, 1)", False), ("f(b.s, 0)", True)):
        text = CALLS.replace("f(b.s, 1)", call)
        if wrong:
            with pytest.raises(lag.LagError, match="no links"):
                scene(text)
        else:
            assert len(scene(text).compilation.flat.guards) == 3


def test_what_is_known_of_a_condition_is_left_out_of_it(scene: Write) -> None:
    """n == 3 beside what moves, in assertions, events, and functions."""
    text = """function g
      input Real x;
      input Integer n;
      output Real y;
    algorithm
      if n <> 7 then
        assert(n == 3 or x < 0.5, "too far");
      end if;
      y := x;
    end g;
    model M
      parameter Integer n = 2;
      Block b(m = 1, base = world, v(start = 1));
      output Real y = g(b.s/1[m], n);
    equation
      assert(n == 2 or b.s < 0.1, "never told");
      assert(not (n == 2 and b.s > 0.4), "beyond");
      when n <> 3 and b.s > 0.2 then
        reinit(b.v, 2);
      end when;
    end M;"""
    model = scene(text)
    assert len(model.compilation.flat.guards) == 2
    with pytest.raises(lag.RunError, match=r"t = 0\.3: beyond"):
        model.simulate(stop=1.0)
    with pytest.raises(lag.RunError, match="too far"):
        scene(text.replace("b.s > 0.4", "b.s > 4")).simulate(stop=1.0)


def test_texts_are_put_together(scene: Write) -> None:
    """Of numbers, truth values and values of enumerations that are known."""
    model = scene("""type Kind = enumeration(soft, hard);
    model M
      parameter Integer n = 3;
      constant Real third = 1/3;
      parameter String s = "n = " + String(n) + ", " + String(Kind.hard) + String(third, significantDigits = 3)
        + String(n > 2) + "|" + String(n, minimumLength = 3, leftJustified = false) + String(1000000*n + 1) + " "
        + String(abs(-3000001)) + " " + String(3000000/1);
      Block b(m = 1, base = world, along = {1, 0}, v(start = 1));
    equation
      assert(b.s < 1, s);
    end M;""")
    with pytest.raises(lag.RunError, match=r"t = 1: n = 3, hard0\.333true\|  33000001 3000001 3e\+06"):
        model.simulate(stop=2.0)


def test_inner_and_outer(scene: Write) -> None:
    """Two of one name: local references mean the outer one (Modelica 3.6, section 5.4)."""
    model = scene("""model Leaf
      outer Real k;
      Real y = 2*k;
    end Leaf;
    model Branch
      inner outer Real k = k + more;
      parameter Real more = 10;
      Real seen = k;
      Leaf leaf;
    end Branch;
    model M
      inner parameter Real k = 3;
      Branch one, other(more = 20);
      Block b(m = 1, base = world, along = {1, 0});
      output Real a = one.leaf.y, c = other.leaf.y, d = other.seen;
    end M;""")
    run = model.simulate(at=[0.0])
    assert [run[name][0] for name in "acd"] == [26.0, 46.0, 3.0]


def test_names_of_the_modelica_library(scene: Write) -> None:
    """A torsional oscillator in Modelica's words: w = sqrt(c/J)."""
    model = scene("""model M
      import SI = Modelica.Units.SI;
      import Modelica.Constants.{pi, g_n};
      import Modelica.Math.*;
      import R = Modelica.Mechanics.Rotational;
      import Modelica.Mechanics.Rotational.Components.Inertia;
      parameter SI.MomentOfInertia J = 2;
      parameter SI.RotationalSpringConstant c = 8*pi/Modelica.Constants.pi*1[N.m/rad];
      Inertia wheel(J = J, phi(start = 1));
      R.Components.Spring spring(c = c);
      Modelica.Mechanics.Rotational.Components.Fixed wall;
      output SI.Angle exact = Modelica.Math.cos(2[1/s]*time)*1[rad] + sin(0)*1[rad];
      output Real g = g_n/1[m/s2];
    equation
      connect(wall.flange, spring.flange_a);
      connect(spring.flange_b, wheel.flange_a);
    end M;""")
    run = model.simulate(stop=3.0)
    assert run["wheel.phi"] == pytest.approx(run["exact"], abs=1e-9)
    assert run["g"][0] == 9.80665


def test_functions_of_modelica_math_hide_others_of_their_names(scene: Write) -> None:
    """Imported by name, by another one, in the package or whole, in models and functions; elsewhere one's own is meant."""
    model = scene("""function sin
      input Real x;
      output Real y;
    algorithm
      y := 7*x;
    end sin;
    function h
      import Modelica.Math.sin;
      input Real x;
      output Real y;
    algorithm
      y := sin(x);
    end h;
    package P
      import Modelica.Math;
      model Q
        output Real y = Math.sin(1);
      end Q;
      model R
        import Modelica.Math.*;
        output Real y = sin(1);
      end R;
      model S
        import s = Modelica.Math.sin;
        output Real y = s(1);
      end S;
    end P;
    model M
      P.Q q;
      P.R r;
      P.S s;
      Block b(m = 1, base = world);
      output Real own = sin(1), other = h(1);
    end M;""")
    assert model.warnings == []
    run = model.simulate(at=[0.0])
    assert [run[name][0] for name in ("own", "other", "q.y", "r.y", "s.y")] == pytest.approx([7.0, *4*[0.8414709848078965]])
