"""A scene -> a Modelica model of components of Modelica.Mechanics.MultiBody.

Each equation of frames becomes joints and fixed parts between two nodes; bodies and forces are attached to nodes. Loops are
closed by what closes them here; a loop whose hinges have parallel axes has one RevolutePlanarLoopConstraint, for some of its
equations repeat others.
"""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.base.diagnostics import LagError
from lagrangia.frames.attitude_starts import FLOATING
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Variable
from lagrangia.language.frame_attributes import ANGLE
from lagrangia.language.frame_steps import between
from lagrangia.paper.modelica import experiment_line, identifier, output_line, quoted, unit_of
from lagrangia.paper.multibody_forces import Reading, read_statements, refuse
from lagrangia.paper.multibody_joints import ALONG, Piece, merged, pieces_of
from lagrangia.paper.multibody_loads import write_loads
from lagrangia.paper.multibody_walk import planar_cuts, walk
from lagrangia.paper.multibody_writing import LIBRARY, Starts, Way, Writing


def write_multibody(kinematics: Kinematics, starts: Starts, numbers: Mapping[str, float], remarks: Sequence[str] = ()) -> str:
    """`numbers` are the values of parameters. Raises LagError L0901 for what MultiBody has no component for."""
    reading = Reading(kinematics)
    stated = read_statements(reading)
    model = kinematics.graph.model
    outputs = {v.name: told for v in model.variables.values() if v.is_output and (told := _told(reading, v)) is not None}
    for equation in model.constraints:
        refuse(f"the equation '{equation.span.text}'", equation.span)
    writing = Writing(reading, kinematics.graph, starts, stated)
    body = _lines(writing, outputs)
    name = identifier(model.name)
    lost = [v.name for v in model.variables.values() if v.is_output and v.name not in writing.told]
    remarks = [*([f"outputs are not written: {', '.join(lost)}"] if lost else []), *remarks]
    lines = [f"model {name}{quoted(model.description)}", *(f"  // {remark}" for remark in remarks)]
    for p in reading.table.parameters.values():
        if p.name in writing.names:
            value = writing.code(p.formula) if p.formula is not None else repr(numbers[p.name])
            lines.append(f"  parameter Real {writing.names[p.name]}{unit_of(p.unit)} = {value}{quoted(p.description)};")
    return "\n".join([*lines, *body, experiment_line(model), f"end {name};"])


def _told(reading: Reading, output: Variable) -> list[Expr] | None:
    """A number or a vector by what components tell; None of what they do not."""
    try:
        value = reading.evaluator.variable(output.name, 0, output.span)
        return [exact_throughout(x) for x in scalars_of(value)] if len(output.shape) <= 1 else None
    except LagError:
        return None


def _outputs(writing: Writing, outputs: Mapping[str, Sequence[Expr]]) -> list[str]:
    """Declarations of those whose formulas components tell."""
    lines = []
    for name, values in outputs.items():
        v = writing.reading.model.variables[name]
        try:
            told = [writing.code(x) for x in values]
        except LagError:
            continue
        lines.append(f"  {output_line(v, writing.name(name), told)}")
        writing.told.add(name)
    return lines


def _lines(writing: Writing, outputs: Mapping[str, Sequence[Expr]]) -> list[str]:
    """Declarations and equations."""
    model = writing.reading.model
    inputs = [v for v in model.variables.values() if v.kind == "input" and not v.shape]
    writing.inputs = {v.name: writing.name(v.name) for v in inputs}
    declared = [f"  input Real {writing.inputs[v.name]}(start = {writing.starts.values[v.name]!r}); // {v.unit}" for v in inputs]
    writing.connectors["world"] = ["world.frame_b"]
    ways = _needed(writing, _ways(writing))
    cuts = planar_cuts(writing, ways)
    for way in ways:
        walk(writing, way, id(way) in cuts)
    write_loads(writing)
    connects = [f"  connect({first}, {other});" for first, *others in writing.connectors.values() for other in others]
    initial = ["initial equation", *writing.initial] if writing.initial else []
    told = _outputs(writing, outputs)
    return [*declared, _world(writing), *writing.parts, *told, *initial, "equation", *connects, *writing.equations]


