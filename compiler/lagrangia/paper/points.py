"""The points that energies and loads speak of: where they are, how fast they move, and the energies of bodies in these speeds."""

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Term
from lagrangia.frames.evaluation import Value
from lagrangia.frames.planar import ANGLES, LENGTHS
from lagrangia.language.flat import Energy, Work
from lagrangia.language.frame_attributes import COMPONENTS
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import FrameRef
from lagrangia.paper.book import Book
from lagrangia.paper.forms import component_sub
from lagrangia.paper.layout import Name
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.symbolic import ReadableEvaluator, SymbolicKinematics


@dataclass(frozen=True)
class Point:
    """A frame by one of its names, its place (x, y, phi) and twist (x', y', phi') in normal form."""

    frame: str
    place: tuple[Expr, ...]
    twist: tuple[Expr, ...]

    @property
    def sub(self) -> str:
        """Its index on paper."""
        return component_sub(self.frame.removesuffix(".center"))


def points_of(book: Book) -> list[Point]:
    """Those that move, each once; named after a body where one is there."""
    kinematics, tidy = book.equations.scene.kinematics, book.equations.ring.tidy
    model = kinematics.graph.model
    bodies = {t.component for t in book.equations.scene.energies.kinetic}
    known: dict[tuple[Expr, ...], list[str]] = {}
    for name in _frames(book, [*model.energies, *model.works]):
        place = tuple(tidy(exact_throughout(x)) for x in kinematics.pose(name, 0).place)
        known.setdefault(place, []).append(name)
    moving = {place: names for place, names in known.items() if any(book.presentation.symbols.moves(x) for x in place)}
    for name in (n for n in model.frames if n.rpartition(".")[0] in bodies):
        place = tuple(tidy(exact_throughout(x)) for x in kinematics.pose(name, 0).place)
        if place in moving:
            moving[place].append(name)
    found = []
    for place, names in moving.items():
        order = [(n.rpartition(".")[0] not in bodies, not n.endswith(".center"), list(model.frames).index(n), n) for n in names]
        named = min(order)[-1]
        twist = tuple(tidy(exact_throughout(x)) for x in kinematics.pose(named, 1).twist)
        found.append(Point(named, place, twist))
    return found


def _frames(book: Book, statements: "list[Energy | Work]") -> list[str]:
    model = book.equations.scene.kinematics.graph.model
    bindings = {name: v.binding for name, v in model.variables.items() if v.kind == "variable"}
    roots = [x for s in statements for x in ((s.value,) if isinstance(s, Energy) else (s.force, s.position))]
    found = [leaf.name for leaf in leaves(roots, bindings) if isinstance(leaf, FrameRef)]
    return sorted(dict.fromkeys(found), key=list(model.frames).index)


# -------------------------------------------------------------------- energies in speeds


@dataclass(frozen=True)
class Speed:
    """A component of a point's velocity, or its angle's rate: its symbol, its name with so many dots, its value."""

    symbol: Expr
    name: Name
    value: Expr


class _Speeds:
    """Leaves of an evaluator: those of the kinematics, but for velocities of frames, which are symbols."""

    def __init__(self, kinematics: SymbolicKinematics, book: Book, points: Sequence[Point]) -> None:
        self.kinematics, self.book = kinematics, book
        self.points = {p.place: p for p in points}
        self.speeds: dict[Expr, Speed] = {}

    def symbol(self, name: str, level: int) -> Value | None:
        return self.kinematics.symbol(name, level)

    def time(self, level: int) -> Scalar:
        return self.kinematics.time(level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        if level or attribute not in ("v", "w"):
            return self.kinematics.frame(name, attribute, level)
        tidy = self.book.equations.ring.tidy
        place = tuple(tidy(exact_throughout(x)) for x in self.kinematics.pose(name, 0).place)
        twist = [tidy(exact_throughout(x)) for x in self.kinematics.pose(name, 1).twist]
        sub = self.points[place].sub if place in self.points else component_sub(name.removesuffix(".center"))
        labels = [component.name for component in COMPONENTS]
        found = [self._speed(label, sub, x) for label, x in zip(labels, twist, strict=True)]
        return tuple(found[LENGTHS]) if attribute == "v" else found[ANGLES][0]

    def _speed(self, label: str, sub: str, value: Expr) -> Expr:
        if value == 0 or value in self.book.equations.scene.v or not value.free_symbols:
            return value
        symbol = sp.Symbol(f"speed {label} {sub}", real=True)
        self.speeds[symbol] = Speed(symbol, Name(label, sub, 1), value)
        return symbol


def in_speeds(book: Book, terms: Sequence[Term], points: Sequence[Point]) -> tuple[list[Expr], list[Speed]]:
    """Each kinetic energy in the speeds of its points, and these."""
    kinematics = book.equations.scene.kinematics
    at = _Speeds(kinematics, book, points)
    evaluator = ReadableEvaluator(kinematics.graph.model, kinematics.algebra, at)
    return [exact_throughout(evaluator.value(t.statement.value)) for t in terms], list(at.speeds.values())


def with_speeds(p: Presentation, speeds: Sequence[Speed]) -> Presentation:
    """A presentation that knows the names of speeds, too."""
    s = p.symbols
    named = dict(s.names) | {x.symbol: x.name for x in speeds}
    found = Presentation(replace(s, names=named, rates=(*s.rates, *(x.symbol for x in speeds))), p.most_products, p.ring)
    found.turned = p.turned
    return found
