"""The table of `auto`: what each row says, that it decides where it says so, and that its limit is the one told."""

import json
from pathlib import Path
from string import Formatter
from typing import Any

import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.run.choice import _MEASURED, Choice, figure
from lagrangia.run.library import start_runtime
from lagrangia.run.runtime import Settings, Solver, first_choice, load_runtime

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
BEGIN, BESIDE = 0, 1  # LAG_BEGIN, LAG_BESIDE

CRANK = """model Crank
  World world(gravity = {0, 0}); Revolute h(a = world, phi(start = 1)); Bar bar(m = 1, L = 1, a = h.b);
  TorsionDamper d(c = 1e6, a = world, b = h.b); Spring s(k = 1, s_rel0 = 0.3, a = shift(world, {2, 0}), b = bar.b);
end Crank;"""
RUBBED = """model Rubbed
  World world; Revolute h[2](a = {world, bar[1].b}, phi(start = {1, 0.5})); Bar bar[2](each m = 1, each L = 1, a = h.b);
  Block b(m = 2, base = world, v(start = 1)); DryFriction f(F = 0.5, rate = b.v);
end Rubbed;"""

BRAKED = """model Braked
  World world; Revolute h[2](a = {world, bar[1].b}, phi(start = {1, 0.5})); Bar bar[2](each m = 1, each L = 1, a = h.b);
  TorsionDryFriction f(tau = 0.5, a = world, b = h[1].b);
end Braked;"""


def model_of(text: str, folder: Path) -> lag.Model:
    path = folder / "scene.lag"
    path.write_text(text)
    return lag.load(path)


def begun(model: lag.Model, tolerance: float, solver: Solver = Solver.AUTO) -> Choice:
    """What a run would begin with."""
    assert model.engine is not None
    settings = Settings(model.scene.start, model.scene.stop, tolerance, solver=solver)
    return first_choice(model.engine.runtime.library, model.engine.model, settings)


@pytest.fixture(scope="module")
def rows() -> list[Any]:
    """The table as it stands in C."""
    library, found = load_runtime(start_runtime().path()), []
    while row := library.lag_rule(len(found) + 1):
        found.append(row.contents)
    assert not library.lag_rule(0) and not library.lag_rule(-1) and not library.lag_rule(1 << 30)
    return found


def test_every_row_tells_its_reason_with_what_was_measured(rows: list[Any]) -> None:
    assert len(rows) > 25
    for row in rows:
        assert row.name
        reason = row.why.decode()
        assert bool(reason) == (row.moment != BESIDE)
        assert {name for _, name, _, _ in Formatter().parse(reason) if name} <= set(_MEASURED)
        assert ("{limit}" in reason) == (bool(row.limit) and row.moment != BESIDE), reason


def test_of_the_rows_of_the_beginning_one_always_holds(rows: list[Any]) -> None:
    last = [row for row in rows if row.moment == BEGIN][-1]
    assert (last.name, last.to) == (b"usual", Solver.ERK)


@pytest.mark.parametrize(
    ("name", "tolerance", "solver", "rule"),
    [("chain", 1e-8, Solver.PIRK, "smooth"), ("rolling_disc_space", 1e-2, Solver.PIRK, "smooth"),
     ("pendulum", 1e-8, Solver.TAYLOR, "cheap series"),
     ("braked", 1e-2, Solver.ERK5, "loose"), ("braked", 1e-3, Solver.ERK, "usual")],
)  # fmt: skip
def test_the_row_told_decides_at_its_limit(name: str, tolerance: float, solver: Solver, rule: str, tmp_path: Path) -> None:
    """A tolerance at the limit is on the side that the reason says, and one a little farther is not."""
    model = model_of(BRAKED, tmp_path) if name == "braked" else lag.load(EXAMPLES / f"{name}.lag")
    choice = begun(model, tolerance)
    assert (choice.solver, choice.rule) == (solver, rule)
    if (limit := choice.facts["limit"]) > 0:
        at, above = begun(model, limit), begun(model, limit * (1 + 1e-12))
        assert (at.rule == rule, above.rule == rule) == ((True, False) if rule == "smooth" else (False, True))
        assert f"{limit:g}" in choice.why
    assert begun(model, tolerance, Solver.ERK).rule == "asked"


