"""Mass, centre and moments of a body of MJCF: as they are written, or of its shapes."""

import math
from collections.abc import Callable, Mapping, Sequence

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.editor.mjcf_reading import Angles, Vector, Written, towards, turned_moments

_MASSLESS = frozenset({"plane", "hfield"})
_SIZES = {"sphere": 1, "capsule": 2, "ellipsoid": 3, "cylinder": 2, "box": 3}
_WATER = 1000.0  # kg/m3, what the format takes shapes to be made of


@dataclass(frozen=True)
class Mass:
    """kg, m, kg.m2 about the centre; in the axes of the body."""

    m: float
    center: Vector
    moments: Sequence[Vector]

    def scaled(self, factor: float) -> "Mass":
        """Of a body of other density."""
        return Mass(factor * self.m, self.center, [[factor * x for x in row] for row in self.moments])


def written_mass(inertial: Written, angles: Angles) -> Mass:
    """Of <inertial>. Raises LagError L0730."""
    q = angles.attitude(inertial)
    if inertial.get("fullinertia") is not None:
        xx, yy, zz, xy, xz, yz = inertial.numbers("fullinertia", 6)
        moments = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    else:
        moments = _diagonal(inertial.numbers("diaginertia", 3, [0.0] * 3))
    m, center = inertial.numbers("mass", 1)[0], inertial.numbers("pos", 3, [0.0] * 3)
    return _finite(inertial, Mass(m, center, turned_moments(q, moments)))


def shape_mass(geom: Written, angles: Angles) -> Mass | None:
    """Of one shape; None for those that only a file knows, or that have none. Raises LagError L0730."""
    kind = geom.get("type", "sphere") or ""
    if kind in _MASSLESS:
        return Mass(0.0, [0.0] * 3, _diagonal([0.0] * 3))
    if kind not in _SIZES:
        return None
    sizes, center, q = _placed(geom, kind, angles)
    if min(sizes) <= 0:
        fail("L0730", f"a {kind} has sizes above zero", geom.element.span("size"))
    volume, per_mass = _VOLUMES[kind](*sizes)
    m = geom.number("mass") if geom.get("mass") is not None else geom.number("density", _WATER) * volume
    return _finite(geom, Mass(m, center, turned_moments(q, _diagonal([m * x for x in per_mass]))))


def _finite(written: Written, mass: Mass) -> Mass:
    if not all(map(math.isfinite, (mass.m, *(x for row in mass.moments for x in row)))):
        fail("L0730", f"the mass of this <{written.element.tag}>, or a moment, is beyond all numbers", written.element.span())
    return mass


def together(parts: Sequence[Mass]) -> Mass:
    """One body of all parts: Steiner's theorem."""
    m = sum(part.m for part in parts)
    if m == 0:
        return Mass(0.0, [0.0] * 3, _diagonal([0.0] * 3))
    center = [sum(part.m * part.center[k] for part in parts) / m for k in range(3)]
    moments = [[0.0] * 3 for _ in range(3)]
    for part in parts:
        d = [part.center[k] - center[k] for k in range(3)]
        square = sum(x * x for x in d)
        for i in range(3):
            for j in range(3):
                moments[i][j] += part.moments[i][j] + part.m * ((square if i == j else 0.0) - d[i] * d[j])
    return Mass(m, center, moments)


def _placed(geom: Written, kind: str, angles: Angles) -> tuple[Vector, Vector, Vector]:
    """Sizes, centre and attitude; from one end to the other where these are given."""
    if geom.get("fromto") is None or kind == "sphere":
        return geom.leading("size", [0.0] * 3)[: _SIZES[kind]], geom.numbers("pos", 3, [0.0] * 3), angles.attitude(geom)
    ends = geom.numbers("fromto", 6)
    along = [ends[k] - ends[k + 3] for k in range(3)]
    length = math.hypot(*along)
    if length == 0:
        fail("L0730", "'fromto' has no length", geom.element.span("fromto"))
    width = geom.leading("size", [0.0])[0]
    sizes = [width, length / 2] if _SIZES[kind] == 2 else [width, width, length / 2]
    return sizes, [(ends[k] + ends[k + 3]) / 2 for k in range(3)], towards([x / length for x in along])


def _diagonal(values: Vector) -> list[list[float]]:
    return [[values[i] if i == j else 0.0 for j in range(3)] for i in range(3)]


def _sphere(r: float) -> tuple[float, Vector]:
    return 4 / 3 * math.pi * r * r * r, [0.4 * r * r] * 3


def _ellipsoid(a: float, b: float, c: float) -> tuple[float, Vector]:
    return 4 / 3 * math.pi * a * b * c, [(b * b + c * c) / 5, (a * a + c * c) / 5, (a * a + b * b) / 5]


def _cylinder(r: float, h: float) -> tuple[float, Vector]:
    across = (3 * r * r + 4 * h * h) / 12
    return 2 * math.pi * r * r * h, [across, across, r * r / 2]


def _capsule(r: float, h: float) -> tuple[float, Vector]:
    """A cylinder of half length h with a half ball at both ends, whose centres lie 3 r/8 outside."""
    shaft, ends = 2 * math.pi * r * r * h, 4 / 3 * math.pi * r * r * r
    volume = shaft + ends
    across = shaft * (3 * r * r + 4 * h * h) / 12 + ends * (0.4 * r * r + h * h + 0.75 * h * r)
    return volume, [across / volume, across / volume, (shaft * r * r / 2 + ends * 0.4 * r * r) / volume]


def _box(a: float, b: float, c: float) -> tuple[float, Vector]:
    return 8 * a * b * c, [(b * b + c * c) / 3, (a * a + c * c) / 3, (a * a + b * b) / 3]


_VOLUMES: Mapping[str, Callable[..., tuple[float, Vector]]] = {
    "sphere": _sphere, "capsule": _capsule, "ellipsoid": _ellipsoid, "cylinder": _cylinder, "box": _box,
}
