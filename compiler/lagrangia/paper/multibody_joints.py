"""Equations of frames -> joints and fixed parts of Modelica.Mechanics.MultiBody, as they lead from frame to frame."""

from collections.abc import Collection, Sequence

import sympy as sp

from lagrangia.algebra.with_sympy import TIME, Expr, exact_throughout
from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.frames.evaluation import scalars_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.tree import Ref
from lagrangia.paper.multibody_forces import Reading, padded, refuse

Vector = tuple[Expr, ...]
ALONG = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


@dataclass(frozen=True)
class Piece:
    """A part of the way: "shift" by a fixed vector, "turn" by a fixed angle about it, "slider" or "hinge" of a coordinate along
    or about it, or "ball" of an attitude. An inverse one is passed from its second side to its first."""

    kind: str
    vector: Vector = ()
    angle: Expr = sp.S.Zero
    coordinate: str = ""
    is_inverse: bool = False

    @property
    def moves(self) -> bool:
        """Whether it has a freedom."""
        return self.kind not in ("shift", "turn")


def pieces_of(reading: Reading, steps: Sequence[Step], span: Span, told: str) -> list[Piece]:
    """Raises LagError L0901 for what moves otherwise."""
    found: list[Piece] = []
    for step in steps:
        own = _ball(reading, step) or (_shift(reading, step, span, told) if step.kind == "shift"
                                       else _turn(reading, step, span, told))
        found += reversed(own) if step.is_inverse else own
    return found


def _ball(reading: Reading, step: Step) -> list[Piece] | None:
    amount = step.amount
    is_ball = isinstance(amount, Ref) and reading.model.variables[amount.name].is_attitude
    return [Piece("ball", coordinate=amount.name, is_inverse=step.is_inverse)] if is_ball and isinstance(amount, Ref) else None


def _shift(reading: Reading, step: Step, span: Span, told: str) -> list[Piece]:
    vector = padded(scalars_of(reading.evaluator.value(step.amount)))
    moving = _moving(reading, vector, span, told)
    still = [x.xreplace(dict.fromkeys(moving, sp.S.Zero)) for x in vector]
    found = [Piece("shift", tuple(still), is_inverse=step.is_inverse)] if any(x != 0 for x in still) else []
    for s in moving:
        along = tuple(sp.simplify(x.diff(s)) for x in vector)
        if any(x.has(*moving) for x in along) or not _is_unit(along):
            refuse(f"the way of {told}, which is no straight slider's,", span)
        found.append(Piece("slider", along, sp.S.Zero, reading.known[s].of[0], step.is_inverse))
    return found


def _turn(reading: Reading, step: Step, span: Span, told: str) -> list[Piece]:
    axis = ALONG[2] if step.axis is None else scalars_of(reading.evaluator.value(step.axis))
    n, angle = tuple(padded(axis)), exact_throughout(reading.evaluator.value(step.amount))
    moving = _moving(reading, [angle], span, told)
    still = angle.xreplace(dict.fromkeys(moving, sp.S.Zero))
    found = [Piece("turn", n, still, is_inverse=step.is_inverse)] if still != 0 else []
    for s in moving:
        if (side := angle.diff(s)) not in (1, -1):
            refuse(f"the turn of {told}, which is no hinge's,", span)
        found.append(Piece("hinge", tuple(side * x for x in n), sp.S.Zero, reading.known[s].of[0], step.is_inverse))
    return found


def _moving(reading: Reading, amounts: Sequence[Expr], span: Span, told: str) -> list[Expr]:
    """The coordinates in it, in the order of their names."""
    named = {s for x in amounts for s in x.free_symbols}
    found = sorted(named & reading.known.keys(), key=lambda s: [str(x.diff(s)) for x in amounts], reverse=True)
    if TIME in named or any(reading.known[s].kind != "coordinate" for s in found):
        refuse(f"what moves {told} in time", span)
    return found


def _is_unit(vector: Vector) -> bool:
    return bool(sp.simplify(sum(x**2 for x in vector)) == 1)


def merged(pieces: Sequence[Piece]) -> list[Piece]:
    """Without what moves by nothing."""
    return [piece for piece in pieces if piece.moves or any(x != 0 for x in piece.vector)]


def grouped(pieces: Sequence[Piece], driven: Collection[str]) -> list[tuple[Piece, ...]]:
    """Those that one part of the library is, together: none of a driven coordinate, which needs a joint of its own."""
    found, at = list[tuple[Piece, ...]](), 0
    while at < len(pieces):
        sizes = (size for size in (4, 3, 2) if _is_part(pieces[at : at + size], size, driven))
        size = next(sizes, 1)
        found.append(tuple(pieces[at : at + size]))
        at += size
    return found


def _is_part(pieces: Sequence[Piece], size: int, driven: Collection[str]) -> bool:
    if len(pieces) < size or any(piece.is_inverse or piece.coordinate in driven for piece in pieces):
        return False
    kinds, axes = tuple(piece.kind for piece in pieces), tuple(piece.vector for piece in pieces)
    match kinds:
        case ("slider", "slider", "slider", "ball"):
            return axes[:3] == ALONG
        case ("slider", "slider", "hinge"):
            return axes == ALONG
        case ("slider", "hinge"):
            along, about = (sp.Matrix(axis) for axis in axes)
            return all(sp.simplify(x) == 0 for x in along / along.norm() - about / about.norm())  # not against it
        case ("hinge", "hinge"):
            return bool(sp.simplify(sp.Matrix(axes[0]).dot(sp.Matrix(axes[1]))) == 0)
        case ("shift", "turn"):
            return True
    return False
