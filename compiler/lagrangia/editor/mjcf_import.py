"""MJCF, MuJoCo's description of a scene -> Lagrangia text: the tree of bodies, with joints, springs, dampers, motors.

Coordinates mean what they mean in MuJoCo: a hinge that begins at `ref` does so here. Limits are told beside the joints. Shapes
give masses and moments where a body says none. Contacts, tendons and what else has no counterpart is told.
"""

import math
from collections import Counter
from collections.abc import Callable, Sequence

from lagrangia.base.diagnostics import Span, fail
from lagrangia.editor.mjcf_inertia import Mass, shape_mass, together, written_mass
from lagrangia.editor.mjcf_motors import motor_lines
from lagrangia.editor.mjcf_reading import SINGLE, Angles, Defaults, Joint, Vector, Written, turned, turned_moments, with_included
from lagrangia.editor.mjcf_words import unknown_words
from lagrangia.editor.modelica_import import Imported
from lagrangia.editor.robot_text import Names, Place, counted, difference, inertia_matrix, number, quoted, radians, row
from lagrangia.fmu.xmltree import Element

_KINDS = {"hinge": "Revolute", "slide": "Prismatic", "ball": "Spherical", "free": "Free"}
_UNSEEN = frozenset({"asset", "visual", "statistic", "size", "custom", "keyframe", "sensor", "default", "compiler", "option",
                     "worldbody", "actuator", "equality", "extension"})
_IN_BODIES = frozenset({"body", "frame", "inertial", "joint", "freejoint", "geom", "site", "camera", "light"})
_MEDIUM = ("wind", "density", "viscosity", "magnetic")
_FLAGS = frozenset({"gravity", "contact", "constraint", "limit", "energy", "warmstart", "filterparent", "midphase", "nativeccd",
                    "island", "eulerdamp", "autoreset", "sensor", "clampctrl", "refsafe"})
_MAIN = Place("world")
_ROUNDING = 1e-15  # of components of turned axes
_Part = tuple[Element, str | None, Sequence[Element]]
_JOINTS, _SHAPES, _INERTIAL = frozenset({"joint", "freejoint"}), frozenset({"geom"}), frozenset({"inertial"})


def imported_scene(root: Element, file: str, read: Callable[[str, Span], Element]) -> Imported:
    """The text of a file whose root is <mujoco>, and what was left out. `read` gives the root of an included file.
    Raises LagError L0730."""
    return _Scene(with_included(root, read), file).text()


