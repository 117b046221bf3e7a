"""What is written in MJCF, MuJoCo's description of scenes: included files, classes of defaults, angles, attitudes.

Source: https://mujoco.readthedocs.io/en/stable/XMLreference.html; default values and rules are those of the reference.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.records import dataclass
from lagrangia.editor.robot_text import read_numbers
from lagrangia.fmu.xmltree import Element
from lagrangia.frames.quaternions import conjugate, quaternion_product
from lagrangia.solids.stage import matrices, quaternions

_MOST_FILES = 1_000  # that are included, each as often as it is
Vector = Sequence[float]
SINGLE = {"Revolute": ("phi", "w"), "Prismatic": ("s", "v")}  # the coordinate and its rate, where there is one


@dataclass(frozen=True)
class Written:
    """An element with the attributes that its class of defaults gives it."""

    element: Element
    attributes: Mapping[str, str]

    def get(self, name: str, usual: str | None = None) -> str | None:
        """An attribute as it is written."""
        return self.attributes.get(name, usual)

    def numbers(self, name: str, count: int, usual: Vector = ()) -> Vector:
        """Of an attribute. Raises LagError L0730."""
        if (text := self.attributes.get(name)) is None and usual:
            return usual
        return read_numbers(self.element, name, count, text or "")

    def number(self, name: str, usual: float = 0.0) -> float:
        """One of them."""
        return self.numbers(name, 1, [usual])[0]

    def leading(self, name: str, usual: Vector) -> Vector:
        """The first numbers of an attribute that may have more, of which the others are `usual`."""
        text = (self.attributes.get(name) or "").split()
        return [*read_numbers(self.element, name, len(text), " ".join(text)), *usual[len(text):]] if text else usual


@dataclass(frozen=True)
class Joint:
    """`name` as it is written in the text, `coordinate` and `rate` with it. `start` in rad or m."""

    written: Written
    name: str
    kind: str  # the component
    start: float

    @property
    def coordinate(self) -> str:
        """Of one that has a single one."""
        return f"{self.name}.{SINGLE[self.kind][0]}"

    @property
    def rate(self) -> str:
        """Of the coordinate."""
        return f"{self.name}.{SINGLE[self.kind][1]}"


def with_included(root: Element, read: Callable[[str, Span], Element]) -> Element:
    """The elements of included files stand in the place of <include>. `read` gives the root of a file. Raises LagError L0730."""
    files = list[str]()

    def unfolded(element: Element, around: tuple[str, ...]) -> list[Element]:
        if element.tag != "include":
            return [replace(element, children=[x for child in element.children for x in unfolded(child, around)])]
        name = element.get("file")
        if name is None or name in around:
            fail("L0730", "<include> names a file" if name is None else "these files include each other", element.span())
        files.append(name)
        if len(files) > _MOST_FILES:
            fail("L0730", f"more than {_MOST_FILES} files are included", element.span(), "those inside each other multiply")
        return [x for child in read(name, element.span("file")).children for x in unfolded(child, (*around, name))]

    (found,) = unfolded(root, ())
    return found


class Defaults:
    """Attributes by class and tag: a class inherits those of the one around it."""

    def __init__(self, root: Element) -> None:
        self.classes: dict[str, dict[str, dict[str, str]]] = {}
        self.main = "main"
        for element in root.all("default"):
            self.main = element.get("class") or self.main
            self._read(element, self.classes.get(self.main, {}), self.main)

    def _read(self, element: Element, around: Mapping[str, Mapping[str, str]], name: str) -> None:
        here = {tag: dict(attributes) for tag, attributes in around.items()}
        for child in element.children:
            if child.tag != "default":
                here.setdefault(_kind(child.tag), {}).update(child.attributes)
        self.classes[name] = here
        for child in element.children:
            if child.tag == "default":
                inner = child.get("class")
                if inner is None:
                    fail("L0730", "a class of defaults in another needs a name", child.span(), 'write <default class="…">')
                self._read(child, here, inner)

    def written(self, element: Element, around: str | None) -> Written:
        """`around` is the childclass that holds here. Raises LagError L0730 for a class that is not there."""
        name = element.get("class") or around or self.main
        if name not in self.classes and name != self.main:
            fail("L0730", f"there is no class of defaults '{name}'", element.span("class"))
        given = self.classes.get(name, {}).get(_kind(element.tag), {})
        if any(word in element.attributes for word in _ATTITUDES):
            given = {word: value for word, value in given.items() if word not in _ATTITUDES}
        return Written(element, {**given, **element.attributes})


def _kind(tag: str) -> str:
    """Short forms of <general> have the same defaults."""
    return "general" if tag in _ACTUATORS else tag


_ACTUATORS = frozenset({"motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion"})
_ATTITUDES = ("quat", "axisangle", "xyaxes", "zaxis", "euler")


@dataclass(frozen=True)
class Angles:
    """How this file writes angles."""

    is_degree: bool = True
    sequence: str = "xyz"  # upper case turns about fixed axes

    def radians(self, x: float) -> float:
        """An angle of the file."""
        return math.radians(x) if self.is_degree else x

    def attitude(self, written: Written) -> Vector:
        """Unit quaternion, real part first. Raises LagError L0730 for a direction of length zero."""
        given = [name for name in _ATTITUDES if written.get(name) is not None]
        if not given:
            return [1.0, 0.0, 0.0, 0.0]
        if len(given) > 1:
            fail("L0730", f"{' and '.join(given)} both say how <{written.element.tag}> is turned",
                 written.element.span(given[1]))
        return _READERS[given[0]](self, written)

    def _quaternion(self, written: Written) -> Vector:
        return _unit(written, "quat", written.numbers("quat", 4))

    def _axis_angle(self, written: Written) -> Vector:
        *axis, turned = written.numbers("axisangle", 4)
        return about(_unit(written, "axisangle", axis), self.radians(turned))

    def _euler(self, written: Written) -> Vector:
        found: Vector = [1.0, 0.0, 0.0, 0.0]
        for letter, turned in zip(self.sequence, written.numbers("euler", 3), strict=True):
            once = about([float(letter.lower() == axis) for axis in "xyz"], self.radians(turned))
            found = quaternion_product(found, once) if letter.islower() else quaternion_product(once, found)
        return found

    def _two_axes(self, written: Written) -> Vector:
        both = written.numbers("xyaxes", 6)
        x = _unit(written, "xyaxes", both[:3])
        along = sum(a * b for a, b in zip(x, both[3:], strict=True))
        y = _unit(written, "xyaxes", [b - along * a for a, b in zip(x, both[3:], strict=True)])
        z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
        return [float(part) for part in quaternions(np.array([[x, y, z]]).transpose(0, 2, 1))[0]]

    def _third_axis(self, written: Written) -> Vector:
        return towards(_unit(written, "zaxis", written.numbers("zaxis", 3)))


_READERS = {"quat": Angles._quaternion, "axisangle": Angles._axis_angle, "euler": Angles._euler, "xyaxes": Angles._two_axes,
            "zaxis": Angles._third_axis}


def about(axis: Vector, turned: float) -> Vector:
    """The quaternion of a turn, in radians, about a unit vector."""
    s = math.sin(turned / 2)
    return [math.cos(turned / 2), s * axis[0], s * axis[1], s * axis[2]]


def towards(z: Vector) -> Vector:
    """The shortest turn from the third axis to the unit vector z."""
    across = math.hypot(z[0], z[1])
    if across < 1e-10:  # as good as along the axis
        return [1.0, 0.0, 0.0, 0.0] if z[2] > 0 else [0.0, 1.0, 0.0, 0.0]
    return about([-z[1] / across, z[0] / across, 0.0], math.atan2(across, z[2]))


def turned(q: Vector, vector: Vector) -> list[float]:
    """A vector in the axes around a body that is turned by q."""
    return list(quaternion_product(quaternion_product(q, [0.0, *vector]), conjugate(q))[1:])


def turned_moments(q: Vector, moments: Sequence[Vector]) -> list[list[float]]:
    """R J R': a matrix of moments in the axes around."""
    R = matrices(np.array(q))
    full = R @ np.array(moments) @ R.T
    found: list[list[float]] = ((full + full.T) / 2).tolist()
    return found


def _unit(written: Written, name: str, vector: Vector) -> list[float]:
    size = math.hypot(*vector)
    if size < 1e-14:
        fail("L0730", f"'{name}' of <{written.element.tag}> has no direction", written.element.span(name))
    return [x / size for x in vector]
