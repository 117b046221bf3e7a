"""Units as people write them elsewhere are told as they are written here."""

from collections.abc import Callable

import pytest

import lagrangia as lag

MEANT = {"Nm": "N.m", "N m": "N.m", "m²": "m2", "kg*m²": "kg*m2", "sec": "s", "kgm2": "kg.m2", "Nms": "N.m.s",
         "Kg": "kg", "hz": "Hz"}


@pytest.mark.parametrize("unit", MEANT)
def test_a_hint_names_what_was_meant(scene: Callable[[str], lag.Model], unit: str) -> None:
    with pytest.raises(lag.LagError) as error:
        scene(f"model M output Real y = 3[{unit}]; Block b(m = 1, base = world); end M;")
    assert f"did you mean '{MEANT[unit]}'?" in str(error.value)


@pytest.mark.parametrize("kind", ["constant", "parameter"])
@pytest.mark.parametrize(("declared", "message"), [
    ('Real d(unit = "mm") = 3', 'unit = "m", displayUnit = "mm"'), ('Angle d(unit = "deg") = 90', 'unit = "rad"'),
    ('Real d(unit = "degC") = 20', 'unit = "K"'), ('Real d(unit = "foo") = 3', "'foo' is not a unit"),
    ('Real d(unit = u) = 3', 'unit = "m", displayUnit = "mm"'), ('Mm d = 3', 'unit = "m", displayUnit = "mm"'),
    ('Real d[2](each unit = "mm") = {3, 4}', 'unit = "m", displayUnit = "mm"'),
    ('Real d[2](unit = {"m", "s"}) = {3, 4}', "'unit' is one for all elements of an array, not 'm' and 's'"),
    ('Real d(unit = 3) = 3', "'unit' must be a text"), ('Real d(displayUnit = 3) = 3', "'displayUnit' must be a text"),
    ('Length d(displayUnit = "kg") = 3', "what is in m cannot be shown in kg"),
    ('Grams d = 3', "what is in kg cannot be shown in m"),
    ('Length d = 3[kg]', "'d' is in m, this is in kg"), ('Length d[2] = {3, 4[kg]}', "'d' is in m, this is in kg"),
    ('Length d = w*w/w', "'d' is in m, this is in kg"), ('Length d = P.w', "'d' is in m, this is in kg"),
    ('Length d = weight(3)', "'d' is in m, this is in kg"), ('Real d = 3[m] + w', "m and kg cannot be added"),
    ('Integer d = 3[kg]', "'d' is in 1, this is in kg"), ('Integer d(unit = "kg") = 3', "Integer has no attribute 'unit'"),
    ('Length d(min = 0[kg]) = 3', "'d.min' is in m, this is in kg"), ('Strict d(unit = "kg") = 3', "'unit' is final"),
    ('Stricter d = 3', "'unit' is final"), ('Length d(max = max(0, 9[kg])) = 3', "'d.max' is in m, this is in kg"),
    ('Integer d(min = 1[kg]) = 3', "'d.min' is in 1, this is in kg"),
])
def test_constants_and_parameters_are_declared_in_units_by_one_rule(
        scene: Callable[[str], lag.Model], kind: str, declared: str, message: str) -> None:
    with pytest.raises(lag.LagError) as error:
        scene(f"""model M
          type Mm = Real(unit = "mm");
          type Grams = Mass(displayUnit = "m");
          type Strict = Real(final unit = "m");
          type Stricter = Strict(unit = "kg");
          package P constant Mass w = 2; end P;
          function weight input Real x; output Mass y; algorithm y := x; end weight;
          constant String u = "mm";
          constant Mass w = 2;
          {kind} {declared};
          output Real y = 0*w + 0*sum({{d}});
          Block b(m = 1, base = world);
        end M;""")
    assert message in str(error.value)


@pytest.mark.parametrize("declared", [
    "Force d(min = 0.5*w) = 3", "Force d(min = w*0.5) = 3", "AngularVelocity d(max = 2*pi*50) = 3", "Energy d(max = 9*h^2) = 3",
    "Area d(min = sqrt(0.1*a)*h) = 3", "Area d(min = max(0, h)*h) = 3", "Length d(max = half(8)) = 3",
    'Real d(unit = "") = 3', 'Real d(unit = u) = 3', 'Length d = 300[cm]', 'Far d = 3[m]', 'Real d[1](unit = {"m"}) = {3}',
])
@pytest.mark.parametrize("kind", ["constant", "parameter"])
def test_units_of_declarations_that_are_right(scene: Callable[[str], lag.Model], kind: str, declared: str) -> None:
    model = scene(f"""model M
      type Heavy = Real(unit = "kg", min = 5);
      type Far = Heavy(unit = "m", min = 1) "says other things than what it derives from";
      function half input Real x; output Real y; algorithm y := x/2; end half;
      constant String u = "m";
      constant Mass w = 2;
      constant Length h = 1;
      constant Area a = 4;
      {kind} {declared};
      output Real y = sum({{d}}) + (if u == "m" then 0 else 1);
      Block b(m = 1, base = world);
    end M;""")
    assert model.simulate(stop=0.1)["y"][-1] == 3