class _Scene:
    def __init__(self, root: Element, file: str) -> None:
        self.root, self.file = root, file
        for tags in (frozenset({"body"}), _JOINTS):
            _check_names(root, tags, set())
        self.defaults = Defaults(root)
        self.left_out: Counter[str] = Counter()
        self.names, self.joints = Names(), dict[str, Joint]()
        self.taken = {name: self.names.fresh(name) for name in _joint_names(root)}  # joints keep their names before all others
        self.flags = {name: value for x in root.all("option", "flag") for name, value in x.attributes.items()}
        self.frames: list[str] = []
        self.declared: list[str] = []
        self.equations: list[str] = []
        self.energies: list[str] = []
        self.bodies: list[tuple[Place, str, Mass]] = []
        self.counts: Counter[str] = Counter()
        compiler = list(root.all("compiler"))
        self.compiler = Written(compiler[0] if compiler else root, {k: v for x in compiler for k, v in x.attributes.items()})
        self.angles = Angles(self.compiler.get("angle", "degree") == "degree", self.compiler.get("eulerseq") or "xyz")
        self._check_compiler()

    def text(self) -> Imported:
        """All of it."""
        for world in self.root.all("worldbody"):
            for geom, around, _ in _own(world, _SHAPES, None):
                self._see_shape(self._of(geom, around), "standing")
            self._inside(world, _MAIN, None)
        if not self.counts["body"]:
            unknown = [f"not supported yet: {what}" for what in self.left_out]
            fail("L0730", "there is no body in this scene", self.root.span(), "bodies stand in <worldbody>", *unknown)
        motors = [x for group in self.root.all("actuator") for x in group.children]
        inputs, works = motor_lines([self.defaults.written(x, None) for x in motors], self.joints, self.names, self.left_out)
        self._couple()
        self._tell_rest()
        parts = (self.counts["Revolute"], "hinge"), (self.counts["Prismatic"], "slider"), \
                (self.counts["Spherical"], "ball joint"), (self.counts["body"], "body")
        told = f"{counted(*parts).replace('bodys', 'bodies')}, from {self.file}"
        name = self.names.fresh(self.root.get("model") or "Scene")
        gravity = [0.0, 0.0, -9.81]
        for option in self.root.all("option"):
            gravity = list(Written(option, option.attributes).numbers("gravity", 3, gravity))
        if self.flags.get("gravity") == "disable":
            gravity = [0.0] * 3
        lines = [f"model {name} \"{quoted(told)}\"", f"World world(gravity = {row(gravity)});",
                 *(f"Frame {frame};" for frame in self.frames), *self.declared, *self._masses(), *inputs]
        lines += ["equation", *self.equations] if self.equations else []
        lines += ["energy", *self.energies, *works] if self.energies or works else []
        left_out = [f"{what}, {count} of them" if count > 1 else what for what, count in self.left_out.items()]
        return Imported("\n".join([*lines, f"end {name};"]) + "\n", tuple(left_out))

    def _check_compiler(self) -> None:
        at = self.compiler.element
        if self.compiler.get("coordinate", "local") != "local":
            fail("L0730", "not supported yet: places in global coordinates, which newer versions of the format have not either",
                 at.span("coordinate"))
        if len(self.angles.sequence) != 3 or not set(self.angles.sequence.lower()) <= set("xyz"):
            fail("L0730", "'eulerseq' is three of the letters x y z X Y Z", at.span("eulerseq"))
        if self.compiler.get("angle", "degree") not in ("degree", "radian"):
            fail("L0730", "'angle' is degree or radian", at.span("angle"))
        for name in ("boundmass", "boundinertia", "balanceinertia", "alignfree"):
            if self.compiler.get(name, "0") not in ("0", "false", "auto"):
                self.left_out[f"{name} of the compiler"] += 1

    # ------------------------------------------------------------ the tree

    def _inside(self, outer: Element, place: Place, around: str | None) -> None:
        """What stands in a body, a frame or the world; `place` is where it sits, `around` the class that holds."""
        around = outer.get("childclass") or around
        for element in outer.children:
            if element.tag not in _IN_BODIES:
                self.left_out[f"<{element.tag}> in a {outer.tag}"] += 1
            elif element.tag == "frame":
                self._inside(element, self._pose(place, self._plain(element)), around)
            elif element.tag == "body":
                self._body(element, place, element.get("childclass") or around)

    def _body(self, element: Element, outer: Place, around: str | None) -> None:
        self.counts["body"] += 1
        name = element.get("name") or f"body{self.counts['body']}"
        written = self._plain(element)
        for word in ("mocap", "gravcomp"):
            if element.get(word) not in (None, "0", "false"):
                self.left_out[f"{word} of body {name}"] += 1
        joints = [(self._of(joint, holds), self._placed(joint, holds, steps))
                  for joint, holds, steps in _own(element, _JOINTS, around)]
        if joints and self._kind(joints[0][0]) == "Free":
            place = self._floating([own for own, _ in joints], written, name, outer)
        else:
            place = self._carried(joints, self._pose(outer, written), name)
        self.bodies.append((place, name, self._mass(element, around, name)))
        self._inside(element, place, around)

    def _placed(self, joint: Element, around: str | None, steps: Sequence[Element]) -> tuple[Vector, Vector]:
        """Where a joint is in its body, and its axis, from within the frames around it."""
        own = self._of(joint, around)
        place, axis = own.numbers("pos", 3, [0.0] * 3), own.numbers("axis", 3, [0.0, 0.0, 1.0])
        for step in reversed(steps):
            frame = self._plain(step)
            q, ahead = self.angles.attitude(frame), frame.numbers("pos", 3, [0.0] * 3)
            place, axis = [a + b for a, b in zip(ahead, turned(q, place), strict=True)], turned(q, axis)
        return place, [x if abs(x) > _ROUNDING else 0.0 for x in axis]

    def _carried(self, joints: Sequence[tuple[Written, tuple[Vector, Vector]]], at: Place, name: str) -> Place:
        """Where a body is whose joints move it one after the other."""
        passed = [0.0, 0.0, 0.0]  # from the last joint's place back to the body's origin
        for k, (own, (place, axis)) in enumerate(joints):
            at = at.shifted([place[i] - passed[i] for i in range(3)])
            which = str(k + 1) if len(joints) > 1 else ""
            frame = self._frame(name if k + 1 == len(joints) and not any(place) else f"{name}_at{which}")
            self._join(own, axis, f"{name}_joint{which}", at, frame)
            at, passed = Place(frame), list(place)
        if not joints:
            frame = self._frame(name)
            self.equations.append(f"{frame} = {at};")
            return Place(frame)
        return at.shifted([-x for x in passed])

    def _join(self, own: Written, axis: Vector, usual: str, at: Place, frame: str) -> None:
        kind = self._kind(own)
        name = self._joint_name(own, usual)
        if kind == "Free":
            fail("L0730", "a free joint is the only one of its body, which stands in the world", own.element.span())
        start = own.number("ref") if kind in SINGLE else 0.0
        if not any(axis):
            fail("L0730", f"the axis of joint {name} has no direction", own.element.span("axis"))
        if kind == "Revolute":
            start = self.angles.radians(start)
            at = at.turned(-start, axis)
        elif kind == "Prismatic" and start:
            size = math.hypot(*axis)
            at = at.shifted([-start * x / size for x in axis])
        arguments = [f"a = {at}", f"b = {frame}"]
        if kind in SINGLE:
            arguments.append(f"{'along' if kind == 'Prismatic' else 'axis'} = {row(axis)}")
        if start:
            arguments.append(f"{SINGLE[kind][0]}(start = {radians(start) if kind == 'Revolute' else number(start)})")
        told = self._limits(own, kind)
        self.declared.append(f"{kind} {name}({', '.join(arguments)})" + (f" \"{told}\";" if told else ";"))
        self.counts[kind] += 1
        joint = Joint(own, name, kind, start)
        self.joints[own.get("name") or name] = joint
        self._losses(joint)

    def _frame(self, name: str) -> str:
        """A frame of a name like this one."""
        self.frames.append(self.names.fresh(name, "_frame"))
        return self.frames[-1]

    def _joint_name(self, own: Written, usual: str) -> str:
        name = own.get("name")
        return self.taken[name] if name else self.names.fresh(usual)

    def _floating(self, joints: Sequence[Written], body: Written, name: str, outer: Place) -> Place:
        own = joints[0]
        if len(joints) > 1 or outer != _MAIN:
            fail("L0730", "a free joint is the only one of its body, which stands in the world", own.element.span())
        frame, joint = self._frame(name), self._joint_name(own, f"{name}_joint")
        place, q = body.numbers("pos", 3, [0.0] * 3), self.angles.attitude(body)
        starts = [f"{axis}(start = {number(x)})" for axis, x in zip("xyz", place, strict=True) if x]
        if any(q[1:]):
            starts.append(f"S(start = quaternion({', '.join(map(number, q))}))")
        self.declared.append(f"Free {joint}({', '.join(['a = world', f'b = {frame}', *starts])});")
        found = Joint(own, joint, "Free", 0.0)
        self.joints[own.get("name") or joint] = found
        self._losses(found)
        return Place(frame)

    def _losses(self, joint: Joint) -> None:
        """What a joint itself stores and loses."""
        own, known = joint.written, {}
        if any(own.leading("springdamper", [0.0])):
            self.left_out[f"springdamper of joint {joint.name}"] += 1
        for name in ("damping", "armature", "frictionloss", "stiffness"):
            if len((own.get(name) or "").split()) > 1:
                self.left_out[f"{name} of joint {joint.name}, which is no single number"] += 1
            else:
                known[name] = own.number(name)
        if joint.kind in SINGLE:
            squares = [f"{joint.rate}^2"]
        else:
            squares = [f"dot({joint.name}.w, {joint.name}.w)"]
            if joint.kind == "Free":
                squares += [f"der({joint.name}.{axis})^2" for axis in "xyz"]
        if damping := known.get("damping"):
            self.energies += [f"dissipation {number(damping)}*{square}/2;" for square in squares]
        if (armature := known.get("armature")) and joint.kind in SINGLE:
            self.energies.append(f"kinetic {number(armature)}*{squares[0]}/2;")
        elif armature:
            self.left_out[f"armature of joint {joint.name}"] += 1
        if (friction := known.get("frictionloss")) and joint.kind in SINGLE:
            self.energies.append(f"dissipation {number(friction)}*abs({joint.rate});")
        elif friction:
            self.left_out[f"frictionloss of joint {joint.name}"] += 1
        if (stiffness := known.get("stiffness")) and joint.kind in SINGLE:
            free = own.number("springref")
            free = self.angles.radians(free) if joint.kind == "Revolute" else free
            self.energies.append(f"potential {number(stiffness)}*{difference(joint.coordinate, free)}^2/2;")
        elif stiffness:
            self.left_out[f"stiffness of joint {joint.name}"] += 1

    def _limits(self, own: Written, kind: str) -> str:
        limited = own.get("limited", "auto")
        parts = []
        if limited != "false" and own.get("range") is not None and kind != "Free":
            lower, upper = own.numbers("range", 2)
            if lower > upper:
                fail("L0730", "'range' ends below where it begins", own.element.span("range"))
            if kind != "Prismatic":
                lower, upper = self.angles.radians(lower), self.angles.radians(upper)
            parts.append(f"from {number(lower)} to {number(upper)} {'m' if kind == 'Prismatic' else 'rad'}")
        if own.get("actuatorfrclimited", "auto") != "false" and own.get("actuatorfrcrange") is not None:
            lower, upper = own.numbers("actuatorfrcrange", 2)
            parts.append(f"motors from {number(lower)} to {number(upper)} {'N' if kind == 'Prismatic' else 'N.m'}")
        return "; ".join(parts)

    def _kind(self, own: Written) -> str:
        kind = "free" if own.element.tag == "freejoint" else own.get("type", "hinge") or ""
        if kind not in _KINDS:
            fail("L0730", f"there is no joint of type '{kind}'", own.element.span("type"), f"there are {', '.join(_KINDS)}")
        return _KINDS[kind]

    # ------------------------------------------------------------ masses

    def _mass(self, element: Element, around: str | None, name: str) -> Mass:
        shapes = [(self._of(geom, holds), steps) for geom, holds, steps in _own(element, _SHAPES, around)]
        for own, _ in shapes:
            self._see_shape(own, "touching")
        rule = self.compiler.get("inertiafromgeom", "auto")
        for inertial, _, steps in _own(element, _INERTIAL, around) if rule != "true" else ():
            return self._outside(written_mass(self._plain(inertial), self.angles), steps)
        if rule == "false":
            return together([])
        first, last = self.compiler.numbers("inertiagrouprange", 2, [0, 5])
        parts = []
        for own, steps in shapes:
            if not first <= own.number("group") <= last:
                continue
            if own.get("shellinertia") == "true":
                self.left_out[f"shellinertia of a shape of body {name}"] += 1
            mass = shape_mass(own, self.angles)
            if mass is None:
                self.left_out[f"the mass of a {own.get('type')} of body {name}"] += 1
                continue
            parts.append(self._outside(mass, steps))
        return together(parts)

    def _outside(self, mass: Mass, steps: Sequence[Element]) -> Mass:
        """In the axes around frames."""
        for step in reversed(steps):
            frame = self._plain(step)
            q, place = self.angles.attitude(frame), frame.numbers("pos", 3, [0.0] * 3)
            center = [a + b for a, b in zip(place, turned(q, mass.center), strict=True)]
            mass = Mass(mass.m, center, turned_moments(q, mass.moments))
        return mass

    def _masses(self) -> list[str]:
        total = self.compiler.number("settotalmass", -1)
        sum_of_all = sum(mass.m for _, _, mass in self.bodies)
        factor = total / sum_of_all if total > 0 and sum_of_all > 0 else 1.0
        lines = []
        for place, name, mass in self.bodies:
            if mass.m == 0 and not any(map(any, mass.moments)):
                continue
            scaled = mass.scaled(factor)
            center = place.shifted(scaled.center)
            lines.append(f"Body {self.names.fresh(f'{name}_body')}(center = {center}, m = {number(scaled.m)}, "
                         f"I = {inertia_matrix(scaled.moments)});")
        return lines

    # ------------------------------------------------------------ the rest

    def _couple(self) -> None:
        """Joints that follow others; other equalities close loops of the tree."""
        for element in (x for group in self.root.all("equality") for x in group.children):
            own = self.defaults.written(element, None)
            first, second = (self.joints.get(own.get(name) or "") for name in ("joint1", "joint2"))
            if own.get("active") == "false":
                continue
            if element.tag != "joint" or first is None or first.kind not in SINGLE or \
                    (own.get("joint2") is not None and (second is None or second.kind not in SINGLE)):
                self.left_out[f"<{element.tag}> in equality"] += 1
                continue
            factors = own.leading("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])
            led = "" if second is None else difference(second.coordinate, second.start)
            terms = [number(factors[0] + first.start)] if factors[0] + first.start or not led else []
            terms += [f"{number(c)}*{led}{f'^{power}' if power > 1 else ''}"
                      for power, c in enumerate(factors) if power and c and led]
            self.equations.append(f"{first.coordinate} = {' + '.join(terms) or '0'};".replace("+ -", "- "))

    def _tell_rest(self) -> None:
        self.left_out.update(unknown_words(self.root))
        for element in self.root.children:
            if element.tag not in _UNSEEN:
                self.left_out[f"<{element.tag}>"] += 1
            if element.tag == "option":
                for name in _MEDIUM:
                    if any(x not in ("0", "0.0") for x in (element.get(name) or "").split()):
                        self.left_out[f"{name} of the medium"] += 1

        for name, value in self.flags.items():
            if value == "disable" and name not in _FLAGS:
                self.left_out[f"that '{name}' is disabled"] += 1
        is_touching = "disable" not in (self.flags.get("contact"), self.flags.get("constraint"))
        if is_touching and self.counts["touching"] and self.counts["touching"] + self.counts["standing"] > 1:
            self.left_out["contact between shapes"] += 1

    def _see_shape(self, geom: Written, what: str) -> None:
        """Whether it could touch another one."""
        self.counts[what] += any(geom.get(name, "1") != "0" for name in ("contype", "conaffinity"))

    def _of(self, element: Element, around: str | None) -> Written:
        return self._plain(element) if element.tag == "freejoint" else self.defaults.written(element, around)

    def _plain(self, element: Element) -> Written:
        return Written(element, element.attributes)

    def _pose(self, place: Place, written: Written) -> Place:
        """A place followed by the pose of an element."""
        place = place.shifted(written.numbers("pos", 3, [0.0] * 3))
        q = self.angles.attitude(written)
        size = math.hypot(*q[1:])
        return place if size == 0 else place.turned(2 * math.atan2(size, q[0]), [x / size for x in q[1:]])


def _joint_names(root: Element) -> list[str]:
    own = [name] if root.tag in ("joint", "freejoint") and (name := root.get("name")) else []
    return own + [x for child in root.children if child.tag != "equality" for x in _joint_names(child)]


def _check_names(root: Element, tags: frozenset[str], seen: set[str]) -> None:
    """Raises LagError L0730 for two elements of one name, but where equations speak of joints."""
    for child in root.children:
        name = child.get("name")
        if child.tag in tags and name:
            if name in seen:
                what = "bodies" if "body" in tags else "joints"
                fail("L0730", f"there are two {what} of the name '{name}'", child.span("name"))
            seen.add(name)
        if child.tag != "equality":
            _check_names(child, tags, seen)


def _own(outer: Element, tags: frozenset[str], around: str | None, steps: Sequence[Element] = ()) -> list[_Part]:
    """What belongs to a body itself, the class that holds for each, and the frames around it."""
    found: list[_Part] = []
    for child in outer.children:
        if child.tag == "frame":
            found += _own(child, tags, child.get("childclass") or around, [*steps, child])
        elif child.tag in tags:
            found.append((child, around, steps))
    return found
