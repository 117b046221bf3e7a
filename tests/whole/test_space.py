"""Scenes in space: known problems, Newton's and Euler's equations for trees at random, planar scenes that are tilted."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

import lagrangia as lag
from lagrangia.model import Model

FOLDER, EXAMPLES = Path(__file__).with_name("spatial"), Path(__file__).parents[2] / "models" / "examples"
REFERENCES = yaml.safe_load((FOLDER / "references.yaml").read_text(encoding="utf-8"))
Array = np.ndarray


@cache
def example(name: str, *outputs: str) -> Model:
    own = FOLDER / f"{name}.lag"
    return Model(own if own.exists() else EXAMPLES / f"{name}.lag", outputs=outputs)


def vector(run: lag.Trajectory, name: str, at: int = -1, size: int = 3) -> list[float]:
    return [run[f"{name}[{k}]"][at] for k in range(1, size + 1)]


# ---------------------------------------------------------------- known problems


def test_the_rotary_pendulum() -> None:
    """Places, angular velocities in both axes, and forces in the hinges, to thirteen digits."""
    model = example("furuta", "rod.center.w", "rod.center.omega", "swinging.reaction", "turning.reaction")
    known = REFERENCES["furuta"]
    run = model.simulate(at=[0, *(row["t"] for row in known)], tolerance=1e-13)
    for k, row in enumerate(known, 1):
        assert [run["turning.phi"][k], run["swinging.phi"][k]] == pytest.approx(row["angles"], rel=1e-12)
        assert vector(run, "reached", k) == pytest.approx(row["tip"], abs=1e-12)
        assert vector(run, "rod.center.w", k) == pytest.approx(row["w_world"], abs=1e-11)
        assert vector(run, "rod.center.omega", k) == pytest.approx(row["w_body"], abs=1e-11)
        assert vector(run, "swinging.reaction", k) == pytest.approx(row["force_on_rod"], abs=1e-10)
        assert vector(run, "turning.reaction", k) == pytest.approx(row["force_on_arm"], abs=1e-10)
    assert run.energy.total - run.energy.total[0] == pytest.approx(np.zeros(len(known) + 1), abs=1e-12)


def test_linear_motion_of_the_rotary_pendulum() -> None:
    model = example("furuta")
    hanging = model.linearize(initial={"swinging.phi": 0.0, "turning.w": 0.0, "swinging.w": 0.0}, about="start")
    assert sorted(abs(x) for x in np.linalg.eigvals(hanging.A))[2:] == pytest.approx([8.57332190674328280] * 2, rel=1e-12)


@pytest.mark.parametrize("spin", ["fast", "slow"])
def test_the_gyroscope_in_gimbals(spin: str) -> None:
    known = REFERENCES["gyroscope"][spin]
    model = example("gyroscope", "rotor.center.r")
    run = model.simulate(initial={"spinning.w": known["spin"]}, at=[0, known["t"]], tolerance=1e-13)
    assert [run[f"{name}.phi"][-1] for name in ("outer", "inner", "spinning")] == pytest.approx(known["angles"], rel=3e-12)
    assert vector(run, "rotor.center.r") == pytest.approx(known["centre"], abs=1e-12)


@pytest.mark.parametrize("place", ["zero", "nominal", "general"])
def test_forward_dynamics_of_the_robot_arm(place: str) -> None:
    known = REFERENCES["robot_arm"][place]
    initial = {f"joint[{k}].phi": q for k, q in enumerate(known["q"], 1)}
    initial |= {f"joint[{k}].w": v for k, v in enumerate(known["v"], 1)}
    torques = {f"torque[{k}]": tau for k, tau in enumerate(known["torque"], 1)}
    run = example("robot_arm").simulate(initial=initial, parameters=torques, at=[0, 1e-6])
    assert vector(run, "acceleration", 0, 6) == pytest.approx(known["acceleration"], rel=1e-12, abs=1e-12)
    assert vector(run, "flange", 0) == pytest.approx(known["flange"], abs=1e-15)


# ---------------------------------------------------------------- closed loops


@pytest.mark.parametrize(("name", "coordinate", "repeats"), [("cardan", "first.phi", True), ("double_cardan", "first.phi", True),
                                                             ("bricard", "p0.phi", True)])
def test_loops_close_without_hints(name: str, coordinate: str, repeats: bool) -> None:
    """Also where their equations repeat each other, as they do in all three; what every position repeats is told."""
    known = REFERENCES[name]
    run = example(name).simulate(at=[0, *known["t"]], tolerance=1e-12)
    assert run[coordinate][1:] == pytest.approx(known["angles"], rel=1e-11, abs=1e-11)
    assert run.statistics.constraint_residual < 1e-13
    assert example(name).freedom["degrees_of_freedom"] == 1 and bool(example(name).freedom["repeated"]) is repeats


def test_a_double_cardan_shaft_turns_evenly() -> None:
    run = example("double_cardan", "der(arm_4.phi)", "shaft_3.center.omega").simulate(stop=2, tolerance=1e-11)
    assert run["shaft_3.center.omega[1]"] == pytest.approx(run["first.w"], rel=1e-9)


FOUR_BAR = """
model FourBar
  {world};
  Revolute j1(a = {base}, {axis} phi(start = 60[deg], fixed = true), w(start = 3, fixed = true));
  Bar crank(m = 1, L = 0.4, a = j1.b);
  Revolute j2(a = crank.b, {axis} phi(start = 0));
  Bar coupler(m = 1.5, L = 1, a = j2.b);
  Revolute j4(a = shift({base}, {{0.9, 0}}), {axis} phi(start = 80[deg]));
  Bar rocker(m = 1, L = 0.7, a = j4.b);
  Revolute j3(a = coupler.b, {axis} b = rocker.b);
