"""Starts that are stated by expressions which are not finite everywhere: nothing crashes, and no digit is lost."""

import warnings
from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia import assembly
from lagrangia.pipeline import compile_file

Write = Callable[[str], lag.Model]


def begin(model: lag.Model, **options: object) -> dict[str, float]:
    """All coordinates, rates and outputs at the start."""
    run = model.simulate(stop=1e-9, interval=1e-9, **options)
    names = [c.name for c in (*model.scene.coordinates, *model.scene.rates, *model.scene.outputs)]
    return {name: float(run[name][0]) for name in names}


# ---------------------------------------------------------------- not finite at the guess

ROD = "PointMass A(m = 1); Link l(a = world, b = A.center, L = {L});"
UNBOUNDED = {  # what is stated, and what vanishes then
    "a quotient": (ROD.format(L="1"), "A.center.y/A.center.x = 0.5;", lambda x, y, vx, vy: y - 0.5 * x),
    "a steep quotient": (ROD.format(L="1[km]"), "A.center.x/A.center.y = 1e3;", lambda x, y, vx, vy: x - 1e3 * y),
    "a small rod": (ROD.format(L="1[mm]"), "A.center.y/A.center.x = 0.5;", lambda x, y, vx, vy: y - 0.5 * x),
    "an angle": (ROD.format(L="1"), "atan2(A.center.y, A.center.x) = 2.5;", lambda x, y, vx, vy: x - np.cos(2.5)),
    "rates": (ROD.format(L="1"), "A.center.x = 0.6; A.center.v[2]/(A.center.v[1] - 1) = -2;",
              lambda x, y, vx, vy: vy + 2 * (vx - 1)),
    "a direction": ("PointMass A(m = 1);", "A.center.x/norm(A.center.r) = 0.6; norm(A.center.r) = 2[m];",
                    lambda x, y, vx, vy: abs(x - 1.2) + abs(abs(y) - 1.6)),
    "a logarithm and a root": ("PointMass A(m = 1);",
                               "log(A.center.x/1[m]) = 1; sqrt(A.center.v[2]/1[m/s] - 3) = 2; 1/A.center.y = 5[1/m];",
                               lambda x, y, vx, vy: abs(x - np.e) + abs(vy - 7) + abs(y - 0.2)),
}


@pytest.mark.parametrize("case", UNBOUNDED)
def test_what_is_not_finite_at_the_guess_is_solved_from_beside_it(
    case: str, scene: Write, capfd: pytest.CaptureFixture[str]
) -> None:
    parts, stated, gap = UNBOUNDED[case]
    model = scene(f"model M {parts} initial equation {stated} end M;")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        start = begin(model)
    x, y, vx, vy = (start[f"{a}A.center.{b}{c}"] for a, c in (("", ""), ("der(", ")")) for b in "xy")
    assert abs(gap(x, y, vx, vy)) < 1e-12 * max(1, abs(x), abs(y))
    made = compile_file(model.path)
    found, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    assert worst == -1
    np.testing.assert_allclose(found, [x, y, vx, vy], rtol=1e-9, atol=1e-12)
    assert capfd.readouterr() == ("", "")  # what LAPACK says of NaN goes past Python


@pytest.mark.parametrize(("stated", "told"), [
    ("sqrt(-1 - b.s^2/1[m2]) = 1;", "it has no finite value"),
    ("b.s/norm({b.s, 1e-3[m]}) = 2;", "it misses by 1"),
])
def test_what_holds_nowhere_is_refused(stated: str, told: str, scene: Write) -> None:
    with pytest.raises(lag.LagError, match=f"L0606.*{told}"):
        begin(scene(f"model M Block b(m = 1, base = world); initial equation {stated} end M;"))


def test_a_direction_that_contradicts_is_told_although_its_slope_is_boundless_at_the_guess(scene: Write) -> None:
    stated = "A.center.x = 1; A.center.y = 1; A.center.x/norm(A.center.r) = 0.9;"
    model = scene(f"model M PointMass A(m = 1); initial equation {stated} end M;")
    with pytest.raises(lag.LagError, match="L0606"):
        begin(model)
