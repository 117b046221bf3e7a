"""Ways between frames -> parts of Modelica.Mechanics.MultiBody with their starts, joined one behind the other."""

import math
from collections.abc import Sequence

import sympy as sp

from lagrangia.base.diagnostics import Span
from lagrangia.frames.edges import Closure
from lagrangia.paper.multibody_forces import refuse
from lagrangia.paper.multibody_joints import Piece, grouped
from lagrangia.paper.multibody_writing import Way, Writing

_FRAMES = "Modelica.Mechanics.MultiBody.Frames"
# Joints of several coordinates: their class, and for each coordinate its place and its rate.
_SEVERAL = {
    ("slider", "slider", "hinge"): ("Joints.Planar", (("s_x", "v_x"), ("s_y", "v_y"), ("phi", "w"))),
    ("slider", "hinge"): ("Joints.Cylindrical", (("s", "v"), ("phi", "w"))),
    ("hinge", "hinge"): ("Joints.Universal", (("phi_a", "w_a"), ("phi_b", "w_b"))),
}


def walk(writing: Writing, way: Way, is_planar_cut: bool) -> None:
    """Declares the parts of a way, and joins them."""
    groups = grouped(way.pieces, writing.driven)
    moving = [group for group in groups if group[0].moves]
    last = ""
    for group in groups:
        own = way.owner if len(moving) <= 1 or not group[0].moves else f"{way.owner}_{group[0].coordinate.rpartition('.')[2]}"
        name = writing.name(own if group[0].moves or not moving else f"{own}_place")
        _declare(writing, group, name, is_planar_cut)
        ends = (f"{name}.frame_a", f"{name}.frame_b")
        first, after = ends[::-1] if group[0].is_inverse else ends
        if last:
            writing.equations.append(f"  connect({last}, {first});")
        else:
            writing.attach(first, way.first)
        last = after
    writing.attach(last, way.last)


def _declare(writing: Writing, group: Sequence[Piece], name: str, is_planar_cut: bool) -> None:
    kinds, first = tuple(piece.kind for piece in group), group[0]
    if kinds[-1] == "ball":
        _declare_ball(writing, group, name)
    elif kinds in _SEVERAL:
        kind, names = _SEVERAL[kinds]
        one, other = writing.vector(first.vector), writing.vector(group[-1].vector)
        axes = {"Joints.Planar": [f"n = {other}", f"n_x = {one}"], "Joints.Cylindrical": [f"n = {one}"]}
        n = axes.get(kind) or [f"n_a = {one}", f"n_b = {other}"]
        starts = [text for piece, pair in zip(group, names, strict=True) for text in _started(writing, piece, name, pair)]
        writing.part(kind, name, *n, *starts)
    elif first.kind in ("hinge", "slider"):
        kind, pair = ("Joints.Revolute", ("phi", "w")) if first.kind == "hinge" else ("Joints.Prismatic", ("s", "v"))
        axis, is_driven = f"n = {writing.vector(first.vector)}", first.coordinate in writing.driven
        if is_planar_cut and first.kind == "hinge":
            writing.part("Joints.RevolutePlanarLoopConstraint", name, axis)
            return
        writing.flanges[first.coordinate] = name
        writing.part(kind, name, axis, *(["useAxisFlange = true"] if is_driven else []), *_started(writing, first, name, pair))
    elif kinds == ("shift",):
        writing.part("Parts.FixedTranslation", name, f"r = {writing.vector(first.vector)}")
    else:
        turn, place = group[-1], [f"r = {writing.vector(first.vector)}"] if len(group) == 2 else []
        writing.part("Parts.FixedRotation", name, *place, f"n = {writing.vector(turn.vector)}",
                     f"angle = {writing.code(turn.angle * 180 / sp.pi)}")


def _started(writing: Writing, piece: Piece, name: str, pair: tuple[str, str]) -> list[str]:
    """Modifications of a place and its rate by their starts."""
    writing.motion[piece.coordinate] = f"{name}.{pair[0]}", f"{name}.{pair[1]}"
    fixed = ", fixed = true" if piece.coordinate in writing.starts.free else ""
    known = zip(pair, (piece.coordinate, f"der({piece.coordinate})"), strict=True)
    return [f"{own}(start = {writing.start(label)}{fixed})" for own, label in known if label in writing.starts.values]


