"""Known problems in space: scenes in spatial/cases.lag, or written here where they have many bodies; references in cases.yaml."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

import lagrangia as lag
from lagrangia.model import Model

FOLDER, EXAMPLES = Path(__file__).with_name("spatial"), Path(__file__).parents[2] / "models" / "examples"
REFERENCES = yaml.safe_load((FOLDER / "cases.yaml").read_text(encoding="utf-8"))
Array = np.ndarray


@cache
def scene(name: str, *outputs: str) -> Model:
    return Model(FOLDER / "cases.lag", model=name, outputs=outputs)


def vector(run: lag.Trajectory, name: str, at: int, size: int = 3) -> list[float]:
    return [run[f"{name}[{k}]"][at] for k in range(1, size + 1)]


def rows(model: Model, known: list[dict], **more: object) -> tuple[lag.Trajectory, list[tuple[int, dict]]]:
    run = model.simulate(at=[0, *(row["t"] for row in known)], tolerance=1e-13, **more)
    return run, list(enumerate(known, 1))


def same_attitude(found: list[float], known: list[float], error: float) -> None:
    assert np.abs(np.multiply(found, np.sign(found[0]))) == pytest.approx(np.abs(known), abs=error)
    assert abs(np.dot(found, known)) == pytest.approx(1, abs=error)


# ---------------------------------------------------------------- tops and hinges


@pytest.mark.parametrize("solver", ["pirk", "taylor"])
@pytest.mark.parametrize(("kind", "start"), [("fast", {}), ("slow", {"theta": 1.0, "phi_rate": -3.0, "psi_rate": 40.0})])
def test_the_tip_of_a_top_is_held_by_its_force(kind: str, start: dict[str, float], solver: str) -> None:
    run, known = rows(scene("HeavyTop", "tip.reaction", "top.center.w"), REFERENCES["top"][kind], parameters=start, solver=solver)
    for k, row in known:
        assert run["top.center.r"][k] == pytest.approx(row["centre"], abs=1e-12)
        assert vector(run, "tip.w", k) == pytest.approx(row["w"], abs=3e-10)
        assert vector(run, "tip.reaction", k) == pytest.approx(row["force"], abs=1e-10)


@pytest.mark.parametrize("solver", ["pirk", "taylor"])
@pytest.mark.parametrize(("case", "w"), [("a", [0.5, 0.2, 1.5]), ("b", [1.2, 0.5, 0.3])])
def test_a_free_body_turns_as_it_should(case: str, w: list[float], solver: str) -> None:
    values = {f"w[{k}]": x for k, x in enumerate(w, 1)}
    run, known = rows(scene("EulerTop"), REFERENCES["euler_top"][case], parameters=values, solver=solver)
    for k, row in known:
        assert vector(run, "der(body.center.S)", k) == pytest.approx(row["w"], abs=2e-12)
        same_attitude(vector(run, "body.center.S", k, 4), row["Q"], 2e-12)


def test_gimbals_pass_their_lock() -> None:
    known = REFERENCES["gimbal_lock"]
    run, found = rows(scene("GimbalLock", "alpha.reaction", "der(alpha.w)", "der(beta.w)", "der(gamma.w)", "rotor.center.w"),
                      known["rows"])
    for k, row in found:
        joints = ("alpha", "beta", "gamma")
        assert [run[f"{name}.phi"][k] for name in joints] == pytest.approx(row["q"], abs=1e-11)
        assert [run[f"{name}.w"][k] for name in joints] == pytest.approx(row["v"], abs=1e-10)
        assert [run[f"der({name}.w)"][k] for name in joints] == pytest.approx(row["a"], abs=1e-9)
        assert vector(run, "rotor.center.w", k) == pytest.approx(row["w"], abs=1e-9)
        assert vector(run, "alpha.reaction", k) == pytest.approx(row["force"], abs=1e-10)
    angle = scene("GimbalLock").simulate(stop=5, interval=0.02)["beta.phi"]
    assert (angle[1:] * angle[:-1] < 0).sum() == 7
    first = scene("GimbalLock").simulate(at=[0, known["first"]["t"]], tolerance=1e-13)
    assert first["beta.phi"][-1] == pytest.approx(0, abs=1e-12)


def test_a_rotary_pendulum_with_bearings_that_damp() -> None:
    run, known = rows(scene("DampedFuruta"), REFERENCES["furuta_damped"])
    for k, row in known:
        assert [run["turning.phi"][k], run["swinging.phi"][k]] == pytest.approx([row["phi"], row["theta"]], abs=5e-12)
        assert run["rod.center.r"][k] == pytest.approx(row["centre"], abs=5e-12)


def test_a_robot_arm_swings_freely() -> None:
    arm = Model(EXAMPLES / "robot_arm.lag", outputs=("link[6].w", "link[6].omega"))
    start = {"joint[2].phi": np.pi / 4, "joint[3].phi": np.pi, "joint[4].phi": 0.3, "joint[5].phi": np.pi / 4, "joint[1].w": 0.5}
    run, known = rows(arm, REFERENCES["robot_arm_swing"], initial=start)
    for k, row in known:
        assert [run[f"joint[{i}].phi"][k] for i in range(1, 7)] == pytest.approx(row["q"], abs=2e-11)
        assert [run[f"joint[{i}].w"][k] for i in range(1, 7)] == pytest.approx(row["v"], abs=5e-10)
        assert vector(run, "acceleration", k, 6) == pytest.approx(row["a"], rel=1e-9)
        assert vector(run, "flange", k) == pytest.approx(row["flange"], abs=1e-11)
        assert vector(run, "link[6].omega", k) == pytest.approx(row["w"], abs=2e-10)


# ---------------------------------------------------------------- loops


def test_a_planar_four_bar_in_a_tilted_plane() -> None:
    model = scene("TiltedFourBar", "body2.center.Q", "body2.center.w")
    run, known = rows(model, REFERENCES["tilted_four_bar"])
    for k, row in known:
        assert [run["A.phi"][k], run["A.w"][k]] == pytest.approx([row["angle"], row["w"]], abs=2e-9)
        assert run["body2.center.r"][k] == pytest.approx(row["centre"], abs=1e-9)
        assert vector(run, "body2.center.w", k) == pytest.approx(row["w2"], abs=2e-9)
        same_attitude(vector(run, "body2.center.Q", k, 4), row["Q"], 1e-9)
    assert model.freedom["degrees_of_freedom"] == 1 and model.freedom["repeated"]


def rod_start() -> dict[str, float]:
    """Parameters of Rssr with which the rod begins without spin."""
    rest = Rotation.from_rotvec([0, -1.6258742567362116, 0]).inv()
    ends = np.array([0.3, 0, 0]), np.array([0.9, 0.5, 0.2]) + rest.inv().apply([0.6, 0, 0])
    along = (ends[1] - ends[0]) / 1.1
    axis = np.cross([1, 0, 0], along)
    u = axis / np.linalg.norm(axis) * np.arccos(along[0])
    rod = Rotation.from_rotvec(u)
    rate = np.cross([0, 3.2781501882489182, 0], ends[1] - [0.9, 0.5, 0.2]) - np.cross([0, 0, 8], ends[0])
    w = rod.inv().apply(np.cross(along, rate) / 1.1 - [0, 0, 8])
    return {f"u[{k}]": x for k, x in enumerate(u, 1)} | {f"w[{k}]": x for k, x in enumerate(w, 1)}


def test_a_rod_on_two_ball_joints() -> None:
    """Crank and rocker follow the references; the rod's spin, which nothing holds, stays away."""
    run, known = rows(scene("Rssr", "rod.center.omega"), REFERENCES["rssr"], parameters=rod_start())
    for k, row in known:
        assert [run["turning.phi"][k], run["rocking.phi"][k]] == pytest.approx([row["theta"], row["phi"]], abs=1e-11)
        assert run["turning.w"][k] == pytest.approx(row["rate"], abs=1e-10)
        assert run["rod.center.r"][k] == pytest.approx(row["centre"], abs=1e-11)
        assert run["rod.center.omega[1]"][k] == pytest.approx(0, abs=1e-12)


