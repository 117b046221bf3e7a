"""What can be asked of a frame by name: the one table of its attributes, made of components of its place, of its velocity, or of
what its joint exerts on it.

A frame of the plane has three of each: x and y along the world's axes, and about z phi, a rate, a torque.
"""

from collections.abc import Mapping
from functools import cache

from lagrangia.base.records import dataclass
from lagrangia.language.units import Dimension, parse_unit


@dataclass(frozen=True, slots=True)
class Component:
    """One of the numbers that say where a frame is."""

    name: str
    unit: str
    display_unit: str
    words: str  # what it is

    @property
    def is_angle(self) -> bool:
        """Whether it turns, and does not shift."""
        return self.unit == "rad"


@dataclass(frozen=True, slots=True)
class FrameAttribute:
    """`components` are numbers of COMPONENTS, of what `kind` says: "place", "velocity" or "reaction"."""

    name: str
    kind: str
    components: tuple[int, ...]
    unit: str
    is_vector: bool = False

    def has_element(self, index: tuple[int, ...]) -> bool:
        """Whether subscripts, which count from 1, pick a component; none pick the whole."""
        return not index or (self.is_vector and len(index) == 1 and 1 <= index[0] <= len(self.components))

    def picked(self, index: tuple[int, ...]) -> tuple[int, ...]:
        """The components that subscripts pick."""
        return (self.components[index[0] - 1],) if index else self.components


COMPONENTS = (Component("x", "m", "", "horizontal position"), Component("y", "m", "", "height"),
              Component("phi", "rad", "deg", "angle"))

WRENCH_HEADINGS = ("F_x [N]", "F_y [N]", "M [N.m]")  # of the columns of a table

_TABLE = (
    FrameAttribute("r", "place", (0, 1), "m", is_vector=True),
    FrameAttribute("x", "place", (0,), "m"),
    FrameAttribute("y", "place", (1,), "m"),
    FrameAttribute("phi", "place", (2,), "rad"),
    FrameAttribute("v", "velocity", (0, 1), "m/s", is_vector=True),
    FrameAttribute("w", "velocity", (2,), "rad/s"),
    FrameAttribute("reaction", "reaction", (0, 1), "N", is_vector=True),
    FrameAttribute("reaction_torque", "reaction", (2,), "N.m"),
)
ATTRIBUTES: Mapping[str, FrameAttribute] = {attribute.name: attribute for attribute in _TABLE}
REACTIONS = tuple(name for name, a in ATTRIBUTES.items() if a.kind == "reaction")  # on the held port of a component
OF_ANY_FRAME = frozenset(name for name, a in ATTRIBUTES.items() if a.kind != "reaction")
WHOLE_MOTION = ("r", "phi", "v", "w")  # what says all, once
WORDS = "it has the position r (also x and y), the angle phi, the velocity v and the angular velocity w"
WORDS_OF_ELEMENTS = "r and v have two elements, the others are numbers"


@cache
def dimension_of(attribute: str) -> Dimension:
    """That of each of an attribute's components."""
    return parse_unit(ATTRIBUTES[attribute].unit).dimension


def is_vector(attribute: str) -> bool:
    """Whether an attribute has elements."""
    return attribute in ATTRIBUTES and ATTRIBUTES[attribute].is_vector


def reading(kind: str, component: int) -> list[str]:
    """The attributes that are made of a component of a place, velocity or reaction, vectors first."""
    return [name for name, a in ATTRIBUTES.items() if a.kind == kind and component in a.components]


def reads_angle(attribute: str) -> bool:
    """Whether an attribute says how a frame is turned, or turns."""
    return attribute in OF_ANY_FRAME and any(COMPONENTS[k].is_angle for k in ATTRIBUTES[attribute].components)


def is_velocity(attribute: str) -> bool:
    """Whether an attribute says how fast a frame moves or turns."""
    return attribute in ATTRIBUTES and ATTRIBUTES[attribute].kind == "velocity"


def component_named(name: str) -> Component:
    """That which a coordinate of a floating frame is called by: phi of bar.center.phi."""
    last = name.rpartition(".")[2]
    return next(component for component in COMPONENTS if component.name == last)


def place_of(velocity: str) -> str:
    """The attribute whose rate another one is: r of v, phi of w."""
    components = ATTRIBUTES[velocity].components
    return next(name for name, a in ATTRIBUTES.items() if a.kind == "place" and a.components == components)


def as_element(attribute: str, index: tuple[int, ...]) -> tuple[str, tuple[int, ...]]:
    """x is r[1], y is r[2]: the same for what is the same; other attributes as they are."""
    known = ATTRIBUTES.get(attribute)
    if known is None or known.is_vector:
        return attribute, index
    for vector in (a for a in _TABLE if a.is_vector and a.kind == known.kind):
        if known.components[0] in vector.components:
            return vector.name, (vector.components.index(known.components[0]) + 1,)
    return attribute, index