def _declare_ball(writing: Writing, group: Sequence[Piece], name: str) -> None:
    """A ball joint, or free motion: its attitude by three angles, its spin in the axes that it turns against."""
    ball, values = group[-1], writing.starts.values
    S = ball.coordinate
    quaternion = [values[f"{S}[{k}]"] for k in (1, 2, 3, 4)]
    R = matrix(quaternion)
    w = [values[f"der({S})[{k}]"] for k in (1, 2, 3)]
    spin = [sum(x * y for x, y in zip(row, w, strict=True)) for row in R]
    free = [k for k in range(3) if f"{S}.s[{k + 1}]" in writing.starts.free]
    is_free = len(free) == 3
    given = [f"angles_start = {numbers(angles(R))}", f"w_rel_a_start = {numbers(spin)}"]
    given += ["angles_fixed = true", "w_rel_a_fixed = true"] if is_free else []
    if len(group) == 1:
        writing.part("Joints.Spherical", name, *(["enforceStates = true"] if is_free else []), *given)
    else:
        places = [(values[p.coordinate], values[f"der({p.coordinate})"]) for p in group[:-1]]
        fixed = {p.coordinate in writing.starts.free for p in group[:-1]}
        told = ", fixed = {true, true, true}" if fixed == {True} else ""
        writing.part("Joints.FreeMotion", name, *(f"{own}(start = {numbers([place[k] for place in places])}{told})"
                                                  for k, own in enumerate(("r_rel_a", "v_rel_a"))), *given)
        if fixed == {True, False}:
            writing.initial += [f"  {name}.{own}[{k + 1}] = {place[order]!r};" for k, (p, place) in enumerate(
                zip(group[:-1], places, strict=True)) if p.coordinate in writing.starts.free
                for order, own in enumerate(("r_rel_a", "v_rel_a"))]
    if free and not is_free:
        _start_in_part(writing, name, free, w)


def _start_in_part(writing: Writing, name: str, free: Sequence[int], w: Sequence[float]) -> None:
    """Of an attitude that a loop leaves less than three freedoms: those of its axes that nothing else gives."""
    gap, spin = writing.name(f"{name}_gap"), writing.name(f"{name}_spin")
    turned = f"{_FRAMES}.absoluteRotation({name}.frame_a.R, {name}.R_rel_start)"
    writing.parts += [f'  Real {gap}[3] "what {name} is turned from its start";', f'  Real {spin}[3] "its spin in its own axes";']
    writing.equations += [
        f"  {gap} = {_FRAMES}.Orientation.equalityConstraint({turned}, {name}.frame_b.R);",
        f"  {spin} = {_FRAMES}.angularVelocity2({name}.frame_b.R) - {_FRAMES}.resolve2({name}.frame_b.R, "
        f"{_FRAMES}.angularVelocity1({name}.frame_a.R));"]
    writing.initial += [text for k in free for text in (f"  {gap}[{k + 1}] = 0;", f"  {spin}[{k + 1}] = {w[k]!r};")]


def numbers(values: Sequence[float]) -> str:
    """{x, y, z}."""
    return "{" + ", ".join(repr(float(x)) for x in values) + "}"


def matrix(quaternion: Sequence[float]) -> list[list[float]]:
    """R, (3, 3), of a unit quaternion."""
    a, x, y, z = quaternion
    return [[a*a + x*x - y*y - z*z, 2*(x*y - a*z), 2*(x*z + a*y)], [2*(x*y + a*z), a*a - x*x + y*y - z*z, 2*(y*z - a*x)],
            [2*(x*z - a*y), 2*(y*z + a*x), a*a - x*x - y*y + z*z]]


def angles(R: Sequence[Sequence[float]]) -> tuple[float, float, float]:
    """About x, then y, then z as they have moved, rad."""
    b = math.asin(max(-1.0, min(1.0, R[0][2])))
    if math.hypot(R[0][0], R[0][1]) < 1e-12:  # x and z are the same axis
        return math.atan2(R[2][1], R[1][1]), b, 0.0
    return math.atan2(-R[1][2], R[2][2]), b, math.atan2(-R[0][1], R[0][0])


def planar_cuts(writing: Writing, ways: Sequence[Way]) -> set[int]:
    """The ids of the ways whose hinge closes a loop in its plane. Raises LagError L0901 for loops that have no hinge for it."""
    found: set[int] = set()
    by_span = {way.equation.span: way for way in ways if way.equation is not None}
    for closure in writing.starts.planar:
        around = [by_span[span] for span in (closure.span, *_spans(writing, closure)) if span in by_span]
        way = next((way for way in around if id(way) not in found and _can_cut(writing, way)), None)
        if way is None:
            refuse(f"the loop {closure.around}, none of whose joints is a hinge that nothing drives and that others give,",
                   closure.span)
        found.add(id(way))
    return found


def _spans(writing: Writing, closure: Closure) -> list[Span]:
    """Of the edges on both sides of a loop, from where it closes."""
    found, sides = list[Span](), list[list[Span]]()
    for end in (closure.a, closure.b):
        frame, side = end, list[Span]()
        while frame in writing.graph.edge_to:
            edge = writing.graph.edge_to[frame]
            side.append(edge.span)
            frame = edge.parent
        sides.append(side)
    for side, other in (sides, sides[::-1]):
        found += [span for span in side if span not in other]
    return found


def _can_cut(writing: Writing, way: Way) -> bool:
    moving = [piece for piece in way.pieces if piece.moves]
    kept = writing.driven | writing.starts.free | writing.read
    return len(moving) == 1 and moving[0].kind == "hinge" and moving[0].coordinate not in kept
