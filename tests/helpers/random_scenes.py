"""Random scenes of all kinds, each twice: as a scene in Lag, and as bodies in maximal coordinates for tests/helpers/maximal.py.

The same seed gives the same scene, and the same draw the same masses and weight in it, set as parameters: they are compiled once.
Families: trees, loops, rods between uneven masses, hidden kinks, stops, dry friction.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from helpers.maximal import GROUND, Along, Brake, Contact, Kink, Load, Pin, Point, Rod, System, Tie, Turn, push, spring, torsion
from helpers.reference import Array

FAMILIES = ("tree", "loop", "rods", "kinks", "contacts", "friction")


@dataclass(frozen=True)
class RandomScene:
    """The outputs `columns` of the scene are the places `picked` of the reference's state x."""

    family: str
    text: str
    system: System
    x0: Array
    v0: Array
    columns: tuple[str, ...]
    picked: tuple[int, ...]
    is_uneven: bool
    parameters: Mapping[str, float] = field(default_factory=dict)  # of a draw


@dataclass(frozen=True)
class _Frame:
    """A frame of the scene, the point that it is, and the joint coordinate that moves its body, if there is one."""

    name: str
    point: Point
    slider: "_Slider | None" = None


@dataclass(frozen=True)
class _Slider:
    name: str  # of the joint
    point: Point
    at: tuple[float, float]
    along: tuple[float, float]


