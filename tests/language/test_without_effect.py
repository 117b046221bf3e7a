"""What is written and changes nothing is pointed at, and nothing else is."""

from collections.abc import Callable
from pathlib import Path

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
BODY = "Block b(m = 1, base = world, s(start = 0.1)); Spring s(k = 2, stretch = b.s);"
VAIN = {
    "equation connect(world, b.base);": "joined already", "equation connect(b.center, b.center);": "to itself",
    "equation connect(b.center, shift(world, {b.s, 0})) annotation(Foo = 1, Line(points = {{0, 0}, {1, 1}}));":
        "the annotation 'Foo' has no effect here",
    "equation": "this section is empty", "initial equation": "this section is empty", "energy": "this section is empty",
    "constant Real a = 3;": "nothing reads the constant 'a'", "parameter Integer n = 3;": "nothing reads the parameter 'n'",
    "parameter Boolean n = true;": "nothing reads the parameter 'n'",
    'parameter String n = "a";': "nothing reads the parameter 'n'",
    "AppliedForce f(at = world, force = {1, 0});": "'f' does nothing", "PointMass p(m = 1, center = world);": "'p' does nothing",
    "AppliedTorque f(on = shift(world, {1, 0}), torque = 3);": "'f' does nothing",
    "energy potential 3[J];": "speaks of nothing that moves", "energy kinetic 3[J];": "speaks of nothing that moves",
    "energy dissipation 1[N/s]*b.s;": "speaks of no rate", "energy work 3[N] on 2[m/s]*time;": "speaks of nothing that moves",
    "equation when b.s < 0 then reinit(b.v, b.v); end when;": "sets a rate to what it is",
    "equation when b.s < 0 then reinit(b.v, pre(b.v)); end when;": "sets a rate to what it is",
    "Integer n(start = 1); equation when b.s < 0 then n = pre(n); end when;": "sets 'n' to what it is",
    "equation if true then end if;": "nothing stands in this block",
    "output Length y = b.s*(1 + 0*time);": "this is 0, whatever 'time' is",
    "AppliedForce f(at = b.center, force = {b.s*0.0[N/m], 2});": "this is 0, whatever 'b.s' is",
    "function f input Real x; output Real y; algorithm y := 1 - 0/x; end f; output Real q = f(b.s/1[m]);": "whatever 'x' is",
    "output Length y = if time > 1 then b.s elseif time>1 then 2*b.s else 0;": "is never taken: 'time>1' stands in",
    "AppliedForce f(at = b.center, force = {if time > 1 then 2*b.s*1[N/m] else 2*b.s*1[N/m], 0});": "both branches are '2*b.s",
    "output Real y = 2 annotation(HideResult = true);": "the annotation 'HideResult' has no effect",
    "inner Real w = 3; output Real y = w;": "'inner' has no effect: no component inside has an outer 'w'",
    "Rotational.Inertia i(J = 1), j(J = 1, flange_a = i.flange_b); equation connect(j.flange_a, i.flange_b);":
        "'j.flange_a' and 'i.flange_b' are joined already",
    "Rotational.Inertia i(J = 1); equation connect(i.flange_a, i.flange_a);": "joins a connector to itself",
    "parameter output Length L = 1; output Length y = b.s + L;": "'output' has no effect on a parameter",
    "equation for i in 1:3 loop end for;": "nothing stands in this block",
    "Disc d(each m = 1, r = 1, center = b.center);": "'each' has no effect", "discrete Real x = 1;": "'discrete' has no effect",
    "Length q(min = 5) = b.s;": "'min' of 'q' has no effect", "Length q(nominal = 5) = b.s;": "'nominal' of 'q' has no effect",
    "parameter Real k(start = 3) = 1; output Real y = k*time;": "'start' of 'k' has no effect",
    "coordinate Length x(max = 3); energy kinetic 1[kg]*der(x)^2;": "'max' of 'x' has no effect",
    "energy potential virtual(b.s)*1[N];": "virtual(x) is 0 here",
    "output Length y = b.s + virtual(b.s);": "virtual(x) is 0 here",
    "equation when virtual(b.s) + b.s < 0 then reinit(b.v, 1); end when;": "virtual(x) is 0 here",
    "Bar bar(m = 1, L = 1); Revolute r(a = world, b = bar.a); TorsionSpring t(a = bar.a, b = bar.a, k = 1);":
        "'t' does nothing: its two ends are one",
    "Rotational.Inertia i(J = 1); Rotational.SpringDamper t(c = 1, d = 1, flange_a = i.flange_a, flange_b = i.flange_b);":
        "'t' does nothing: its two ends are one",
    "energy work 0 on b.s;": "a force of 0",
    "AppliedForce f(at = b.center, force = {0, 0});": "'f' does nothing",
    "Force z = -0*3*2[N]; ForcePair f(a = world, b = b.center, force = z);": "'f' does nothing",
    "energy potential 0*b.s;": "an energy of 0",
    "energy for i in 3:1 loop potential i*b.s*1[N]; end for;": "this loop has no pass",
    "energy if false then potential b.s*1[N]; end if;": "this condition is false",
    "coordinate Length x; equation x = b.s; 2*x = 2*b.s; energy kinetic 1[kg]*der(x)^2/2;": "this equation removes nothing",
    "model T end T; T t;": "nothing uses 't'",
    "model T parameter Real k = 2; coordinate Length x; energy kinetic 1[kg]*der(x)^2; end T; T t;": "the parameter 'k'",
    "function f input Real x; output Real y; algorithm y := x; annotation(derivative = g); end f; output Real q = f(b.s/1[m]);":
        "the annotation 'derivative'",
    "function f input Real x; output Real y; algorithm y := 3*x; y := x; end f; output Real q = f(b.s/1[m]);":
        "nothing reads this value of 'y'",
    "function f input Real x; output Real y = 3; algorithm y := x; end f; output Real q = f(b.s/1[m]);": "this value of 'y'",
    "function f input Real x; output Real y; protected Real t; algorithm t := x; y := t; t := 2; end f; "
    "output Real q = f(b.s/1[m]);": "this value of 't'",
    "function f input Real x; output Real y; protected Real v[2]; algorithm v[1] := x; v[2] := x; v[1] := 2; y := v*v; end f; "
    "output Real q = f(b.s/1[m]);": "this value of 'v[1]'",
    "function f input Real x; output Real y; algorithm y := x; if x > 0 then y := 1; else y := 2; end if; end f; "
    "output Real q = f(b.s/1[m]);": "this value of 'y'",
    "annotation(solver = 3);": "the annotation 'solver'", "annotation(Evaluate = true);": "the annotation 'Evaluate'",
    "Length q = b.s annotation(Varying = true);": "the annotation 'Varying'",
}
WRONG = {
    "parameter Length L(displayUnit = \"furlong\") = 1; output Length y = L;": "'furlong' is not a unit",
    "parameter Length L(displayUnit = \"kg\") = 1; output Length y = L;": "cannot be shown in kg",
    "annotation(experiment(StopTime = 1[kg]));": "StopTime is in kg", "annotation(experiment = 3);": "an experiment has no value",
    "annotation(experiment(StopTime = 1, StopTime = 2));": "given twice", 'annotation(allow = "L9999");': "no warning 'L9999'",
    "annotation(experiment(StopTime = 1)); annotation(experiment(StopTime = 2));": "given twice",
    "Block c(m = 1, base = world, s(start = 1), s(start = 2));": "given twice",
}


