"""Where in the source it is decided what a scene needs."""

from collections.abc import Iterable, Iterator

import casadi as ca

from lagrangia.base.diagnostics import Span
from lagrangia.dynamics.energies import Energies, generalised_force
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Flat, Time
from lagrangia.needs.linearity import Degree, NotLinear, rewrite


def place_of_world(kinematics: Kinematics) -> Span | None:
    """Where the scene declares its World; None where it does not, and gravity is the usual one."""
    model = kinematics.graph.model
    declared = model.frames["world"].span
    return declared if declared != model.span else None


def place_of_moving_support(kinematics: Kinematics) -> Span | None:
    """Where `time` stands first in what moves a support or a coordinate and jumps or bends at known times."""
    return _place(kinematics, _moving(kinematics), True)


def place_of_time(kinematics: Kinematics, is_event: bool = False) -> Span | None:
    """Where `time` stands first in what acts or moves; `is_event`: in what jumps or bends at known times, outputs as well."""
    return _place(kinematics, (*_statements(kinematics), *(_outputs(kinematics) if is_event else ())), is_event)


def _place(kinematics: Kinematics, statements: Iterable[Flat], is_event: bool) -> Span | None:
    bindings = {name: variable.binding for name, variable in kinematics.graph.model.variables.items()}
    modes = kinematics.algebra.mode_symbols
    for statement in statements:
        times = [leaf.span for leaf in leaves([statement], bindings) if isinstance(leaf, Time)]
        if times and (not is_event or _depends(kinematics, statement, modes)):
            return times[0]
    return None


def _statements(kinematics: Kinematics) -> Iterator[Flat]:
    """Forces, energies, equations, shifts and turns."""
    for work in kinematics.graph.model.works:
        yield from (work.force, work.position)
    for when in kinematics.graph.model.whens:
        yield from when.expressions()
    yield from (energy.value for energy in kinematics.graph.model.energies)
    yield from _moving(kinematics)


def _moving(kinematics: Kinematics) -> Iterator[Flat]:
    """Equations, shifts and turns."""
    graph = kinematics.graph
    for equation in graph.model.constraints:
        yield from (equation.left, equation.right)
    yield from (step.amount for edge in graph.edges for step in edge.steps)
    yield from (step.amount for cut in graph.closures for step in (*cut.steps_a, *cut.steps_b))


def _outputs(kinematics: Kinematics) -> Iterator[Flat]:
    variables = kinematics.graph.model.variables.values()
    return (variable.binding for variable in variables if variable.is_output and variable.binding is not None)


def _depends(kinematics: Kinematics, statement: Flat, symbols: ca.SX) -> bool:
    value = ca.vertcat(*[ca.SX(x) for x in scalars_of(kinematics.evaluator.value(statement))])
    return bool(ca.depends_on(value, symbols))


def place_of_nonlinear_term(kinematics: Kinematics, energies: Energies, motion: Motion) -> Span | None:
    """The first potential, dissipation or load whose forces are not linear in q, v and u."""
    forces = [(ca.gradient(ca.SX(term.value), motion.q), term.statement.span) for term in energies.potential]
    forces += [(ca.gradient(ca.SX(term.value), motion.v), term.statement.span) for term in energies.dissipation]
    forces += [(generalised_force([load], motion.q, motion.v), load.statement.span) for load in energies.loads]
    return next((span for force, span in forces if not is_linear(kinematics, motion, force)), None)


def is_linear(kinematics: Kinematics, motion: Motion, force: ca.SX) -> bool:
    """In q, v and u, with coefficients that only time events change."""
    modes = kinematics.algebra.mode_symbols
    felt = motion.felt.reactions if motion.felt else ca.SX(0, 1)
    moving, fixed = ca.vertcat(motion.q, motion.v, motion.u, felt), ca.vertcat(motion.p, kinematics.symbols.tau)
    try:
        degrees = rewrite(ca.vertcat(*ca.sparsify(force).nonzeros()), moving, motion.t, modes, fixed).degrees
    except NotLinear:
        return False
    return max(degrees, default=Degree.PARAMETER) <= Degree.LINEAR
