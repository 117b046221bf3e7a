"""Energies, loads and equations -> warnings of those that do nothing: a force on the ground or of 0, a mass that is fixed, a
torsion spring whose two ends are one, an equation that repeats others."""

from collections.abc import Iterable, Iterator, Mapping

from lagrangia.base.diagnostics import LIBRARY, Diagnostic, Report
from lagrangia.constraints.rows import Constraints
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.joints import component_of, joints_of
from lagrangia.language.flat import Energy, FlatModel, Work
from lagrangia.language.folding import fold
from lagrangia.language.frame_attributes import is_velocity
from lagrangia.language.mentions import children, nodes, reached
from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, Ref, Unary

Statement = Energy | Work


def find_idle_statements(graph: ComponentGraph, told: Iterable[Diagnostic] = ()) -> Report:
    """L0224 for components, and for single statements of the scene itself, but where `told` speaks of them; what a joint holds
    has its weight for the reaction."""
    report, model = Report(), graph.model
    _find_lonely(graph, report)
    if not graph.coordinates:
        return report
    known, grounded = {warning.span for warning in told}, _grounded(graph)
    bindings = {name: v.binding for name, v in model.variables.items() if v.kind == "variable"}
    stated: dict[object, list[Statement]] = {}
    ends = _Ends(model, bindings)
    for k, statement in enumerate(_all(model)):
        stated.setdefault(statement.component or k, []).append(statement)
    for key, statements in stated.items():
        why, span = set[str](), statements[0].span
        for statement in statements:
            why.add(_idle(statement, model, bindings, grounded))
            if "" in why:
                break
        if isinstance(key, str) and span not in known and all(map(ends.are_one, statements)):
            report.warning("L0224", f"'{key}' does nothing: its two ends are one", span, "give it other ends, or leave it out")
        if "" in why or span in known or (isinstance(key, str) and _is_body(statements) and _carries(key, model)):
            continue
        name = f"'{key}'" if isinstance(key, str) else "this"
        report.warning("L0224", f"{name} does nothing: it speaks of {' and of '.join(sorted(why))}", span,
                       "give it another place, or leave it out")
    return report


def find_idle_equations(constraints: Constraints) -> Report:
    """L0224 for equations of people's own that remove no freedom, as others say the same."""
    report = Report()
    for row in constraints.repeated:
        if row.loop is None and not row.balanced and not row.span.source.name.startswith(LIBRARY):
            report.warning("L0224", "this equation removes nothing: others say the same", row.span, "leave it out")
    return report


class _Ends:
    """What of the places and positions that statements read is one and the same."""

    def __init__(self, model: FlatModel, bindings: Mapping[str, Flat | None]) -> None:
        self.model, self.bindings = model, bindings
        self.first: dict[str, str] = {}
        for equation in model.frame_equations:
            sides = [side.name for side in (equation.left, equation.right) if isinstance(side, FrameRef) and not side.attribute]
            if len(sides) == 2 and (one := self._frame(sides[0])) != (other := self._frame(sides[1])):
                self.first[one] = other

    def are_one(self, statement: Statement) -> bool:
        """Whether all that moves in a statement of the library is the difference of something from itself."""
        value = statement.value if isinstance(statement, Energy) else statement.position
        if not statement.span.source.name.startswith(LIBRARY) and not (isinstance(statement, Energy) and statement.is_of_library):
            return False
        if not self._has_difference(value):
            return False
        found, vanishing = list[object](), set[object]()
        for node in reached([value], self.bindings):
            if (place := self._place(node)) is not None and not (isinstance(node, Ref) and node.name in self.bindings):
                found.append(place)
            elif isinstance(node, Binary) and node.operator == "-" and (place := self._place(node.left)) is not None and (
                    place == self._place(node.right)):
                vanishing.add(place)
        return bool(found) and set(found) == vanishing and all(found.count(place) <= 2 for place in vanishing)

    def _has_difference(self, value: Flat) -> bool:
        """Most have none, which is seen in a fifth of the time."""
        seen, pending = set[str](), [value]
        while pending:
            node = pending.pop()
            if node.__class__ is Binary and node.operator == "-":
                return True
            pending += children(node)
            if node.__class__ is Ref and node.name not in seen:
                seen.add(node.name)
                if (binding := self.bindings.get(node.name)) is not None:
                    pending.append(binding)
        return False

    def _place(self, node: Flat) -> object:
        """What tells one place or coordinate from others; None for anything else."""
        while isinstance(node, Ref) and (binding := self.bindings.get(node.name)) is not None:
            node = binding
        if isinstance(node, FrameRef) and node.attribute:
            return self._frame(node.name), node.attribute, node.index
        is_moving = isinstance(node, Ref) and self.model.variables[node.name].kind == "coordinate"
        return (node.name, node.index) if is_moving and isinstance(node, Ref) else None

    def _frame(self, name: str) -> str:
        while name in self.first:
            name = self.first[name]
        return name