end FourBar;
"""


def test_a_planar_four_bar_of_spatial_hinges_moves_as_the_planar_one() -> None:
    """In a plane of space that no axis of coordinates lies in; forces in the plane are those of the planar one, in all hinges."""
    tilt = np.array([1, 2, -2]) / 3
    R = turn(tilt, 0.7)
    gravity = "{" + ", ".join(repr(float(x)) for x in R @ [0, -9.81, 0]) + "}"
    world, base = f"World world(gravity = {gravity})", "turn(world, 0.7, {1, 2, -2})"
    ways = {"world": "World world", "base": "world", "axis": ""}, {"world": world, "base": base, "axis": "axis = {0, 0, 2},"}
    texts = [FOUR_BAR.format(**way) for way in ways]
    joints = ("j1", "j2", "j3", "j4")
    flat, tilted = (Model(lag.loads(text).path, outputs=tuple(f"{j}.reaction" for j in joints)) for text in texts)
    a, b = (model.simulate(stop=1, interval=0.25, tolerance=1e-12) for model in (flat, tilted))
    for name in ("j1.phi", "j2.phi", "j4.phi", "der(j1.phi)"):
        assert b[name] == pytest.approx(a[name], abs=1e-10)
    for joint in joints:
        force = np.array([b[f"{joint}.reaction[{k}]"] for k in (1, 2, 3)]).T @ R
        known = np.array([a[f"{joint}.reaction[{k}]"] for k in (1, 2)]).T
        assert force[:, :2] == pytest.approx(known, abs=1e-8)
    assert tilted.freedom["degrees_of_freedom"] == 1 and tilted.freedom["repeated"]


# ---------------------------------------------------------------- a second formulation


class Tree:
    """A tree of hinges and sliders, each about or along a line like any other, with a body behind each joint."""

    def __init__(self, seed: int, n: int = 6) -> None:
        random = np.random.default_rng(seed)
        self.n, self.parents = n, [int(random.integers(-1, k)) if k else -1 for k in range(n)]
        self.slides = random.random(n) < 0.3
        self.slides[0] = False
        axes = random.normal(size=(n, 3))
        axes[::3] = np.eye(3)[random.integers(0, 3, len(axes[::3]))]
        self.axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
        self.ahead, self.centres = random.uniform(-1, 1, (2, n, 3))
        self.m = random.uniform(0.5, 2, n)
        points = random.uniform(-0.5, 0.5, (n, 8, 3))
        self.J = np.array([sum(m / 8 * (p @ p * np.eye(3) - np.outer(p, p)) for p in own - own.mean(0))
                           for m, own in zip(self.m, points, strict=True)])
        self.q, self.v, self.tau = random.uniform(-1, 1, (3, n))
        self.gravity = random.uniform(-10, 10, 3)

    def text(self) -> str:
        def curly(x: Array) -> str:
            return "{" + ", ".join(map(curly, x)) + "}" if np.ndim(x) else repr(float(x))

        lines = ["model Tree", f"  World world(gravity = {curly(self.gravity)});"]
        for k, parent in enumerate(self.parents):
            kind, way, q, w = ("Prismatic", "along", "s", "v") if self.slides[k] else ("Revolute", "axis", "phi", "w")
            base = "world" if parent < 0 else f"j{parent}.b"
            lines += [f"  {kind} j{k}(a = shift({base}, {curly(self.ahead[k])}), {way} = {curly(2 * self.axes[k])}, "
                      f"{q}(start = {float(self.q[k])!r}), {w}(start = {float(self.v[k])!r}));",
                      f"  Body b{k}(m = {float(self.m[k])!r}, I = {curly(self.J[k])}, "
                      f"center = shift(j{k}.b, {curly(self.centres[k])}));",
                      f"  output Real a{k} = der(j{k}.{w});"]
        works = [f"  work {float(self.tau[k])!r} on j{k}.{'s' if self.slides[k] else 'phi'};" for k in range(self.n)]
        return "\n".join([*lines, "energy", *works, "end Tree;"])

    def accelerations(self) -> Array:
        """By Newton's and Euler's equations of each body and the Jacobians of their twists."""
        n = self.n
        R, r, w, v = (np.zeros(shape) for shape in ((n, 3, 3), (n, 3), (n, 3), (n, 3)))
        alpha, a = np.zeros((n, 3)), np.zeros((n, 3))  # with no accelerations of coordinates
        Jw, Jv = np.zeros((n, 3, n)), np.zeros((n, 3, n))
        M, h = np.zeros((n, n)), np.zeros(n)
        for k, parent in enumerate(self.parents):
            at = (np.eye(3), *np.zeros((5, 3)), *np.zeros((2, 3, n))) if parent < 0 else (
                R[parent], r[parent], w[parent], v[parent], alpha[parent], a[parent], Jw[parent], Jv[parent])
            R0, r0, w0, v0, alpha0, a0, Jw0, Jv0 = at
            e = R0 @ self.axes[k]
            d = R0 @ (self.ahead[k] + (self.q[k] * self.axes[k] if self.slides[k] else 0))
            R[k], r[k], w[k], alpha[k], Jw[k] = R0, r0 + d, w0, alpha0, Jw0
            v[k] = v0 + np.cross(w0, d)
            a[k] = a0 + np.cross(alpha0, d) + np.cross(w0, np.cross(w0, d))
            Jv[k] = Jv0 - skew(d) @ Jw0
            if self.slides[k]:
                v[k] += e * self.v[k]
                a[k] += 2 * np.cross(w0, e * self.v[k])
                Jv[k][:, k] += e
            else:
                R[k] = R0 @ turn(self.axes[k], self.q[k])
                w[k] = w0 + e * self.v[k]
                alpha[k] = alpha0 + np.cross(w0, e) * self.v[k]
                Jw[k] = Jw0.copy()
                Jw[k][:, k] += e
            c = R[k] @ self.centres[k]
            J = R[k] @ self.J[k] @ R[k].T
            Jc = Jv[k] - skew(c) @ Jw[k]
            ac = a[k] + np.cross(alpha[k], c) + np.cross(w[k], np.cross(w[k], c)) - self.gravity
            M += self.m[k] * Jc.T @ Jc + Jw[k].T @ J @ Jw[k]
            h += self.m[k] * Jc.T @ ac + Jw[k].T @ (J @ alpha[k] + np.cross(w[k], J @ w[k]))
        return np.linalg.solve(M, self.tau - h)


def skew(a: Array) -> Array:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def turn(axis: Array, angle: float) -> Array:
    return np.eye(3) + np.sin(angle) * skew(axis) + (1 - np.cos(angle)) * skew(axis) @ skew(axis)


@pytest.mark.parametrize("seed", range(4))
def test_trees_move_by_newton_and_euler(seed: int) -> None:
    tree = Tree(seed)
    model = lag.loads(tree.text())
    run = model.simulate(stop=0.3, at=[0, 0.3], tolerance=1e-11)
    known = tree.accelerations()
    assert [run[f"a{k}"][0] for k in range(tree.n)] == pytest.approx(known, rel=1e-11, abs=1e-11 * np.abs(known).max())
    assert run.energy.total - run.energy.work == pytest.approx([run.energy.total[0]] * 2, rel=1e-9)


# ---------------------------------------------------------------- planes in space

PLANAR = """
model Chain
  {world};
  Revolute first(a = {base}, {axis} phi(start = 0.4));
  Bar upper(m = 1, L = 0.7, a = first.b);
  Prismatic along(a = upper.b, along = {{0, 1}}, s(start = 0.1));
  Disc lower(m = 0.5, r = 0.2, center = shift(along.b, {{0.1, 0.2}}));
  Spring spring(k = 20, s_rel0 = 0.3, a = {base}, b = lower.center);
  Damper damper(c = 0.1, a = {base}, b = upper.b);
  AppliedForce push(at = upper.b, force = {force});
  BodyForce thrust(at = lower.center, force = {{0.2, 0.3}});
