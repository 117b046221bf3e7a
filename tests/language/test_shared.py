"""Work without bound: what stands for the same thing is computed once, and what cannot be is refused in good time.

What `lag check` refuses is in tests/errors (names_loops_in_loops, names_sum_of_sums, function_calls_in_calls, ...).
"""

import math
from pathlib import Path

import pytest

import lagrangia
from lagrangia.command.cli import WRONG, main

DEPTH = 40


def function(name: str, value: str) -> str:
    return f"function {name}\n  input Real x;\n  output Real y;\nalgorithm\n  y := {value};\nend {name};\n"


# Each f calls the one before twice: x + 1, by 2^40 calls if each were made. The argument of `bent` stands in it three times.
FUNCTIONS = function("f0", "x + 1") + "".join(function(f"f{k}", f"(f{k - 1}(x) + f{k - 1}(x))/2") for k in range(1, DEPTH + 1))
NESTED = FUNCTIONS + function("bent", "x - x*sin(x)/4") + f"""
model Nested
  Block b(m = 1, base = world, s(start = 0.5));
  Real x = b.s/1[m];
  Real x0 = x;
  {" ".join(f"Real x{k} = x{k - 1} - x{k - 1}*sin(x{k - 1})/4;" for k in range(1, DEPTH + 1))}
  output Real called = {"bent(" * DEPTH}x{")" * DEPTH};
  output Real named = x{DEPTH};
  output Real same = f{DEPTH}(x);
  output Real rate = der(called);
  AppliedForce push(at = b.center, force = {{1[N]*called, 0}});
end Nested;
"""


def test_what_is_used_twice_is_computed_once(tmp_path: Path) -> None:
    file = tmp_path / "nested.lag"
    file.write_text(NESTED)
    run = lagrangia.load(file).simulate(stop=0.5, interval=0.5, tolerance=1e-12)
    s, v = float(run["b.s"][-1]), float(run["b.v"][-1])
    y, slope = s, 1.0
    for _ in range(DEPTH):
        y, slope = y - y * math.sin(y) / 4, slope * (1 - math.sin(y) / 4 - y * math.cos(y) / 4)
    assert float(run["called"][-1]) == pytest.approx(y, rel=1e-14)
    assert float(run["named"][-1]) == pytest.approx(y, rel=1e-14)
    assert float(run["same"][-1]) == pytest.approx(s + 1, rel=1e-14)
    assert float(run["rate"][-1]) == pytest.approx(slope * v, rel=1e-12)


@pytest.mark.parametrize("command", ["equations", "export --to sympy"])
@pytest.mark.parametrize("value", ["called", "named"])
def test_equations_without_end_are_refused(command: str, value: str, tmp_path: Path, capsys, monkeypatch) -> None:
    """SymPy writes what stands in two places twice."""
    monkeypatch.chdir(tmp_path)
    Path("nested.lag").write_text(NESTED.replace("1[N]*called", f"1[N]*{value}"))
    first, *others = command.split()
    assert main([first, "nested.lag", *others]) == WRONG
    told = capsys.readouterr().err
    assert "error[L0712]" in told
    assert "more than 1500 parts" in told


@pytest.mark.parametrize("value", ["called", "named"])
def test_modelica_has_each_part_once(value: str, tmp_path: Path, monkeypatch) -> None:
    """By instructions."""
    monkeypatch.chdir(tmp_path)
    Path("nested.lag").write_text(NESTED.replace("1[N]*called", f"1[N]*{value}"))
    assert main(["export", "nested.lag", "--to", "modelica"]) == 0
    text = Path("Nested.mo").read_text()
    assert text.count(" = sin(") == DEPTH


def test_loops_of_functions_with_branches(tmp_path: Path) -> None:
    """A long loop with a branch: 0 + 1 + 0 + 1 ..., which took time as the square of its length."""
    file = tmp_path / "branches.lag"
    file.write_text("""
function steps
  input Real x;
  output Real y;
algorithm
  y := 0;
  for i in 1:4000 loop
    if mod(i, 2) > 0.5 then y := y + x; else y := y - x/2; end if;
  end for;
end steps;
model Branches
  Block b(m = 1, base = world, s(start = 0.5));
  output Real y = steps(0.5);
end Branches;
""")
    assert float(lagrangia.load(file).simulate(stop=0.1, interval=0.1)["y"][-1]) == pytest.approx(500, rel=1e-14)
