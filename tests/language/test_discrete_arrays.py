"""Arrays of discrete variables, and events of their changes, beside answers by hand."""

from pathlib import Path

import pytest

import lagrangia

PARTS = """
model Part "Counts by one and by two"
  Integer n[2](each start = 0), all = sum(n);
  Boolean u;
equation
  when u then
    n[1] = pre(n[1]) + 1;
    n[2] = pre(n[2]) + 2;
  end when;
end Part;
model Parts "k = 1, 2, ..., 5 at 0.5, 1, ...; x = t"
  Block block(m = 1, base = world, v(start = 1));
  Integer k(start = 0), n[3](start = {0, 10, 20}), m[2] = {n[1] + 1, n[2] - n[1]}, M[2, 2], same[2];
  Integer seen[3](each start = 0), w[2](each start = 0), many(start = 0), h[2];
  Boolean b[2](each start = false), low[2] = {block.s < 1.1, n[1] < 2};
  discrete Real r[2](start = {0.5, 1});
  Part part[2](u = {block.s > 1.1, not low[2]});
  output Integer total = sum(n);
equation
  same = {n[1], k};
  when initial() then M = {{1, 2}, {3, 4}}; end when;
  when time > 0.5*(k + 1) then
    k = pre(k) + 1;
    n[1] = pre(n[1]) + 1;
    n[2] = pre(n[2]) + n[1];
    n[3] = pre(n[3]) - 1;
    b = {not pre(b[1]), block.s > 1.1};
    r = {time, pre(r[1])};
    M[2, 1] = k;
  end when;
  when block.s > 1.3 then w = pre(w) + {1, 2}; end when;
  for i in 1:3 loop
    when n[i] >= 3*i + 8 then seen[i] = pre(seen[i]) + 1; end when;
  end for;
  when same[1] + total > 40 and m[2] > 11 then many = pre(many) + 1; end when;
  when sample(0, 0.6) then h[1] = integer(2*block.s); h[2] = n[1]; end when;
  annotation(experiment(StopTime = 2.7));
end Parts;
"""
CHANGES = """
model Changes "n = 1, 2, ..., 5 at 0.5, 1, ...; r = 0.5, 1, ..., the first of which is its start; x = t"
  Block block(m = 1, base = world, v(start = 1));
  Integer n(start = 0), step(start = 0), first(start = 0), second(start = 0), whole = integer(block.s), wholes(start = 0);
  Integer flips(start = 0), rs(start = 0), one(start = 0), v[2](each start = 0), vs(start = 0), up(start = 0);
  discrete Real r(start = 0.5);
  Boolean b(start = false);
equation
  when initial() then up = 7; end when;
  when time > 0.5*(n + 1) then n = pre(n) + 1; b = not pre(b); r = 0.5*n; v = {n, integer(n/2)}; end when;
  when change(n) then first = pre(first) + 1; step = 10*n + pre(n); end when;
  when {change(n), block.s > 0.7} then second = pre(second) + 1; end when;
  when change(whole) then wholes = pre(wholes) + 1; end when;
  when change(b) then flips = pre(flips) + 1; end when;
  when change(r) then rs = pre(rs) + 1; end when;
  when change(v[2]) then vs = pre(vs) + 1; end when;
  when n/2 == 1 then one = pre(one) + 1; end when;
  assert(n <> 3, "three", AssertionLevel.warning);
  annotation(experiment(StopTime = 2.7));
end Changes;
"""
OF_PARTS = {"k": 5, "n[1]": 5, "n[2]": 25, "n[3]": 15, "b[1]": 1, "b[2]": 1, "r[1]": 2.5, "r[2]": 2, "M[1,1]": 1, "M[2,1]": 5,
            "w[1]": 1, "w[2]": 2, "seen[1]": 0, "seen[2]": 1, "seen[3]": 0, "many": 1, "h[1]": 4, "h[2]": 4, "part[1].n[1]": 1,
            "part[1].n[2]": 2, "part[2].n[1]": 1, "part[2].n[2]": 2, "total": 45}
OF_CHANGES = {"n": 5, "first": 5, "step": 54, "second": 6, "wholes": 2, "flips": 5, "rs": 4, "vs": 2, "one": 1, "up": 7}


@pytest.mark.parametrize(("text", "name", "wanted"), [(PARTS, "Parts", OF_PARTS), (CHANGES, "Changes", OF_CHANGES)])
def test_beside_hand(tmp_path: Path, text: str, name: str, wanted: dict[str, float]) -> None:
    file = tmp_path / f"{name}.lag"
    file.write_text(text, encoding="utf-8")
    model = lagrangia.load(file, model=name)
    for solver in ("auto", "erk", "implicit"):
        result = model.simulate(solver=solver)
        assert {x: float(result[x][-1]) for x in wanted} == pytest.approx(wanted, abs=1e-9)
        assert len([said for said in result.warnings if "three (n <> 3" in said]) == ("n <> 3" in text)
    assert not [said for said in model.warnings if "L0224" in said]


def test_a_variable_bound_to_one_that_events_set(tmp_path: Path) -> None:
    """m = n, as an equation, was told to be n's value."""
    file = tmp_path / "bound.lag"
    file.write_text(CHANGES.replace("equation\n", "  Integer m, ms(start = 0);\nequation\n  m = n;\n  when change(m) then "
                                    "ms = 10*m + pre(m); end when;\n", 1), encoding="utf-8")
    model = lagrangia.load(file)
    assert model.simulate()["ms"][-1] == 54 and not [said for said in model.warnings if "'ms'" in said or "pre(n)" in said]


WHOLE = """
model Whole "x = t; c and M change at 1 and 2, in two elements at once, and at 3 in one; on = {t > 1, t < 2, t > 3}"
  Block block(m = 1, base = world, v(start = 1));
  Integer c[2](each start = 0), M[2, 2](each start = 0), k(start = 0);
  Boolean on[3](start = {false, true, false});
  Integer changes(start = 0), last(start = 0), cells(start = 0), rises(start = 0), flips(start = 0);
equation
  when block.s > k + 1 then
    k = pre(k) + 1;
    c = {min(k, 2), 3*k};
    M = {{0, k}, {0, c[1]}};
    on = {true, k < 2, k > 2};
  end when;
  when change(c) then changes = pre(changes) + 1; last = pre(c[2]); end when;
  when change(M) then cells = pre(cells) + 1; end when;
  when edge(on) then rises = pre(rises) + 1; end when;
  when change(on) then flips = pre(flips) + 1; end when;
  annotation(experiment(StopTime = 3.5));
end Whole;
"""


def test_changes_and_edges_of_arrays(tmp_path: Path) -> None:
    """Of any element, and one event where several change at once."""
    file = tmp_path / "whole.lag"
    file.write_text(WHOLE, encoding="utf-8")
    result = lagrangia.load(file).simulate()
    wanted = {"k": 3, "changes": 3, "last": 6, "cells": 3, "rises": 2, "flips": 3}
    assert {name: result[name][-1] for name in wanted} == wanted


@pytest.mark.parametrize(("statement", "said"), [
    ("when change(block.s) then k = 1; end when;", "all the time"),
    ("when change(2*n) then k = 1; end when;", "an expression changes")])
def test_changes_that_are_none(tmp_path: Path, statement: str, said: str) -> None:
    file = tmp_path / "none.lag"
    file.write_text(f"""
model Still
  Block block(m = 1, base = world);
  Integer n(start = 0), k(start = 0);
equation
  when block.s > 1 then n = 1; end when;
  {statement}
end Still;
""", encoding="utf-8")
    with pytest.raises(lagrangia.LagError, match=said):
        lagrangia.load(file)
