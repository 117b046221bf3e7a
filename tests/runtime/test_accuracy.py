"""The C run time: the method and its accuracy on motions known to 18 digits."""

import ctypes
import math
import re
from array import array
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import pytest

from helpers.native_models import FOLDER, OSCILLATOR, compiled, started
from lagrangia.native.build import build, find_compiler
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

# ---------------------------------------------------------------------------------------------------------------- method


def tableau() -> dict[str, list[list[float]]]:
    """The arrays of dop853_tableau.h, with zeros filled in."""
    text = (FOLDER / "methods" / "dop853_tableau.h").read_text()
    found = {}
    for name, body in re.findall(r"lag_dop853_(\w+)(?:\[\w+\])? =\s*(.*?);", text, re.S):
        rows = re.findall(r"\{\d+, \{([\d, ]+)\},\s*\{([^}]+)\}\}", body)
        found[name] = [_dense(columns, weights) for columns, weights in rows] or [_numbers(body)]
    return found


def _numbers(text: str) -> list[float]:
    return [float(number) for number in text.strip("{} \n").split(",")]


def _dense(columns: str, weights: str) -> list[float]:
    row = [0.0] * 16
    for column, weight in zip(_numbers(columns), _numbers(weights), strict=True):
        row[int(column)] = weight
    return row


def dot(x: Iterable[float], y: Iterable[float]) -> float:
    return math.fsum(a * b for a, b in zip(x, y, strict=True))


def test_tableau_satisfies_order_conditions() -> None:
    arrays = tableau()
    c, A, b = arrays["node"][0], arrays["stage"], arrays["stage"][12]
    assert len(A) == 16
    for i in range(16):
        assert dot(A[i], [1.0] * 16) == pytest.approx(c[i], abs=2e-14)
    for k in range(8):
        powers = [x**k for x in c]
        assert dot(b, powers) == pytest.approx(1 / (k + 1), abs=1e-14)
    for m in range(7):
        for k in range(7 - m):  # the trees [tau^m [tau^k]], orders up to 8
            inner = [dot(row, [x**k for x in c]) for row in A]
            tree = [x**m * y for x, y in zip(c, inner, strict=True)]
            assert dot(b, tree) == pytest.approx(1 / ((k + 1) * (k + m + 2)), abs=1e-14)
    for k in range(5):
        assert dot(arrays["error5"][0], [x**k for x in c]) == pytest.approx(0, abs=1e-14)
    for k in range(3):
        assert dot(arrays["error3"][0], [x**k for x in c]) == pytest.approx(0, abs=1e-13)
    assert abs(dot(arrays["error5"][0], [x**5 for x in c])) > 1e-4


@pytest.mark.parametrize(("solver", "longest", "order", "inside_order", "most_evaluations"), [
    (Solver.ERK, 0.5, (7.5, 9.5), 7, math.inf), (Solver.ERK5, 0.25, (4.6, 6.5), 4, 6),
])
def test_order_of_convergence(runtime: Runtime, solver: Solver, longest: float, order: tuple[float, float], inside_order: float,
                              most_evaluations: float) -> None:
    """Of the high order dense output takes evaluations of its own; of the low one a step takes `most_evaluations` at most."""
    model = compiled(1, rhs=OSCILLATOR)
    errors, inside = [], []
    for h in (longest, longest / 2):
        with started(runtime, model, [1], [0], t_stop=8, tolerance=1e3, first_step=h, max_step=h, solver=solver) as run:
            rows = run.advance([8 - 0.3 * h, 8])
            assert run.statistics.steps == 8 / h
            assert run.statistics.rhs_evaluations <= most_evaluations * 8 / h + 2
        errors.append(abs(rows[1][1] - math.cos(8)))
        inside.append(abs(rows[0][1] - math.cos(8 - 0.3 * h)))
    assert order[0] < math.log2(errors[0] / errors[1]) < order[1]
    assert math.log2(inside[0] / inside[1]) > inside_order