def test_long_equations_are_counted() -> None:
    model = lag.load(EXAMPLES / "chain.lag", n=20)
    choice = begun(model, 3e-3)
    assert (choice.solver, choice.rule) == (Solver.ADAMS, "long equations")
    operations = model.scene.notes["rhs_operations"]
    assert choice.why == f"{operations} operations a call, more than {700 + 20 * 20}"


def last_choice(model: lag.Model, **asked: Any) -> Choice:
    statistics = model.simulate(**asked).statistics
    assert statistics is not None
    return statistics.choice


def test_rows_that_are_many_are_told() -> None:
    """How far they are apart is known by the steps between them."""
    model = lag.load(EXAMPLES / "chain.lag")
    choice = last_choice(model, at=[k * 1e-5 for k in range(2001)])
    assert choice.rule == "many rows"
    assert choice.facts["rows_apart"] < choice.facts["limit"] == 0.01
    assert f"rows {figure(choice.facts['rows_apart'])} steps apart, fewer than 0.01" in choice.why
    assert last_choice(model, at=[5.0]).rule == "smooth"


def test_stiffness_is_told(tmp_path: Path) -> None:
    model = model_of(CRANK, tmp_path)
    run = model.simulate(at=[50.0])
    assert run.statistics is not None and run.statistics.steps_by[Solver.IMPLICIT] > 0
    assert run.statistics.choice.rule == "stiff"
    assert run.statistics.choice.facts["reach"] > 0.5 and run.statistics.choice.facts["looks"] >= 3


def test_what_swings_back_is_told() -> None:
    choice = last_choice(lag.load(EXAMPLES / "pendulum.lag"), at=[9.0])
    assert (choice.rule, choice.solver) == ("swing", Solver.ORBIT)


@pytest.mark.parametrize(("at", "rule", "solver"), [(0.5, "asked", Solver.ADAMS), (20.0, "holding", Solver.ERK)])
def test_what_holds_is_told(at: float, rule: str, solver: Solver, tmp_path: Path) -> None:
    """Only while it does: steps that are left to another leave the row that decided as it is."""
    choice = last_choice(model_of(RUBBED, tmp_path), at=[at], solver="adams")
    assert (choice.rule, choice.solver) == (rule, solver), choice.why


def test_commands_tell_the_row(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = str(EXAMPLES / "chain.lag")
    wanted = "smooth, 252 operations a call, the tolerance 1e-08 at most 0.002"
    assert main(["simulate", path, "--stats", "-o", str(tmp_path / "x.csv")]) == 0
    said = capsys.readouterr().out
    assert f"  pirk: {wanted}\n" in said
    assert "solver by the rule 'smooth': rhs_cost 252, tolerance 1e-08, limit 0.002" in said
    assert main(["explain", path, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["solver"], told["rule"], told["why"]) == ("pirk", "smooth", wanted)
    assert main(["simulate", path, "--solver", "erk", "-o", str(tmp_path / "x.csv")]) == 0
    assert "asked for" not in capsys.readouterr().out


@pytest.mark.parametrize(("value", "text"), [(0.0, "0"), (252.0, "252"), (0.8123, "0.81"), (31.4, "31"), (3.14, "3.1"),
                                             (1e-8, "1e-08"), (1.5e6, "1.5e+06"), (float("inf"), "inf")])  # fmt: skip
def test_figures_are_short(value: float, text: str) -> None:
    assert figure(value) == text


def test_choices_do_not_depend_on_when_a_run_was_paused(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a busy machine it is paused sooner, in the midst of rows that lie in one step."""
    model = lag.load(EXAMPLES / "bicycle.lag")
    whole = model.simulate(tolerance=1e-6)
    monkeypatch.setattr("lagrangia.run.simulate._FIRST", 1e-9)
    monkeypatch.setattr("lagrangia.run.simulate._PAUSE", 1e-9)
    parts = model.simulate(tolerance=1e-6)
    assert all((whole[name] == parts[name]).all() for name in model.coordinate_names)