def random_scene(seed: int) -> RandomScene:
    """Every fourth of each family has a second part, which does not know of the first."""
    kind, turn = seed % len(FAMILIES), seed // len(FAMILIES)
    beside = FAMILIES[(kind + turn // 4) % len(FAMILIES)] if turn % 4 == 3 else None
    return _Builder(seed).build(FAMILIES[kind], beside)


def drawn(scene: RandomScene, seed: int, draw: int) -> RandomScene:
    """It with other masses, each 0.3 to 3 times what it was, and another weight; as it is written in draw 0."""
    if draw == 0:
        return scene
    random, old = np.random.default_rng([seed, draw]), scene.system
    factors = np.array([float(f"{10 ** x:.3g}") for x in random.uniform(-0.5, 0.5, len(old.m))])
    gravity = round(float(random.uniform(-3, 3)), 3), round(float(random.uniform(-12, 3)), 3)
    m, I = np.array(old.m) * factors, np.array(old.I) * factors
    parameters = {f"b{k}.m": float(value) for k, value in enumerate(m, 1)}
    parameters |= {f"world.gravity[{k}]": value for k, value in enumerate(gravity, 1)}
    system = replace(old, m=list(map(float, m)), I=list(map(float, I)), gravity=gravity)
    return replace(scene, system=system, parameters=parameters)


class _Builder:
    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.lines: list[str] = []
        self.starts: list[str] = []
        self.m: list[float] = []
        self.I: list[float] = []
        self.names: list[str] = []
        self.points: set[int] = set()  # bodies that do not turn
        self.x: list[float] = []
        self.v: list[float] = []
        self.ties: list[Tie] = []
        self.loads: list[Load] = []
        self.kinks: list[Kink] = []
        self.contacts: list[Contact] = []
        self.brakes: list[Brake] = []
        self.frames: list[_Frame] = []
        self.hinges: list[tuple[str, int, int]] = []  # name, body below, body
        self.sliders: list[_Slider] = []
        self.is_uneven = False
        self.mark = ""  # of names in a part

    def build(self, family: str, beside: str | None) -> RandomScene:
        gravity = (self.number(-2, 2), self.number(-10, 2))
        self.lines.append(f"World world(gravity = {{{gravity[0]}, {gravity[1]}}});")
        getattr(self, f"_{family}")()
        if not self.is_uneven:
            self.loads_of_all_kinds()
            if beside is not None:
                self.part_beside(beside)
        columns = [(f"{name}.center.{axis}", 3 * k + j) for k, name in enumerate(self.names)
                   for j, axis in enumerate(("x", "y", "phi")) if not (axis == "phi" and k in self.points)]
        equations = ["initial equation", *self.starts] if self.starts else []
        text = "\n  ".join(["model Scene", *self.lines, *equations, "annotation(experiment(StopTime = 1));"])
        system = System(self.m, self.I, gravity, self.ties, self.loads, self.kinks, self.contacts, self.brakes)
        return RandomScene(family, f"{text}\nend Scene;\n", system, np.array(self.x), np.array(self.v),
                           tuple(name for name, _ in columns), tuple(k for _, k in columns), self.is_uneven)

    def part_beside(self, family: str) -> None:
        self.mark = "_2"
        for part in (self.frames, self.hinges, self.sliders):
            part.clear()
        getattr(self, f"_{family}")()
        if not self.is_uneven:
            self.loads_of_all_kinds()

    # ---------------------------------------------------------------- numbers

    def number(self, low: float, high: float) -> float:
        return round(float(self.random.uniform(low, high)), 3)

    def chance(self, p: float) -> bool:
        return bool(self.random.random() < p)

    def mass(self) -> float:
        return float(f"{10 ** self.random.uniform(-6, 6):.3g}") if self.is_uneven else self.number(0.2, 3)

    def rate(self) -> float:
        return self.number(-2, 2)

    def place(self, point: Point) -> Array:
        return point.place(np.array(self.x))

    def velocity(self, point: Point) -> Array:
        x, v = np.array(self.x), np.array(self.v)
        return point.rows(x, v)[0] @ v if x.size else np.zeros(2)

    def some_frame(self) -> _Frame:
        return self.frames[int(self.random.integers(len(self.frames)))]

    def anchor(self) -> tuple[float, float]:
        return self.number(-1, 1), self.number(-1, 1)

    # ---------------------------------------------------------------- bodies and joints

    def add_body(self, name: str, m: float, I: float, state: Array, rates: Array) -> int:
        self.names.append(name)
        self.m.append(m)
        self.I.append(I)
        self.x += [float(value) for value in state]
        self.v += [float(value) for value in rates]
        return len(self.names) - 1

    def ground(self, at: tuple[float, float]) -> _Frame:
        return _Frame(f"shift(world, {{{at[0]!r}, {at[1]!r}}})", Point(GROUND, at))

    def bar(self, frame: _Frame, is_moving: bool = True) -> int:
        """A bar on a hinge at a frame."""
        k = len(self.names) + 1
        m, length, angle = self.mass(), self.number(0.3, 1.2), self.number(-3, 3)
        w = self.rate() if is_moving else 0.0
        below = frame.point.body
        turned, turning = (self.x[3 * below + 2], self.v[3 * below + 2]) if below != GROUND else (0.0, 0.0)
        self.lines.append(f"Revolute j{k}(a = {frame.name}, phi(start = {angle}), w(start = {w})); "
                          f"Bar b{k}(m = {m}, L = {length}, a = j{k}.b);")
        phi, omega = turned + angle, turning + w
        arm = length / 2 * np.array([np.cos(phi), np.sin(phi)])
        center = self.place(frame.point) + arm
        speed = self.velocity(frame.point) + omega * np.array([-arm[1], arm[0]])
        body = self.add_body(f"b{k}", m, m * length**2 / 12, np.array([*center, phi]), np.array([*speed, omega]))
        self.ties.append(Pin(frame.point, Point(body, (-length / 2, 0))))
        self.frames.append(_Frame(f"b{k}.b", Point(body, (length / 2, 0))))
        self.hinges.append((f"j{k}", below, body))
        return body

    def slider(self, at: tuple[float, float] | None = None) -> _Slider:
        """A mass on a straight track on the ground."""
        k = len(self.names) + 1
        at, angle, s, v, m = at or self.anchor(), self.number(-3, 3), self.number(-0.5, 0.5), self.rate(), self.mass()
        along = float(np.cos(angle)), float(np.sin(angle))
        self.lines.append(f"Prismatic j{k}(a = shift(world, {{{at[0]}, {at[1]}}}), along = {{{along[0]!r}, {along[1]!r}}}, "
                          f"s(start = {s}), v(start = {v})); PointMass b{k}(m = {m}, center = j{k}.b);")
        body = self.add_body(f"b{k}", m, 1.0, np.array([at[0] + s * along[0], at[1] + s * along[1], 0]),
                             np.array([v * along[0], v * along[1], 0]))
        self.points.add(body)
        point = Point(body)
        self.ties += [Along(point, (-along[1], along[0]), at), Turn(GROUND, body)]
        slider = _Slider(f"j{k}", point, at, along)
        self.sliders.append(slider)
        self.frames.append(_Frame(f"j{k}.b", point, slider))
        return slider

    def particle(self, below: _Frame) -> None:
        """A mass at the end of a rod."""
        k = len(self.names) + 1
        m = self.mass()
        start, away = self.place(below.point), np.array([self.number(0.3, 1), self.number(-0.8, 0.8)])
        x, y = (float(value) for value in start + away)
        length = float(np.hypot(x - start[0], y - start[1]))
        self.lines.append(f"PointMass b{k}(m = {m}); Link r{k}(L = {length!r}, a = {below.name}, b = b{k}.center);")
        self.starts.append(f"b{k}.center.x = {x!r}; b{k}.center.y = {y!r};")
        body = self.add_body(f"b{k}", m, 1.0, np.array([x, y, 0]), np.zeros(3))
        self.points.add(body)
        self.ties += [Rod(below.point, Point(body), length), Turn(GROUND, body)]
        self.frames.append(_Frame(f"b{k}.center", Point(body)))

    def link(self, a: _Frame, b: _Frame) -> None:
        length = float(np.hypot(*(self.place(b.point) - self.place(a.point))))
        self.lines.append(f"Link l{len(self.lines)}(L = {length!r}, a = {a.name}, b = {b.name});")
        self.ties.append(Rod(a.point, b.point, length))

    # ---------------------------------------------------------------- loads

    def loads_of_all_kinds(self) -> None:
        for k in range(int(self.random.integers(1, 3))):
            frame, at = self.some_frame(), self.anchor()
            stiffness, length, c = self.number(1, 20), self.number(0, 0.3), self.number(0, 0.5)
            if frame.slider is None:
                at = at[0] + 4, at[1]  # far from its anchor, where a length is smooth
                self.lines.append(f"SpringDamper p{k}{self.mark}(a = {self.ground(at).name}, b = {frame.name}, k = {stiffness}, "
                                  f"s_rel0 = {length}, c = {c});")
                self.loads.append(spring(Point(GROUND, at), frame.point, stiffness, length, c))
        if self.hinges and self.chance(0.5):
            name, below, body = self.hinges[int(self.random.integers(len(self.hinges)))]
            stiffness, c = self.number(0.5, 5), self.number(0, 0.5)
            other = "world" if below == GROUND else f"{self.names[below]}.center"
            self.lines.append(f"TorsionSpringDamper t_{name}(a = {other}, b = {self.names[body]}.center, k = {stiffness}, "
                              f"c = {c});")
            self.loads.append(torsion(below, body, stiffness, c))
        if self.chance(0.6):
            frame, size, omega = self.some_frame(), self.number(-5, 5), self.number(1, 6)
            self.lines.append(f"AppliedForce drive{self.mark}(at = {frame.name}, force = {{{size}*sin({omega}*time), {size}}});")
            self.loads.append(push(frame.point, lambda t, r: size * np.array([np.sin(omega * t), 1])))

    # ---------------------------------------------------------------- the families

    def grow(self, count: int, is_moving: bool = True) -> None:
        self.bar(self.ground(self.anchor()), is_moving)
        for _ in range(count - 1):
            self.bar(self.some_frame(), is_moving)

    def _tree(self) -> None:
        if self.chance(0.4):
            slider = self.slider()
            self.bar(_Frame(f"{slider.name}.b", slider.point))
        self.grow(int(self.random.integers(1, 4)))

    def _loop(self) -> None:
        arms = []
        for k in range(2):
            frame = self.ground((1.6 * k, self.number(-0.3, 0.3)))
            for _ in range(int(self.random.integers(1, 3))):
                self.bar(frame, is_moving=False)
                frame = self.frames[-1]
            arms.append(frame)
        self.link(*arms)

    def _rods(self) -> None:
        self.is_uneven = self.chance(0.7)
        self.particle(self.ground(self.anchor()))
        for _ in range(int(self.random.integers(1, 3))):
            self.particle(self.frames[-1])

    def _kinks(self) -> None:
        """Sliders with forces that bend or jump with their places, springs that pass through their anchors."""
        for _ in range(int(self.random.integers(1, 3))):
            slider = self.slider()
            if self.chance(0.4):
                self.anchored(slider)
            else:
                self.bent(slider)
        if self.chance(0.5):
            self.bar(_Frame(f"{self.sliders[0].name}.b", self.sliders[0].point))

    def anchored(self, slider: _Slider) -> None:
        k, length = self.number(5, 40), self.number(0.1, 0.6)
        self.lines.append(f"Spring a_{slider.name}(a = shift(world, {{{slider.at[0]}, {slider.at[1]}}}), b = {slider.name}.b, "
                          f"k = {k}, s_rel0 = {length});")
        self.loads.append(spring(Point(GROUND, slider.at), slider.point, k, length))
        self.kinks.append(_place_on(slider, 0.0))

    def bent(self, slider: _Slider) -> None:
        K, C, s = self.number(5, 40), self.number(0.05, 0.4), f"{slider.name}.s"
        laws: list[tuple[str, Callable[[float], float], tuple[float, ...]]] = [
            (f"-{K}*max(0, {s} - {C})", lambda x: -K * max(0.0, x - C), (C,)),
            (f"-{K}*abs({s} - {C})", lambda x: -K * abs(x - C), (C,)),
            (f"-{K}*min(1, max(-1, {s}/{C}))", lambda x: -K * min(1.0, max(-1.0, x / C)), (C, -C)),
            (f"if {s} > {C} then -{K}*({s} - {C}) elseif {s} < -{C} then -{K}*({s} + {C}) else 0",
             lambda x: -K * (x - C) if x > C else -K * (x + C) if x < -C else 0.0, (C, -C)),
            (f"-{K}*({s} - {C})*abs({s} - {C})", lambda x: -K * (x - C) * abs(x - C), (C,)),
            (f"-{K}*sqrt(({s} - {C})^2)", lambda x: -K * abs(x - C), (C,)),
            (f"if {s} > {C} then -{K} else 0", lambda x: -K if x > C else 0.0, (C,)),
        ]
        law, force, kinks = laws[int(self.random.integers(len(laws)))]
        (dx, dy), at = slider.along, np.array(slider.at)
        self.lines.append(f"Real f_{slider.name} = {law}; AppliedForce n_{slider.name}(at = {slider.name}.b, "
                          f"force = {{f_{slider.name}*({dx!r}), f_{slider.name}*({dy!r})}});")
        along = np.array(slider.along)
        self.loads.append(push(slider.point, lambda t, r: force(float(along @ (r - at))) * along))
        self.kinks += [_place_on(slider, c) for c in kinks]

    def _contacts(self) -> None:
        if self.chance(0.5):
            slider = self.slider()
            if self.chance(0.5):
                self.bar(_Frame(f"{slider.name}.b", slider.point))
        else:
            self.grow(int(self.random.integers(1, 3)))
        for k in range(int(self.random.integers(1, 3))):
            frame, angle = self.some_frame(), self.number(-3, 3)
            e = float(self.random.choice([0.0, 0.0, 0.5, 0.8, 1.0]))
            normal, place = (float(np.cos(angle)), float(np.sin(angle))), self.place(frame.point)
            below = self.number(0.05, 0.4)
            at = (float(place[0] - below * normal[0]), float(place[1] - below * normal[1]))
            self.lines.append(f"Stop c{k}{self.mark}(a = {self.ground(at).name}, b = {frame.name}, "
                              f"along = {{{normal[0]!r}, {normal[1]!r}}}, e = {e});")
            self.contacts.append(Contact(Along(frame.point, normal, at), e))

    def _friction(self) -> None:
        if self.chance(0.6):
            slider = self.slider()
            if self.chance(0.5):
                self.bar(_Frame(f"{slider.name}.b", slider.point))
        else:
            self.grow(int(self.random.integers(1, 3)))
        for slider in self.sliders:
            F = self.number(0.5, 6)
            self.lines.append(f"DryFriction d_{slider.name}(F = {F}, rate = {slider.name}.v);")
            self.brakes.append(Brake(Along(slider.point, slider.along, slider.at), F))
        for name, below, body in self.hinges:
            if self.chance(0.7):
                tau = self.number(0.1, 2)
                self.lines.append(f"TorsionDryFriction d_{name}(tau = {tau}, a = {name}.a, b = {name}.b);")
                self.brakes.append(Brake(Turn(below, body), tau))


def _place_on(slider: _Slider, at: float) -> Kink:
    tie = Along(slider.point, slider.along, slider.at)
    return lambda x: float(tie.residual(x)[0]) - at
