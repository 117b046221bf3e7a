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
from lagrangia.language.frame_attributes import ABOUT_Z, COMPONENTS
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import FrameRef
from lagrangia.paper.book import Book
from lagrangia.paper.forms import component_sub
from lagrangia.paper.layout import Name
from lagrangia.paper.parameter_symbols import ReadableEvaluator
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.symbolic import SymbolicKinematics


@dataclass(frozen=True)
class Point:
    """A frame by one of its names, in normal form: its place and velocity along the axes of the world, and how it turns: in the
    plane an angle and its rate, in space an angular velocity in its own axes."""

    frame: str
    place: tuple[Expr, ...]
    velocity: tuple[Expr, ...]
    angle: Expr | None
    spin: tuple[Expr, ...]

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
        known.setdefault(_whereabouts(book, name), []).append(name)
    moving = {place: names for place, names in known.items() if any(book.presentation.symbols.moves(x) for x in place)}
    for name in (n for n in model.frames if n.rpartition(".")[0] in bodies):
        place = _whereabouts(book, name)
        if place in moving:
            moving[place].append(name)
    found = []
    for place, names in moving.items():
        order = [(n.rpartition(".")[0] not in bodies, not n.endswith(".center"), list(model.frames).index(n), n) for n in names]
        named = min(order)[-1]
        size = model.space.dimensions
        velocity, spin = (tuple(map(tidy, map(exact_throughout, x))) for x in _rates(kinematics, named))
        found.append(Point(named, place[:size], velocity, None if model.space.is_spatial else place[size], spin))
    return found


def _whereabouts(book: Book, name: str) -> tuple[Expr, ...]:
    """The place of a frame and, behind it, how it is turned."""
    kinematics = book.equations.scene.kinematics
    if kinematics.graph.model.space.is_spatial:
        place = (*kinematics.frame(name, "r", 0), *(x for row in kinematics.frame(name, "R", 0) for x in row))
    else:
        place = kinematics.pose(name, 0).place
    return tuple(book.equations.ring.tidy(exact_throughout(x)) for x in place)


def _rates(kinematics: SymbolicKinematics, name: str) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Velocity, and angular velocity in the frame's own axes."""
    if kinematics.graph.model.space.is_spatial:
        return kinematics.frame(name, "v", 0), kinematics.frame(name, "omega", 0)
    twist = kinematics.pose(name, 1).twist
    return twist[LENGTHS], twist[ANGLES]


def _frames(book: Book, statements: "list[Energy | Work]") -> list[str]:
    model = book.equations.scene.kinematics.graph.model
    bindings = {name: v.binding for name, v in model.variables.items() if v.kind == "variable"}
    roots = [x for s in statements for x in ((s.value,) if isinstance(s, Energy) else (s.force, s.position))]
    found = [leaf.name for leaf in leaves(roots, bindings) if isinstance(leaf, FrameRef)]
    return sorted(dict.fromkeys(found), key=list(model.frames).index)


# -------------------------------------------------------------------- energies in speeds


@dataclass(frozen=True)
class Speed:
    """A component of a point's velocity, or its angle's rate: its symbol, its name with so many dots, its value. `is_spin`: of an
    angular velocity in space, which is the rate of nothing."""

    symbol: Expr
    name: Name
    value: Expr
    is_spin: bool = False


_OF_PLANE, _OF_SPACE = ("v", "w"), ("v", "omega", ABOUT_Z)


class _Speeds:
    """Leaves of an evaluator: those of the kinematics, but for velocities of frames, which are symbols."""

    def __init__(self, kinematics: SymbolicKinematics, book: Book, points: Sequence[Point]) -> None:
        self.kinematics, self.book = kinematics, book
        self.points = {p.frame: p for p in points}
        self.names = {_whereabouts(book, p.frame): p.frame for p in points}
        self.speeds: dict[Expr, Speed] = {}

    def symbol(self, name: str, level: int) -> Value | None:
        return self.kinematics.symbol(name, level)

    def time(self, level: int) -> Scalar:
        return self.kinematics.time(level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        space = self.kinematics.graph.model.space
        if level or attribute not in (_OF_SPACE if space.is_spatial else _OF_PLANE):
            return self.kinematics.frame(name, attribute, level)
        tidy, named = self.book.equations.ring.tidy, self.names.get(_whereabouts(self.book, name), name)
        sub = self.points[named].sub if named in self.points else component_sub(name.removesuffix(".center"))
        velocity, spin = (list(map(tidy, map(exact_throughout, x))) for x in _rates(self.kinematics, name))
        if attribute == "v":
            return tuple(self._speed(Name(c.name, sub, 1), x) for c, x in zip(space.components, velocity, strict=False))
        if not space.is_spatial:
            return self._speed(Name(COMPONENTS[ANGLES][0].name, sub, 1), spin[0])
        found = tuple(self._speed(spin_name(sub, k), x, is_spin=True) for k, x in enumerate(spin, 1))
        return found[2] if attribute == ABOUT_Z else found

    def _speed(self, name: Name, value: Expr, is_spin: bool = False) -> Expr:
        if value == 0 or value in self.book.equations.scene.v or not value.free_symbols:
            return value
        symbol = sp.Symbol(f"speed {name.base} {name.sub}", real=True)
        self.speeds[symbol] = Speed(symbol, name, value, is_spin)
        return symbol


def spin_name(sub: str, k: int) -> Name:
    """The k-th component of an angular velocity, in own axes."""
    return Name("omega", f"{sub} {k}")


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
