"""What people declare and nothing reads: a force that acts on nothing, an input or a parameter that changes nothing."""

from collections.abc import Iterable, Iterator, Mapping

from lagrangia.base.diagnostics import Report, Span
from lagrangia.language.classes import ClassTable
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.folding import fold
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.instances import Instance, Slot
from lagrangia.language.mentions import nodes, reached
from lagrangia.language.tree import Array, Call, Flat, FrameRef, Ref, Reference
from lagrangia.language.unread import inside
from lagrangia.language.written_reads import Written, written_reads

_FORCES = ("N", "N.m")
_MOST_NAMED = 3
_ACTS = "give it to a component, as AppliedForce(force = ...) or ForcePair, or write in a section `energy`: work {name} on ...;"


def find_idle(model: FlatModel, root: Instance, table: ClassTable) -> Report:
    """A warning for each declaration of people's own that nothing mentions, neither an equation nor another variable."""
    report = Report()
    own = [(slot, variable) for instance in (root, *inside(root)) for slot in instance.members.values()
           if isinstance(slot, Slot) and slot.declaration.name_span.source not in table.library_sources
           and (variable := model.variables.get(slot.path)) is not None
           and (_could_act(variable) or (instance is root and variable.kind in ("input", "parameter")))]
    mentioned = _mentioned(nodes(*expressions_of(model)) if own else ())
    read = {slot.declaration.name_span for slot, _ in own if slot.path in mentioned}
    told = set[Span]()
    written: Written | None = None
    for slot, variable in own:
        place, is_force = slot.declaration.name_span, variable.kind == "variable"
        unread = _unread(variable, mentioned)
        if not unread or place in told or (is_force and _follows_from_motion(model, variable)):
            continue
        written = written or written_reads(model, (root, *inside(root)), table)
        if slot.path in written.left_out or (place in read and slot.path in written.chosen):
            continue
        told.add(place)
        what = "this force acts on nothing: nothing reads" if is_force else f"nothing reads the {variable.kind}"
        out = "leave it out" if slot.path not in mentioned else _advice(slot, variable, mentioned[slot.path], table)
        acts = _ACTS.format(name=slot.declaration.name), "or let it be looked at: output"
        report.warning("L0224", f"{what} {unread}", place, *(acts if is_force else (out,)))
    forces = [v for s, v in own if v.kind == "variable" and v.span not in told and v.name in mentioned]
    _find_read_in_vain(model, root, forces, told, report)
    _find_useless(root, table, report)
    return report


def _mentioned(parts: Iterable[Flat]) -> dict[str, set[tuple[int, ...]]]:
    """The variables among parts of expressions, and by which indices; () stands for all of one."""
    found: dict[str, set[tuple[int, ...]]] = {}
    for node in parts:
        if isinstance(node, Ref):
            found.setdefault(node.name, set()).add(node.index)
    return found


def _unread(variable: Variable, mentioned: Mapping[str, set[tuple[int, ...]]]) -> str:
    """What of a variable nobody mentions, for people: its name, or those of elements other than 0; "" where there is none."""
    read = mentioned.get(variable.name, set())
    if not read:
        return f"'{variable.name}'"
    if () in read:
        return ""
    left = [label for label, index in variable.elements()
            if not any(index[:k] in read for k in range(1, len(index) + 1)) and not _is_zero(variable.binding, index)]
    more = f" and {len(left) - _MOST_NAMED} more" if len(left) > _MOST_NAMED else ""
    return ", ".join(f"'{label}'" for label in left[:_MOST_NAMED]) + more


def _is_zero(value: Flat | None, index: tuple[int, ...]) -> bool:
    """Whether an element is 0, as those of vectors along an axis and of diagonal matrices are."""
    for place in index:
        value = value.items[place - 1] if isinstance(value, Array) else None
    return value is not None and fold(value) == 0


def _advice(slot: Slot, variable: Variable, read: set[tuple[int, ...]], table: ClassTable) -> str:
    """What to do about some elements of an array."""
    sizes = slot.declaration.dimensions
    is_counted = len(variable.shape) == len(sizes) == 1 and not (
        isinstance(sizes[0], Reference) and (str(sizes[0]) == "Boolean" or table.found(str(sizes[0]), sizes[0].span)))
    if is_counted and {index[0] for index in read} == set(range(1, 1 + len(read))):
        return "read what is left, or make the array smaller"
    return "read what is left, or " + ("write 0 in its place" if variable.kind == "parameter" else "declare what is read alone")


def _find_read_in_vain(model: FlatModel, root: Instance, forces: list[Variable], told: set[Span], report: Report) -> None:
    """The last force of each chain that ends in variables of the scene that nothing reads and that are no outputs."""
    if not forces:
        return
    variables = model.variables
    idle = {slot.path for slot in root.members.values() if isinstance(slot, Slot)
            and (v := variables.get(slot.path)) is not None and v.kind == "variable" and not v.is_output}
    bindings = {name: v.binding for name, v in variables.items()}
    values = [(v.start, None if name in idle else v.binding) for name, v in variables.items()]
    rates = [state.rate for state in model.states.values()]
    roots = [*model.stated(), *rates, *(x for pair in values for x in pair if x is not None)]
    felt = {node.name for node in reached(roots, bindings) if isinstance(node, Ref)}
    readers = {name: [v.name for v in variables.values() if v.binding is not None and name in _names_of(v.binding)]
               for name in (force.name for force in forces) if name not in felt}
    lost = {*readers, *(v.name for v in variables.values() if v.span in told)}
    for force in forces:
        if force.name in readers and lost.isdisjoint(readers[force.name]) and not _follows_from_motion(model, force):
            name = force.name.rpartition(".")[2]
            report.warning("L0224", f"this force acts on nothing: nothing reads '{readers[force.name][0]}', which reads "
                           f"'{force.name}'", force.span, _ACTS.format(name=name), "or let it be looked at: output")


def _names_of(node: Flat) -> set[str]:
    return {part.name for part in nodes(node) if isinstance(part, Ref)}


def _find_useless(root: Instance, table: ClassTable, report: Report) -> None:
    """Components of people's own that have nothing at all."""
    for instance in inside(root):
        if not (instance.members or instance.clauses or instance.frame or instance.span.source in table.library_sources):
            report.warning("L0224", f"nothing uses '{instance.path}': it has no energy, frame or equation", instance.span,
                           "leave it out")


def _could_act(variable: Variable) -> bool:
    """Whether it is a force that is not to be looked at."""
    return (variable.kind == "variable" and not variable.is_output and variable.unit in _FORCES
            and variable.binding is not None)


def _follows_from_motion(model: FlatModel, variable: Variable) -> bool:
    """What holds a joint or a contact does."""
    bindings = {name: v.binding for name, v in model.variables.items()}
    return variable.binding is not None and any(_follows(node) for node in reached([variable.binding], bindings))


def _follows(node: Flat) -> bool:
    if isinstance(node, FrameRef):
        return node.attribute in REACTIONS
    return isinstance(node, Call) and node.function in ("contact_force", "constraint_force")


def expressions_of(model: FlatModel) -> Iterator[Flat]:
    """All that is stated, and the bindings and starts of all variables."""
    yield from model.stated()
    for variable in model.variables.values():
        yield from (x for x in (variable.binding, variable.start) if x is not None)