def test_dense_output_meets_both_ends_of_a_step(runtime: Runtime) -> None:
    model = compiled(1, rhs="a[0] = -sin(q[0]);")
    with started(runtime, model, [1], [0.5], t_stop=10, tolerance=1e-5, solver=Solver.ERK) as run:
        times = [0.0]
        ends = [run.row()[0]]
        for _ in range(4):
            ends.append(run.advance_steps(1)[0])
            times.append(run.time)
    with started(runtime, model, [1], [0.5], t_stop=10, tolerance=1e-5, solver=Solver.ERK) as run:
        for t, end in zip(times[1:], ends[1:], strict=True):
            rows = run.advance([t * (1 - 1e-13), t])
            assert list(rows[0][1:3]) == pytest.approx(list(end[1:3]), abs=1e-12)
            assert rows[1] == end


# -------------------------------------------------------------------------------------------------------------- accuracy

KEPLER = "const double r2 = q[0]*q[0] + q[1]*q[1], r3 = r2*sqrt(r2); a[0] = -q[0]/r3; a[1] = -q[1]/r3;"


def double_pendulum(m: float, L: float, centre: float, inertia: float, damping: float) -> str:
    """Two equal bars, angles from the downward vertical."""
    coupling = m * L * centre
    return f"""
    const double C = {coupling!r}*cos(q[0] - q[1]), S = {coupling!r}*sin(q[0] - q[1]);
    const double M11 = {inertia + m * centre**2 + m * L**2!r}, M22 = {inertia + m * centre**2!r}, D = M11*M22 - C*C;
    const double f1 = -S*v[1]*v[1] - {m * (centre + L)!r}*9.81*sin(q[0]) - {damping!r}*v[0];
    const double f2 = S*v[0]*v[0] - {m * centre!r}*9.81*sin(q[1]);
    a[0] = (M22*f1 - C*f2)/D; a[1] = (M11*f2 - C*f1)/D;"""


@dataclass(frozen=True)
class Case:
    """A motion with reference states; `see` maps (q, v) to what is compared, `size` is its amplitude."""

    rhs: str
    q: list[float]
    v: list[float]
    reference: dict[float, list[float]]
    size: float
    kinds: tuple[int, ...] = (1, 1)

    def see(self, q: list[float], v: list[float]) -> list[float]:
        return [*q, *v][: len(next(iter(self.reference.values())))]


class Tips(Case):
    """Compared in the plane: the tip of the first and of the second bar."""

    def see(self, q: list[float], v: list[float]) -> list[float]:
        x, y = math.sin(q[0]), -math.cos(q[0])
        return [x, y, x + math.sin(q[1]), y - math.cos(q[1])]


class RelativeAngles(Case):
    """Compared from the horizontal, the second bar relative to the first."""

    def see(self, q: list[float], v: list[float]) -> list[float]:
        return [q[0] - math.pi / 2, v[0], q[1] - q[0], v[1] - v[0]]


