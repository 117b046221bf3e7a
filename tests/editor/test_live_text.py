"""Changes of a text, read statement by statement, give the tree that the whole text gives."""

import random
import re
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from lagrangia.base.diagnostics import LagError, Source, Span
from lagrangia.editor.live_text import LiveText
from lagrangia.editor.reading import Known, read_text
from lagrangia.language.syntax import parse

PIECES = ("// why\n", "/* a", "*/", '"', "'", ";", "(", ")", "Real z; ", "parameter Real a = -1 + 2 - 3, b; ", "a.", "end",
          "extends W(x = 1); ", "protected ", "public ", "annotation(Icon());", "x = 2*y; ", "final ", " model N end N; ",
          "equation ", "\n", "7", "for i in 1:2 loop x = i; end for; ", "kinetic 1;", "import A.B;", "connect(a.b, c[1].d); ",
          "when x < 0 then reinit(x, 1); ")
TEXTS = ("""import "p.lag";
model W "words" Real w; end W;
model M "of a class"
  Real a, b = 3, c; // c
  extends W(w = -1 + 2 + 3);
protected
  parameter Length d[2] = {1, 2} "d"; Real e;/* e */Real f;
  Real g if a > 1;
equation
  a = b; b = -c*2 + 1;
  for i in 1:2 loop d[i] = 1; end for;
  if true then e = 1; else e = 2; end if; f = 1;
energy
  kinetic 1; potential 2; dissipation 3;
end M;
model N extends M; Real z; Real y; Real x; algorithm x := 1; y := 2; z := 3; end N;
""", *(Path(__file__).parents[2] / "models" / name for name in ("examples/four_bar.lag",)))


def plain(x: Any, source: Source) -> Any:
    """A tree, with where all of it stands."""
    if isinstance(x, Span):
        assert x.source is source
        return x.start, x.end
    if isinstance(x, tuple):
        return [plain(item, source) for item in x]
    if is_dataclass(x) and not isinstance(x, Source):
        return type(x).__name__, [plain(getattr(x, field.name), source) for field in fields(x)]
    return x.text if isinstance(x, Source) else x


def said(read: Any, source: Source) -> Any:
    try:
        return plain(read(source), source)
    except LagError as error:
        return [(d.code, d.message, d.span and (d.span.start, d.span.end)) for d in error.diagnostics]


def changed(text: str, rng: random.Random) -> str:
    """One place of it: mostly a word, a line or a statement, else anything."""
    kind = rng.randrange(6)
    if kind < 2:
        found = rng.choice(list(re.finditer(r"\w+", text)))
        return text[: found.start()] + rng.choice(("x", "12", "2.5", f"{found[0]}2")) + text[found.end() :]
    if kind < 5:
        lines = text.split("\n")
        k = rng.randrange(len(lines))
        lines[k : k + rng.randrange(2)] = rng.choice(([], [rng.choice(PIECES)], [lines[k], lines[k].replace("a", "a9")]))
        return "\n".join(lines)
    start = rng.randrange(len(text) + 1)
    end = min(len(text), start + rng.choice((0, 0, 1, 3, 20, 200)))
    return text[:start] + rng.choice((*PIECES, "", text[start : start + rng.randrange(60)])) + text[end:]


def test_changed_statements_give_the_tree_of_the_whole() -> None:
    rng, fast = random.Random(7), 0
    for begin in TEXTS:
        text = good = begin if isinstance(begin, str) else begin.read_text()
        live = LiveText()
        for _ in range(60):
            new = changed(text, rng)
            if live.syntax is not None and new == live.syntax.source.text:
                continue
            before, source = live.recorder, Source("x", new)
            assert said(live.tree, source) == said(parse, source), (text, new)
            is_right = live.syntax is not None and live.syntax.source is source
            fast += is_right and live.recorder is before
            good = new if is_right else good
            text = new if rng.random() < 0.3 else good  # also from one that is wrong to the next
    assert fast > 15


SCENE = """model Swing "a swing"
  parameter Length L = 2 "length";
  parameter Integer n = 3;
  parameter Boolean is_held = true;
  Revolute hinge(a = world, phi(start = 1, fixed = is_held));
  Bar bar(m = 2, L = L, a = hinge.b), other(m = 1, L = 1, a = bar.b);
  Spring s(k = 3, a = world, b = bar.center);
  Prismatic slide[n](each a = world);
  Block block[n](each m = 1, base = slide.b);
  Leg leg(L = 0.25, n = n);
  protected Damper d(c = 2, a = world, b = other.b); output Length y = bar.b.y;
equation
  connect(leg.hip, bar.a); connect(leg.foot[1], leg.foot[2]);
end Swing;
"""
LEG = """model Leg
  parameter Length L = 0.5;
  parameter Integer n = 2;
  Frame hip, foot[n];
equation
  for i in 1:n loop foot[i] = shift(hip, {i, -L}); end for;
end Leg;
"""