def _world(writing: Writing) -> str:
    gravity = [writing.starts.values.get(f"world.gravity[{k}]", 0.0) for k in (1, 2, 3)]
    size = float(np.linalg.norm(gravity))
    if size and any(str(s) != "world.gravity" and not str(s).startswith("world.gravity[")
                    for x in writing.gravity for s in x.free_symbols):
        g = sp.sqrt(sum(x**2 for x in writing.gravity))
        return f"  inner {LIBRARY}.World world(n = {writing.vector(writing.gravity)}, g = {writing.code(g)});"
    n = "{" + ", ".join(repr(x / size + 0.0) for x in gravity) + "}" if size else "{0, -1, 0}"
    return f"  inner {LIBRARY}.World world(n = {n}, g = {size!r});"


def _ways(writing: Writing) -> list[Way]:
    model, found = writing.reading.model, list[Way]()
    for root in writing.graph.roots:
        if not root.is_ground:
            found.append(Way("world", root.frame, tuple(_floating(root.frame, root.attributes)), f"{root.frame}.free"))
    for equation in model.frame_equations:
        first, last, steps = between(equation.left, equation.right)
        if {first, last} & {*writing.graph.unused_frames}:
            continue
        owners = {name.rpartition(".")[0] for name in (first, last)}
        owner = next(iter(owners)) if len(owners) == 1 and "" not in owners else last
        pieces = pieces_of(writing.reading, steps, equation.span, f"'{owner}'")
        if any(owner == component for component, _ in writing.bodies) and not any(piece.moves for piece in pieces):
            owner = last  # the ends of a bar
        if pieces:
            found.append(Way(first, last, tuple(merged(pieces)), owner, equation))
        elif writing.node(first) != writing.node(last):
            first, last = writing.node(first), writing.node(last)
            writing.leader[last if last != "world" else first] = first if last != "world" else last
    _require_once(writing, found)
    return found


def _require_once(writing: Writing, ways: Sequence[Way]) -> None:
    """Raises LagError L0901 for a coordinate of several joints, each of which would move by itself."""
    seen: set[str] = set()
    for way in ways:
        for piece in (piece for piece in way.pieces if piece.moves):
            if piece.coordinate in seen:
                refuse(f"the coordinate '{piece.coordinate}' of more than one joint",
                       way.equation.span if way.equation is not None else writing.reading.model.span)
            seen.add(piece.coordinate)


def _floating(frame: str, attributes: Sequence[str]) -> list[Piece]:
    found = [Piece("slider", axis, coordinate=f"{frame}.{name}") for name, axis in zip("xyz", ALONG, strict=True)
             if name in attributes]
    found += [Piece("hinge", ALONG[2], coordinate=f"{frame}.{ANGLE}")] if ANGLE in attributes else []
    return [*found, *([Piece("ball", coordinate=f"{frame}.{FLOATING}")] if FLOATING in attributes else [])]


def _needed(writing: Writing, ways: list[Way]) -> list[Way]:
    """Without fixed parts that lead to where nothing is."""
    used = {writing.node(body.frame) for body in writing.stated.bodies} | {"world"}
    used |= {writing.node(name) for what in writing.reading.known.values() if what.kind not in ("coordinate", "input")
             for name in (what.of[:1] if what.kind == "spin" else what.of)}
    used |= {writing.node(frame) for _, frame in writing.stated.torques}
    while True:
        count = Counter(writing.node(end) for way in ways for end in (way.first, way.last))
        left = [way for way in ways if any(piece.moves for piece in way.pieces)
                or all(count[writing.node(end)] > 1 or writing.node(end) in used for end in (way.first, way.last))]
        if len(left) == len(ways):
            return ways
        ways = left


__all__ = ["Starts", "write_multibody"]
