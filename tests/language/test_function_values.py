"""Functions of arrays and records, with several results, defaults and while loops: values and derivatives."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
MODEL = """
record R "of a load" Real a = 1; Real b[2]; end R;
record P R r; Real c; end P;
function length_of "of a vector" input Real x[:]; output Real y; protected Real s = 0;
algorithm for i in 1:size(x, 1) loop s := s + x[i]^2; end for; y := sqrt(s); end length_of;
function scaled input Real x[:]; input Real k = 2; output Real y[size(x, 1)]; algorithm y := k*x; end scaled;
function extremes input Real x[:]; output Real low = x[1]; output Real high = x[1];
algorithm for i in 2:size(x, 1) loop
  if x[i] < low then low := x[i]; elseif x[i] > high then high := x[i]; end if; end for; end extremes;
function turned input R r; output R s; algorithm s.a := -r.a; s.b := r.b[{2, 1}]; end turned;
function packed input R r; input Real c; output P p; algorithm p.r := turned(r); p.c := c; end packed;
function power input Real x; input Integer n; output Real y; protected Integer k = 0;
algorithm y := 1; while k < n loop y := y*x; k := k + 1; end while; end power;
function iterated "x := A*x" input Real A[:, size(A, 1)]; input Real x0[size(A, 1)]; input Integer n; output Real x[size(A, 1)];
algorithm x := x0; for i in 1:n loop x := A*x; end for; end iterated;
function spread input Real x[:]; output Real y; protected Real a, b; algorithm (a, b) := extremes(x); y := b - a; end spread;
function totals input R r[2]; output Real y; algorithm y := sum(r.a) + r[2].b[1]; end totals;
function solved "of A x = b, by elimination without pivots" input Real A[:, :]; input Real b[size(A, 1)];
  output Real x[size(A, 1)]; protected Integer n = size(A, 1); Real U[n, n] = A; Real f;
algorithm x := b;
  for k in 1:n - 1 loop for i in k + 1:n loop
    f := U[i, k]/U[k, k]; U[i, :] := U[i, :] - f*U[k, :]; x[i] := x[i] - f*x[k]; end for; end for;
  for j in 0:n - 1 loop
    for i in n - j + 1:n loop x[n - j] := x[n - j] - U[n - j, i]*x[i]; end for; x[n - j] := x[n - j]/U[n - j, n - j]; end for;
end solved;
model M
  Block b(m = 1, base = world, s(start = 3));
  R r(a = 3, b = {4, 2}); R t = turned(r); P p = packed(r, 5); R both[2](a = {1, 2}, each b = {7, 8});
  Real lo, hi, only;
STATED
equation
  (lo, hi) = extremes({b.s, 2, 5}); (, only) = extremes({1, 9, 4});
end M;
"""
VALUES = {
    "length_of({3, 4, 12})": 13, "length_of(fill(1, 9))": 3, "scaled({1, 2})[2]": 4, "sum(scaled({1, 2}, k = 5))": 15, "lo": 2,
    "hi": 5, "only": 9, "t.a": -3, "t.b[1]": 2, "p.r.b[2]": 4, "p.c": 5, "power(b.s, 3)": 27, "power(2, 0)": 1,
    "sum(iterated([0, 1; 1, 1], {1, 1}, 5))": 21, "spread({4, b.s, 8, 6})": 5, "totals(both)": 10,
    "totals({R(a = 1, b = {2, 3}), turned(r)})": 0, "length_of(scaled(scaled({3, 4})))": 20, "extremes({4, 1, 2})": 1,
    "solved([2, 1, 0; 1, 3, 1; 0, 1, 4], {3, 5, 5})*{1, 10, 100}": 111,
}


def test_they_give_what_they_say(scene: Write) -> None:
    taken = {text: text.replace("scaled({1, 2})[2]", "sum(scaled({1, 2})) - 2") for text in VALUES}
    stated = "\n".join(f"  output Real y{k} = {text};" for k, text in enumerate(taken.values()))
    model = scene(MODEL.replace("STATED", stated))
    run = model.simulate(at=[0.0])
    assert {text: run[f"y{k}"][0] for k, text in enumerate(taken)} == pytest.approx(VALUES, abs=1e-13)
    assert not model.compilation.flat.warnings


def test_they_are_differentiated_exactly(scene: Write) -> None:
    """Of |(3, t^2)|, and of the solution of (2 + t) x + y = 1, x + 2 y = t."""
    stated = "output Real y = der(length_of({3, time^2})), z = der(solved([2 + time, 1; 1, 2], {1, time})*{1, 0});"
    run = scene(MODEL.replace("STATED", stated)).simulate(at=[0.0, 1.0, 1.5], stop=1.5)
    t = np.array([0.0, 1.0, 1.5])
    assert run["y"] == pytest.approx(2 * t**3 / np.sqrt(9 + t**4), abs=1e-13)
    assert run["z"] == pytest.approx((-(3 + 2 * t) - 2 * (2 - t)) / (3 + 2 * t) ** 2, abs=1e-13)


def test_energies_may_be_made_of_them(scene: Write) -> None:
    """A spring of a function of two distances: k (x^2 + y^2)/2 by its length."""
    text = MODEL.replace("STATED", "energy potential 1[N/m]*length_of({b.s, 0*b.s, 0*b.s})^2/2;")
    assert scene(text).simulate(at=[0.0, np.pi], stop=3.2)["b.s"][1] == pytest.approx(-3, abs=1e-7)


def test_calls_with_known_values_are_evaluated_once_each(scene: Write) -> None:
    """Of functions that call each other twice there would be 2^25 evaluations."""
    functions = ["function f0 input Integer x; output Integer y; algorithm y := x + 1; end f0;"] + [
        f"function f{k} input Integer x; output Integer y; algorithm y := mod(f{k - 1}(x) + f{k - 1}(x + 1), 7); end f{k};"
        for k in range(1, 26)]
    wanted = [x + 1 for x in range(1, 27)]
    for _ in range(25):
        wanted = [(a + b) % 7 for a, b in pairwise(wanted)]
    model = scene("\n".join(functions) + "model M constant Integer k = f25(1); "
                  "Block b(m = 1, base = world); output Real y = k; end M;")
    assert model.simulate(at=[0.0])["y"][0] == wanted[0]


def test_the_evaluation_of_calls_is_bounded(scene: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of other values than all before: 2^12 of them."""
    monkeypatch.setattr("lagrangia.language.loops._MOST_OPERATIONS", 3000)
    functions = ["function f0 input Integer x; output Integer y; algorithm y := x; end f0;"] + [
        f"function f{k} input Integer x; output Integer y; algorithm y := f{k - 1}(2*x) + f{k - 1}(2*x + 1); end f{k};"
        for k in range(1, 13)]
    with pytest.raises(lag.LagError, match=r"L0209.*the calls of functions whose values are needed"):
        scene("\n".join(functions) + "model M constant Integer k = f12(1); Block b[k](each m = 1, each base = world); end M;")
