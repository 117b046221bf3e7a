"""Forces that follow from the motion, reactions of joints and what holds at contacts: of what makes it, forces, dissipation
functions and the conditions of events alone may depend on them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.language.events import are_alike
from lagrangia.language.flat import Equation, FlatModel, FrameEquation
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.mentions import leaves, nodes, reached
from lagrangia.language.tree import Call, Flat, FrameRef, Ref

CONSTRAINT_FORCE = "constraint_force"
Stated = tuple[Iterable[Flat], str, Span]


def keep_consequences_out(model: FlatModel, report: Report) -> None:
    """Raises LagError L0911 for the rate of a reaction, L0914."""
    speaks_of_reactions = speaks_of_contacts = False
    for node in nodes(*_of_all_kinds(model)):
        if node.__class__ is FrameRef or node.__class__ is Call:
            speaks_of_reactions |= _is_reaction(node)
            speaks_of_contacts |= _is_contact_force(node)
    if speaks_of_reactions:
        _keep_reactions_out(model, report)
        _keep_rates_out(model, report, _is_reaction, "reaction")
    if speaks_of_contacts:
        _keep_contact_forces_out(model, report)
        _keep_rates_out(model, report, _is_contact_force, "contact force")
    report.raise_errors()


def place_of_contact_forces(model: FlatModel) -> Span | None:
    """Where the first force or dissipation function is stated that depends on the force of a contact."""
    bindings = _bindings(model)
    return next((span for expressions, _, span in _of_forces(model)
                 if any(map(_is_contact_force, reached(expressions, bindings)))), None)


def place_of_felt_reactions(model: FlatModel) -> Span | None:
    """Where the first force or dissipation function is stated that depends on a reaction."""
    bindings = _bindings(model)
    return next((span for expressions, _, span in _of_forces(model)
                 if any(map(_is_reaction, reached(expressions, bindings)))), None)


def refuse_felt_reactions(model: FlatModel, what: str) -> None:
    """Raises LagError L0914 where forces feel reactions."""
    span = place_of_felt_reactions(model)
    if span is not None:
        fail("L0914", f"not supported yet: {what} of scenes with forces that feel reactions", span,
             "lag simulate, FMUs, --to python and --to casadi have them")


def contact_forces_in(model: FlatModel, has_events: bool = False) -> list[Call[Flat]]:
    """Those that forces or dissipation functions depend on; or conditions of events, too."""
    stated = [node for expressions, _, _ in _of_forces(model) for node in expressions]
    stated += [when.condition for when in model.whens if has_events]
    return [node for node in reached(stated, _bindings(model)) if isinstance(node, Call) and _is_contact_force(node)]


def side_of(model: FlatModel, x: Flat) -> tuple[int, float] | None:
    """The first equation one side of which is x, by its place among all: 1.0 for the left side, -1.0 for the right one; of an x
    that nothing moves, as x = 2*time and x = block.s, the side that it moves."""
    bindings = _bindings(model)

    def other_name(side: Flat) -> Flat:
        while isinstance(side, Ref) and not side.index and isinstance(value := bindings.get(side.name), Ref | FrameRef):
            side = value
        return side

    sides = ((k, sign, side) for k, equation in enumerate(model.constraints)
             for sign, side in ((1.0, equation.left), (-1.0, equation.right)))
    x = other_name(x)
    found = next(((k, sign) for k, sign, side in sides if are_alike(other_name(side), x)), None)
    return found if found is None or _moves(model, x) else (found[0], -found[1])


def _moves(model: FlatModel, x: Flat) -> bool:
    """Whether the motion decides it, and not time alone."""
    variables = model.variables
    return any(isinstance(leaf, FrameRef) or (isinstance(leaf, Ref) and variables[leaf.name].kind == "coordinate")
               for leaf in leaves([x], _bindings(model)))


def name_of_constraint(equation: int) -> str:
    """By which the evaluator asks for the force of an equation along its left side."""
    return f"{CONSTRAINT_FORCE}({equation})"


def is_constraint_force(node: Flat) -> bool:
    """Whether it is the force of an equation itself."""
    return isinstance(node, Call) and node.function == CONSTRAINT_FORCE


def equation_of(name: str) -> int:
    """The place of the equation of such a name."""
    return int(name.removeprefix(f"{CONSTRAINT_FORCE}(").removesuffix(")"))


_SET = "what an event sets"
_AT_EVENTS = ("conditions of events may ask for forces: when norm(hinge.reaction) > 25, or contact_force(x) > 25, then "
              "torn = true; end when")


def asks_for_forces(node: Flat, bindings: Mapping[str, Flat | None]) -> bool:
    """Whether an expression, or what it refers to, has a reaction or the force of a contact in it."""
    return any(_is_reaction(x) or _is_contact_force(x) for x in reached([node], bindings))


def contact_forces_of(node: Flat, bindings: Mapping[str, Flat | None]) -> list[Flat]:
    """Each x of contact_force(x) in an expression, or in what it refers to."""
    return [x.arguments[0] for x in reached([node], bindings) if isinstance(x, Call) and _is_contact_force(x)]


def speaks_of_contact_forces(model: FlatModel, expression: Flat) -> bool:
    """Whether an expression, or what it refers to, has the force of a contact in it."""
    return any(map(_is_contact_force, reached([expression], _bindings(model))))


def _keep_reactions_out(model: FlatModel, report: Report) -> None:
    bindings = _bindings(model)
    for expressions, what, span in (*_of_positions(model), *_of_parameters(model)):
        for node in reached(expressions, bindings):
            if _is_reaction(node):
                of = f"reaction of '{node.name.rpartition('.')[0]}'" if isinstance(node, FrameRef) else "force of a constraint"
                report.error("L0914", f"{what} cannot depend on the {of}", span,
                             "reactions follow from the motion: forces and dissipation functions may feel them, as "
                             "mu*radius*norm(hinge.reaction)*abs(hinge.w)", *_hints_of(what))


def _keep_contact_forces_out(model: FlatModel, report: Report) -> None:
    bindings = _bindings(model)
    for expressions, what, span in (*_of_positions(model), *_of_parameters(model)):
        if any(map(_is_contact_force, reached(expressions, bindings))):
            report.error("L0914", f"{what} cannot depend on a contact force", span,
                         "forces and dissipation functions can, as mu*contact_force(x)*abs(rate)", *_hints_of(what))


def _hints_of(what: str) -> tuple[str, ...]:
    return (_AT_EVENTS,) if what == _SET else ()


def _keep_rates_out(model: FlatModel, report: Report, is_one: Callable[[Flat], bool], what: str) -> None:
    bindings = _bindings(model)
    for node in nodes(*(binding for binding in bindings.values() if binding is not None)):
        if isinstance(node, Call) and node.function == "der" and any(map(is_one, reached(node.arguments, bindings))):
            report.error("L0911", f"the rate of a {what} is not known", node.span)


def _is_reaction(node: Flat) -> bool:
    return is_constraint_force(node) or (isinstance(node, FrameRef) and node.attribute in REACTIONS)


def _is_contact_force(node: Flat) -> bool:
    return isinstance(node, Call) and node.function == "contact_force"


# ------------------------------------------------------------ what a model states


def _bindings(model: FlatModel) -> Mapping[str, Flat | None]:
    return {name: v.binding for name, v in model.variables.items()}


def _of_positions(model: FlatModel) -> list[Stated]:
    """All that makes the motion, but for forces, dissipation functions and parameters."""
    equations: list[FrameEquation | Equation] = [*model.frame_equations, *model.constraints, *model.initial_equations]
    stated: list[Stated] = [((e.left, e.right), "an equation", e.span) for e in equations]
    stated += [((e.value,), f"a {e.kind} energy", e.span) for e in model.energies if e.kind != "dissipation"]
    stated += [((w.position,), "a position that a force works on", w.span) for w in model.works]
    stated += [((x.rate, x.value), _SET, x.span) for when in model.whens for x in when.resets]
    stated += [(sampler.expressions(), "a value that is held", sampler.span) for sampler in model.samplers]
    stated += [(delay.expressions(), "what is read late", delay.span) for delay in model.delays]
    stated += [((v.start,), "a start value", v.start.span) for v in model.variables.values() if v.start is not None]
    return stated


def _of_forces(model: FlatModel) -> list[Stated]:
    dampers: list[Stated] = [((e.value,), "a dissipation function", e.span) for e in model.energies if e.kind == "dissipation"]
    return dampers + [((w.force,), "a force", w.span) for w in model.works]


def _of_parameters(model: FlatModel) -> list[Stated]:
    return [((v.binding,), f"the {v.kind} '{v.name}'", v.binding.span) for v in model.variables.values()
            if v.kind in ("parameter", "constant") and v.binding is not None]


def _of_all_kinds(model: FlatModel) -> Iterator[Flat]:
    """All that is stated, but for repeats, in which nothing stands that does not stand elsewhere, and frames that are joined."""
    for joint in model.news(model.frame_equations):
        yield from (side for side in (joint.left, joint.right) if not isinstance(side, FrameRef))
    for equation in (*model.constraints, *model.initial_equations):
        yield from (equation.left, equation.right)
    yield from (energy.value for energy in model.energies if id(energy) not in model.repeats)
    for work in model.news(model.works):
        yield from (work.position, work.force)
    for when in model.whens:
        yield from when.expressions()
    for sampler in model.samplers:
        yield from sampler.expressions()
    for delay in model.delays:
        yield from delay.expressions()
    for variable in model.news(model.variables.values()):
        yield from (x for x in (variable.start, variable.binding) if x is not None)
