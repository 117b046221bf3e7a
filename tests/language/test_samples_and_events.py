"""Samples and events of one instant, in the order of what they read (Modelica 3.6, section 8.3.5)."""

from pathlib import Path

import pytest

import lagrangia

HEAD = """model Together
  coordinate Length q(start = 0, fixed = true); Velocity v(start = 1, fixed = true) = der(q);
  VARIABLES
  Real doubled = 2*u;
equation
  """
TAIL = """
  annotation(experiment(StopTime = 1.1));
energy kinetic 1[kg]*der(q)^2;
end Together;"""


def together(tmp_path: Path, statements: str) -> lagrangia.Model:
    """With all variables that are given values; it ends a tenth behind what comes at 1 s."""
    named = [name for name in "nkrsuw" if f" {name} = " in statements]
    variables = " ".join(f"{'Integer' if name in 'nk' else 'Real'} {name}(start = 0);" for name in named)
    file = tmp_path / "together.lag"
    file.write_text(HEAD.replace("VARIABLES", variables) + statements + TAIL, encoding="utf-8")
    return lagrangia.load(file)


@pytest.mark.parametrize(("statements", "found"), [
    # samples, an event of the time, and one that follows it
    ("when sample(0.25, 0.25) then u = 10 + time/1[s]; end when; when time >= 1 then n = 1; end when; "
     "when n > 0 then r = u; end when;", {"u": 11, "r": 11}),
    ("when n > 0 then r = pre(u); s = pre(doubled) + u; end when; when time >= 1 then n = 1; end when; "
     "when sample(0.25, 0.25) then u = 10 + time/1[s]; end when;", {"r": 10.75, "s": 21.5 + 11}),
    ("when sample(0.25, 0.25) then u = 10 + n; end when; when time >= 1 then n = 1; end when; "
     "when n > 0 then r = u; end when;", {"u": 11, "r": 11}),
    # n = 2, of which the sample u and then the event of k and the sample w follow; all read what was before as well
    ("when sample(0, 0.5) then u = 100*n + pre(n) + w; end when; when time >= 1 then n = 2; end when; "
     "when sample(0, 1) then w = pre(w) + pre(k) + 1; end when; when doubled > 300 then k = 5; r = w; end when; "
     "when k > 0 then s = pre(u) + pre(w) + pre(k); end when;", {"w": 2, "u": 202, "k": 5, "r": 2, "s": 2}),
    # what reads rates has those before they are reset
    ("when sample(0, 1) then u = v/1[m/s]; end when; when time >= 1 then reinit(v, 7); end when;", {"u": 1}),
    # changes of what is held, from its first value on
    ("when sample(0, 0.25) then u = floor(2*time/1[s]) + 3; end when; when change(u) then n = pre(n) + 1; r = pre(u); end when;",
     {"n": 3, "r": 4}),
])
@pytest.mark.parametrize("solver", ["auto", "implicit"])
def test_each_reads_what_it_follows_from(tmp_path: Path, statements: str, found: dict[str, float], solver: str) -> None:
    result = together(tmp_path, statements).simulate(solver=solver)
    assert {name: float(result[name][-1]) for name in found} == found


def test_events_at_the_start_by_what_is_sampled_there(tmp_path: Path) -> None:
    """u = 5 comes at t = 0, where the event is none yet; rates that are reset count in the account."""
    circle = ("when sample(0, 5) then u = 5 + n; end when; when u > 3 then n = 1; reinit(v, 3); end when; "
              "when n > 0 then w = u; end when;")
    with pytest.raises(lagrangia.LagError, match="follow from each other where their events come at one instant"):
        together(tmp_path, circle)
    result = together(tmp_path, circle.replace("5 + n", "5 + pre(n)")).simulate()
    assert {name: float(result[name][0]) for name in ("n", "u", "w")} == {"n": 1, "u": 5, "w": 5}
    assert result["q"][-1] == pytest.approx(3.3) and abs(result.energy.residual).max() < 1e-9