@pytest.mark.parametrize("text", VAIN)
def test_what_changes_nothing_is_pointed_at(scene: Write, text: str) -> None:
    (told,) = scene(f"model M {BODY} {text} end M;").warnings
    assert told.startswith("warning[L0224]") and VAIN[text] in told, told
    assert "scene.lag:1:" in told


@pytest.mark.parametrize("text", WRONG)
def test_what_cannot_be_meant_is_refused(scene: Write, text: str) -> None:
    with pytest.raises(lag.LagError) as error:
        scene(f"model M {BODY} {text} end M;")
    assert WRONG[text] in str(error.value)


@pytest.mark.parametrize("text", [
    'annotation(Documentation(info = "x"), version = "1", __mine = 3);', "annotation(experiment(StopTime = 100[ms]));",
    "Disc d[2](each m = 1, each r = 1, each center = b.center);", "constant Integer n = 2; Disc d[n](each m = 1, each r = 1, "
    "each center = b.center);",
    "Bar p(m = 1, L = 1); Revolute r(a = world, b = p.a); TorsionSpring t(a = world, b = p.a, k = 1);",
    "Rotational.Inertia i(J = 1), j(J = 1); Rotational.Spring t(c = 1, flange_a = i.flange_b, flange_b = j.flange_a);",
    "parameter Integer n = 0; energy for i in 1:n loop potential i*b.s*1[N]; end for;",
    "PointMass p(m = 1, center = world); Spring r(a = p.center, b = b.center, k = 1);",
    "Weld w(a = world); PointMass p(m = 1, center = w.b);", "Block c(m = 1, base = world, s(start = 1), s(fixed = true));",
    "function f input Real x; output Real y = 0; protected Real t = 1; Real v[2]; algorithm for i in 1:3 loop y := y + t; t := x;"
    " end for; v[1] := y; if x > 0 then v[1] := 1; end if; y := y + v[1]; end f; "
    "output Real q = f(b.s/1[m]);",
    "Bar wall(m = 1, L = 1, a = world); Spring r(a = wall.b, b = b.center, k = 1);", "input Force u(min = 0) = 1; "
    "AppliedForce f(at = b.center, force = {u, 0});"])