end Chain;
"""


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 2.0, -2.0)])
def test_a_planar_scene_in_another_plane_has_the_planar_motion(axis: tuple[float, ...]) -> None:
    """All is turned: gravity, the base, and forces along the world's axes. Motions agree to rounding."""
    R = turn(np.array(axis) / np.linalg.norm(axis), 0.7)
    gravity, force = R @ [0, -9.81, 0], R @ [0.3, 0.4, 0]

    def curly(x: Array) -> str:
        return "{" + ", ".join(repr(float(part)) for part in x) + "}"

    flat = lag.loads(PLANAR.format(world="World world", base="world", axis="", force="{0.3, 0.4}"))
    base = f"turn(world, 0.7, {curly(np.array(axis))})"
    tilted = lag.loads(PLANAR.format(world=f"World world(gravity = {curly(gravity)})", base=base, axis="axis = {0, 0, 3},",
                                     force=curly(force)))
    assert tilted.compilation.flat.space.is_spatial and not flat.compilation.flat.space.is_spatial
    a, b = (model.simulate(stop=2, tolerance=1e-12, interval=0.5) for model in (flat, tilted))
    for name in ("first.phi", "along.s", "der(first.phi)", "der(along.s)"):
        assert b[name] == pytest.approx(a[name], rel=1e-10, abs=1e-10)


