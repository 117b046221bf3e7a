"""Events of one instant, in the order of what they read: values by hand, as the Modelica specification has them."""

from pathlib import Path

import pytest

import lagrangia

ORDER = """
model Order "x = cos(t) is below 0 from pi/2 + 2 pi k on: what events give is read in order"
  Block block(m = 1, base = world, s(start = 1));
  Spring spring(k = 1, stretch = block.s);
  Boolean raw = block.s < 0, ready = m > 1, done;
  discrete Time t0(start = -10);
  Integer late(start = 0), m(start = 0), seen(start = 0), was(start = 0), k(start = 0), j(start = 0), lists(start = 0);
  Integer changes(start = 0), last(start = 0), after(start = 0);
  discrete Velocity v(start = 0), w(start = 0);
equation
  when raw and time > t0 + 1 then late = pre(late) + 1; end when;
  when done then v = der(block.s); last = seen; end when;
  when edge(ready) then w = der(block.s); reinit(der(block.s), -2); was = pre(m); end when;
  when block.s < 0 then seen = 10*m + pre(m); done = m > 1 and not pre(ready); end when;
  when raw then t0 = time; m = pre(m) + 1; end when;
  when m == 2 then k = pre(k) + 1; elsewhen m >= 2 then k = pre(k) + 10; end when;
  when {m == 2, k == 1} then j = k; lists = pre(lists) + 1; end when;
  when change(m) then changes = pre(changes) + 10*m + pre(m); end when;
  when pre(m) == 2 then after = 10*lists + j; end when;
  annotation(experiment(StopTime = 16));
end Order;
"""
# From the second time on m > 1: der(x) = -1 is set to -2, which others read as it was. `late` comes one second after t0.
READ = {"m": 3, "late": 3, "seen": 32, "done": 0, "last": 21, "was": 1, "k": 1, "j": 1, "lists": 1, "changes": 63, "after": 11}


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_runs(tmp_path: Path, solver: str) -> None:
    file = tmp_path / "order.lag"
    file.write_text(ORDER, encoding="utf-8")
    model = lagrangia.load(file)
    result = model.simulate(solver=solver, tolerance=1e-9)
    assert not model.warnings and {name: float(result[name][-1]) for name in READ} == READ
    assert result["v"][-1] == pytest.approx(-1) and result["w"][-1] == pytest.approx(-1)
    assert result["block.s"][-1] == pytest.approx(-1.9153191, abs=1e-6)  # -2 cos(16)


@pytest.mark.parametrize("version", ["2", "3"])
def test_fmus(tmp_path: Path, version: str) -> None:
    fmpy = pytest.importorskip("fmpy")
    file = tmp_path / "order.lag"
    file.write_text(ORDER, encoding="utf-8")
    (path,) = lagrangia.load(file).export_fmu(tmp_path / "order.fmu", fmi=version)
    for kind in ("ModelExchange", "CoSimulation"):
        end = fmpy.simulate_fmu(str(path), fmi_type=kind, stop_time=16, output=[*READ], relative_tolerance=1e-7)[-1]
        assert {name: float(end[name]) for name in READ} == READ, kind


@pytest.mark.parametrize(("clauses", "n"), [
    ("equation when k == 2 then n = pre(n) + 1; elsewhen k >= 2 then n = pre(n) + 10; end when;", 1),
    ("equation when k >= 2 then n = pre(n) + 1; elsewhen k >= 1 then n = pre(n) + 10;"
     "elsewhen k > 0 then n = 100; end when;", 11),
    ("Integer i, j, m; equation when k == 3 and n < 5 then n = pre(n) + 1; end when;"
     "when k >= 2 then j = k; end when; when j >= 2 then i = j + 1; end when;"
     "when i == 3 and j == 2 and k == 2 then m = 7; end when; when m == 7 then terminate(\"m\"); end when;", 0),
])
def test_short_ones(tmp_path: Path, clauses: str, n: int) -> None:
    """k = 1, 2, 3 at 0.2, 0.4, 0.6."""
    file = tmp_path / "short.lag"
    file.write_text(f"""model Short
  Block block(m = 1, base = world);
  Integer k(start = 0), n(start = 0);
  {clauses}
  when time > 0.2*(pre(k) + 1) then k = pre(k) + 1; end when;
end Short;
""", encoding="utf-8")
    result = lagrangia.load(file).simulate(stop=0.7)
    assert result["n"][-1] == n and result.time[-1] == pytest.approx(0.4 if "terminate" in clauses else 0.7)


@pytest.mark.parametrize(("force", "s"), [
    ("if n > 0 then 1 else 0", 0.5), ("if n >= 1 then 1 else 0", 0.5), ("if n < 1 then 0 else 1", 0.5),
    ("if n <= 0 then 0 else 1", 0.5),
    ("if n >= 0 then 1 else 0", 2), ("if n <= 1 then 1 else 0", 2), ("if part < 0.3 then 0 else 1", 0.5),
    ("if part > 0.3 then 1 else 0", 0), ("if n > 0 and block.s < 9 then 1 else 0", 0.5),
    ("if n > held then 1 else 0", 0.375), ("if n > late then 1 else 0", 0.375), ("if n - late <= held then 0 else 1", 0.375),
])
def test_forces_on_a_level(tmp_path: Path, force: str, s: float) -> None:
    """What events set to the very level that a force compares it with, where it stays: n = 1, part = 0.3 from 1 s on, held = 1
    and late = 1 from 1.5 s on."""
    file = tmp_path / "level.lag"
    file.write_text(f"""model Level
  Block block(m = 1, base = world);
  Integer n(start = 0), held(start = 0);
  discrete Real part(start = 0);
  Real late = if time < 1.5 then 0 else 1;
energy
  work 1[N]*({force}) on block.s;
equation
  when time > 1 then n = 1; part = 0.3*n; end when;
  when sample(1.5, 5) then held = 1; end when;
end Level;
""", encoding="utf-8")
    assert lagrangia.load(file).simulate(stop=2.0, solver="erk")["block.s"][-1] == pytest.approx(s)


@pytest.mark.parametrize(("force", "s"), [("sign(n)", 0.5), ("if n > 0 then 1 elseif n >= 0 then 0.5 else 3", 1.25)])
def test_forces_that_tell_both_sides_of_a_level(tmp_path: Path, force: str, s: float) -> None:
    """sign(n) is 0 at n = 0, and neither n > 0 nor n < 0 is true there: they were refused."""
    file = tmp_path / "sign.lag"
    file.write_text(f"""model Sign
  Block block(m = 1, base = world);
  Integer n(start = 0);
energy
  work 1[N]*({force}) on block.s;
equation
  when time > 1 then n = 1; end when;
end Sign;
""", encoding="utf-8")
    assert lagrangia.load(file).simulate(stop=2.0, solver="erk")["block.s"][-1] == pytest.approx(s)