# ---------------------------------------------------------------- chains on ball joints


def chain(bars: list[tuple[float, float, tuple[float, float, float], int]], attitudes: list[Rotation], spins: Array) -> Model:
    """Mass, length, moments, axis of each bar; attitudes and angular velocities (own axes) as they are in the world."""
    lines = ["model Chain", "  World world(gravity = {0, 0, -9.81});"]
    behind, before, place = Rotation.identity(), np.zeros(3), "world"
    for k, ((m, L, moments, axis), turned, w) in enumerate(zip(bars, attitudes, spins, strict=True), 1):
        ahead = behind.inv() * turned
        x, y, z, real = map(float, ahead.as_quat())
        relative = w - ahead.inv().apply(before)
        half, whole = ("{" + ", ".join(repr(float(L * part * (n == abs(axis)) * np.sign(axis))) for n in (1, 2, 3)) + "}"
                       for part in (0.5, 1.0))
        lines.append(f"  Spherical j{k}(a = {place}, S(start = quaternion({real!r}, {x!r}, {y!r}, {z!r})), "
                     f"w(start = {{{', '.join(repr(float(item)) for item in relative)}}}));")
        lines.append(f"  Body b{k}(m = {m!r}, I = {{{', '.join(map(repr, moments))}}}, center = shift(j{k}.b, {half}));")
        behind, before, place = turned, w, f"shift(j{k}.b, {whole})"
    n = len(bars)
    lines += [f"  Frame last = {place};", "  output Position tip[3] = last.r;"]
    lines += [f"  output AngularVelocity w[3] = b{n}.center.omega;", "  output Force held[3] = j1.reaction;",
              "  output Force knee[3] = j2.reaction;", "end Chain;"]
    return lag.loads("\n".join(lines))