PENDULUM = "Revolute h(a = B, phi(start = 0.5) AXIS); Bar b(m = 1, L = 1, a = h.b);"


@pytest.mark.parametrize(("text", "names"), [
    (PENDULUM + "TorsionDryFriction rub(tau = 0.3, rate = h.w);", ["h.phi"]),
    (PENDULUM + "equation when h.phi < -0.2 then reinit(der(h.phi), -0.8*pre(der(h.phi))); end when;", ["h.phi"]),
    ("Revolute h(a = B AXIS); Bar b(m = 1, L = 1, a = h.b); Motion m(of = h.phi, to = 0.3*sin(2[rad/s]*time)); "
     "Revolute k(a = b.b AXIS); Bar c(m = 1, L = 0.5, a = k.b);", ["k.phi", "m.reaction"]),
    (PENDULUM.replace("a = B", "a = turn(shift(B, {0.1[m]*sin(3[rad/s]*time), 0}), 0.2*cos(2[rad/s]*time))"), ["h.phi"]),
    (PENDULUM + "Revolute k(a = shift(B, {0.5, 0}) AXIS); Bar c(m = 1, L = 1, a = k.b); Link l(L = 0.6, a = b.b, b = c.b);",
     ["h.phi", "k.phi"]),
    (PENDULUM.replace("Revolute h(", "RoughRevolute h(mu = 0.3, radius = 0.1, "), ["h.phi"]),
    ("Rolling r(r = 0.3, base = turn(B, -0.2)); Disc d(m = 1, r = 0.3, center = r.center);", ["r.s"]),
], ids=["dry friction", "event", "motion", "moving support", "link", "friction by reactions", "rolling"])  # fmt: skip
def test_what_happens_in_a_plane_happens_in_a_tilted_one(text: str, names: list[str]) -> None:
    gravity = turn(np.array([1, 2, -2]) / 3, 0.7) @ [0, -9.81, 0]
    tilted = f"World world(gravity = {{{', '.join(repr(float(x)) for x in gravity)}}}); Frame B = turn(world, 0.7, {{1, 2, -2}});"
    ways = [("World world; Frame B = world;", ""), (tilted, ", axis = {0, 0, 1}")]
    a, b = (lag.loads(f"model M {head} {text.replace(' AXIS', axis)} end M;").simulate(stop=1, tolerance=1e-11, interval=0.25)
            for head, axis in ways)
    for name in names:
        assert b[name] == pytest.approx(a[name], abs=1e-10)
    assert b.energy.residual == pytest.approx(np.zeros(b.time.size), abs=1e-9)


