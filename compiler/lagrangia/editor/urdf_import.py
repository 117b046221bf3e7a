"""URDF, the description of a robot -> Lagrangia text: links are frames and bodies, joints are joints, fixed ones welds.

Names stay as they are. Limits are told beside the joints. What has no counterpart is told.
Source: http://wiki.ros.org/urdf/XML; angles r, p, y turn about the fixed axes x, y, z in this order.
"""

import math
from collections import Counter
from collections.abc import Sequence

from lagrangia.base.diagnostics import Report, fail
from lagrangia.base.records import dataclass
from lagrangia.editor.modelica_import import Imported
from lagrangia.editor.robot_text import Names, Place, counted, inertia_matrix, number, quoted, read_numbers, row
from lagrangia.fmu.xmltree import Element, read_xml

_JOINTS = {"revolute": "Revolute", "continuous": "Revolute", "prismatic": "Prismatic", "fixed": "Weld", "floating": "Free",
           "planar": "PlanarJoint"}
_OF_ONE = ("revolute", "continuous", "prismatic")  # with one coordinate
_SHAPES = frozenset({"visual", "collision", "material"})
_KNOWN = {"robot": {"link", "joint"} | _SHAPES, "link": {"inertial"} | _SHAPES,
          "joint": {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"}}
_AXES = (1, 0, 0), (0, 1, 0), (0, 0, 1)


@dataclass(frozen=True)
class _Joint:
    element: Element
    name: str  # as it is written in the text
    kind: str
    parent: str
    child: str


def imported_robot(name: str, content: bytes) -> Imported:
    """The text of the file called `name`, and what was left out. Raises LagError L0730 for what is no URDF."""
    root = read_xml(name, content)
    if root.tag != "robot":
        fail("L0730", f"'{name}' is no robot but <{root.tag}>", None, "a URDF file holds <robot>, with links and joints")
    if any(word.startswith("xacro:") for word in _tags(root)):
        fail("L0730", "this is xacro, which writes URDF", root.span(), f"run it first: xacro {name} > robot.urdf")
    return _Robot(root, name).text()


def _tags(element: Element) -> list[str]:
    return [element.tag, *(tag for child in element.children for tag in _tags(child))]


class _Robot:
    def __init__(self, root: Element, file: str) -> None:
        self.root, self.file, self.report = root, file, Report()
        self.links: dict[str, Element] = {}
        for link in root.all("link"):
            self._once(link, self.links.setdefault(self._name(link), link))
        if not self.links:
            fail("L0730", "there is no link in this robot", root.span(),
                 'links are its bodies: <link name="arm"> with <inertial>')
        self.names = Names()
        self.left_out: list[str] = []
        joints = [(x, self._name(x)) for x in root.all("joint")]
        first = {name: x for x, name in reversed(joints)}
        for x, name in joints:
            self._once(x, first[name])
        told = {name: self.names.fresh(name) for _, name in joints}
        self.frames = {name: "world" if name == "world" and self._is_root(name) else self.names.fresh(name, "_link")
                       for name in self.links}
        self.joints = [found for x, name in joints if (found := self._joint(x, told[name]))]
        mimics = [(mimic, told[name]) for x, name in joints if (mimic := x.first("mimic")) is not None]
        self.report.add([mimic.fault("L0730", f"what joint {name} mimics is no joint of the robot", "joint")
                         for mimic, name in mimics if mimic.get("joint") not in told])
        self._check_tree()
        self.report.raise_errors()

    def text(self) -> Imported:
        """All of it."""
        roots = [name for name in self.links if self._is_root(name)]
        moving = Counter(_JOINTS[joint.kind] for joint in self.joints if joint.kind in _JOINTS)
        title = self.root.get("name") or "Robot"
        counts = (moving["Revolute"], "hinge"), (moving["Prismatic"], "slider"), (len(self.links), "link")
        told = f"{counted(*counts)}, from {self.file}"
        name = self.names.fresh(title)
        lines = [f"model {name} \"{quoted(told)}\"", "World world(gravity = {0, 0, -9.81});"]
        lines += [f"Frame {self.frames[name]};" for name in self.links if self.frames[name] != "world"]
        lines += [line for joint in self.joints if (line := self._joint_line(joint))]
        lines += [line for name in self.links if name not in roots and (line := self._body(name))]
        equations = [f"{self.frames[name]} = world;" for name in roots if self.frames[name] != "world"]
        equations += [line for joint in self.joints for line in (*self._turned_back(joint), *self._mimic(joint))]
        losses = [line for joint in self.joints for line in self._dissipation(joint)]
        lines += ["equation", *equations] if equations else []
        lines += ["energy", *losses] if losses else []
        self._tell_rest()
        return Imported("\n".join([*lines, f"end {name};"]) + "\n", tuple(self.left_out))

    # ------------------------------------------------------------ names

    def _name(self, element: Element) -> str:
        name = element.get("name")
        if name is None:
            self.report.add([element.fault("L0730", f"a {element.tag} needs a name")])
        return name or ""

    def _once(self, element: Element, first: Element) -> None:
        if element is not first and (name := element.get("name")) is not None:
            self.report.add([element.fault("L0730", f"there are two {element.tag}s of the name '{name}'", "name")])

    # ------------------------------------------------------------ the tree

    def _joint(self, element: Element, name: str) -> _Joint | None:
        ends = []
        for tag in ("parent", "child"):
            end = element.first(tag)
            link = end.get("link") if end is not None else None
            if link is None or link not in self.links:
                at = end if end is not None else element
                self.report.add([at.fault("L0730", f"the {tag} of joint {name} is no link of the robot", "link")])
            ends.append(link or "")
        return _Joint(element, name, element.get("type") or "", *ends)

    def _is_root(self, link: str) -> bool:
        return all(child.get("link") != link for child in self.root.all("joint", "child"))

    def _check_tree(self) -> None:
        for name, count in Counter(joint.child for joint in self.joints).items():
            if count > 1 and name in self.links:
                told = f"the link '{name}' is the child of {count} joints: robots of URDF are trees"
                self.report.add([self.links[name].fault("L0730", told, "name")])
        below = {joint.child: joint.parent for joint in self.joints}
        for name in self.links:
            seen, at = {name}, below.get(name)
            while at is not None and at not in seen:
                seen.add(at)
                at = below.get(at)
            if at == name:
                self.report.add([self.links[name].fault("L0730", f"the link '{name}' carries itself", "name")])
                return

    # ------------------------------------------------------------ statements

    def _joint_line(self, joint: _Joint) -> str:
        """The declaration of the joint; none for one that is left out."""
        if joint.kind not in _JOINTS:
            self.left_out.append(f"joint {joint.name} of type '{joint.kind}': its child '{joint.child}' is joined to nothing now")
            return ""
        place = self._pose(self.frames[joint.parent], joint.element.first("origin"))
        arguments = [f"a = {place}", f"b = {self.frames[joint.child]}"]
        if joint.kind == "planar" and (upright := _upright(self._axis(joint))) is not None:
            arguments = [f"a = {place.turned(*upright)}"]  # the equation of the child turns back
        elif joint.kind in _OF_ONE:
            arguments.append(f"{'along' if joint.kind == 'prismatic' else 'axis'} = {row(self._axis(joint))}")
        told = self._limits(joint)
        return f"{_JOINTS[joint.kind]} {joint.name}({', '.join(arguments)})" + (f" \"{told}\";" if told else ";")

    def _axis(self, joint: _Joint) -> list[float]:
        axis = joint.element.first("axis")
        return read_numbers(axis, "xyz", 3) if axis is not None else [1.0, 0.0, 0.0]

    def _turned_back(self, joint: _Joint) -> list[str]:
        """Of a joint in a plane whose normal is not z: the child's axes are those of the parent's place, turned in the plane."""
        if joint.kind != "planar" or (upright := _upright(self._axis(joint))) is None:
            return []
        angle, axis = upright
        return [f"{self.frames[joint.child]} = {Place(f'{joint.name}.b').turned(-angle, axis)};"]

    def _limits(self, joint: _Joint) -> str:
        limit, (angle, force, speed) = joint.element.first("limit"), _UNITS[joint.kind == "prismatic"]
        if limit is None or joint.kind not in _OF_ONE:
            return ""
        known = {name: read_numbers(limit, name, 1)[0] for name in ("lower", "upper", "effort", "velocity") if limit.get(name)}
        parts = []
        if joint.kind != "continuous" and ("lower" in known or "upper" in known):
            parts.append(f"from {number(known.get('lower', 0.0))} to {number(known.get('upper', 0.0))} {angle}")
        parts += [f"{what} up to {number(known[name])} {unit}" for name, what, unit in (("effort", *force), ("velocity", *speed))
                  if name in known]
        return "; ".join(parts)

    def _body(self, link: str) -> str:
        inertial = self.links[link].first("inertial")
        mass, inertia = (inertial.first(tag) if inertial is not None else None for tag in ("mass", "inertia"))
        if inertial is None or mass is None:
            return ""
        m = read_numbers(mass, "value", 1)[0]
        J = {name: read_numbers(inertia, name, 1)[0] if inertia is not None else 0.0 for name in _MOMENTS}
        if m == 0 and not any(J.values()):
            return ""
        written = inertia_matrix([[J[f"i{min(a, b)}{max(a, b)}"] for b in "xyz"] for a in "xyz"])
        center = self._pose(self.frames[link], inertial.first("origin"))
        name = self.names.fresh(f"{link}_body")
        return f"Body {name}(center = {center}, m = {number(m)}, I = {written});"

    def _pose(self, frame: str, origin: Element | None) -> Place:
        """A frame followed by an origin."""
        place = Place(frame)
        if origin is None:
            return place
        ahead, (roll, pitch, yaw) = (read_numbers(origin, name, 3) if origin.get(name) else [0.0] * 3 for name in ("xyz", "rpy"))
        return place.shifted(ahead).turned(yaw, _AXES[2]).turned(pitch, _AXES[1]).turned(roll, _AXES[0])

    def _mimic(self, joint: _Joint) -> list[str]:
        mimic = joint.element.first("mimic")
        if mimic is None:
            return []
        other = next((x for x in self.joints if x.element.get("name") == mimic.get("joint")), None)
        if other is None or other is joint or not {joint.kind, other.kind} <= {*_OF_ONE}:
            self.left_out.append(f"what joint {joint.name} mimics")
            return []
        factor, offset = (read_numbers(mimic, name, 1)[0] if mimic.get(name) else usual
                          for name, usual in (("multiplier", 1.0), ("offset", 0.0)))
        own, led = (f"{x.name}.{'s' if x.kind == 'prismatic' else 'phi'}" for x in (joint, other))
        more = f" {'-' if offset < 0 else '+'} {number(abs(offset))}" if offset else ""
        return [f"{own} = {number(factor)}*{led}{more};"]

    def _dissipation(self, joint: _Joint) -> list[str]:
        dynamics = joint.element.first("dynamics")
        if dynamics is None or joint.kind == "fixed":
            return []
        damping, friction = (read_numbers(dynamics, name, 1)[0] if dynamics.get(name) else 0.0
                             for name in ("damping", "friction"))
        if friction:
            self.left_out.append(f"the friction of joint {joint.name}, {number(friction)}")
        if damping and joint.kind not in _OF_ONE:
            self.left_out.append(f"the damping of joint {joint.name}, {number(damping)}")
            return []
        rate = f"{joint.name}.{'v' if joint.kind == 'prismatic' else 'w'}"
        return [f"dissipation {number(damping)}*{rate}^2/2;"] if damping else []

    def _tell_rest(self) -> None:
        """What else stands in the file; shapes are no part of the motion."""
        found: Counter[str] = Counter()
        for parent in (self.root, *self.root.all("link"), *self.root.all("joint")):
            found.update(f"<{x.tag}> in a {parent.tag}" for x in parent.children if x.tag not in _KNOWN[parent.tag])
        self.left_out += [f"{what}, {count} of them" if count > 1 else what for what, count in found.items()]


def _upright(axis: Sequence[float]) -> tuple[float, tuple[float, float, float]] | None:
    """The angle and the axis of the turn that takes z to an axis; None where that is none."""
    x, y, z = axis
    across = math.hypot(x, y)
    if across == 0:
        return None if z >= 0 else (math.pi, (1, 0, 0))
    return math.atan2(across, z), (-y / across, x / across, 0)


_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_UNITS = {False: ("rad", ("torque", "N.m"), ("speed", "rad/s")), True: ("m", ("force", "N"), ("speed", "m/s"))}