def test_what_has_an_effect_is_not(scene: Write, text: str) -> None:
    assert scene(f"model M {BODY} {text} end M;").warnings == []


def test_what_others_read_is_no_number_for_nothing(scene: Write) -> None:
    """A sibling that is not in the scene reads L; a function inside the class reads k."""
    text = """package P
      model Base parameter Length L = 1; constant Real k = 2; Real z = f(1);
        function f input Real x; output Real y; algorithm y := k*x; end f; end Base;
      model One extends Base; output Real y = z; end One;
      model Two extends Base; output Length q = L; end Two;
    end P; """
    assert scene(f"{text} model M {BODY} P.One one; end M;").warnings == []


@pytest.mark.parametrize("head, inside", [
    ("type E = enumeration(a, b annotation(foo = 1));", "parameter E e = E.a; output Real y = if e == E.a then 1 else 2;"),
    ("package A model B Real y = 1; end B; end A;", "import A.B annotation(foo = 1); B x;"),
    ("package A model B Real y = 1; end B; end A;", "import A.* annotation(foo = 1); B x;"),
    ("package A model B Real y = 1; end B; end A;", "import A.{B} annotation(foo = 1); B x;"),
    ("package A model B Real y = 1; end B; end A;", "import C = A.B annotation(foo = 1); C x;")])
def test_annotations_of_values_and_imports_that_nobody_knows(scene: Write, head: str, inside: str) -> None:
    (told,) = scene(f"{head} model M {inside} {BODY} end M;").warnings
    assert "L0224" in told and "the annotation 'foo' has no effect here" in told


def test_of_the_experiments_of_two_bases_the_first_counts(scene: Write) -> None:
    """An experiment of the scene itself, and one that both bases have from one model, are no rivals."""
    text = f"""model A {BODY} annotation(experiment(StopTime = 2)); end A;  model N end N;
      model B extends N; annotation(experiment(StopTime = 5, Tolerance = 1e-6)); end B;  model D extends B; end D;
      model M extends A; extends D; %s end M;"""
    (told,) = scene(text % "").warnings
    assert "this StopTime has no effect: another model that M extends has one" in told and "scene.lag:2:" in told
    assert scene(text % "annotation(experiment(StopTime = 3));").warnings == []
    assert scene(text.replace("StopTime = 2", "StopTime = 5.0[s]") % "").warnings == []  # they agree
    assert scene("model A annotation(experiment(StopTime = 2)); end A; model B extends A; end B; model D extends A; end D; "
                 f"model M extends B; extends D; {BODY} end M;").warnings == []


def test_inputs_of_functions_that_nothing_reads(scene: Write) -> None:
    text = "function f input Real x; input Real y; output Real z; protected Real w, v; algorithm w := x; z := w; end f;"
    told = scene(f"{text} function g input Real x; output Real z = x; end g; "
                 f"model M {BODY} output Real q = f(b.s/1[m], 2) + g(1); end M;").warnings
    assert [x.partition(": ")[2].splitlines()[0] for x in told] == ["nothing reads the input 'y' of f",
                                                                    "nothing reads the variable 'v' of f"]


def test_imports_that_names_of_the_class_hide(tmp_path: Path) -> None:
    (tmp_path / "a.lag").write_text("""package P constant Real k = 5; end P;
      model M import P.k; parameter Real k = 7; World world; Block b(m = k, base = world); end M;""")
    (warning,) = lag.load(tmp_path / "a.lag").warnings
    assert "nothing uses this 'k': M has one of its own" in warning


def test_imports_that_nothing_uses(tmp_path: Path) -> None:
    """What a file brings that is imported by another one counts for it."""
    for name, text in (("parts", f"model Part {BODY} end Part;"), ("all", 'import "parts.lag"; model Other Block b; end Other;'),
                       ("none", "model None Block b; end None;")):
        (tmp_path / f"{name}.lag").write_text(text)
    main = tmp_path / "main.lag"
    main.write_text('import "all.lag"; import "none.lag"; import "all.lag"; model M Part p; end M;')
    found = lag.load(main).warnings
    assert [x.partition(": ")[2].splitlines()[0] for x in found] == ["nothing uses 'none.lag'", "'all.lag' is imported already"]


def test_inputs_keep_to_their_limits(scene: Write) -> None:
    text = "model M input Force u(min = 0, max = 2, start = {}); Block b(m = 1, base = world); " \
           "AppliedForce f(at = b.center, force = {{u, 0}}); end M;"
    model = scene(text.format(1))
    for inputs in ({"u": 3.0}, ([0.0, 1.0], {"u": [0.0, -1.0]})):
        with pytest.raises(lag.LagError, match=r"L0605.*the input 'u' is"):
            model.simulate(at=[1], inputs=inputs)
    with pytest.raises(lag.LagError, match="L0605"):
        scene(text.format(5)).simulate(at=[1])