def test_five_bars_from_rest() -> None:
    slanted = np.array([[1, 1, 0], [1, -1, 0]]) / np.sqrt(2)
    vectors = [[0, 0.8, 0], [0.9, 0, 0], 0.7 * slanted[0], [0, -0.5, 0], 1.2 * slanted[1]]
    bars = [(0.1, 0.2, (1 / 3000, 1 / 3000, 0.00001), -3)] * 5
    model = chain(bars, [Rotation.from_rotvec(x) for x in vectors], np.zeros((5, 3)))
    run, known = rows(model, REFERENCES["five_bars"])
    for k, row in known:
        for n, centre in enumerate(row["centres"], 1):
            assert run[f"b{n}.center.r"][k] == pytest.approx(centre, abs=2e-12)
        same_attitude(list(run["b5.center.Q"][k]), row["Q"], 1e-11)
        assert vector(run, "w", k) == pytest.approx(row["w"], abs=2e-10)


def test_two_bars_that_spin() -> None:
    bars = [(1.0, 1.0, (0.01, 1 / 12, 1 / 12), 1), (0.7, 0.8, (0.02, 0.7 * 0.64 / 12, 0.7 * 0.64 / 12), 1)]
    model = chain(bars, [Rotation.identity(), Rotation.from_rotvec([0, 0, np.pi / 3])], np.array([[3, -0.5, 1], [-2, 1, 2]]))
    run, known = rows(model, REFERENCES["two_bars"])
    for k, row in known:
        assert vector(run, "tip", k) == pytest.approx(row["end"], abs=1e-11)
        assert vector(run, "w", k) == pytest.approx(row["w"], abs=1e-10)
        assert vector(run, "held", k) == pytest.approx(row["force"], abs=1e-9)
        assert vector(run, "knee", k) == pytest.approx(row["knee_force"], abs=1e-9)


