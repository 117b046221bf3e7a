"""Where attitudes begin, and how they turn there: those that are declared, and those of floating frames."""

from collections.abc import Mapping, Sequence

from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.records import dataclass
from lagrangia.language.flat import Frame, Variable
from lagrangia.language.tree import Array, Binary, Call, Flat, Number

HINGES = "hinges turn it as well, and are known there: a Universal and a Revolute, instead of a Spherical or of floating"
_READ_ALONE = frozenset({"R", "attitude", "omega_z"})
FLOATING = "S"  # the attitude of a floating frame


@dataclass(frozen=True)
class Attitude:
    """A coordinate that is one. `start`: a unit quaternion, None where it is not turned; `rate`: the angular velocity, in its
    axes."""

    name: str
    start: Flat | None
    rate: Flat | None
    is_fixed: bool
    is_rate_fixed: bool
    description: str
    span: Span


def of_variable(variable: Variable, rate: Flat | None, is_rate_fixed: bool) -> Attitude:
    """Of one that is declared; `rate`: the start of what is bound to its rate."""
    return Attitude(variable.name, variable.start, rate, variable.is_fixed, is_rate_fixed, variable.description, variable.span)


def of_frame(frame: Frame) -> Attitude:
    """Of a floating frame, by what its declaration says of Q, and of omega, or of w in the world's axes. Raises LagError."""
    for name in _READ_ALONE & frame.starts.keys():
        fail("L0208", f"a frame does not begin by its {name}", frame.starts[name].span,
             'its attitude begins at Q(start = angles("zxz", 10[deg], 20[deg], 0)), its rates at omega(start = {0, 0, 1})')
    start, rate, in_world = (frame.starts.get(name) for name in ("Q", "omega", "w"))
    if rate is not None and in_world is not None:
        fail("L0601", "the angular velocity is said twice, by omega in the frame's axes and by w in the world's", in_world.span,
             "leave one of them out")
    if rate is None and in_world is not None:
        rate = in_world if start is None else _seen_from(start, in_world)
    return Attitude(f"{frame.name}.{FLOATING}", start, rate, "Q" in frame.fixed, not frame.fixed.isdisjoint(("omega", "w")),
                    f"attitude of the floating {frame.owner}", frame.span)


def refuse_attitudes(attitudes: Mapping[str, Attitude], what: str, *hints: str) -> None:
    """Raises LagError L0901 where attitudes are coordinates, which what is asked for does not know."""
    for name, attitude in attitudes.items():
        fail("L0901", f"not supported yet: {what} where an attitude is a coordinate ('{name}')", attitude.span, *hints)


def element(value: Flat, k: int) -> Flat:
    """The k-th one of an array, from 1 on."""
    return Call("element", (value, Number(float(k), None, value.span, True)), (), value.span)


def _seen_from(quaternion: Flat, vector: Flat) -> Flat:
    """R^T x: x + 2 a (x x u) + 2 u x (u x x) of the unit quaternion (a, u), as an array."""
    span = vector.span
    a, *u = (element(quaternion, k) for k in range(1, 5))
    x = [element(vector, k) for k in (1, 2, 3)]
    inner = _cross(u, x, span)
    outer = _cross(u, inner, span)
    twice = Number(2.0, None, span)
    found: list[Flat] = []
    for k in range(3):
        aside = Binary("-", outer[k], Binary("*", a, inner[k], span), span)
        found.append(Binary("+", x[k], Binary("*", twice, aside, span), span))
    return Array(tuple(found), span)


def _cross(a: Sequence[Flat], b: Sequence[Flat], span: Span) -> Sequence[Flat]:
    return [Binary("-", Binary("*", a[i], b[j], span), Binary("*", a[j], b[i], span), span) for i, j in ((1, 2), (2, 0), (0, 1))]
