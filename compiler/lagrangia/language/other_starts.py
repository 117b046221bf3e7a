"""Starts of what is no coordinate: `spring.phi_rel(start = 0.1, fixed = true)` is the initial equation phi_rel = 0.1."""

from dataclasses import replace

from lagrangia.base.diagnostics import Report
from lagrangia.language.flat import Equation, FlatModel, Variable, rate_of
from lagrangia.language.tree import Number, Ref


def with_other_starts(model: FlatModel) -> FlatModel:
    """The model with such starts as equations; those that are not fixed have no effect (L0608), as others say where it begins."""
    report, found, variables = Report(), list[Equation](), dict(model.variables)
    for variable in model.variables.values():
        if not _is_other(variable, model):
            continue
        variables[variable.name] = replace(variable, start=None, is_fixed=False)
        if variable.is_fixed:
            value = variable.start or Number(0.0, None, variable.span)
            component = variable.name.rpartition(".")[0]
            found.append(Equation(Ref(variable.name, (), variable.span), value, variable.span, component))
        else:
            report.warning("L0608", f"this start has no effect: '{variable.name}' follows from coordinates, which begin where "
                           "they are told to", variable.span, f"to begin there: {variable.name}(start = ..., fixed = true)")
    if len(found) == len(report.diagnostics) == 0:
        return model
    return replace(model, variables=variables, initial_equations=(*model.initial_equations, *found),
                   warnings=(*model.warnings, *report.diagnostics))


def _is_other(variable: Variable, model: FlatModel) -> bool:
    if variable.kind != "variable" or variable.shape or variable.binding is None:
        return False
    of = rate_of(variable)
    is_rate = of is not None and of in model.variables and model.variables[of].kind == "coordinate"
    return (variable.start is not None or variable.is_fixed) and not is_rate