@pytest.mark.parametrize("n", [5, 20])
def test_a_hanging_chain(n: int) -> None:
    m = L = 1 / n
    across = m * L**2 / 12 + m * 0.01**2 / 4
    turns = [Rotation.from_rotvec([0, 0, 1.2 * k / n]) for k in range(1, n + 1)]
    model = chain([(m, L, (m * 0.01**2 / 2, across, across), 1)] * n, turns, np.array([[10, 0, 0]] * n))
    run, known = rows(model, REFERENCES[f"hanging_{n}"])
    for k, row in known:
        assert vector(run, "tip", k) == pytest.approx(row["end"], abs=2e-10)
        assert vector(run, "w", k) == pytest.approx(row["w"], abs=2e-8)
        assert vector(run, "held", k) == pytest.approx(row["force"], abs=1e-7)


# ---------------------------------------------------------------- frames that turn, lattices


def test_a_mass_in_a_plane_that_turns() -> None:
    run, known = rows(scene("TurningPlane"), REFERENCES["foucault"]["turning"])
    for k, row in known:
        assert [run["south.s"][k], run["east.s"][k]] == pytest.approx([row["x"], row["y"]], abs=1e-12)
        assert run["mass.center.r"][k] == pytest.approx(row["r"], abs=1e-12)


def test_the_pendulum_of_paris() -> None:
    run, known = rows(scene("Paris", "bob.center.v"), REFERENCES["foucault"]["paris"])
    for k, row in known:
        assert run["bob.center.r"][k] == pytest.approx(row["r"], abs=2e-10)
        assert vector(run, "bob.center.v", k) == pytest.approx(row["v"], abs=2e-10)


def lattice(n: int, k: float, length: float, mass: float) -> str:
    """Point masses at (1..n)^3 with springs to their neighbours and to walls."""
    lines = ["model Lattice", "  World world(gravity = {0, 0, 0});"]

    def node(at: tuple[int, ...]) -> str:
        name = "p" + "".join(map(str, at))
        return f"{name}.center" if all(1 <= x <= n for x in at) else "shift(world, {" + ", ".join(map(str, at)) + "})"

    inside = range(1, n + 1)
    for at in ((i, j, l) for i in inside for j in inside for l in inside):
        x, y, z = at
        lines.append(f"  PointMass p{x}{y}{z}(m = {mass}, center(x(start = {x}), y(start = {y}), z(start = {z})));")
    for axis in range(3):
        for a in range(n + 1):
            for b, c in ((b, c) for b in inside for c in inside):
                first, second = [b, c], [b, c]
                first.insert(axis, a), second.insert(axis, a + 1)
                ends = f"a = {node(tuple(first))}, b = {node(tuple(second))}"
                lines.append(f"  Spring s{axis}{a}{b}{c}(k = {k}, s_rel0 = {length}, {ends});")
    return "\n".join([*lines, "end Lattice;"])


def test_a_lattice_of_stretched_springs() -> None:
    known = REFERENCES["lattice"]
    found = lag.loads(lattice(3, 200.0, 0.75, 0.5)).modes(about="start")
    assert np.sort(found.omega) == pytest.approx(np.repeat(known["omega"], known["count"]), rel=1e-12)


@pytest.mark.slow
def test_a_lattice_of_springs_without_length() -> None:
    """It is exactly linear, though written with lengths."""
    model = lag.loads(lattice(4, 1.0, 0.0, 1.0))
    start = {"p123.center.x": 1.3, "p123.center.y": 1.8, "p123.center.z": 3.1,
             "der(p441.center.x)": 0.5, "der(p441.center.z)": -1.0}
    run, known = rows(model, REFERENCES["zero_length"], initial=start)
    for k, row in known:
        for node in ("111", "123", "232", "444"):
            moved = [run[f"p{node}.center.{axis}"][k] - float(at) for axis, at in zip("xyz", node, strict=True)]
            assert moved == pytest.approx(row[node], abs=1e-12)