@pytest.mark.parametrize("text", [
    "Revolute h(a = world, axis = {0, 0, 2}); Bar b(m = 1, L = 1, a = h.b);",
    "World world(gravity = {0, -9.81, 0}); Revolute h(a = world); Bar b(m = 1, L = 1, a = h.b);",
    "Revolute h(a = world); Bar b(m = 1, L = 1, a = shift(h.b, {0.1, 0.2, 0}));",
    "Revolute h(a = world); Body b(m = 1, I = {0.1, 0.2, 0.3}, center = shift(h.b, {1, 0}));",
    "Revolute h(a = world); Box b(m = 1, size = {1, 2, 3}, center = shift(h.b, {1, 0}));",
])  # fmt: skip
def test_what_lies_in_the_plane_is_planar(text: str) -> None:
    assert not lag.loads(f"model M {text} end M;").compilation.flat.space.is_spatial


@pytest.mark.parametrize(("text", "why"), [
    ("Revolute h(a = world, axis = {0, 1, 0});", "it turns about the axis {0, 1, 0}"),
    ("World world(gravity = {0, -9.81, 1}); Revolute h(a = world);", "'gravity' has a third component"),
    ("Revolute h(a = shift(world, {0, 0, 1}));", "a shift has a third component"),
    ("Revolute h(a = world); output Length z = b.center.z;", "it speaks of z"),
    ("Revolute h(a = world); output Length z = b.center.r[3];", "it speaks of b.center.r[3]"),
    ("Revolute h(a = world); output Real z[3] = to_frame(b.center, {0, 1, 0});", "it speaks of to_frame"),
])  # fmt: skip
def test_what_leaves_the_plane_is_told(text: str, why: str) -> None:
    box = "Box b(m = 1, size = {1, 2, 3}, center = shift(h.b, {1, 0}));"
    found = lag.loads(f"model M {text} {box} end M;").compilation.flat.found
    assert found.space.is_spatial and found.why == why and found.span is not None and found.span.text in text


def test_a_planar_hinge_turns_the_other_way_about_the_other_side() -> None:
    text = "model M Revolute h(a = world, axis = {0, 0, SIDE}, phi(start = 0.3)); Bar b(m = 1, L = 1, a = h.b); end M;"
    there, back = (lag.loads(text.replace("SIDE", side)) for side in ("1", "-2"))
    assert not back.compilation.flat.space.is_spatial
    a, b = there.simulate(stop=1, initial={"h.phi": -0.3})["h.phi"], back.simulate(stop=1)["h.phi"]
    assert a == pytest.approx(-b, rel=1e-7) and (a[0], b[0]) == (-0.3, 0.3)


# ---------------------------------------------------------------- words of space


