"""Random mechanisms with closed loops and ties, written as scenes in Lag: the same seed gives the same scene."""

from dataclasses import dataclass

import numpy as np

from helpers.reference import Array


@dataclass(frozen=True)
class LoopBody:
    """A bar or disc of mass m and inertia I, and what holds it: joint or tie -> the side of it that the body is on, 1 for b."""

    name: str
    m: float
    I: float
    held: dict[str, int]


@dataclass(frozen=True)
class RandomLoops:
    text: str
    bodies: tuple[LoopBody, ...]


class _Growth:
    """Arms grow from the ground; the ends of arms are tied by bars between two hinges, by links, or by gears on their roots."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.lines: list[str] = []
        self.bodies: dict[str, LoopBody] = {}
        self.tips: list[tuple[str, str, Array, float]] = []  # frame, body, place, angle

    def number(self, low: float, high: float) -> float:
        return round(float(self.random.uniform(low, high)), 3)

    def body(self, name: str, m: float, inertia: float, **held: int) -> None:
        self.bodies[name] = LoopBody(name, m, inertia, held)

    def arm(self, k: int, count: int) -> None:
        """Bars one behind the other, each on a hinge with a spring in it, the first one perhaps on a slider."""
        place, angle, frame, below = np.array([1.5 * k, self.number(-0.2, 0.2)]), 0.0, "", ""
        base = f"shift(world, {{{place[0]}, {place[1]}}})"
        if self.random.random() < 0.4:
            self.lines.append(f"Prismatic s{k}(a = {base}, along = {{1, {self.number(-0.5, 0.5)}}}); "
                              f"PointMass c{k}(m = 0.5, center = s{k}.b); Spring g{k}(k = 30, stretch = s{k}.s);")
            base = f"s{k}.b"
        for i in range(1, count + 1):
            j, b, turn = f"j{k}_{i}", f"b{k}_{i}", self.number(0.4, 1.2)
            m, length, angle = self.number(0.3, 2), self.number(0.5, 1), angle + turn
            self.lines.append(f"Revolute {j}(a = {frame or base}, phi(start = {turn})); "
                              f"Bar {b}(m = {m}, L = {length}, a = {j}.b); TorsionSpring t{k}_{i}(k = 4, twist = {j}.phi);")
            self.body(b, m, m * length**2 / 12, **{j: 1})
            if below:
                self.bodies[below].held[j] = -1
            place = place + length * np.array([np.cos(angle), np.sin(angle)])
            frame, below = f"{b}.b", b
        self.tips.append((frame, below, place, angle))

    def close(self, k: int) -> None:
        """Ties the tips of arms k and k + 1."""
        (a, left, here, turned), (b, right, there, _) = self.tips[k], self.tips[k + 1]
        length, angle = float(np.hypot(*(there - here))), float(np.arctan2(*(there - here)[::-1]))
        if self.random.random() < 0.5:
            self.lines.append(f"Link l{k}(L = {length}, a = {a}, b = {b});")
            self.bodies[left].held[f"l{k}"], self.bodies[right].held[f"l{k}"] = -1, 1
            return
        self.lines.append(f"Revolute p{k}(a = {a}, phi(start = {angle - turned})), q{k}(a = r{k}.b, b = {b}); "
                          f"Bar r{k}(m = 0.7, L = {length}, a = p{k}.b);")
        self.body(f"r{k}", 0.7, 0.7 * length**2 / 12, **{f"p{k}": 1, f"q{k}": -1})
        self.bodies[left].held[f"p{k}"], self.bodies[right].held[f"q{k}"] = -1, 1

    def train(self, k: int) -> None:
        """A disc on a bearing in the ground, geared to another one, which a belt ties to a third."""
        for i, radius in enumerate((0.1, 0.2, 0.15)):
            self.lines.append(f"Revolute w{k}_{i}(a = shift(world, {{{0.3 * i}, {0.1 * i}}})); "
                              f"Disc d{k}_{i}(m = 1.5, r = {radius}, center = w{k}_{i}.b);")
            self.body(f"d{k}_{i}", 1.5, 1.5 * radius**2 / 2, **{f"w{k}_{i}": 1})
        self.lines.append(f"Gear m{k}(r_a = 0.1, r_b = 0.2, a = w{k}_0.b, b = w{k}_1.b, carrier = world); "
                          f"Belt n{k}(r_a = 0.08, r_b = 0.12, a = w{k}_1.b, b = w{k}_2.b, carrier = world);")
        for tie, a, b in (("m", 0, 1), ("n", 1, 2)):
            self.bodies[f"d{k}_{a}"].held[f"{tie}{k}"], self.bodies[f"d{k}_{b}"].held[f"{tie}{k}"] = -1, 1


def random_loops(seed: int, arms: int) -> RandomLoops:
    """Arms of two or three bars, neighbours tied at their tips, and a train of wheels that one arm's root drives."""
    growth = _Growth(seed)
    for k in range(arms):
        growth.arm(k, 2 + int(growth.random.integers(2)))
    for k in range(arms - 1):
        growth.close(k)
    growth.train(arms)
    lines = [*growth.lines, "equation", f"w{arms}_0.phi = 2*j0_1.phi;"]
    return RandomLoops("model Loops\n  " + "\n  ".join(lines) + "\nend Loops;\n", tuple(growth.bodies.values()))