DRIVE = """import Rotational.*;
type Way = enumeration(up, down);
package Numbers constant Real g = 9.81; constant Integer two = 2; end Numbers;
function Twice input Real x; output Real y; algorithm y := 2*x; end Twice;
model Stage
  parameter Boolean is_stiff = true; parameter Integer n = 2; parameter Real ratio(min = 0[m]/1[m]) = 3;
  parameter Way way = Way.up;
  constant Real c = 2*n; Flange a, b;
  Spring s(c = if is_stiff then 100 else 1, flange_a = a, flange_b = b) if n > 1;
  Real x = n*Numbers.g; Real table_[n] = fill(ratio, n);
end Stage;
model Drive
  parameter Integer n = Numbers.two; parameter Boolean is_stiff = n > 1; parameter Real m[n] = {1, 2}; constant Real j = 2[kg.m2];
  Inertia first(J = j, phi(start = 0.1)), last(J = Twice(m[2])*1[kg.m2]);
  SpringDamper spring(c = 10, d = 1, flange_a = first.flange_b, flange_b = last.flange_a);
  Stage stage(is_stiff = is_stiff, n = n, ratio = m[1]), other(n = stage.n);
  Torque torque(tau = stage.x*1[N.m] + last.J*0, flange = last.flange_b);
  Inertia many[n](each J = j); Bar bar(m = other.x*1[kg], L = 1, a = world), far(m = 1, L = stage.n, a = bar.b);
equation
  connect(many[1].flange_a, many[2].flange_a); when first.w > 3 then reinit(last.w, 0); end when;
end Drive;
"""
SPACE = """model Top
  World world(gravity = {0, 0, -9.81}); parameter Real up[3] = {0, 0, 1}; parameter Integer n = 3; Real free;
  Spherical ball(a = world); Body body(m = 1, I = {1, 1, 1}, center = ball.b);
  Revolute turn(a = body.center, axis = up), other(a = turn.b, axis = {1, 0, 0}); Prismatic rail(a = other.b, along = turn.axis);
  PointMass p(m = n, center = other.b); Prismatic slide(a = turn.b, along = {0, n, 1}); PointMass q(m = 2, center = slide.b);
equation
  free = p.center.z;
end Top;
"""


def meant(x: Any) -> Any:
    """What a flat model says, and where."""
    if isinstance(x, Span):
        return str(x), x.text
    if isinstance(x, dict):
        return [(meant(key), meant(value)) for key, value in x.items()]
    if isinstance(x, tuple | list | set | frozenset):
        items = [meant(item) for item in x]
        return items if isinstance(x, tuple | list) else sorted(map(repr, items))
    parts = [meant(getattr(x, f.name)) for f in fields(x) if f.name != "repeats"] if is_dataclass(x) else []
    return (type(x).__name__, parts) if parts else repr(x)


def looked_at(texts: str, changes: int, path: Path, rng: random.Random) -> int:
    """Changes a text so often; how often what a component brings was kept."""
    text, known, kept = texts, Known(), 0
    path.write_text(texts)
    for _ in range(changes):
        new = changed(text, rng)

        def read(path: Path, new: str = new) -> Source:
            return Source(str(path), new)

        live, fresh = read_text(path, read, known), read_text(path, read)
        assert [d.render() for d in live.diagnostics] == [d.render() for d in fresh.diagnostics], (text, new)
        assert meant(live.flat) == meant(fresh.flat), (text, new)
        kept += any(one is c.visits.last.get(key) for scene in known.components.values() for c in scene.spaces.values()
                    for key, one in c.visits.now.items())
        text = new if rng.random() < 0.2 or not any(d.severity == "error" for d in fresh.diagnostics) else texts
    return kept


@pytest.mark.parametrize("texts", [LEG + SCENE, DRIVE, SPACE], ids=("plane", "drive", "space"))
def test_what_is_kept_of_a_text_changes_nothing_that_is_told_of_it(texts: str, tmp_path: Path) -> None:
    """Diagnostics with their places, and the flat model, of a text after each of many changes, as of one that is read afresh."""
    path = tmp_path / "x.lag"
    path.write_text(texts)
    assert not [d for d in read_text(path, lambda path: Source(str(path), texts)).diagnostics if d.severity == "error"]
    assert looked_at(texts, 60, path, random.Random(3)) > 1


def test_one_component_of_many_is_made_anew(tmp_path: Path) -> None:
    parts = "".join(f"  Bar b{k}(m = 1, L = 1, a = {f'b{k - 1}.b' if k else 'world'});\n" for k in range(20))
    known, path = Known(), tmp_path / "x.lag"
    path.write_text("")
    for mass in "12":
        text = f"model M\n{parts}end M;\n".replace("b7(m = 1", f"b7(m = {mass}")
        read_text(path, lambda path, text=text: Source(str(path), text), known)
    (kept,) = (c for scene in known.components.values() for c in scene.spaces.values())
    assert len(kept.now) == 20 and sum(kept.last.get(key) is one for key, one in kept.now.items()) == 19
    assert len(kept.visits.now) == 20 and sum(kept.visits.last.get(key) is one for key, one in kept.visits.now.items()) == 18


def test_imports_of_what_is_not_there_are_told_of(tmp_path: Path) -> None:
    """In a text with classes that have inputs they ended the reading."""
    path, text = tmp_path / "x.lag", DRIVE.replace("import Rotational.*", "import Rotatonal.*")
    path.write_text(text)
    assert "L0204" in [d.code for d in read_text(path, lambda path: Source(str(path), text)).diagnostics]