def test_words_of_frames_agree() -> None:
    """R takes to_world there and to_frame back, Q is R, omega is w, and velocity_at is that of a frame that sits there."""
    text = """
    model M
      World world(gravity = {0, 0, -9.81});
      Universal joint(a = shift(world, {0, 0, 1}), phi_a(start = 0.4), phi_b(start = -0.7), w_a(start = 2));
      Screw screw(a = shift(joint.b, {1, 0, 0}), axis = {1, 2, 0}, pitch = 0.1, phi(start = 4), w(start = 3));
      Cylindrical slide(a = screw.b, axis = {0, 1, 0}, s(start = 0.2), v(start = 0.5), w(start = -1));
      Cylinder body(m = 1, r = 0.3, h = 1, center = shift(slide.b, {0.1, 0.2, 0.3}));
      Ring ring(m = 0.2, r = 0.1, center = shift(joint.b, {0, 0.5, 0}));
      Cone cone(m = 0.2, r = 0.1, h = 0.3, center = shift(screw.b, {0, 0.5, 0}));
      Ball ball(m = 0.1, r = 0.1, center = shift(joint.b, {0, 0, 0.4}));
      output Real there[3] = to_world(body.center, {1, 2, 3}) - body.center.R*{1, 2, 3};
      output Real back[3] = to_frame(body.center, to_world(body.center, {1, 2, 3})) - {1, 2, 3};
      output Real spin[3] = to_world(body.center, body.center.omega) - body.center.w;
      output Real speed[3] = velocity_at(slide.b, body.center.r) - body.center.v;
      output Real slope[3] = der(body.center.r) - body.center.v;
      output Real turning[3] = der(body.center.R)*{1, 2, 3} - cross(body.center.w, to_world(body.center, {1, 2, 3}));
      output Real own[3] = der(body.center.omega) - to_frame(body.center, der(body.center.w));
    end M;
    """
    model = Model(lag.loads(text).path, outputs=("body.center.R", "body.center.Q"))
    run = model.simulate(stop=0.5, tolerance=1e-9)
    for name in ("there", "back", "spin", "speed", "slope", "turning", "own"):
        for k in (1, 2, 3):
            assert run[f"{name}[{k}]"] == pytest.approx(np.zeros(run.time.size), abs=2e-12)
    q = np.array([run[f"body.center.Q[{k}]"] for k in (1, 2, 3, 4)])
    assert (q**2).sum(0) == pytest.approx(np.ones(run.time.size), rel=1e-14)
    w, x, y, z = q
    R = [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
         [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
         [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]
    for i in range(3):
        for j in range(3):
            assert run[f"body.center.R[{i + 1},{j + 1}]"] == pytest.approx(R[i][j], abs=1e-14)


def test_torques_on_attitudes_and_forces_in_own_axes_do_their_work() -> None:
    """The energy account closes, and a torque along an axis is what works on the coordinate of a hinge about it."""
    text = """
    model M
      World world(gravity = {0, 0, 0});
      Revolute hinge(a = world, axis = {1, 2, 2});
      Body body(m = 1, I = {0.1, 0.2, 0.25}, center = shift(hinge.b, {0.3, 0.1, 0}));
      HOW
    end M;
    """
    ways = ["AppliedTorque motor(on = body.center, torque = {1, 2, 2});",
            "TorquePair motor(a = world, b = body.center, torque = {1, 2, 2});"]
    runs = [lag.loads(text.replace("HOW", way)).simulate(stop=1, tolerance=1e-12) for way in ways]
    plain = lag.loads(text.replace("HOW", "energy work 3[N.m] on hinge.phi;")).simulate(stop=1, tolerance=1e-12)
    for run in runs:
        assert run["hinge.phi"][-1] == pytest.approx(plain["hinge.phi"][-1], rel=1e-11)
        assert run.energy.total[-1] - run.energy.total[0] == pytest.approx(run.energy.work[-1], rel=1e-10)
    jet = "BodyForce jet(at = body.center, force = {0, 0, 1});"
    thrust = lag.loads(text.replace("HOW", jet)).simulate(stop=1, tolerance=1e-12)
    assert thrust.energy.total[-1] == pytest.approx(thrust.energy.work[-1], rel=1e-10)
    assert abs(thrust["hinge.phi"][-1]) > 0.1
