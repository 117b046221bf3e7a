"""Names in components that are not there and in branches not taken are looked up; words before a name stand once."""

from collections.abc import Callable
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import main

Write = Callable[[str], lag.Model]
SCENE = "model P Real x = 2; end P; model M parameter Boolean has = false; parameter Integer n = 2; P p[3]; "\
        "Block b(m = 1, base = world); {} end M;"
WRONG = {
    "Damper d(a = world, b = b.center, c = banana) if has;": "'banana' is not known",
    "Damper d(a = world, b = b.centre, c = 1) if has;": "no member 'centre'",
    "equation if has then b.s = banana; end if;": "'banana' is not known",
    "equation if has then for i in 1:2 loop b.s = i*p[j].x*1[m]; end for; end if;": "'j' is not known",
    "output Length y = if has then foo(b.s) else b.s;": "there is no function 'foo'",
    "output Length y = if n > 2 then b.s else b.s + (if n == 7 then b.zzz else 0);": "no member 'zzz'",
    "energy if n > 5 then potential b.q*1[N]; end if;": "no member 'q'",
    "equation when b.s > 3 then if has then reinit(b.w, 0); end if; end when;": "no member 'w'",
    "energy if has then for e in P loop potential e*b.s*1[N]; end for; end if;": "'P' is not known",
    'equation if has then assert(b.s < 1, "far", AssertionLevel.warn); end if;': "'AssertionLevel' is not known",
    "final final parameter Real k = 3;": "'final' stands twice", "Bar c(each each m = 1, L = 1);": "'each' stands twice",
    "parameter constant Real k = 3;": "'constant' beside 'parameter'", "input output Real k;": "'output' beside 'input'",
    "replaceable replaceable model D = Damper;": "'replaceable' stands twice",
    "parameter input Real k = 1;": "'input' beside 'parameter'",
}
RIGHT = """Damper d(a = world, b = q.center, c = 3*sin(p[7].x)) if has; PointMass q(m = 1) if has;
  output Length y = if has then q.center.x + p[5].x*1[m] + sum(p[i].x for i in 1:9)*1[m] else b.s;
  output Length z = if has then size(p, 1)*1[m] + pre(y) + der(b.s)*1[s] else b.s;
equation if has then connect(q.center, b.center); for i in 1:3, j in 1:2 loop b.s = p[i].x*j*sum({m for m in 1:3})*1[m]; end for;
  when b.s > 3 then reinit(b.v, 2); terminate("x"); end when; assert(b.s > 3, "foo" + String(b.s)); end if;"""


WHATEVER_IS_TAKEN = """type E = enumeration(low, high);
record R Real k = 1; end R; function g input R r; output Real y; algorithm y := r.k; end g;
package P constant Real q = 3; package S constant Real z[2] = {5, 6}; end S; end P;
model Road parameter Real grade = 1; Real slope(stateSelect = StateSelect.never) = grade; end Road;
model M import Z = P.S; parameter Boolean has = HAS; parameter Real k[E] = {1, 2}, both[Boolean] = {1, 2}; parameter R r[2];
  inner Road road; Block b(m = 1, base = world);
  Spring s[E](each stretch = b.s, k = {k[e] for e in E}) if has annotation(Icon(graphics = {Line(points = {{0, 0}, {1, 1}})}));
  replaceable Road t[Boolean](each grade = Z.z[end], each slope(nominal = Any.thing)) if has constrainedby Road(grade = P.q);
  output Real y = if has then sum(k[e] for e in E) + sum(both[x] for x in Boolean) + g(r[2]) + sum(g(r[i]) for i) + Z.z[1] else 1;
  output Real z = if has then delay(b.s/1[m], 0.1) + road.grade + sum(k[e] for e in E.low:E.high) + time/1[s] + pi else 1;
equation
  if has then
    for e in E loop
      for i in 1:Integer(e) loop assert(r[i].k < 9 and k[e] > 0, "few" + String(i), level = AssertionLevel.error); end for;
    end for;
    assert(b.s < 1, "far", AssertionLevel.warning);
  end if;
energy
  if has then for e in E loop potential k[e]*b.s^2/2; end for; end if;
drawing
  if has then for e in E loop circle(b.center, size = 0.2*Integer(e)); end for; end if;
end M;"""
STARTS = {"initial equation b.s^2 = -1;": "cannot be solved", "initial equation sin(b.s/1[m]) = 1.5;": "it misses by 0.5",
          "initial equation der(der(b.s)) = 3;": "it misses by 3"}


@pytest.mark.parametrize("text", STARTS)
def test_starts_that_cannot_hold_are_told_by_check(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They were told by runs alone, where no loop asked for an assembly."""
    (tmp_path / "m.lag").write_text(f"model M Block b(m = 1, base = world); {text} end M;")
    assert main(["check", str(tmp_path / "m.lag")]) == 2
    assert "error[L0606]" in (told := capsys.readouterr().err) and STARTS[text] in told and "^^^" in told


@pytest.mark.parametrize("text", WRONG)
def test_what_names_nothing_is_refused(text: str, scene: Write) -> None:
    with pytest.raises(LagError) as found:
        scene(SCENE.format(text))
    assert WRONG[text] in str(found.value) and "^" in str(found.value)


@pytest.mark.parametrize("has", ["true", "false"])
def test_enumerations_levels_and_annotations_are_not(has: str, scene: Write) -> None:
    """Those that count elements and passes, `delay`, and attributes that mean nothing here were names of nothing, too."""
    assert scene(WHATEVER_IS_TAKEN.replace("HAS", has)).coordinate_names == ("b.s",)


def test_what_could_be_there_is_not(scene: Write) -> None:
    assert scene(SCENE.format(RIGHT)).coordinate_names == ("b.s",)
