"""table(x, "file", ...): files in their dialects, what holds between rows and beyond them, beside SciPy's splines."""

from collections.abc import Callable
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.base.table_data import Beyond
from lagrangia.command.cli import main
from lagrangia.fmu.build import host_platform
from lagrangia.fmu.export import Export, export_fmu
from lagrangia.native.prebuilt import find_fmu
from lagrangia.run.columns import read_columns
from lagrangia.run.library import has_runtime
from lagrangia.run.lookup import made_table
from lagrangia.run.scene import from_json, to_json

Function = Callable[[float], float]
pytestmark = pytest.mark.skipif(not has_runtime(), reason="no run time")
X = np.array([0.3, 0.35, 0.7, 1.0, 1.1, 1.6, 1.9])
Y = np.array([1.5, -0.2, 0.1, 0.9, 0.8, -1.0, 1.5])
PERIOD = X[-1] - X[0]
OPTIONS = [pair for pair in product(("linear", "steps", "cubic", "monotone"), ("hold", "linear", "periodic"))
           if pair != ("steps", "linear")]


def between(smoothness: str, beyond: str) -> Function:
    """The same by SciPy and NumPy."""
    again = beyond == "periodic"
    if smoothness == "cubic":
        return CubicSpline(X, Y, bc_type="periodic" if again else "not-a-knot")
    if smoothness == "monotone":
        beside = (np.r_[X[:-1] - PERIOD, X, X[1:] + PERIOD], np.r_[Y[:-1], Y, Y[1:]])
        return PchipInterpolator(*(beside if again else (X, Y)))
    if smoothness == "linear":
        return lambda t: float(np.interp(t, X, Y))
    return lambda t: float(Y[np.clip(np.searchsorted(X, t, side="right") - 1, 0, len(X) - 1)])


def whole(smoothness: str, beyond: str) -> Function:
    inside = between(smoothness, beyond)

    def value(t: float) -> float:
        t = X[0] + (t - X[0]) % PERIOD if beyond == "periodic" else t
        end = 0 if t < X[0] else -1 if t > X[-1] else None
        if end is None:
            return float(inside(t))
        slope = inside(X[end], 1) if smoothness in ("cubic", "monotone") else \
            (Y[1] - Y[0]) / (X[1] - X[0]) if end == 0 else (Y[-1] - Y[-2]) / (X[-1] - X[-2])
        return float(Y[end] + (slope * (t - X[end]) if beyond == "linear" else 0.0))

    return value


