"""Text of a Modelica model of components of MultiBody: parts, the nodes that they are joined at, names, formulas.

Frames that are the same are one node, to which connectors are joined.
"""

from collections.abc import Mapping, Sequence

from lagrangia.algebra.with_sympy import TIME, Expr, exact_throughout
from lagrangia.base.records import dataclass
from lagrangia.frames.edges import Closure
from lagrangia.frames.graph import ComponentGraph
from lagrangia.language.flat import FrameEquation
from lagrangia.paper.modelica import RESERVED, Printer, identifier
from lagrangia.paper.multibody_forces import Quantity, Reading, Stated, padded, refuse
from lagrangia.paper.multibody_joints import Piece

LIBRARY = "Modelica.Mechanics.MultiBody"


@dataclass(frozen=True)
class Starts:
    """Values of coordinates and rates at the start, attitudes as quaternions; `free` are coordinates that nothing else gives
    there; `planar` are loops of which three equations repeat others, as of all in the plane."""

    values: Mapping[str, float]
    free: frozenset[str]
    planar: tuple[Closure, ...]


@dataclass(frozen=True)
class Way:
    """What an equation of frames says: pieces from one frame to another, as a component's or a frame's own."""

    first: str
    last: str
    pieces: tuple[Piece, ...]
    owner: str
    equation: FrameEquation | None = None


class Writing:
    """Parts, what joins them, and names."""

    def __init__(self, reading: Reading, graph: ComponentGraph, starts: Starts, stated: Stated) -> None:
        self.reading, self.graph, self.starts, self.stated = reading, graph, starts, stated
        self.taken = {*RESERVED, "world", "Modelica"}
        self.parts: list[str] = []
        self.equations: list[str] = []
        self.initial: list[str] = []
        self.leader: dict[str, str] = {}
        self.connectors: dict[str, list[str]] = {}
        self.motion: dict[str, tuple[str, str]] = {}  # of coordinates: place and rate
        self.flanges: dict[str, str] = {}  # of coordinates: the joint that can be driven
        self.lengths: dict[tuple[str, ...], str] = {}  # of pairs of frames: the part that knows their distance
        self.names: dict[str, str] = {}  # of parameters
        self.inputs: dict[str, str] = {}
        self.told: set[str] = set()  # outputs that are written
        self.stated_starts = {} if graph.closures or graph.model.initial_equations else {
            name: start for c in graph.coordinates for name, start in ((c.name, c.start), (c.rate_name, c.rate_start))
            if start is not None}
        self.printer = Printer()
        self.bodies = {(body.component, body.frame): self.name(body.component or body.frame) for body in stated.bodies}
        self.driven = {what.of[0] for _, what in stated.forces if what.kind == "coordinate"}
        acting = [*stated.forces.values(), *(x for torque in stated.torques.values() for x in torque)]
        self.read = {reading.known[s].of[0] for x in acting for s in x.free_symbols & reading.known.keys()
                     if reading.known[s].kind == "coordinate"}  # by forces

    # ------------------------------------------------------------ names, formulas

    def name(self, wanted: str) -> str:
        """An identifier of Modelica that nothing else has."""
        found = identifier(wanted)
        while found in self.taken:
            found += "_"
        self.taken.add(found)
        return found

    def code(self, x: Expr) -> str:
        """A formula in Modelica's words."""
        x, known = exact_throughout(x), {}
        for s in sorted(x.free_symbols, key=str):
            if s in self.reading.known:
                known[s] = self._text(self.reading.known[s])
            elif s != TIME:
                name = str(s)
                known[s] = "world.g" if name == "world.gravity" else self.names.get(name) or self._parameter(name)
        renamed = x.xreplace({s: type(s)(text, real=True) for s, text in known.items()})
        return str(self.printer.doprint(renamed))

    def start(self, label: str) -> str:
        """Of a coordinate or a rate: as the scene states it by parameters, where nothing else decides; else its number."""
        if label in self.stated_starts:
            stated = exact_throughout(self.reading.evaluator.value(self.stated_starts[label]))
            if stated.free_symbols:
                return self.code(stated)
        return repr(self.starts.values[label])

    def _parameter(self, name: str) -> str:
        self.names[name] = self.name(name)
        formula = self.reading.table.parameters[name].formula
        if formula is not None:
            self.code(formula)  # whose parameters are declared, too
        return self.names[name]

    def _text(self, what: Quantity) -> str:
        if what.kind == "input":
            return self.inputs[what.of[0]]
        if what.order < 2:
            if what.kind == "coordinate" and what.of[0] in self.motion:
                return self.motion[what.of[0]][what.order]
            if what.kind == "distance" and what.of in self.lengths:
                return _rate(f"{self.lengths[what.of]}.length", what.order)
            if what.kind == "place":
                return _rate(f"{self.connector(what.of[0])}.r_0[{what.place[0] + 1}]", what.order)
            if what.kind == "spin":
                frame, k = self.connector(what.of[0]), what.place[0] + 1
                world = " + ".join(f"{frame}.R.T[{i}, {k}]*{frame}.R.w[{i}]" for i in (1, 2, 3))
                return f"{frame}.R.w[{k}]" if what.of[1] == "omega" else f"({world})"
            if what.kind == "axes":
                i, j = what.place
                return f"{self.connector(what.of[0])}.R.T[{j + 1}, {i + 1}]"
        refuse(f"a force that reads the {what.kind} of '{' '.join(what.of)}'", self.reading.model.span)

    def vector(self, items: Sequence[Expr]) -> str:
        """{x, y, z}."""
        return "{" + ", ".join(self.code(x) for x in padded(items)) + "}"

    # ------------------------------------------------------------ nodes

    def node(self, frame: str) -> str:
        """The frame that stands for all that are the same."""
        while (ahead := self.leader.get(frame, frame)) != frame:
            frame = ahead
        return "world" if frame in self.reading.model.frames and self.reading.model.frames[frame].is_ground else frame

    def connector(self, frame: str) -> str:
        """One of its connectors. Raises LagError L0901 where nothing is there."""
        found = self.connectors.get(self.node(frame))
        if not found:
            refuse(f"a force at '{frame}', where no part is,", self.reading.model.frames[frame].span)
        return found[0]

    def attach(self, connector: str, frame: str) -> None:
        """Joins a connector to what is at a frame."""
        self.connectors.setdefault(self.node(frame), []).append(connector)

    def part(self, kind: str, name: str, *given: str) -> str:
        """Declares a part; `kind` within the library, or a full name. Returns its name."""
        where = kind if kind.startswith("Modelica.") else f"{LIBRARY}.{kind}"
        told = f"({', '.join(given)})" if given else ""
        self.parts.append(f"  {where} {name}{told};")
        return name

    @property
    def gravity(self) -> list[Expr]:
        """As formulas read it."""
        return padded(self.reading.evaluator.variable("world.gravity", 0, self.reading.model.span))


def _rate(text: str, order: int) -> str:
    return f"der({text})" if order else text
