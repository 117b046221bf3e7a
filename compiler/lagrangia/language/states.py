"""First-order states: a variable z with an equation der(z) = f, or one that is solved for der(z), as T*der(z) = u - z.

Each is made the rate of a coordinate of its own, of inertia 1, on which f works: as M dv/dt = f is what moves all rates, every
solver, FMU and sweep has it. The coordinate, the integral of z, is in nothing else; its energy is none of the mechanism's.

A declared coordinate is one as well where its equation is not linear in rates, as those that hold a motion must be, and where
nothing but forces reads it: it moves no mass, so no force is needed to keep the equation.
"""

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import replace
from typing import TypeGuard

from lagrangia.base.diagnostics import Report, Span
from lagrangia.base.records import dataclass
from lagrangia.language.flat import Energy, Equation, FlatModel, FrameEquation, State, Variable, When, Work
from lagrangia.language.mentions import children, nodes, reached
from lagrangia.language.tree import Binary, Call, Flat, FrameRef, Number, Ref, Unary


@dataclass(frozen=True)
class FoundStates:
    """What the states of a model add to it, and the equations that are left."""

    states: Mapping[str, State]
    variables: Mapping[str, Variable]  # the states, bound, and their coordinates
    energies: tuple[Energy, ...]
    works: tuple[Work, ...]
    equations: tuple[Equation, ...]


def mechanics_of(energies: Sequence[Energy], works: Sequence[Work], frames: Sequence[FrameEquation], whens: Sequence[When],
                 variables: Mapping[str, Variable]) -> list[Flat]:
    """What tells masses, places and resets of rates; not forces."""
    return [*(energy.value for energy in energies), *(work.position for work in works),
            *(side for equation in frames for side in (equation.left, equation.right)),
            *(rate for when in whens for reset in when.resets
              if not (isinstance(rate := reset.rate, Ref) and variables[rate.name].kind == "coordinate"))]


def find_states(variables: Mapping[str, Variable], equations: Sequence[Equation], ends: Set[str], mechanics: Sequence[Flat],
                report: Report) -> FoundStates:
    """`ends`: variables of connectors, whose rates are held unless an equation gives one alone. Reports L0901 for arrays of
    states, L0231 for a second equation of the same."""
    states, left = dict[str, State](), list[Equation]()
    variables = {**variables, **_idle_coordinates(variables, equations, ends, mechanics)}
    for equation in equations:
        found = _state_of(equation, variables, ends)
        if found is None:
            left.append(equation)
        elif found.name in states:
            report.error("L0231", f"'{found.name}' has two equations for its rate", equation.span,
                         f"the other one is at {states[found.name].span}")
        elif variables[found.name].shape:
            report.error("L0901", f"not supported yet: the array '{found.name}' of first-order states", equation.span,
                         "declare each by itself, or in an array of components")
        else:
            states[found.name] = found
    made = {name: new for state in states.values() for name, new in _variables_of(state, variables[state.name]).items()}
    energies = tuple(Energy("kinetic", _half_square(state), state.component, state.span, is_of_library=True, is_signal=True)
                     for state in states.values())
    works = tuple(Work(state.rate, Ref(state.coordinate, (), state.span), state.component, state.span, is_signal=True)
                  for state in states.values())
    return FoundStates(states, made, energies, works, tuple(left))