# References: closed forms (Kepler's equation, Jacobi's functions, matrix exponentials), or Taylor series of high order in
# multiple precision checked against an extrapolation code in quadruple precision; 18 digits or more are right.
CASES = {
    "Kepler 0.6": Case(
        KEPLER,
        [0.4, 0],
        [0, 2],
        {
            20: [-0.77007557841124044, 0.78834481699442438, -0.894183731988691497, -0.12346176416804095],
            100: [-0.10418320443418060, -0.69474171556795059, 1.2361777626870763, 0.56462325108586457],
        },
        size=1,
    ),
    "Kepler 0.99": Case(
        KEPLER,
        [0.01, 0],
        [0, math.sqrt(199)],
        {
            1: [-1.339314318191828685, 0.1321809070607890006],
            20: [-1.438132493154337110, 0.1261095858558247437],
            100: [-0.9388973273317407724, -0.1408830418653664609],
        },
        size=1,
    ),
    "pendulum swinging": Case(
        "a[0] = -sin(q[0]);",
        [0],
        [1],
        {2 * math.pi: [-0.443944662290258816, 0.897846803312944007]},
        1,
        (0,),
    ),
    "pendulum near its separatrix": Case(
        "a[0] = -sin(q[0]);",
        [179.9 * math.pi / 180],
        [0],
        {
            5: [3.012117212670403932, -0.1293732495930838650],
            20: [-3.121403403452826931, 0.02011332400792372295],
            50: [-3.139543797279738907, -0.001073143646572228107],
        },
        math.pi,
        (0,),
    ),
    "pendulum rotating": Case(
        "a[0] = -sin(q[0]);",
        [0],
        [2.1],
        {5: [6.333424069819392547, 2.099399103919267954], 100: [126.6324510806264510823, 1.882197847822007650]},
        math.pi,
        (0,),
    ),
    "two masses, damped": Case(
        "const double f = 2*(q[1] - q[0]) + 0.1*(v[1] - v[0]); a[0] = (f - 3*q[0] - 0.3*v[0])/2; a[1] = -f - q[1];",
        [1, 0],
        [0, 0.5],
        {
            1: [0.1839306645861929179, 0.8453643814452949323, -1.077687035779679912, 0.4196451754127788584],
            10: [0.007024048459553239618, 0.1022413410269144308, 0.1650586908710957044, 1.037596548835110924],
            100: [0.002982303619591565588, 0.003173402327674700392, -0.007740225447198053638, -0.009375449640900075581],
        },
        1,
    ),
    "quarter car over a step": Case(
        "const double s = 80000*(q[1]-q[0]) + 350*(v[1]-v[0]); a[0] = s/2500; a[1] = (500000*(0.1-q[1]) - 15020*v[1] - s)/320;",
        [0, 0],
        [0, 4.69375],
        {0.1: [0.01371656894765291556, 0.09201101540239088376], 5: [0.07538846215534975243, 0.09573343036811594905]},
        0.1,
    ),
    "double pendulum": Tips(
        double_pendulum(1, 1, 1, 0, 0),
        [math.pi / 2] * 2,
        [0, 0],
        {5: [-0.58686920981627114532, -0.80968174647180080514, -1.5507784694704428004, -1.0759127348126524565]},
        1,
        (0, 0),
    ),
    "double pendulum, damped": RelativeAngles(
        double_pendulum(13.86, 0.5, 0.25, 0.292908, 0.1),
        [math.pi / 2] * 2,
        [0, 0],
        {
            1: [-2.915161357931965093, 2.947065631985872531, -0.5164476259671957187, -7.249062905137639115],
            3: [-2.315814712626491486, 4.100899424391187455, -1.736610642804923231, -0.03314630939350927809],
        },
        1,
        (0, 0),
    ),
    "stiff spring pendulum": Case(
        "const double r = sqrt(q[0]*q[0] + q[1]*q[1]), f = -1e6*(r - 1)/r; a[0] = f*q[0]; a[1] = f*q[1] - 9.81;",
        [1, 0],
        [0, 0],
        {
            1: [-0.98629074280213375439, -0.16504631169751566685, -0.29694694362071681506, 1.7748260636421157975],
            5: [0.94238391974646738738, -0.33456275886425351935, -0.85708590055202621853, -2.4144208719785924179],
        },
        1,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_error_follows_the_tolerance(runtime: Runtime, name: str) -> None:
    case = CASES[name]
    n = len(case.q)
    model = compiled(n, kinds=list(case.kinds), rhs=case.rhs)
    errors = {}
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        with started(runtime, model, case.q, case.v, t_stop=max(case.reference), tolerance=tolerance,
                     solver=Solver.ERK) as run:
            rows = run.advance(sorted(case.reference))
        assert rows.status is Status.OK
        seen = [case.see(rows[i][1 : n + 1].tolist(), rows[i][n + 1 : 2 * n + 1].tolist()) for i in range(rows.count)]
        right = [case.reference[t] for t in sorted(case.reference)]
        errors[tolerance] = max(abs(x - y) for row in zip(seen, right, strict=True) for x, y in zip(*row, strict=True))
    assert errors[1e-12] < 1e-9 * case.size
    assert errors[1e-12] < 1e-5 * errors[1e-4]
    for loose, tight in ((1e-4, 1e-8), (1e-6, 1e-10), (1e-8, 1e-12)):
        assert errors[tight] < 3e-2 * errors[loose]


@pytest.mark.parametrize("length", [1e-6, 3e8])
@pytest.mark.parametrize("second", [1e-9, 1e9])
def test_units_do_not_matter(runtime: Runtime, length: float, second: float) -> None:
    def steps(amplitude: float, period: float) -> int:
        w = 2 * math.pi / period
        model = compiled(1, rhs=f"a[0] = -{w * w!r}*q[0];")
        with started(runtime, model, [amplitude], [0], t_stop=10 * period, tolerance=1e-9) as run:
            row = run.advance([9.9 * period])[0]
            assert row[1] == pytest.approx(amplitude * math.cos(2 * math.pi * 9.9), rel=1e-7)
            return run.statistics.steps

    assert abs(steps(length, second) - steps(1, 1)) <= 2


UNIT = """
LAG_API double unit(int kind, double q, double other);
double unit(int kind, double q, double other) /* of q, beside a coordinate `other` of kind 1, at tolerance 1e-6 */
{
    const int kinds[] = {kind, 1};
    const double y[] = {q, other, 0, 0};
    double memory[64] = {0};
    LagArena arena = {memory, 0};
    LagScale scale;
    lag_scale_init(&scale, 2, kinds, 1e-6);
    lag_scale_layout(&scale, &arena);
    lag_scale_reset(&scale);
    lag_scale_note(&scale, y);
    return lag_scale_unit(&scale, 0, y, y);
}
"""


def test_units_of_error() -> None:
    unit = ctypes.CDLL(str(build("unit", (FOLDER / "state" / "scale.c").read_text() + UNIT, include=[FOLDER]))).unit
    unit.restype, unit.argtypes = ctypes.c_double, (ctypes.c_int, ctypes.c_double, ctypes.c_double)
    assert unit(1, 1e-30, 0) == pytest.approx(1e-6 * unit(1, 1e-24, 0)) == pytest.approx(5e-38)
    assert unit(0, 1e6, 0) == unit(0, 10, 0) == pytest.approx(math.pi * unit(0, 1, 0))
    assert unit(1, 1e-9, 1) > 1e5 * unit(2, 1e-9, 1)
    assert unit(1, 0, 0) == 0


def test_many_turns_do_not_loosen_an_angle(runtime: Runtime) -> None:
    model = compiled(1, kinds=[0], rhs="a[0] = -sin(q[0]);")
    far = 2 * math.pi * 2**17
    near = started(runtime, model, [1], [0], t_stop=20, tolerance=1e-7)
    away = started(runtime, model, [far + 1], [0], t_stop=20, tolerance=1e-7)
    with near, away:
        difference = away.advance([20])[0][1] - far - near.advance([20])[0][1]
        assert abs(difference) < 1e-6
        assert abs(away.statistics.steps - near.statistics.steps) <= 3


@pytest.mark.parametrize(
    ("acceleration", "end"),
    [("0*q[0]", 0.0), ("-9.81", -9.81 * 50), ("sin(t)", 10 - math.sin(10)), ("1 - q[0]", 1 - math.cos(10))],
)
def test_starts_from_rest_at_zero(runtime: Runtime, acceleration: str, end: float) -> None:
    with started(runtime, compiled(1, rhs=f"a[0] = {acceleration};"), [0], [0], t_stop=10, tolerance=1e-10) as run:
        assert run.advance([10])[0][1] == pytest.approx(end, abs=1e-8)
        assert run.statistics.steps < 60


def test_rows_do_not_depend_on_how_they_are_asked_for(runtime: Runtime) -> None:
    model = compiled(2, rhs=KEPLER)
    times = [0.1 * i for i in range(200)]
    with started(runtime, model, [0.4, 0], [0, 2], t_stop=20, tolerance=1e-8) as run:
        at_once = run.advance(times)
    with started(runtime, model, [0.4, 0], [0, 2], t_stop=20, tolerance=1e-8) as run:
        one_by_one = array("d")
        for t in times:
            one_by_one.extend(run.advance([t]).values)
    assert at_once.values == one_by_one


def test_a_second_start_is_like_the_first(runtime: Runtime) -> None:
    with started(runtime, compiled(2, rhs=KEPLER), [0.4, 0], [0, 2], t_stop=50) as run:
        first = run.advance([10, 50]), run.statistics
        run.start([0.4, 0], [0, 2])
        assert (run.advance([10, 50]), run.statistics) == first


def test_runs_in_threads_are_independent(runtime: Runtime) -> None:
    model = compiled(2, rhs=KEPLER)

    def end(e: float) -> array:
        with started(runtime, model, [1 - e, 0], [0, math.sqrt((1 + e) / (1 - e))], t_stop=300) as run:
            return run.advance([300]).values

    orbits = [0.1, 0.3, 0.5, 0.7] * 3
    alone = [end(e) for e in orbits]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(end, orbits)) == alone