def area(force: Function, corners: list[float], end: float) -> float:
    """From 0 on, of a polynomial between corners."""
    places, weights = np.polynomial.legendre.leggauss(4)
    cuts = [0.0, *(c for c in corners if 0 < c < end), end]
    return sum(w * force((a + b) / 2 + (b - a) / 2 * x) * (b - a) / 2
               for a, b in pairwise(cuts) for x, w in zip(places, weights, strict=True))


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., lag.Model]:
    def model(text: str, **files: str) -> lag.Model:
        for name, content in files.items():
            (tmp_path / f"{name}.csv").write_text(content, encoding="utf-8")
        (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
        return lag.load(tmp_path / "scene.lag")

    return model


def rows(x: np.ndarray, *columns: np.ndarray, head: str = "t,F") -> str:
    return head + "\n" + "\n".join(",".join(map(repr, row)) for row in zip(*(c.tolist() for c in (x, *columns)), strict=True))


@pytest.mark.parametrize(("smoothness", "beyond"), OPTIONS)
def test_forces_between_rows_and_beyond(smoothness: str, beyond: str, write: Callable[..., lag.Model]) -> None:
    """One of time and one that runs backwards: values, and areas to rounding."""
    options = f'smoothness = "{smoothness}", beyond = "{beyond}"'
    points = ", ".join(f"{{{', '.join(map(repr, values.tolist()))}}}" for values in (X, Y))
    model = write(f"""model Pushed
      Block a(m = 1, base = world), b(m = 1, base = world);
      output Real F = table(time, "force.csv", {options}), G = table(2 - 1.5*time/1[s], {points}, {options});
      AppliedForce f(at = a.center, force = {{1[N]*F, 0}}), g(at = b.center, force = {{1[N]*G, 0}});
    end Pushed;""", force=rows(X, Y))
    F = whole(smoothness, beyond)
    backwards: Function = lambda t: F(2 - 1.5 * t)  # noqa: E731
    at = [0.1, 0.9, 2.31, 4.4]
    run = model.simulate(at=at, tolerance=1e-11)
    knots = [x + k * PERIOD for k in range(-5, 4) for x in X]
    for force, name, corners in ((F, "a", sorted(knots)), (backwards, "b", sorted((2 - x) / 1.5 for x in knots))):
        assert run["F" if name == "a" else "G"] == pytest.approx([force(t) for t in at], abs=1e-13)
        assert run[f"der({name}.s)"] == pytest.approx([area(force, corners, t) for t in at], abs=1e-12)


ROAD = """model Quarter
  World world(gravity = {0, 0});
  parameter Real v = 1;
  Frame road = shift(world, {0, table(v*time, "road.csv", smoothness = "cubic", beyond = "linear")});
  Prismatic axle(a = world, along = {0, 1}), body(a = world, along = {0, 1});
  PointMass wheel(m = 40, center = axle.b), car(m = 300, center = body.b);
  AxialSpring tyre(a = road, b = wheel.center, k = 150000, along = {0, 1});
  AxialSpring spring(a = wheel.center, b = car.center, k = 15000, along = {0, 1});
  AxialDamper damper(a = road, b = car.center, c = 1200, along = {0, 1});
  output Length z = road.y; output Velocity dz = road.v[2]; output Acceleration ddz = der(der(z));
end Quarter;"""
T = np.linspace(0, 2, 21)
Z = 0.05 * np.sin(2 * T) + 0.02 * np.cos(5 * T)


def ridden(v: float, end: float) -> np.ndarray:
    """The same by SciPy, piece by piece: axle.s, body.s and their rates."""
    S = CubicSpline(T, Z)

    def slope(t: float, y: np.ndarray) -> list[float]:
        spring = 15000 * (y[0] - y[1])
        damper = 1200 * (v * S(v * t, 1) - y[3])
        return [y[2], y[3], (150000 * (S(v * t) - y[0]) - spring) / 40, (spring + damper) / 300]

    y = np.zeros(4)
    for a, b in pairwise([*(t for t in T / v if t < end), end]):
        y = solve_ivp(slope, (a, b), y, method="DOP853", rtol=1e-13, atol=1e-16).y[:, -1]
    return y


NAMES = ("axle.s", "body.s", "der(axle.s)", "der(body.s)")


@pytest.mark.parametrize("solver", ["auto", "erk", "pirk", "adams", "implicit", "taylor", "casadi:cvodes"])
def test_a_road_moves_a_support(solver: str, write: Callable[..., lag.Model]) -> None:
    """By its positions, velocities and accelerations; nothing jumps in it."""
    model = write(ROAD, road=rows(T, Z, head="x,z"))
    assert "kick" not in model.scene.tapes
    run = model.simulate(at=[1.93], tolerance=1e-12, solver=solver, parameters={"v": 0.7})
    close = 1e-10 if solver != "casadi:cvodes" else 1e-7
    assert [run[name][0] for name in NAMES] == pytest.approx(ridden(0.7, 1.93).tolist(), abs=close)
    S, x = CubicSpline(T, Z), 0.7 * 1.93
    assert [run[name][0] for name in ("z", "dz", "ddz")] == pytest.approx([0.7**k * float(S(x, k)) for k in range(3)], abs=1e-12)


def test_sweeps_scenes_in_files_and_fmus_have_their_tables(write: Callable[..., lag.Model], tmp_path: Path) -> None:
    model = write(ROAD, road=rows(T, Z, head="x,z"))
    sweep = model.simulate_many(parameters={"v": [0.5, 1.0]}, outputs=["final(body.s)"], stop=1.5, tolerance=1e-11)
    assert sweep["final(body.s)"] == pytest.approx([ridden(v, 1.5)[1] for v in (0.5, 1.0)], abs=1e-9)
    (table,) = from_json(to_json(model.scene)).tables
    assert (list(table.y), table.pitch, table.beyond) == (Z.tolist(), pytest.approx(0.1), Beyond.LINEAR)
    if find_fmu(data_folder("runtime"), "3"):
        path = tmp_path / "quarter.fmu"
        export_fmu(model, Export("3", platforms=(host_platform(),), engine="tape", sources=False), path)
        told = main(["fmu", "check", str(path)])
        assert told == 0


def test_steps_of_a_support_act_through_its_dampers(write: Callable[..., lag.Model]) -> None:
    """A support that jumps by h gives c h of impulse, and a spring that is longer."""
    model = write("""model Jumps
      World world(gravity = {0, 0});
      Frame road = shift(world, {table(time, "road.csv", smoothness = "steps"), 0});
      Block b(m = 2, base = world);
      AxialDamper d(a = road, b = b.center, c = 3);
    end Jumps;""", road="t [s],x [mm]\n0,0\n0.5,100\n3,100\n")
    run = model.simulate(at=[0.4, 1.5], tolerance=1e-11)
    assert run["der(b.s)"] == pytest.approx([0, 0.15 * np.exp(-1.5)], abs=1e-10)


@pytest.mark.parametrize("n", [40, 400])
def test_small_motion_knows_tables(n: int, write: Callable[..., lag.Model]) -> None:
    """Stiffness that time decides: written out by CasADi, or looked up."""
    t = np.linspace(0, 4, n)
    model = write("""model Stiff
      Block b(m = 2, base = world);
      energy potential 1[N/m]*table(time, "k.csv", smoothness = "cubic")*b.s^2/2;
    end Stiff;""", k=rows(t, 5 + np.sin(t), head="t,k"))
    k = CubicSpline(t, 5 + np.sin(t))(1.7)
    assert pytest.approx(np.array([[k]]), abs=1e-12) == model.linearize(time=1.7).K
    functions = model.functions()
    found = np.array(functions["jacobian"](t=1.7, q=[0.1], v=[0.0], p=model.parameter_values())["jacobian"])
    assert found == pytest.approx(np.array([[-k / 2, 0]]), abs=1e-12)


def test_along_a_coordinate(write: Callable[..., lag.Model]) -> None:
    """A track's height, and a spline of it, by its pieces: energy is kept, and the speed follows from it."""
    x = np.linspace(-3, 3, 25)
    model = write("""model Track
      Block b(m = 1, base = world, s(start = -2, fixed = true), v(start = 0.5, fixed = true));
      output Real h = table(b.s, "track.csv", smoothness = "cubic");
      energy potential 9.81[N]*table(b.s, "track.csv", smoothness = "cubic")*1[m];
    end Track;""", track=rows(x, x**2 / 4, head="x,h"))
    run = model.simulate(at=[0.2, 0.9, 1.7], tolerance=1e-11)
    s = run["b.s"]
    assert run["h"] == pytest.approx(s**2 / 4, abs=1e-9)  # a spline has parabolas
    assert run["der(b.s)"] ** 2 / 2 + 9.81 * s**2 / 4 == pytest.approx(0.125 + 9.81, abs=1e-8)


DIALECTS = {
    "commas": "time,z\n0,1.5\n0.1,-2e-3\n1,0\n",
    "no names": "0,1.5\n0.1,-2e-3\n1,0",
    "decimal commas": "Zeit [s];z (mm)\n0;1500\n0,1;-2\n1;0\n",
    "tabs": "time\tz\r\n0\t1.5\r\n0.1\t-0.002\r\n1\t0\r\n",
    "spaces": "# by hand\ntime  z\n 0   1.5\n0.1  -.002\n\n1 0.\n",
    "quotes and a mark": "\ufefftime,\"z [m]\"\n0,1.5\n# a remark\n0.1,-2E-03\n1,+0\n",
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects(dialect: str, write: Callable[..., lag.Model]) -> None:
    model = write("""model Reads
      Block b(m = 1, base = world);
      output Length z = table(time, "data.csv");
    end Reads;""", data=DIALECTS[dialect])
    assert model.simulate(at=[0.05, 0.55])["z"] == pytest.approx([0.749, -0.001], abs=1e-15)


def test_numbers_are_read_as_python_reads_them(tmp_path: Path) -> None:
    chance = np.random.default_rng(5)
    spread = chance.standard_normal(2000) * 10.0 ** chance.integers(-300, 300, 2000)
    texts = [*map(repr, spread.tolist()), *(f"{x:.25f}" for x in chance.standard_normal(500)), "1e23", "9007199254740993",
             "123456789012345678901234567890", "5e-324", "1e-400", "-0", ".5", "5.", "+3", "00012.50e+01", "1E22"]
    (tmp_path / "numbers.csv").write_text("\n".join(f"{k},{text}" for k, text in enumerate(texts)))
    found = read_columns(tmp_path / "numbers.csv").values[1]
    assert found.tolist() == [float(text) for text in texts]


@pytest.mark.parametrize(("content", "what"), [
    ("t,z\n0,1\n0.5,two\n1,3\n", "data.csv:3: 'two' is no finite number"),
    ("t,z\n0,1\n0.5\n1,3\n", "data.csv:3 has 1 cells, not 2"),
    ("t,z\n0,1\n0.5,\n1,3\n", "data.csv:3: '' is no finite number"),
    ("t,z\n0,inf\n1,1\n", "data.csv:2: 'inf' is no finite number"),
    ("t,z\n", "has no rows"), ("", "has no rows"), ("t,t\n0,1\n1,2\n", "two columns of one name"),
    ("t [s],z [mN/mm2x]\n0,1\n1,2\n", "mm2x"),
])
def test_what_is_no_table(content: str, what: str, write: Callable[..., lag.Model]) -> None:
    with pytest.raises(lag.LagError, match=what.replace("(", r"\(")):
        write('model Reads Block b(m = 1, base = world); output Real z = table(time, "data.csv"); end Reads;', data=content)


def test_mat_and_parquet(tmp_path: Path) -> None:
    scipy_io, pandas = pytest.importorskip("scipy.io"), pytest.importorskip("pandas")
    t, z = np.linspace(0, 1, 5), np.arange(5.0)
    scipy_io.savemat(tmp_path / "data.mat", {"t": t, "z": z})
    scipy_io.savemat(tmp_path / "matrix.mat", {"both": np.column_stack([t, z])})
    pandas.DataFrame({"t [s]": t, "z [mm]": z}).to_parquet(tmp_path / "data.parquet")
    for name, heads in (("data.mat", ("t", "z")), ("matrix.mat", ("", "")), ("data.parquet", ("t", "z"))):
        found = read_columns(tmp_path / name)
        assert found.names == heads and found.values.tolist() == [t.tolist(), z.tolist()]
    assert found.units == ("s", "mm")


def test_a_table_that_ends_ends_the_run(write: Callable[..., lag.Model], tmp_path: Path,
                                         capsys: pytest.CaptureFixture[str]) -> None:
    model = write("""model Ends
      Block b(m = 1, base = world);
      AppliedForce f(at = b.center, force = {table(time, "force.csv", beyond = "error"), 0});
    end Ends;""", force="t,F\n0,1\n2,1\n")
    assert model.simulate(at=[2.0])["der(b.s)"] == pytest.approx([2.0], abs=1e-12)
    with pytest.raises(lag.RunError, match=r"the table 'force.csv' ends.*t = 2"):
        model.simulate(stop=3)
    assert main(["simulate", str(tmp_path / "scene.lag"), "--stop", "3", "-o", str(tmp_path / "rows.csv")]) == 1
    assert len((tmp_path / "rows.csv").read_text().splitlines()) > 300  # what was computed is kept
    assert main(["simulate", str(tmp_path / "scene.lag"), "-o", str(tmp_path / "force.csv")]) == 2
    assert "a result does not take its place" in capsys.readouterr().err
    if find_fmu(data_folder("runtime"), "2"):
        path = tmp_path / "ends.fmu"
        export_fmu(model, Export("2", platforms=(host_platform(),), engine="tape", sources=False), path)
        for kind in ("me", "cs"):
            run = ["simulate", str(path), "--kind", kind, "-o", str(tmp_path / "fmu.csv"), "--stop"]
            assert (main([*run, "2"]), main([*run, "3"])) == (0, 1)
        assert "a table ends here" in capsys.readouterr().err


def test_a_table_that_changes_is_read_again(write: Callable[..., lag.Model]) -> None:
    text = 'model Reads Block b(m = 1, base = world); output Real z = table(time, "data.csv"); end Reads;'
    assert write(text, data="0,1\n1,1\n").simulate(at=[0.5])["z"] == [1.0]
    assert write(text, data="0,1\n1,1\n").is_cached
    assert write(text, data="0,2\n1,2\n").simulate(at=[0.5])["z"] == [2.0]


def test_many_rows_cost_no_search() -> None:
    """Knots that do not lie evenly, in the order of time and at any place: found as by NumPy."""
    chance = np.random.default_rng(8)
    x = np.cumsum(chance.uniform(0.01, 1.0, 100_000))
    table = made_table("many", x, chance.standard_normal(100_000), "linear", Beyond.HOLD)
    assert len(table.x) == len(x) and len(made_table("even", 0.1 * np.arange(1000), x[:1000], "linear", Beyond.HOLD).x) == 0
    for place in (*chance.uniform(x[0], x[-1], 50), x[0], x[70_000]):
        k = np.searchsorted(x, place, side="right") - 1
        assert table.piece(place)[0] == x[k]