def _idle_coordinates(variables: Mapping[str, Variable], equations: Sequence[Equation], ends: Set[str],
                      mechanics: Sequence[Flat]) -> dict[str, Variable]:
    """Coordinates that are states, as variables: one equation, not linear, gives the rate; nothing else that holds reads them."""
    bindings = {name: variable.binding for name, variable in variables.items()}
    candidates = dict[str, Equation]()
    read = list(mechanics)
    for equation in equations:
        names = _rates_in([side for side in (equation.left, equation.right) if _is_coordinate_rate(side, variables)], variables)
        names = names if len(names) == 1 else _rates_in((equation.left, equation.right), variables)
        if isinstance(equation.left, Ref) and _is_open(variables[equation.left.name]) and bindings[equation.left.name] is None:
            bindings[equation.left.name] = equation.right
        elif len(names) == 1 and names.isdisjoint(candidates) and _is_number(min(names), variables) and not _is_virtual(equation):
            candidates[names.pop()] = equation
        elif _state_of(equation, variables, ends) is None:
            read += [equation.left, equation.right]
    known = dict[str, int]()
    found = {name for name, equation in candidates.items()
             if max(_degree(side, bindings, known) for side in (equation.left, equation.right)) > 1}
    if not found:
        return {}
    read += [side for name, equation in candidates.items() if name not in found for side in (equation.left, equation.right)]
    found -= {node.name for node in reached(read, bindings) if isinstance(node, Ref)}
    return {name: replace(variables[name], kind="variable") for name in found}


def _rates_in(sides: Iterable[Flat], variables: Mapping[str, Variable]) -> set[str]:
    """The coordinates whose rates stand there."""
    return {str(node.arguments[0]) for node in nodes(*sides) if _is_coordinate_rate(node, variables)}


def _is_coordinate_rate(node: Flat, variables: Mapping[str, Variable]) -> TypeGuard[Call[Flat]]:
    return (isinstance(node, Call) and node.function == "der" and isinstance(inner := node.arguments[0], Ref)
            and variables[inner.name].kind == "coordinate")


def _is_number(name: str, variables: Mapping[str, Variable]) -> bool:
    """Whether a coordinate is a number: no array, and no element of one."""
    return name in variables and not variables[name].shape


def _is_virtual(equation: Equation) -> bool:
    return any(isinstance(node, Call) and node.function == "virtual" for node in nodes(equation.left, equation.right))


def _degree(node: Flat, bindings: Mapping[str, Flat | None], known: dict[str, int]) -> int:
    """Of an expression in rates: 0 without them, 1 where it is linear in them, more where it is not. `known`: of variables."""
    match node:
        case Ref(name):
            if name not in known:
                known[name], binding = 0, bindings.get(name)
                known[name] = 0 if binding is None else _degree(binding, bindings, known)
            return known[name]
        case FrameRef(_, attribute):
            return int(attribute in ("v", "w"))
        case Call("der"):
            return 1
    inside = [_degree(inner, bindings, known) for inner in children(node)]
    match node:
        case Unary() | Binary("+" | "-"):
            return max(inside)
        case Binary("*"):
            return min(sum(inside), 2)
        case Binary("/"):
            return inside[0] if inside[1] == 0 else 2
    return 2 * (max(inside, default=0) > 0)


def _state_of(equation: Equation, variables: Mapping[str, Variable], ends: Set[str]) -> State | None:
    """Of der(z) = f, either way round, or an equation with one der(z), in a sum and with factors; z has no value of its own."""
    left, right, span = equation.left, equation.right, equation.span
    rates = [node for node in nodes(left, right) if _is_rate(node, variables)]
    found = next((side for side in (left, right) if _is_rate(side, variables)), rates[0] if len(rates) == 1 else None)
    if found is None:
        return None
    (name,) = (inner.name for inner in found.arguments if isinstance(inner, Ref))
    if name in ends and found is not left and found is not right:
        return None
    is_left = found is left or (found is not right and _has_rate(left, variables))
    rate = _solved(left, right, variables) if is_left else _solved(right, left, variables)
    return None if rate is None else State(name, f"{name}.integral", rate, equation.component, span, Equation(left, right, span))


def _is_rate(node: Flat, variables: Mapping[str, Variable]) -> TypeGuard[Call[Flat]]:
    if not (isinstance(node, Call) and node.function == "der" and isinstance(inner := node.arguments[0], Ref)):
        return False
    return inner.name in variables and _is_open(variables[inner.name])


def _is_open(variable: Variable) -> bool:
    return variable.kind == "variable" and variable.binding is None


