"""Tables in two variables."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

import lagrangia as lag
from helpers.reference import integrate

XS, YS, ZS = [0, 0.5, 1.5], [-1, 0, 2], [[-3, 0, 2], [-2, -1, 0], [1, -2, -4]]


def model(folder: Path, force: str) -> lag.Model:
    (folder / "scene.lag").write_text(f"""model M
      Block b(m = 1, base = world, s(start = 0.2), v(start = 1));
      Force F = {force};
      AppliedForce f(at = b.center, force = {{F, 0}});
    end M;""")
    return lag.Model(folder / "scene.lag", outputs=("F",))


@pytest.mark.parametrize("solver", ["auto", "erk9", "implicit"])
def test_a_map_of_place_and_speed(solver: str, tmp_path: Path) -> None:
    """Straight in each cell, held beyond; kinks are no trouble to a run of 1e-11."""
    table = RegularGridInterpolator((XS, YS), np.array(ZS, float))

    def force(_t: float, s: np.ndarray, v: np.ndarray) -> np.ndarray:
        return table([np.clip(s[0], 0, 1.5), np.clip(v[0], -1, 2)])

    text = "table2(b.s, b.v, {0[m], 0.5, 1.5}, {-1[m/s], 0, 2}, {{-3[N], 0, 2}, {-2, -1, 0}, {1, -2, -4}})"
    run = model(tmp_path, text).simulate(at=np.linspace(0, 3, 61), tolerance=1e-12, solver=solver)
    values = [force(0, [s], [v])[0] for s, v in zip(run["b.s"], run["b.v"], strict=True)]
    assert run["F"] == pytest.approx(values, abs=1e-14)
    assert len(run.events) == 5
    q, _ = integrate(force, [0.2], [1.0], np.linspace(0, 3, 61), [float(t) for t in run.events])
    assert run["b.s"] == pytest.approx(q[0], abs=1e-10)


def test_time_and_parameters(tmp_path: Path) -> None:
    """F = t (1 + t) of straight lines in x = t, y = t is bilinear in one cell: v = 1 + t^2/2 + t^3/3."""
    scene = model(tmp_path, "table2(time, 1 + time/1[s], {0[s], 4}, {0, 8}, {{0[N], 0}, {0, 32}})")
    run = scene.simulate(stop=3, tolerance=1e-12)
    assert run["F"] == pytest.approx(run.time * (1 + run.time), abs=1e-12)
    assert run["b.v"][-1] == pytest.approx(1 + 4.5 + 9, abs=1e-10)


@pytest.mark.parametrize(("text", "code"), [
    ("table2(b.s, b.v, {0[m], 1}, {0[m/s], 1}, {1[N], 2})", "L0303"),
    ("table2(b.s, b.v, {0[m], 1}, {0[m/s], 1}, {{1[N], 2}})", "L0303"),
    ("table2(b.s, b.v, {0[m], 1}, {0[m/s], 1}, {{1[N], 2}, {3}})", "L0303"),
    ("table2(b.s, b.v, {1[m], 0}, {0[m/s], 1}, {{1[N], 2}, {3, 4}})", "L0303"),
    ("table2(b.s, b.v, {0[s], 1}, {0[m/s], 1}, {{1[N], 2}, {3, 4}})", "L0304"),
    ("table2(b.s, b.v, {0[m], 1}, {0[m/s], 1}, {{1[m], 2}, {3, 4}})", "L030"),
    ("table2(b.s, {0[m], 1}, {1[N], 2})", "L0215"),
])
def test_what_is_wrong(text: str, code: str, tmp_path: Path) -> None:
    with pytest.raises(lag.LagError, match=code):
        model(tmp_path, text)


def test_of_a_file_with_units_in_any_order(tmp_path: Path) -> None:
    """As of the same points in the text; an FMU needs nothing else."""
    rows = [f"{1000 * x},{y},{z}" for x, line in zip(XS, ZS, strict=True) for y, z in zip(YS, line, strict=True)]
    (tmp_path / "map.csv").write_text("x [mm],v [m/s],F [N]\n" + "\n".join(reversed(rows)) + "\n")
    literal = "table2(b.s, b.v, {0[m], 0.5, 1.5}, {-1[m/s], 0, 2}, {{-3[N], 0, 2}, {-2, -1, 0}, {1, -2, -4}})"
    found, wanted = (model(tmp_path, text).simulate(at=[0.5, 1, 3]) for text in ('table2(b.s, b.v, "map.csv")', literal))
    assert np.abs(np.array(found["b.s"]) - wanted["b.s"]).max() < 1e-15
    assert model(tmp_path, 'table2(b.s, b.v, "map.csv", column = "F")').export_fmu(tmp_path / "one.fmu")


@pytest.mark.parametrize(("text", "rows", "said"), [
    ('table2(b.s, b.v, "map.csv")', "x,y,z\n0,0,1\n0,1,2\n1,0,3\n", "nothing at 1, 1"),
    ('table2(b.s, b.v, "map.csv")', "x,y,z\n0,0,1\n0,1,2\n1,0,3\n1,1,3\n1,1,4\n", "a point twice"),
    ('table2(b.s, b.v, "map.csv")', "x,y,z,w\n0,0,1,1\n0,1,2,1\n1,0,3,1\n1,1,3,1\n", "L0703.*no column for the values"),
    ('table2(b.v, b.v, "map.csv")', "x [m],y,z\n0,0,1\n0,1,2\n1,0,3\n1,1,3\n", "L0304.*column 1 of 'map.csv' is in m"),
    ('table2(b.s, b.v, "none.csv")', "x,y,z\n", "L0703.*none.csv"),
    ('table2(b.s, b.v, "map.csv", smoothness = "cubic")', "x,y,z\n0,0,1\n", "L0901.*'smoothness'"),
    ("table2(b.s, b.v, 3)", "x,y,z\n0,0,1\n", "L0215.*has a file"),
])
def test_what_is_no_map_is_told(text: str, rows: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "map.csv").write_text(rows)
    with pytest.raises(lag.LagError, match=said):
        model(tmp_path, text).simulate(at=[1.0])
