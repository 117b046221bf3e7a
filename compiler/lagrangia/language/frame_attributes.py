"""What can be asked of a frame by name: a table of its attributes for each space, made of components of its place, of its
velocity, or of what its joint exerts on it.

A frame of the plane has three of each: x and y along the world's axes, and about z phi, a rate, a torque. A frame in space has
six: three along the world's axes and three about them; its attitude is a matrix R or a quaternion Q, whose rate is no component.
"""

from collections.abc import Mapping
from functools import cache

from lagrangia.base.records import dataclass
from lagrangia.language.tree import FrameRef
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
    """`components` are numbers of those of a space, of what `kind` says: "place", "velocity" or "reaction"; an "attitude" and a
    velocity in the frame's own axes have none. `whole`: the shape of what is no vector of components."""

    name: str
    kind: str
    components: tuple[int, ...]
    unit: str
    is_vector: bool = False
    whole: tuple[int, ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """The sizes of its dimensions, () of a number."""
        return self.whole or ((len(self.components),) if self.is_vector else ())

    def has_element(self, index: tuple[int, ...]) -> bool:
        """Whether subscripts, which count from 1, pick a component; none pick the whole."""
        return len(index) <= len(self.shape) and all(1 <= i <= n for i, n in zip(index, self.shape, strict=False))

    def picked(self, index: tuple[int, ...]) -> tuple[int, ...]:
        """The components that subscripts pick; none of what has none."""
        if not self.components:
            return ()
        return (self.components[index[0] - 1],) if index else self.components


ANGLE = "phi"  # of a frame of the plane
ABOUT_Z = "omega_z"  # in the frame's own axes, of a frame that turns about no other axis: kinematics.py refuses others


@dataclass(frozen=True)
class Space:
    """What a frame is made of, in the plane or in space."""

    name: str
    dimensions: int  # of a position
    components: tuple[Component, ...]  # of the place of a floating frame
    wrench: tuple[str, ...]  # what the numbers of a force and a torque are called
    attributes: Mapping[str, FrameAttribute]
    whole_motion: tuple[str, ...]  # what says all, once
    words: str
    words_of_elements: str
    missing: Mapping[str, str]  # attributes of the other space, and what to write in their place

    @property
    def is_spatial(self) -> bool:
        """Whether it has three dimensions."""
        return self.dimensions == 3

    @property
    def of_any_frame(self) -> frozenset[str]:
        """Attributes of frames, whether joints hold them or not."""
        return frozenset(name for name, a in self.attributes.items() if a.kind != "reaction")


def _table(*rows: FrameAttribute) -> Mapping[str, FrameAttribute]:
    return {attribute.name: attribute for attribute in rows}


PLANE = Space(
    "plane", 2, (Component("x", "m", "", "horizontal position"), Component("y", "m", "", "height"),
                 Component("phi", "rad", "deg", "angle")),
    ("x", "y", "torque"),
    _table(
        FrameAttribute("r", "place", (0, 1), "m", is_vector=True),
        FrameAttribute("x", "place", (0,), "m"),
        FrameAttribute("y", "place", (1,), "m"),
        FrameAttribute("phi", "place", (2,), "rad"),
        FrameAttribute("v", "velocity", (0, 1), "m/s", is_vector=True),
        FrameAttribute("w", "velocity", (2,), "rad/s"),
        FrameAttribute("reaction", "reaction", (0, 1), "N", is_vector=True),
        FrameAttribute("reaction_torque", "reaction", (2,), "N.m"),
    ),
    ("r", "phi", "v", "w"),
    "it has the position r (also x and y), the angle phi, the velocity v and the angular velocity w",
    "r and v have two elements, the others are numbers", {},
)
SPACE = Space(
    "space", 3, (Component("x", "m", "", "position along x"), Component("y", "m", "", "position along y"),
                 Component("z", "m", "", "position along z")),
    ("x", "y", "z", "torque_x", "torque_y", "torque_z"),
    _table(
        FrameAttribute("r", "place", (0, 1, 2), "m", is_vector=True),
        FrameAttribute("x", "place", (0,), "m"),
        FrameAttribute("y", "place", (1,), "m"),
        FrameAttribute("z", "place", (2,), "m"),
        FrameAttribute("R", "attitude", (), "1", whole=(3, 3)),
        FrameAttribute("Q", "attitude", (), "1", whole=(4,)),
        FrameAttribute("attitude", "attitude", (), "rad", whole=(3,)),
        FrameAttribute("v", "velocity", (0, 1, 2), "m/s", is_vector=True),
        FrameAttribute("w", "velocity", (3, 4, 5), "rad/s", is_vector=True),
        FrameAttribute("omega", "velocity", (), "rad/s", whole=(3,)),
        FrameAttribute(ABOUT_Z, "velocity", (), "rad/s"),
        FrameAttribute("reaction", "reaction", (0, 1, 2), "N", is_vector=True),
        FrameAttribute("reaction_torque", "reaction", (3, 4, 5), "N.m", is_vector=True),
    ),
    ("r", "R", "v", "w"),
    "it has the position r (also x, y and z), the attitude R (a matrix) or Q (a quaternion), the velocity v and the angular "
    "velocity w, in its own axes omega",
    "r, v, w and omega have three elements, R three times three, Q four",
    {"phi": "in space a frame has no one angle: its attitude is R (a matrix) or Q (a quaternion), and the angle of a hinge is "
            "the hinge's own, as hinge.phi"},
)
SPATIAL_ONLY = SPACE.attributes.keys() - PLANE.attributes.keys()  # whoever names them has a scene in space

# Of the plane, for what is of the plane alone.
COMPONENTS, ATTRIBUTES, OF_ANY_FRAME = PLANE.components, PLANE.attributes, PLANE.of_any_frame
# Of the columns of a table, by how many numbers a wrench has.
WRENCH_HEADINGS = {3: ("F_x [N]", "F_y [N]", "M [N.m]"),
                   6: ("F_x [N]", "F_y [N]", "F_z [N]", "M_x [N.m]", "M_y [N.m]", "M_z [N.m]")}
REACTIONS = tuple(name for name, a in ATTRIBUTES.items() if a.kind == "reaction")  # on the held port of a component
WORDS = PLANE.words


def space_of(node: FrameRef) -> Space:
    """That in which a frame is asked for something."""
    return SPACE if node.is_spatial else PLANE


def known_of(node: FrameRef) -> FrameAttribute:
    """What is asked of a frame."""
    return space_of(node).attributes[node.attribute]


@cache
def dimension_of(attribute: str) -> Dimension:
    """That of each of an attribute's components."""
    return parse_unit((ATTRIBUTES.get(attribute) or SPACE.attributes[attribute]).unit).dimension


def frame_shape(node: FrameRef) -> tuple[int, ...]:
    """The sizes of what is asked of a frame, where subscripts have not picked: () of a number, and of the frame itself."""
    return known_of(node).shape[len(node.index):] if node.attribute else ()


def reading(kind: str, component: int, space: Space = PLANE) -> list[str]:
    """The attributes that are made of a component of a place, velocity or reaction, vectors first."""
    return [name for name, a in space.attributes.items() if a.kind == kind and component in a.components]


def reads_angle(attribute: str, space: Space = PLANE) -> bool:
    """Whether an attribute says how a frame is turned, or turns."""
    known = space.attributes.get(attribute)
    if known is None or known.kind == "reaction":
        return False
    return not known.components or any(k >= space.dimensions for k in known.components)


def is_velocity(attribute: str) -> bool:
    """Whether an attribute says how fast a frame moves or turns; it is the same in both spaces."""
    known = SPACE.attributes.get(attribute)
    return known is not None and known.kind == "velocity"


def component_named(name: str) -> Component:
    """That which a coordinate of a floating frame is called by: phi of bar.center.phi, and of Euler's angles theta and psi."""
    last = name.rpartition(".")[2]
    last = "phi" if last in ("theta", "psi") else last
    return next(component for component in (*COMPONENTS, *SPACE.components) if component.name == last)


def place_of(node: FrameRef) -> str | None:
    """The attribute whose rate another one is: r of v, phi of w; None where there is none."""
    components = known_of(node).components
    known = space_of(node).attributes.items()
    return next((name for name, a in known if a.kind == "place" and a.components == components and components), None)


def as_element(node: FrameRef) -> tuple[str, tuple[int, ...]]:
    """x is r[1], y is r[2]: the same for what is the same; other attributes as they are."""
    known = known_of(node) if node.attribute else None
    if known is None or known.shape or not known.components:
        return node.attribute, node.index
    for vector in (a for a in space_of(node).attributes.values() if a.is_vector and a.kind == known.kind):
        if known.components[0] in vector.components:
            return vector.name, (vector.components.index(known.components[0]) + 1,)
    return node.attribute, node.index