def _has_rate(side: Flat, variables: Mapping[str, Variable]) -> bool:
    return any(_is_rate(node, variables) for node in nodes(side))


def _solved(side: Flat, other: Flat, variables: Mapping[str, Variable]) -> Flat | None:
    """What the only rate in `side` is, where that is `other`; None where it stands in anything but sums and products."""
    if _is_rate(side, variables):
        return other
    match side:
        case Unary("-", operand, span):
            return _solved(operand, Unary("-", other, span), variables)
        case Binary("+" | "-" | "*" | "/" as operator, left, right, span):
            inverse = {"+": "-", "-": "+", "*": "/", "/": "*"}[operator]
            if _has_rate(left, variables):
                return _solved(left, Binary(inverse, other, right, span), variables)
            if operator in "+*":
                return _solved(right, Binary(inverse, other, left, span), variables)
            return _solved(right, Binary(operator, left, other, span), variables) if operator == "-" else None
    return None


def _variables_of(state: State, variable: Variable) -> dict[str, Variable]:
    unit = _times_seconds(variable.unit)
    coordinate = Variable(state.coordinate, "coordinate", (), unit, "", None, None, False, None, None, False,
                          f"of {state.name} over time: nothing depends on it", variable.span)
    rate = Call("der", (Ref(state.coordinate, (), variable.span),), (), variable.span)
    return {state.coordinate: coordinate, state.name: replace(variable, binding=rate)}


def _half_square(state: State) -> Flat:
    z = Ref(state.name, (), state.span)
    return Binary("/", Binary("*", z, z, state.span), Number(2.0, None, state.span, True), state.span)


def _times_seconds(unit: str) -> str:
    """N/m -> N.s/m; what has no unit stays without one."""
    if unit.endswith("/s"):
        return unit.removesuffix("/s")
    if not unit or unit == "1":
        return "s" if unit else ""
    above, stroke, below = unit.partition("/")
    return f"{'' if above == '1' else above + '.'}s{stroke}{below}"


def refuse_states_elsewhere(model: FlatModel, report: Report) -> None:
    """What mechanics cannot be made of rates that have no place: reports L0901. And rates that depend on themselves: L0212."""
    if not model.states:
        return
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    for value, span, what in statements_of_motion(model):
        read = (node.name for node in reached([value], bindings) if isinstance(node, Ref))
        name = next((name for name in read if name in model.states), None)
        if name is not None:
            report.error("L0901", f"not supported yet: the first-order state '{name}' in {what}", span,
                         "let it act as a force or a torque: work ... on ..., AppliedForce, AppliedTorque")
    for state in model.states.values():
        if _asks_for(state.name, [state.rate], model, bindings, set()):
            report.error("L0212", f"the rate of '{state.name}' depends on itself", state.span,
                         f"solve it for der({state.name})")


def statements_of_motion(model: FlatModel) -> Iterable[tuple[Flat, Span, str]]:
    """What mechanics is made of, but for forces, with what it is."""
    for energy in model.energies:
        if not energy.is_signal:
            what = "a dissipation function" if energy.kind == "dissipation" else f"a {energy.kind} energy"
            yield energy.value, energy.span, what
    for frames in model.frame_equations:
        yield from ((side, frames.span, "the place of a frame") for side in (frames.left, frames.right))
    for equation in model.constraints:
        yield from ((side, equation.span, "an equation that holds the motion") for side in (equation.left, equation.right))


def _asks_for(name: str, roots: Sequence[Flat], model: FlatModel, bindings: Mapping[str, Flat | None], seen: set[str]) -> bool:
    """Whether expressions read der(name), through the rates of other states as well."""
    read = {inner.name for node in reached(roots, bindings) for rate in nodes(node)
            if isinstance(rate, Call) and rate.function == "der" and isinstance(inner := rate.arguments[0], Ref)}
    for other in read & model.states.keys():
        if other == name:
            return True
        if other not in seen:
            seen.add(other)
            if _asks_for(name, [model.states[other].rate], model, bindings, seen):
                return True
    return False
