"""What acts late: `delay(x, T)` is x as it was T earlier; before the start it is what it is there, or what `before = ...` says.

Each is a variable of its own, bound to what it is late of, so that what is asked of expressions is asked of that, too.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from lagrangia.base.diagnostics import Report, fail
from lagrangia.language.flat import Delay, FlatModel, Variable
from lagrangia.language.folding import fold
from lagrangia.language.idle import expressions_of
from lagrangia.language.mentions import nodes, reached
from lagrangia.language.states import statements_of_motion
from lagrangia.language.tree import Call, Flat, Ref

_WRITE = "write: delay(x, 0.2), or delay(x, 0.2, before = ...) with what x was before the start"


def declare_delays(calls: Mapping[str, Call[Flat]], report: Report) -> dict[str, Delay]:
    """By the names of the variables that stand for the calls. Reports L0215, L0605."""
    found = {}
    for name, call in calls.items():
        named = dict(call.named)
        if len(call.arguments) != 2 or named.keys() - {"before"} or len(named) < len(call.named):
            report.error("L0215", "delay takes what is late and by how much, and `before` by its name", call.span, _WRITE)
            continue
        value, lag = call.arguments
        known = fold(lag)
        if isinstance(known, float | int) and not known > 0:
            report.error("L0605", f"a delay must be positive, not {known:g} s", lag.span)
        found[name] = Delay(name, value, lag, named.get("before"), call.span)
    return found


def with_delays(model: FlatModel, delays: Mapping[str, Delay]) -> FlatModel:
    """The model with those that something reads."""
    if not delays:
        return model
    bindings: dict[str, Flat | None] = {name: variable.binding for name, variable in model.variables.items()}
    bindings |= {delay.name: delay.value for delay in delays.values()}
    read = {node.name for node in reached(expressions_of(model), bindings) if isinstance(node, Ref)}
    used = tuple(delay for delay in delays.values() if delay.name in read)
    return replace(model, delays=used, variables={**model.variables, **{delay.name: variable_of(delay) for delay in used}})


def variable_of(delay: Delay) -> Variable:
    """What stands for it."""
    return Variable(delay.name, "delayed", (), "", "", delay.value, None, False, None, None, False, "", delay.span)


def check_delays(model: FlatModel, report: Report) -> None:
    """Reports L0901 for delays in what mechanics is made of, of rates, and in initial equations."""
    if not model.delays:
        return
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    where = [*statements_of_motion(model),
             *((work.position, work.span, "the place on which a force works") for work in model.works),
             *((side, equation.span, "an initial equation") for equation in model.initial_equations
               for side in (equation.left, equation.right))]

    def reads(roots: Iterable[Flat]) -> bool:
        return any(isinstance(x, Ref) and model.variables[x.name].kind == "delayed" for x in reached(roots, bindings))

    for value, span, what in where:
        if what != "a dissipation function" and reads([value]):
            report.error("L0901", f"not supported yet: a delayed value in {what}", span,
                         "let it act as a force or a torque: AppliedForce, AppliedTorque, or in the rate of a first-order state")
    if model.at_rest is not None:
        report.error("L0901", "not supported yet: a start in equilibrium of a scene with delays", model.at_rest,
                     "state the position of rest as start values")
    for node in nodes(*expressions_of(model)):
        if isinstance(node, Call) and node.function == "der" and reads(node.arguments):
            report.error("L0901", "not supported yet: the rate of a delayed value", node.span,
                         "write the delayed value of the rate: delay(der(x), T)")


def refuse_delays(model: FlatModel, what: str, *hints: str) -> None:
    """Raises LagError L0901 for scenes in which something acts late."""
    if model.delays:
        fail("L0901", f"not supported yet: {what} of a scene with delays", model.delays[0].span,
             *(hints or ("lag simulate, sweeps and FMUs for Co-Simulation have them",)))
