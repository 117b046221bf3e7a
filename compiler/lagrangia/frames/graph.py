"""FlatModel -> ComponentGraph: frames are nodes, frame equations are edges usable in both directions.

The spanning tree starts at the ground; a part of the graph that carries mass but is joined to no ground floats, with
coordinates of its own; a part without mass is an error, or is left out when nothing uses it.
"""

from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import field
from functools import cached_property

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.frames.attitude_starts import FLOATING, Attitude, element, of_frame, of_variable
from lagrangia.frames.edges import Closure, Edge, choose_tree, close, close_in_space
from lagrangia.frames.planes import NoPlane, Plane
from lagrangia.frames.unbound_hints import hint_in_a_row, hint_of_equation
from lagrangia.language.attitudes import parts_of
from lagrangia.language.consequences import keep_consequences_out
from lagrangia.language.flat import FlatModel, Frame, FrameEquation, rate_of
from lagrangia.language.frame_attributes import Space, reading, reads_angle
from lagrangia.language.frame_steps import Step, between
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Call, Flat, FrameRef, Number, Ref, Time

_MOST_NAMES, _ENDS = 12, 4  # of the components along a loop that are told


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A coordinate with what is declared of its start."""

    name: str
    unit: str
    display_unit: str
    start: Flat | None
    rate_start: Flat | None
    is_fixed: bool
    description: str
    span: Span
    is_rate_fixed: bool = False
    state: str = ""  # the first-order state that is its rate
    attitude: str = ""  # of which it is a part
    part: int = 0  # from 1 on

    @property
    def has_start(self) -> bool:
        """Whether anything is said about where it begins, or how fast."""
        return self.start is not None or self.rate_start is not None or self.is_fixed or self.is_rate_fixed

    @property
    def rate_name(self) -> str:
        """As it is written in models and results."""
        return self.state or (f"der({self.attitude})[{self.part}]" if self.attitude else f"der({self.name})")


@dataclass(frozen=True, slots=True)
class Root:
    """The root of a tree of frames: the ground, or a floating frame with its coordinates in the order of `attributes`."""

    frame: str
    attributes: tuple[str, ...] = ()  # the names of components of its place

    @property
    def is_ground(self) -> bool:
        """Whether it is fixed to the world."""
        return not self.attributes


@dataclass(frozen=True)
class ComponentGraph:
    """Frames as nodes, joints and other components as edges; spanning trees, and what closes loops."""

    model: FlatModel
    roots: tuple[Root, ...]
    edges: tuple[Edge, ...]  # of the spanning trees, parents first
    closures: tuple[Closure, ...]  # the edges outside the trees
    coordinates: tuple[Coordinate, ...]
    cut_coordinates: Mapping[str, Closure]  # of cut joints, read off the frames
    unused_frames: tuple[str, ...]
    lost_coordinates: tuple[Coordinate, ...] = ()  # those of the cut joints
    dependent_coordinates: tuple[Coordinate, ...] = ()  # given by linear constraints
    attitudes: Mapping[str, Attitude] = field(default_factory=dict)  # of which coordinates are parts
    plane: Plane | NoPlane | None = None  # of a scene in space: that in which all of it moves, once it was looked for

    @cached_property
    def kept_coordinates(self) -> frozenset[str]:
        """Those of cut joints in space, which move no body: each has a constraint of its own."""
        kept = {part for cut in self.closures if cut.kept for part in (parts_of(cut.kept) if cut.kind == "ball" else (cut.kept,))}
        return frozenset(kept | {cut.ahead_kept for cut in self.closures if cut.ahead_kept})

    @cached_property
    def edge_to(self) -> Mapping[str, Edge]:
        """By the frames that they lead to."""
        return {edge.child: edge for edge in self.edges}

    @cached_property
    def has_inner_loops(self) -> bool:
        """Whether the two sides of some loop part at a frame that moves."""
        ground = {root.frame for root in self.roots if root.is_ground}
        return any(self._moving_at(cut.a) & self._moving_at(cut.b) for cut in self.closures) or any(
            self._root_of(cut.a) not in ground for cut in self.closures)

    def _moving_at(self, frame: str) -> set[str]:
        """What is led to by edges that move, on the way from the root."""
        found = set()
        while frame in self.edge_to:
            edge = self.edge_to[frame]
            found |= set() if edge.is_rigid else {frame}
            frame = edge.parent
        return found

    def _root_of(self, frame: str) -> str:
        while frame in self.edge_to:
            frame = self.edge_to[frame].parent
        return frame

    @property
    def lies_in_plane(self) -> bool:
        """Whether all of a scene in space moves in parallel planes, and has their equations."""
        return isinstance(self.plane, Plane)

    def summary(self) -> str:
        """Counts, and a line for each root, edge and closure."""
        lines = [f"{len(self.model.frames)} frames, {len(self.edges)} edges, {len(self.roots)} trees"]
        for root in self.roots:
            lines.append(f"root {root.frame}" + ("" if root.is_ground else f" floats: {', '.join(root.attributes)}"))
        for edge in self.edges:
            how = ", ".join(f"{'back ' if s.is_inverse else ''}{s.kind} {s.amount.span.text}" for s in edge.steps) or "same"
            lines.append(f"{edge.parent} -> {edge.child}: {how}")
        for cut in self.closures:
            freedom = f", coordinate {cut.coordinate}" if cut.coordinate else ""
            lines.append(f"{cut.a} = {cut.b} closes a loop ({cut.kind}){freedom}")
        lines += [f"coordinate {c.name} [{c.unit}]" for c in self.coordinates]
        lines += [f"left out {name}" for name in self.unused_frames]
        return "\n".join(lines)


def build_graph(model: FlatModel, plane: Plane | None = None) -> ComponentGraph:
    """`plane`: that in which a scene in space moves. Raises LagError (L04xx): ports joined to nothing, joints that depend on
    frames."""
    return _Building(model, plane).build()


class _Building:
    def __init__(self, model: FlatModel, plane: Plane | None) -> None:
        self.model, self.plane = model, plane
        self.report = Report()
        self.bindings = {name: v.binding for name, v in model.variables.items()}
        self.candidates: list[Edge] = []
        self.turning: set[str] = set()  # declared attitudes that turn frames
        self.attitudes: dict[str, Attitude] = {}
        self.neighbours: dict[str, list[Edge]] = {name: [] for name in model.frames}
        self.parent: dict[str, str] = {}
        self.edges: list[Edge] = []

    def build(self) -> ComponentGraph:
        keep_consequences_out(self.model, self.report)
        for equation in self.model.frame_equations:
            self._add_edge(equation)
        outside = self._choose_tree()
        massive = self._massive_frames()
        used = self._used_frames(massive)
        roots = [Root(name) for name, frame in self.model.frames.items() if frame.is_ground]
        for root in roots:
            self._grow(root.frame)
        unused, floating = list[str](), list[Root]()
        for island in self._islands():
            if island & massive.keys():
                root = self._floating_root(island, massive, used)
                floating.append(root)
                self._grow(root.frame)
            elif island & used.keys():
                self._report_unbound(island, used)
            else:
                unused += sorted(island)
        self.report.raise_errors()
        closures = self._closures(outside, set(unused))
        cut = {closure.coordinate: closure for closure in closures if closure.coordinate}
        found = self._coordinates(floating)
        coordinates, lost = (tuple(c for c in found if (c.name in cut) == is_lost) for is_lost in (False, True))
        self.report.raise_errors()
        return ComponentGraph(self.model, (*roots, *floating), tuple(self.edges), closures, coordinates, cut, tuple(unused), lost,
                              attitudes=self.attitudes, plane=self.plane)

    # ------------------------------------------------------------ edges

    def _add_edge(self, equation: FrameEquation) -> None:
        right, left, steps = between(equation.left, equation.right)
        if not steps:
            if left != right:
                self.candidates.append(Edge(right, left, (), (), False, equation.span))
            return
        coordinates, moves_with_time = dict[str, None](), False
        for leaf in leaves([step.amount for step in steps], self.bindings):
            if isinstance(leaf, FrameRef):
                fail("L0402", f"a joint's shift or turn cannot depend on the frame '{leaf.name}'", equation.span)
            variable = self.model.variables.get(leaf.name) if isinstance(leaf, Ref) else None
            if isinstance(leaf, Time) or (variable is not None and variable.kind == "input"):
                moves_with_time = True
            elif variable is not None and variable.is_attitude:
                self.turning.add(variable.name)
                coordinates |= dict.fromkeys(parts_of(variable.name))
            elif variable is not None and variable.kind == "coordinate":
                coordinates[variable.name] = None
        self._require_steady_axes(steps, equation.span)
        self.candidates.append(Edge(right, left, steps, (*coordinates,), moves_with_time, equation.span))

    def _require_steady_axes(self, steps: tuple[Step, ...], span: Span) -> None:
        """An axis that moves in its own frame would turn by more than the angle says."""
        axes = [step.axis for step in steps if step.axis is not None]
        for leaf in leaves(axes, self.bindings) if axes else ():
            variable = self.model.variables.get(leaf.name) if isinstance(leaf, Ref) else None
            if variable is None or variable.kind not in ("parameter", "variable"):
                fail("L0402", "the axis of a turn is fixed in the frame that it begins at: it depends on parameters alone", span,
                     "turn first to where the axis points, then about it: turn(turn(a, alpha), phi, {1, 0, 0})")

    def _grow(self, root: str) -> None:
        """Breadth first from the root."""
        self.parent[root] = ""
        queue = deque([root])
        while queue:
            here = queue.popleft()
            for edge in self.neighbours[here]:
                ahead = edge if edge.parent == here else edge.inverse()
                if ahead.child not in self.parent:
                    self.parent[ahead.child] = here
                    self.edges.append(ahead)
                    queue.append(ahead.child)

    def _choose_tree(self) -> list[Edge]:
        """Makes neighbours of what the tree's edges join; returns the other edges."""
        ground = [name for name, frame in self.model.frames.items() if frame.is_ground]
        self.uses = Counter(name for edge in self.candidates for name in edge.coordinates)
        sides = [side for equation in self.model.constraints for side in (equation.left, equation.right)]
        tied = {leaf.name for leaf in leaves(sides, self.bindings) if isinstance(leaf, Ref)}
        chosen = choose_tree(self.model.frames, tuple(self.candidates), ground, self.uses, tied, self._started())
        for k in sorted(chosen):
            edge = self.candidates[k]
            self.neighbours[edge.parent].append(edge)
            self.neighbours[edge.child].append(edge)
        return [edge for k, edge in enumerate(self.candidates) if k not in chosen]

    def _started(self) -> set[str | None]:
        """Coordinates that something is said about where they begin, or how fast."""
        stated = [node for e in self.model.initial_equations for node in (e.left, e.right)]
        named = {node.arguments[0] if isinstance(node, Call) and node.function == "der" else node for node in stated}
        said = {node.name for node in named if isinstance(node, Ref)}
        said |= {name for name, v in self.model.variables.items() if v.start is not None or v.is_fixed}
        return {rate_of(v) if v.kind != "coordinate" else name for name in said if (v := self.model.variables.get(name))}

    def _closures(self, outside: list[Edge], unused: set[str]) -> tuple[Closure, ...]:
        """The edges outside the tree close loops, unless they only say again what identities of frames say."""
        same = _Same()
        for edge in self.edges:
            if not edge.steps:
                same.join(edge.parent, edge.child)
        news = [e for e in outside if e.parent not in unused and (e.steps or same.find(e.parent) != same.find(e.child))]
        found = []
        for edge in news:
            around, base = self._loop(edge)
            told = " - ".join(_shortened(around))
            is_spatial = self.model.space.is_spatial and self.plane is None
            found.append(close_in_space(edge, self.uses, told, base) if is_spatial else close(edge, self.uses, told))
        return tuple(found)

    def _loop(self, edge: Edge) -> tuple[list[str], str]:
        """Components along the loop that an edge closes, and the frame where its sides part."""
        ways = []
        for end in (edge.parent, edge.child):
            way = [end]
            while self.parent[way[-1]]:
                way.append(self.parent[way[-1]])
            ways.append(way)
        while len(ways[0]) > 1 and ways[0][-2:] == ways[1][-2:]:
            ways = [way[:-1] for way in ways]
        around = [name.rpartition(".")[0] or name for name in (*reversed(ways[0]), *ways[1])]
        return [name for name, before in zip(around, ["", *around], strict=False) if name != before], ways[0][-1]

    # ------------------------------------------------------------ islands

    def _islands(self) -> list[set[str]]:
        """Sets of frames joined to each other and not to the ground, in the order of declaration."""
        islands, seen = [], set(self.parent)
        for start in self.model.frames:
            if start in seen:
                continue
            island, queue = {start}, deque([start])
            while queue:
                here = queue.popleft()
                for edge in self.neighbours[here]:
                    for end in (edge.parent, edge.child):
                        if end not in island:
                            island.add(end)
                            queue.append(end)
            seen |= island
            islands.append(island)
        return islands

    def _massive_frames(self) -> dict[str, set[str]]:
        """Frames whose motion some kinetic term measures, with the attributes it reads."""
        return self._read_frames([e.value for e in self.model.energies if e.kind == "kinetic"])

    def _used_frames(self, massive: Mapping[str, set[str]]) -> dict[str, set[str]]:
        """Those, and what else is read of frames."""
        model = self.model
        roots: list[Flat] = [e.value for e in model.energies if e.kind != "kinetic"]
        roots += [x for w in model.works for x in (w.force, w.position)]
        roots += [x for e in (*model.initial_equations, *model.constraints) for x in (e.left, e.right)]
        roots += model.looks()
        roots += [v.binding for v in model.variables.values() if v.is_output and v.binding is not None]
        found = self._read_frames(roots)
        return found | {name: found.get(name, set()) | attributes for name, attributes in massive.items()}

    def _read_frames(self, roots: list[Flat]) -> dict[str, set[str]]:
        read: dict[str, set[str]] = {}
        for leaf in leaves(roots, self.bindings):
            if isinstance(leaf, FrameRef):
                read.setdefault(leaf.name, set()).add(leaf.attribute)
        return read

    def _floating_root(self, island: set[str], massive: dict[str, set[str]], used: dict[str, set[str]]) -> Root:
        """The frame with given starts, else the first whose motion the kinetic energy measures.

        The angle is no coordinate when nothing depends on it, as for a point mass, be it one that carries hinges.
        """
        frames = sorted(island, key=self._order.__getitem__)
        started = [name for name in frames if self.model.frames[name].starts]
        root = (started or [name for name in frames if name in massive])[0]
        turning = self._turning_with(root)
        space = self.model.space
        has_angle = any(reads_angle(attribute, space) for name in turning for attribute in used.get(name, ())) or any(
            step.kind == "shift" for name in turning for edge in self.neighbours[name] for step in edge.steps
        )
        names = [component.name for component in space.components if has_angle or not component.is_angle]
        return Root(root, (*names, FLOATING) if has_angle and space.is_spatial else tuple(names))

    @cached_property
    def _order(self) -> dict[str, int]:
        return {name: k for k, name in enumerate(self.model.frames)}

    def _turning_with(self, root: str) -> set[str]:
        """The frames that turn with the root: in the plane not those behind hinges whose coordinates nothing but the motion
        speaks of; in space one hinge stands for no attitude."""
        found, queue, is_planar = {root}, [root], not self.model.space.is_spatial
        while queue:
            here = queue.pop()
            for edge in self.neighbours[here]:
                is_hinge = len(edge.steps) == 1 and edge.steps[0].kind == "turn" and len(edge.coordinates) == 1 and is_planar
                is_free = is_hinge and isinstance(edge.steps[0].amount, Ref) and edge.coordinates[0] not in self._spoken_of
                for end in (edge.parent, edge.child):
                    if end not in found and not (is_free and self.uses[edge.coordinates[0]] == 1):
                        found.add(end)
                        queue.append(end)
        return found

    @cached_property
    def _spoken_of(self) -> set[str]:
        """Coordinates that energies, forces, equations of the motion or events speak of."""
        model = self.model
        stated: list[Flat] = [e.value for e in model.energies] + [x for w in model.works for x in (w.force, w.position)]
        stated += [x for e in model.constraints for x in (e.left, e.right)]
        stated += model.looks()
        return {leaf.name for leaf in leaves(stated, self.bindings) if isinstance(leaf, Ref)}

    def _report_unbound(self, island: set[str], used: dict[str, set[str]]) -> None:
        frames = [self.model.frames[name] for name in self.model.frames if name in island]
        named = next((f for f in frames if f.name in used), frames[0])
        port, _, component = named.name.rpartition(".")[::-1]
        component_text = f" of {named.owner} '{component}'" if component else ""
        hint = (hint_of_equation(self.model, component)
                or f"bind it to a port, to `world` or to a place: {port} = ...; or connect({named.name}, ...)")
        others = dict.fromkeys(f"{f.owner} '{x}'" for f in frames if f.name in used
                               for x in (f.name.rpartition(".")[0],) if x and x != component)
        if component and others:
            self.report.error("L0401", f"the port '{port}'{component_text} is joined to {', '.join(others)} alone, and nothing "
                              "there has a mass or a place", named.span, hint, hint_in_a_row(self.model, named.name, island))
            return
        self.report.error("L0401", f"the port '{port}'{component_text} is joined to nothing", named.span, hint)

    # ------------------------------------------------------------ coordinates

    def _coordinates(self, floating: list[Root]) -> list[Coordinate]:
        rates, fixed_rates = self._rate_starts(), self._fixed_rates()
        found = []
        outputs = {v.name for v in self.model.variables.values() if v.is_output}  # have a column of their own
        states = {state.coordinate: name for name, state in self.model.states.items() if name not in outputs}
        for variable in self.model.variables.values():
            if variable.kind != "coordinate":
                continue
            if variable.is_attitude:
                if variable.name not in self.turning:
                    self.report.error("L0402", f"the attitude '{variable.name}' turns no frame", variable.span,
                                      "write: b = turn(a, S)")
                found += self._of_attitude(of_variable(variable, rates.get(variable.name), variable.name in fixed_rates))
                continue
            if variable.shape:
                self.report.error("L0906", f"not supported yet: the array of coordinates '{variable.name}'", variable.span,
                                  "declare an array of components with one coordinate each")
                continue
            found.append(Coordinate(variable.name, variable.unit, variable.display_unit, variable.start, rates.get(variable.name),
                                    variable.is_fixed, variable.description, variable.span, variable.name in fixed_rates,
                                    states.get(variable.name, "")))
        for root in floating:
            found += self._floating_coordinates(root)
        self._refuse_other_starts({root.frame for root in floating})
        return found

    def _of_attitude(self, attitude: Attitude) -> list[Coordinate]:
        """Three coordinates, which begin at 0: what is said of the start is where their reference begins."""
        self.attitudes[attitude.name] = attitude
        nothing, rate = Number(0.0, "rad", attitude.span), attitude.rate
        return [
            Coordinate(name, "rad", "deg", nothing, element(rate, k) if rate is not None else None, attitude.is_fixed,
                       attitude.description, attitude.span, attitude.is_rate_fixed, attitude=attitude.name, part=k)
            for k, name in enumerate(parts_of(attitude.name), 1)
        ]

    def _fixed_rates(self) -> set[str | None]:
        """`w(start = 2, fixed = true)` where w = der(phi) fixes the rate of phi."""
        return {rate_of(v) for v in self.model.variables.values() if v.is_fixed and v.kind != "coordinate"}

    def _rate_starts(self) -> dict[str, Flat]:
        """`w(start = 2)` where w = der(phi) starts the rate of phi."""
        starts = {}
        for variable in self.model.variables.values():
            if variable.start is None or variable.kind == "coordinate":
                continue
            name = rate_of(variable)
            if name is None or name not in self.bindings or self.model.variables[name].kind != "coordinate":
                if variable.kind == "variable":
                    self.report.error("L0907", f"not supported yet: a start for '{variable.name}', which is no coordinate",
                                      variable.span, f"write it as an initial equation: {variable.name} = ...;")
                continue
            starts[name] = variable.start
        return starts

    def _floating_coordinates(self, root: Root) -> list[Coordinate]:
        frame, space = self.model.frames[root.frame], self.model.space
        return [
            Coordinate(f"{root.frame}.{part.name}", part.unit, part.display_unit, _start(frame, "place", k, space),
                       _start(frame, "velocity", k, space), _is_fixed(frame, "place", k, space),
                       f"{part.words} of the floating {frame.owner}", frame.span, _is_fixed(frame, "velocity", k, space))
            for k, part in enumerate(space.components) if part.name in root.attributes
        ] + (self._of_attitude(of_frame(frame)) if FLOATING in root.attributes else [])

    def _refuse_other_starts(self, roots: set[str]) -> None:
        for frame in self.model.frames.values():
            if frame.starts and frame.name not in roots:
                self.report.error("L0907", f"not supported yet: a start for the frame '{frame.name}', which joints already place",
                                  frame.span, "start the coordinates of the joints, or write an initial equation")


class _Same:
    """Union-find over names."""

    def __init__(self) -> None:
        self.leader: dict[str, str] = {}

    def find(self, name: str) -> str:
        while (leader := self.leader.get(name, name)) != name:
            self.leader[name] = name = self.leader.get(leader, leader)  # shortens the path for who asks next
        return name

    def join(self, a: str, b: str) -> None:
        self.leader[self.find(a)] = self.find(b)


def _shortened(names: list[str]) -> list[str]:
    return names if len(names) <= _MOST_NAMES else [*names[:_ENDS], f"{len(names) - 2 * _ENDS} more", *names[-_ENDS:]]


def _start(frame: Frame, kind: str, k: int, space: Space) -> Flat | None:
    """What a frame's declaration says about the start of a component of its place or velocity."""
    for name in reading(kind, k, space):
        if name in frame.starts:
            known, start = space.attributes[name], frame.starts[name]
            return element(start, known.components.index(k) + 1) if known.is_vector else start
    return None


def _is_fixed(frame: Frame, kind: str, k: int, space: Space) -> bool:
    return not frame.fixed.isdisjoint(reading(kind, k, space))
