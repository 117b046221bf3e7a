"""Bodies and loads -> parts of Modelica.Mechanics.MultiBody at the frames that they belong to."""

from collections.abc import Sequence

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.paper.multibody_forces import Quantity, RigidBody, refuse, spring_of
from lagrangia.paper.multibody_walk import angles, matrix, numbers
from lagrangia.paper.multibody_writing import Writing

_ROTATIONAL, _TRANSLATIONAL = "Modelica.Mechanics.Rotational.Sources", "Modelica.Mechanics.Translational.Sources"


def write_loads(writing: Writing) -> None:
    """Raises LagError L0901 for loads on what MultiBody does not drive."""
    forces = writing.stated.forces
    pushes: dict[tuple[str, str], list[Expr]] = {}
    for body in writing.stated.bodies:
        _body(writing, body)
        pushes[body.component, body.frame] = [-body.mass * g for g in writing.gravity]  # the weight, which the world gives
    lines: dict[tuple[str, tuple[str, ...]], Expr] = {}
    drives: dict[str, Expr] = {}
    for (component, what), force in forces.items():
        if what.kind == "distance":
            lines[component, what.of] = force
        elif what.kind == "coordinate":
            drives[what.of[0]] = drives.get(what.of[0], sp.S.Zero) + force
        elif what.kind == "angle":
            torque = writing.stated.torques.setdefault((component, what.of[0]), [sp.S.Zero] * 3)
            torque[2] += force
        else:
            push = pushes.setdefault((component, what.of[0]), [sp.S.Zero] * 3)
            push[what.place[0]] += force
    for (component, ends), force in lines.items():
        _line(writing, component, ends, force)
    for name, force in drives.items():
        _drive(writing, name, force)
    for kind, acting in (("force", pushes), ("torque", writing.stated.torques)):
        for (component, frame), vector in acting.items():
            _on_frame(writing, kind, component, frame, [sp.simplify(x) for x in vector])


def _body(writing: Writing, body: RigidBody) -> None:
    I = body.inertia
    entries = [(f"I_{i + 1}{j + 1}", I[i][j]) for i, j in ((0, 0), (1, 1), (2, 2), (1, 0), (2, 0), (2, 1))]
    told = [f"{name} = {writing.code(x)}" for name, x in entries if x != 0 or name[-1] == name[-2]]
    name = writing.part("Parts.Body", writing.bodies[body.component, body.frame], f"m = {writing.code(body.mass)}",
                        "r_CM = {0, 0, 0}", *told, *_guesses(writing, body.frame))
    writing.attach(f"{name}.frame_a", body.frame)


def _guesses(writing: Writing, frame: str) -> list[str]:
    """Where it is at the start, and how it moves, where that is known."""
    values = writing.starts.values
    if f"{frame}.Q[1]" not in values:
        return []
    r, v, w, Q = ([values[f"{frame}.{name}[{k}]"] for k in range(1, 5 if name == "Q" else 4)] for name in "rvwQ")
    return [f"r_0(start = {numbers(r)})", f"v_0(start = {numbers(v)})", f"angles_start = {numbers(angles(matrix(Q)))}",
            f"w_0_start = {numbers(w)}"]


def _line(writing: Writing, component: str, ends: Sequence[str], force: Expr) -> None:
    """Between two frames."""
    s, v = (writing.reading.symbol_of(Quantity("distance", tuple(ends), (), order)) for order in (0, 1))
    known = spring_of(force, s, v, writing.reading.known)
    k, d, rest = known or (sp.S.Zero,) * 3
    name = writing.name(component or "between")
    writing.lengths.setdefault(tuple(ends), name)
    if known is None:
        writing.part("Forces.LineForceWithMass", name, "m = 0")
        source = writing.part(f"{_TRANSLATIONAL}.Force2", writing.name(f"{name}_force"))
        writing.equations += [f"  connect({source}.flange_{x}, {name}.flange_{x});" for x in "ab"]
        writing.equations.append(f"  {source}.f = {writing.code(force)};")
    elif d == 0:
        writing.part("Forces.Spring", name, f"c = {writing.code(k)}", f"s_unstretched = {writing.code(rest)}")
    elif k == 0:
        writing.part("Forces.Damper", name, f"d = {writing.code(d)}")
    else:
        writing.part("Forces.SpringDamperParallel", name, f"c = {writing.code(k)}", f"s_unstretched = {writing.code(rest)}",
                     f"d = {writing.code(d)}")
    for x, frame in zip("ab", ends, strict=True):
        writing.attach(f"{name}.frame_{x}", frame)


def _drive(writing: Writing, coordinate: str, force: Expr) -> None:
    """Torque in a hinge, or force along a slider."""
    joint = writing.flanges.get(coordinate)
    if joint is None:
        variable = writing.reading.model.variables.get(coordinate)
        refuse(f"what acts along '{coordinate}'", variable.span if variable else writing.reading.model.span)
    is_hinge = writing.motion[coordinate][0].endswith(".phi")
    kind, letter = (f"{_ROTATIONAL}.Torque", "tau") if is_hinge else (f"{_TRANSLATIONAL}.Force", "f")
    name = writing.part(kind, writing.name(f"{joint}_drive"), "useSupport = true")
    writing.equations += [f"  connect({name}.flange, {joint}.axis);", f"  connect({name}.support, {joint}.support);",
                          f"  {name}.{letter} = {writing.code(force)};"]


def _on_frame(writing: Writing, kind: str, component: str, frame: str, vector: Sequence[Expr]) -> None:
    """A force or torque in the world's axes; none that is nothing, or on the ground."""
    if all(x == 0 for x in vector) or writing.node(frame) == "world":
        return
    name = writing.part(f"Forces.World{kind.capitalize()}", writing.name(f"{component or frame}_{kind}"))
    writing.attach(f"{name}.frame_b", frame)
    writing.equations.append(f"  {name}.{kind} = {writing.vector(vector)};")
