"""`terminate` in the branches of a `when`: the first that comes at an instant is the one, and nothing else tells of it."""

import math

import pytest

import lagrangia


@pytest.mark.parametrize(("branches", "end", "n", "text"), [
    ('n = 1; elsewhen k > 0 then terminate("second")', 3, 1, ""),
    ('terminate("first"); elsewhen k > 0 then n = 1', 1, 0, "first"),
    ('n = 0; terminate("first"); elsewhen k > 0 then terminate("second")', 1, 0, "first"),
    ('n = 1; elsewhen k > 1 then n = 2; terminate("later"); elsewhen k > 0 then terminate("last")', 2, 2, "later")])
def test_the_first_branch_ends_a_run(branches: str, end: float, n: int, text: str) -> None:
    """Both conditions come true at t = 1, k > 1 at 2."""
    model = lagrangia.loads(f"""model M Real x(start = 0, fixed = true); Integer n(start = 0), k(start = 0);
        equation der(x) = 1; when sample(0, 1) then k = integer(time/1[s]); end when;
        when k >= 1 then {branches}; end when; annotation(experiment(StopTime = 3)); end M;""")
    result = model.simulate()
    assert not model.warnings and (result.time[-1], result["n"][-1]) == (end, n)
    assert text in result.ended and bool(result.ended) is bool(text)


def test_branches_that_come_apart_end_runs_as_lone_ones_do() -> None:
    """Conditions that no instant makes true at once: nothing inside stands between, so there are equations on paper, one
    coordinate, and the last row is of the place where it ends."""
    model = lagrangia.loads("""model M
        Block b(m = 1, base = world, along = {1, 0}, s(start = 1)); Spring k(k = 4, stretch = b.s);
        equation when b.s < -0.5 then terminate("left"); elsewhen b.s > 2 then terminate("right"); end when;
        annotation(experiment(StopTime = 2)); end M;""")
    result = model.simulate()
    assert ": left (b.s < -0.5" in result.ended
    assert result["b.s"][-1] == pytest.approx(-0.5, abs=1e-6)
    assert (model.coordinate_names, model.freedom["degrees_of_freedom"]) == (("b.s",), 1)
    assert "E = T + V" in str(model.equations())


@pytest.mark.parametrize("solver", ["erk", "implicit"])
def test_branches_that_meet_end_runs_without_a_trace(solver: str) -> None:
    """x < 0 and -2 x > 0 come at pi/4, where the first one counts; the last, at 5 pi/12, is of its own."""
    chain = """model M
        Block b(m = 1, base = world, along = {{1, 0}}, s(start = 1)); Spring k(k = 4, stretch = b.s); Integer n(start = 0);
        equation when b.s < 0 then {}; elsewhen {{-2*b.s > 0, b.s < -0.5*sqrt(3)}} then terminate("second"); end when;
        annotation(experiment(StopTime = 2)); end M;"""
    for first, end, text in (('n = 1; terminate("first")', math.pi / 4, "first"), ("n = 1", 5 * math.pi / 12, "second")):
        model = lagrangia.loads(chain.format(first))
        result = model.simulate(solver=solver)
        assert text in result.ended and result.time[-1] == pytest.approx(end, abs=1e-6)
        assert not [x for x in (*model.coordinate_names, *(c.name for c in result.columns)) if "terminate" in x]
    alone = lagrangia.loads(chain.replace(" Integer n(start = 0);", "").format('terminate("first")'))
    assert (alone.coordinate_names, alone.freedom["degrees_of_freedom"]) == (("b.s",), 1)
    assert "E = T + V" in str(alone.equations())


@pytest.mark.parametrize("chain", ['when change(n) then terminate("first")',  # what n was follows at the same instant
                                   'when n > 0 then terminate("first"); elsewhen b.s > 2 then terminate("second")',
                                   'when b.s > 2 then terminate("second"); elsewhen change(n) then terminate("first")'])
def test_what_events_set_ends_a_run_at_once(chain: str) -> None:
    model = lagrangia.loads(f"""model M World world(gravity = {{0, 0}}); Block b(m = 1, base = world, v(start = 1));
        Integer n(start = 0); equation when b.s > 1 then n = pre(n) + 1; end when; {chain}; end when; end M;""")
    result = model.simulate(stop=3)
    assert "first" in result.ended and result.time[-1] == pytest.approx(1, abs=1e-6)
