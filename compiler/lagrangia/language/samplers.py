"""Values that are held between instants: `when sample(start, interval) then u = ...; end when;`.

A variable that such a `when` gives a value keeps it until the next instant, start + k interval, k = 0, 1, ... At an instant
pre(x) is the value before it; x itself, of another held variable, the one that it has from there on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lagrangia.base.diagnostics import Report, fail
from lagrangia.language.flat import FlatModel, Held, Sampler, Variable
from lagrangia.language.folding import fold
from lagrangia.language.mentions import reached, read_now
from lagrangia.language.states import statements_of_motion
from lagrangia.language.tree import Ref

_IN_STARTS = "an initial equation"


def declare_held(samplers: Sequence[Sampler], variables: Mapping[str, Variable], report: Report) -> dict[str, Variable]:
    """The variables that are held. Reports L0232 for what cannot be, L0605 for an interval that is not positive."""
    found: dict[str, Variable] = {}
    for sampler in samplers:
        interval = fold(sampler.interval)
        if isinstance(interval, float | int) and not interval > 0:
            report.error("L0605", "the interval of sample(start, interval) must be positive", sampler.interval.span)
        for held in sampler.held:
            variable = variables.get(held.name)
            if variable is None or variable.kind != "variable" or variable.binding is not None or variable.shape:
                is_bound = variable is not None and (variable.binding is not None or variable.kind != "variable")
                why = "it has a value already" if is_bound else "it is an array"
                report.error("L0232", f"'{held.name}' cannot be held: {why}", held.span,
                             "declare it without a value, as Real u(start = 0); each by itself")
            elif held.name in found:
                report.error("L0232", f"'{held.name}' is given a value in two places", held.span,
                             "one `when` gives it its values")
            else:
                found[held.name] = replace(variable, kind="held")
    return found


def check_held(model: FlatModel, report: Report) -> None:
    """Reports L0901 for held values in what mechanics is made of, L0212 for values that follow from themselves."""
    if not model.samplers:
        return
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    starts = [(side, equation.span, _IN_STARTS) for equation in model.initial_equations
              for side in (equation.left, equation.right)]
    for value, span, what in (*statements_of_motion(model), *starts):
        read = (node.name for node in reached([value], bindings) if isinstance(node, Ref))
        name = next((name for name in read if model.variables[name].kind == "held"), None)
        if name is not None and what != "a dissipation function":
            report.error("L0901", f"not supported yet: the held value '{name}' in {what}", span,
                         "let it act as a force or a torque: AppliedForce, AppliedTorque, DCMotor" if what != _IN_STARTS else
                         "write there what it is at its first instant")
    if not report.errors:
        in_order(model)


def refuse_held(model: FlatModel, what: str) -> None:
    """Raises LagError L0901 for scenes with values that are held between instants."""
    if model.samplers:
        fail("L0901", f"not supported yet: {what} of a scene with values that are held between instants", model.samplers[0].span,
             "lag simulate, sweeps and FMUs have them; lag linearize gives the sampled system")


def in_order(model: FlatModel) -> list[Held]:
    """All held values, so that each reads those before it alone. Raises LagError L0212."""
    of = {held.name: held for sampler in model.samplers for held in sampler.held}
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    found: dict[str, Held] = {}
    pending: list[str] = []

    def visit(name: str) -> None:
        if name in found:
            return
        if name in pending:
            chain = " > ".join([*pending[pending.index(name) :], name])
            fail("L0212", f"'{name}' follows from itself at its instants", of[name].span, chain,
                 f"pre({name}) is the value before")
        pending.append(name)
        for other in read_now([of[name].value], bindings):
            if other in of:
                visit(other)
        pending.pop()
        found[name] = of[name]

    for name in of:
        visit(name)
    return [*found.values()]