@pytest.mark.parametrize(("parts", "message"), [
    ("input Real x; output Length y; algorithm y := 3[kg];", "'y' of M.f is in m, this is in kg"),
    ("input Mass x = 3[m]; output Real y; algorithm y := x;", "'x' of M.f is in kg, this is in m"),
    ("input Real x; output Real y; protected Length d = 3[kg]; algorithm y := d*x;", "'d' of M.f is in m, this is in kg"),
    ("input Length x(min = 0[kg]) = 1; output Real y; algorithm y := x;", "'M.f.x.min' is in m, this is in kg"),
    ("input Real x(unit = 3) = 1; output Real y; algorithm y := x;", "'unit' must be a text"),
    ('input Real x(displayUnit = "foo") = 1; output Real y; algorithm y := x;', "'foo' is not a unit"),
    ("input Real x(foo = 3) = 1; output Real y; algorithm y := x;", "Real has no attribute 'foo'"),
    ("input Mass x = 1; output Length y; algorithm if x > 2 then y := x; else y := 1; end if;",
     "'y' of M.f is in m, this is in kg"),
])
def test_variables_of_functions_are_declared_in_units_by_the_same_rule(
        scene: Callable[[str], lag.Model], parts: str, message: str) -> None:
    given = "" if "x = " in parts or "= 1;" in parts else "1"
    with pytest.raises(lag.LagError) as error:
        scene(f"model M function f {parts} end f; output Real y = f({given}); Block b(m = 1, base = world); end M;")
    assert message in str(error.value)


@pytest.mark.parametrize(("limit", "message"), [
    ("E.b", "the parameter 'g' is a, less than its minimum b"), ("1", "'min' must be a value of M.E"),
    ("F.a", "'min' must be a value of M.E")])
def test_limits_of_enumerations_are_values_of_theirs(scene: Callable[[str], lag.Model], limit: str, message: str) -> None:
    text = """model M type E = enumeration(a, b); type F = enumeration(a);  parameter E g(min = %s) = E.a;
      Block b(m = if g == E.a then 1 else 2, base = world); end M;"""
    assert scene(text % "E.a").scene
    with pytest.raises(lag.LagError) as error:
        scene(text % limit)
    assert message in str(error.value)


@pytest.mark.parametrize("text", [
    "Real c = delay(b.v, 0.1)", "Real c = product({b.s, b0.s})", "Real c = product(b.s for k in 1:2)",
    "parameter Real c = 3[m2]", "parameter Area a = 3; parameter Real c = a", "R r = R(c = 3[m2]); Real c = r.c",
    "discrete Real c(start = 1[m2]); equation when time > 0.5 then c = 2; end when",
    "discrete Real c(start = 1); equation when time > 0.5 then c = pre(c) + b.v; end when",
    "discrete Real c(start = 1); equation when sample(0, 0.1) then c = b.v; end when",
    "Real c(start = 1[m2]); equation der(c) = -2*c", "Real c(start = 1); equation der(c) = b.v*b.s",
])
def test_what_is_declared_without_a_unit_has_that_of_what_it_is_made_of(scene: Callable[[str], lag.Model], text: str) -> None:
    """An area or a speed that is taken for a length."""
    with pytest.raises(lag.LagError, match=r"L0304.*'y' is in m, this is in"):
        scene(f"""model M
          record R Real c; end R;
          Block b(m = 1, base = world), b0(m = 1, base = world);
          {text};
          output Length y = c;
        end M;""")


def test_values_at_events_are_in_the_unit_of_the_start(scene: Callable[[str], lag.Model]) -> None:
    with pytest.raises(lag.LagError, match="s and m cannot be equal"):
        scene("""model M
          Block b(m = 1, base = world);
          discrete Real n(start = 1[s]);
        equation
          when time > 0.5 then n = b.s; end when;
        end M;""")


def test_numbers_at_events_and_of_states_may_measure_anything(scene: Callable[[str], lag.Model]) -> None:
    run = scene("""model M
      Block b(m = 1, base = world, s(start = 2));
      discrete Real w(start = 0);
      Real x(start = 0);
      output Length above = b.s - w, beyond = b.s - x;
    equation
      b.v = 0;
      der(x) = b.s/1[m];
      when time > 0.5 then w = 0.5 + time/1[s]; end when;
    end M;""").simulate(stop=1)
    assert run["above"][-1] == pytest.approx(1.0, abs=1e-9)
    assert run["beyond"][-1] == pytest.approx(0.0, abs=1e-9)