def _find_lonely(graph: ComponentGraph, report: Report) -> None:
    """Frames of the scene itself that nothing places, and nothing is joined to."""
    told = set[str]()
    for name in graph.unused_frames:
        stem = name.partition("[")[0]
        if "." not in name and stem not in told:
            told.add(stem)
            report.warning("L0224", f"nothing uses the frame '{stem}', and it is nowhere", graph.model.frames[name].span,
                           f"say where it is, Frame {stem} = shift(world, {{1, 0}}), and join something to it; or leave it out")


def _all(model: FlatModel) -> tuple[Statement, ...]:
    return (*model.energies, *model.works)


def _is_body(statements: Iterable[Statement]) -> bool:
    return any(isinstance(s, Energy) and s.kind == "kinetic" for s in statements)


def _grounded(graph: ComponentGraph) -> set[str]:
    """The frames that are fixed to the ground, with no joint in between whose reaction could be asked for."""
    joints = {id(edge) for edge, _ in joints_of(graph).values()}
    found = {name for name, frame in graph.model.frames.items() if frame.is_ground}
    edges = [edge for edge in graph.edges if edge.is_rigid and id(edge) not in joints]
    size = 0
    while len(found) > size:
        size = len(found)
        for edge in edges:
            if edge.parent in found or edge.child in found:
                found |= {edge.parent, edge.child}
    return found


def _idle(statement: Statement, model: FlatModel, bindings: Mapping[str, Flat | None], grounded: set[str]) -> str:
    """What it would have to speak of, to do anything; "" where it does."""
    value = statement.value if isinstance(statement, Energy) else statement.position
    if _vanishes(statement.force if isinstance(statement, Work) else value, bindings, set()):
        if isinstance(statement, Work) and statement.is_signal and _is_reset(value, model):
            return ""
        return "a force of 0" if isinstance(statement, Work) else "an energy of 0"
    needs_rates = isinstance(statement, Energy) and statement.kind != "potential"
    moves = False
    for node in reached([value], bindings):
        is_rate = is_velocity(node.attribute) if isinstance(node, FrameRef) else isinstance(node, Call) and node.function == "der"
        moves |= isinstance(node, FrameRef) and node.name not in grounded
        moves |= isinstance(node, Ref) and model.variables[node.name].kind == "coordinate"
        if moves and (is_rate or not needs_rates):
            return ""
        needs_rates &= not is_rate
    return "no rate" if moves else "nothing that moves"


def _is_reset(coordinate: Flat, model: FlatModel) -> bool:
    """Whether events, or the start, set the state whose coordinate this is: it rests in between."""
    set_there = {reset.rate.name for when in model.whens for reset in when.resets if isinstance(reset.rate, Ref)}
    set_there |= {equation.left.name for equation in model.initial_equations if isinstance(equation.left, Ref)}
    return str(coordinate) in {state.coordinate for name, state in model.states.items() if name in set_there}


def _vanishes(node: Flat, bindings: Mapping[str, Flat | None], others: set[str]) -> bool:
    """Whether a number, or each of a vector's components, is 0 as it is written. `others` are variables that are not."""
    match node:
        case Array(items):
            return all(_vanishes(item, bindings, others) for item in items)
        case Unary("-", operand) | Binary("/", operand, _) | Call("rotate", (operand, _)):
            return _vanishes(operand, bindings, others)
        case Binary("*", left, right):
            return _vanishes(left, bindings, others) or _vanishes(right, bindings, others)
        case Ref(name, ()) if name not in others and (binding := bindings.get(name)) is not None:
            if not _vanishes(binding, bindings, others):
                others.add(name)
            return name not in others
    return fold(node) == 0


def _carries(component: str, model: FlatModel) -> bool:
    """Whether others are joined to its frames, or read them, but for the one that places it."""
    joined = 0
    for equation in model.frame_equations:
        owners = {component_of(node.name) for node in _frames((equation.left, equation.right))}
        joined += component in owners and len(owners) > 1
    read = any(component_of(node.name) == component for part in _others(component, model) for node in _frames((part,)))
    return joined > 1 or read


def _frames(parts: Iterable[Flat]) -> Iterator[FrameRef]:
    return (node for node in nodes(*parts) if isinstance(node, FrameRef))


def _others(component: str, model: FlatModel) -> Iterator[Flat]:
    """What is stated and bound elsewhere."""
    for statement in _all(model):
        if statement.component != component:
            yield from (statement.value,) if isinstance(statement, Energy) else (statement.force, statement.position)
    for name, variable in model.variables.items():
        if component_of(name) != component and variable.binding is not None:
            yield variable.binding
    for equation in (*model.constraints, *model.initial_equations):
        yield from (equation.left, equation.right)
    for when in model.whens:
        yield from when.expressions()
