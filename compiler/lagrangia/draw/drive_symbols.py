"""Symbols of the components of drive trains, between two ends in millimetres."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.drive_parts import PORT
from lagrangia.draw.strokes import BODIES, HINGES, RODS, SHAPES, Given, Stroke, hatched

Vector = NDArray[np.float64]
LENGTH, HIGHEST = 13.0, 6.5  # mm: from end to end; above and below the shaft no symbol is higher
_SYMBOL = 3.0
_MASSES = {"Inertia": (2.0, 5.0), "Mass": (3.6, 3.0), "MassWithStopAndFriction": (3.6, 3.0), "Vehicle": (4.5, 3.0)}
_SPRINGS = {"Spring": "zigzag", "Damper": "dashpot"}
_PLATES = ("Clutch", "OneWayClutch", "FreeWheel")
_RUBS = ("BearingFriction", "Brake", "SupportFriction")
_GEARS = ("IdealGear", "LossyGear", "IdealLever")
_WHEELS = ("IdealGearR2T", "IdealRollingWheel")
_TURNS = ("Torque", "ConstantTorque", "TorqueStep", "LinearSpeedDependentTorque", "QuadraticSpeedDependentTorque",
          "EddyCurrentTorque")
_DRIVES = {  # of time in [0, 1], what a source prescribes, in [-1, 1]
    "Position": lambda t: np.sin(2 * np.pi * t), "Speed": lambda t: 2 * t - 1, "Accelerate": lambda t: 2 * t**2 - 1,
    "ConstantSpeed": lambda t: 0.4 + 0 * t}
_PUSHES = ("Force", "ConstantForce", "ForceStep", "LinearSpeedDependentForce", "QuadraticSpeedDependentForce", "EddyCurrentForce")


def symbol_of(kind: str, a: Vector, b: Vector, is_alone: bool) -> tuple[list[Stroke], float]:
    """Strokes of a component of the class `kind` from one end to the other, with its shaft, mm; and how high it is above the
    shaft. A component with one flange, which `is_alone`, has it at the end `a`."""
    middle = (a + b) / 2
    if kind in _MASSES:
        half = _MASSES[kind]
        return [_line(a, b), *_beneath(kind, middle, half), _box(middle, half, "grey")], half[1]
    if kind in _SPRINGS:
        return [*_leads(a, b, 0.8), *_between(_SPRINGS[kind], *_inner(a, b, 0.8))], 2.5
    if kind in ("SpringDamper", "ElastoBacklash", "ElastoBacklash2", "ElastoGap"):
        return _spring_and_damper(a, b, kind != "SpringDamper"), 4.5
    if kind in _PLATES:
        return _plates(a, b, kind != "Clutch"), 4.0
    if kind in _RUBS:
        return [_line(a, b), *_pads(middle, kind == "Brake")], 3.4
    if kind in _GEARS:
        left, right = (_box(middle + np.array([side * 1.2, 0.0]), (1.2, high), "white") for side, high in ((-1, 3.0), (1, 5.5)))
        return [_line(a, b), left, right], 5.5
    if kind in _WHEELS:
        wheel = Stroke(middle[None], BODIES, "normal", "white", True, 3.0)
        track = Stroke(middle + np.array([[-4.0, -3.0], [4.0, -3.0]]), RODS, "normal")
        return [_line(a, b), wheel, track, Stroke(middle[None], HINGES, "thin", "black", True, 0.4)], 3.0
    if kind == "IdealPlanetary":
        rings = [Stroke(middle[None], BODIES, "normal", "white", True, r) for r in (4.5, 1.5)]
        planets = [Stroke((middle + 3.0 * np.array([np.cos(x), np.sin(x)]))[None], HINGES, "normal", "white", True, 1.5)
                   for x in (np.pi / 2, np.pi * 7 / 6, -np.pi / 6)]
        return [_line(a, b), *rings, *planets], 4.5
    return _one_sided(kind, a, b) if is_alone else _other(kind, a, b)


def _one_sided(kind: str, a: Vector, b: Vector) -> tuple[list[Stroke], float]:
    """What has one flange."""
    way, middle = np.sign(b[0] - a[0]) * np.array([1.0, 0.0]), (a + b) / 2
    if kind == "Fixed":
        return [_line(a, middle), *hatched(middle, np.array([0.0, way[0]]), 2.6, 2.5)], 3.0
    if kind in _TURNS:
        arrow = SHAPES["curved_arrow"](_given([[*middle, 0.0]], [np.array([1.0])]))
        return [_line(a, middle), *arrow.strokes], 3.6
    if kind in _PUSHES:
        arrow = SHAPES["arrow"](_given([[*(middle + 0.4 * (b - a)), 0.0]], [-way * 6.0], "length"))
        return [_line(a, middle - 0.05 * (b - a)), *arrow.strokes], 1.6
    if kind == PORT:
        return [_line(a, middle), Stroke(middle[None], HINGES, "normal", "white", True, 0.9)], 0.9
    return [_line(a, middle), *_beside_it(kind, middle)], 2.4


def _other(kind: str, a: Vector, b: Vector) -> tuple[list[Stroke], float]:
    middle = (a + b) / 2
    if kind == "Disc":
        plates = [_box(middle + np.array([x, 0.0]), (0.6, 4.0), "white") for x in (-0.6, 0.6)]
        return [_line(a, b), *plates], 4.0
    if kind == "Rod":
        return [_line(a, b), _box(middle, (4.5, 0.8), "white")], 0.8
    if kind == "Torque2":
        return [_line(a, b), *SHAPES["curved_arrow"](_given([[*middle, 0.0]], [np.array([1.0])])).strokes], 3.6
    if kind == "Force2":  # a force on each of the two ends
        left, right = _inner(a, b, 0.8)
        pair = [SHAPES["arrow"](_given([[*(middle + 0.1 * (end - middle)), 0.0]], [0.8 * (end - middle)], "length"))
                for end in (left, right)]
        return [*_leads(a, b, 0.8), *(stroke for one in pair for stroke in one.strokes)], 2.4
    return [_line(a, b), *_beside_it(kind, (a + b) / 2)], 2.4


def _beside_it(kind: str, middle: Vector) -> list[Stroke]:
    """The dial of a sensor, the circle of a joint, or whatever else there is: a box."""
    if kind.endswith("Sensor"):
        return [Stroke(middle[None], BODIES, "normal", "white", True, 2.4),
                Stroke(np.array([middle, middle + np.array([1.1, 1.6])]), HINGES, "normal")]
    box = _box(middle, (3.0, 2.2), "white")
    if kind in _DRIVES:
        return [box, *_graph(middle, _DRIVES[kind])]
    if kind == "HingeFlange":
        return [box, Stroke(middle[None], HINGES, "normal", "white", True, 1.0)]
    if kind == "SliderFlange":
        return [box, Stroke(middle + np.array([[-2.0, 0.0], [2.0, 0.0]]), HINGES, "normal"), _box(middle, (0.9, 0.6), "white")]
    return [box]


def _graph(middle: Vector, prescribed: Callable[[Vector], Vector]) -> list[Stroke]:
    """Of what a source prescribes against time, with its axes."""
    time = np.linspace(0.0, 1.0, 21)
    curve = middle + np.column_stack((4.4 * (time - 0.5), 1.3 * prescribed(time)))
    axes = [middle + np.array([[-2.5, -1.7], [2.5, -1.7]]), middle + np.array([[-2.2, -1.9], [-2.2, 1.8]])]
    return [*(Stroke(axis, HINGES, "thin") for axis in axes), Stroke(curve, HINGES, "normal")]


def _given(places: Sequence[Sequence[float]], numbers: list[Vector], measure: str = "") -> Given:
    return Given(np.array(places), numbers, _SYMBOL, {}, "none", "normal", measure=measure)


def _line(a: Vector, b: Vector) -> Stroke:
    return Stroke(np.array([a, b]), RODS, "thick")


def _box(middle: Vector, half: tuple[float, float], fill: str) -> Stroke:
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(half)
    return Stroke(middle + corners, BODIES, "normal", fill, True)


def _beneath(kind: str, middle: Vector, half: tuple[float, float]) -> list[Stroke]:
    """Wheels of a vehicle, the two stops of a mass."""
    if kind == "Vehicle":
        return [Stroke((middle + np.array([x, -half[1]]))[None], HINGES, "normal", "white", True, 1.2) for x in (-2.6, 2.6)]
    if kind != "MassWithStopAndFriction":
        return []
    stops = [Stroke(middle + np.array([[x, -1.0], [x, -half[1]]]), RODS, "normal") for x in (-5.4, 5.4)]
    return [*stops, *hatched(middle + np.array([0.0, -half[1]]), np.array([1.0, 0.0]), 5.4, 2.5)]


def _inner(a: Vector, b: Vector, share: float) -> tuple[Vector, Vector]:
    return a + (1 - share) / 2 * (b - a), b - (1 - share) / 2 * (b - a)


def _leads(a: Vector, b: Vector, share: float) -> list[Stroke]:
    first, last = _inner(a, b, share)
    return [_line(a, first), _line(last, b)]


def _between(word: str, a: Vector, b: Vector) -> list[Stroke]:
    return SHAPES[word](_given([[*a, 0.0], [*b, 0.0]], [])).strokes


def _spring_and_damper(a: Vector, b: Vector, has_gap: bool) -> list[Stroke]:
    """Side by side; behind a gap where there is a backlash."""
    first, last = _inner(a, b, 0.8)
    end = last - np.array([1.6 * np.sign(b[0] - a[0]), 0.0]) if has_gap else last
    up = np.array([0.0, 2.2])
    strokes = [*_leads(a, b, 0.8), *_between("zigzag", first + up, end + up), *_between("dashpot", first - up, end - up)]
    strokes += [Stroke(np.array([x + up, x - up]), RODS, "normal") for x in (first, end)]
    return [*strokes, Stroke(np.array([last + up, last - up]), RODS, "normal")] if has_gap else strokes


def _plates(a: Vector, b: Vector, is_one_way: bool) -> list[Stroke]:
    middle, gap, high = (a + b) / 2, np.array([0.8, 0.0]), np.array([0.0, 4.0])
    left, right = middle - gap, middle + gap
    strokes = [_line(a, left), _line(right, b), _line(left - high, left + high), _line(right - high, right + high)]
    if is_one_way:
        tip = middle + np.array([3.6, 2.4])
        strokes.append(Stroke(tip + np.array([[0.0, 0.0], [-1.6, 0.8], [-1.6, -0.8]]), HINGES, "thin", "black", True))
    return strokes


def _pads(middle: Vector, is_pressed: bool) -> list[Stroke]:
    """Of a bearing on both sides of the shaft, or of a brake with a disc between them."""
    high = np.array([0.0, 1.2])
    strokes = [_line(middle - high, middle + high)] if is_pressed else []
    for side in (1.0, -1.0):
        strokes += hatched(middle + np.array([0.0, side * 1.4]), np.array([-side, 0.0]), 2.4, 2.5)
    return strokes
