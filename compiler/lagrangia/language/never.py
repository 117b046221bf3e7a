"""Conditions that can never come true, or never be false, and those that only just can, by the bounds of what they compare:
sines, squares, lengths, limits."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations

from lagrangia.base.diagnostics import LagError, Report
from lagrangia.language.elsewhen import exclude
from lagrangia.language.events import COMPARED, parts_of, without_not
from lagrangia.language.flat import Experiment, FlatModel
from lagrangia.language.folding import fold
from lagrangia.language.mentions import reached, rebuilt
from lagrangia.language.parabolas import touches_zero
from lagrangia.language.tree import Binary, Boolean, Call, Flat, FrameRef, IfExpression, Number, Ref, Time, Unary

Bounds = tuple[float, float]
_ANY: Bounds = (-math.inf, math.inf)
_DEEPEST = 20  # bindings of bindings
_HALVES = 50
_JUMPING = frozenset({"floor", "ceil", "integer", "sign", "mod", "div", "rem", "min", "max"})
_RATES = frozenset({"v", "w", "omega"})  # of frames
_OF_CALLS: Mapping[str, Bounds] = {
    **dict.fromkeys(("sin", "cos", "tanh", "sign"), (-1.0, 1.0)),
    **dict.fromkeys(("abs", "sqrt", "exp", "distance"), (0.0, math.inf)),
    **dict.fromkeys(("asin", "atan"), (-math.pi / 2, math.pi / 2)), "acos": (0.0, math.pi), "atan2": (-math.pi, math.pi),
    "cosh": (1.0, math.inf),
}


def find_never(model: FlatModel, report: Report, code: str) -> None:
    """A warning for each event that never comes, and each assertion that always holds."""
    bounding = _Bounding(model, *_declared(model.experiment))
    by_events = {guard for when in model.whens for guard in when.endings}
    conditions = [(when.condition, when.span) for when in model.whens]
    conditions += [(guard.condition, guard.span) for guard in model.guards if guard.kind == "end" and guard not in by_events]
    for condition, span in conditions:
        can_be_true, can_be_false = bounding.truth(condition)
        if can_be_true and can_be_false:
            _tell_touching(model, condition, report)
            continue
        why = "is never true" if not can_be_true else "is true from the start on"
        interval = _interval(model, partial(_is_settled, condition))
        report.warning(code, f"this event never comes: '{condition.span.text}' {why}", span,
                       _advice(interval, model.experiment), interval=interval)
    for guard in model.guards:
        if guard.kind != "end" and _is_always_true(guard.condition, bounding):
            interval = _interval(model, partial(_is_always_true, guard.condition))
            report.warning(code, f"this holds whatever happens: '{guard.condition.span.text}'", guard.span,
                           _advice(interval, model.experiment), interval=interval)


def _tell_touching(model: FlatModel, condition: Flat, report: Report) -> None:
    """L0239 for comparisons that change where one side reaches the other and turns back."""
    for node in _Bounding(model, *_ANY).touching(without_not(condition)):
        report.warning("L0239", f"'{node.span.text}' changes for single instants only, where one side just reaches the other "
                       "and turns back: rounding decides whether these are met", node.span,
                       "leave room, as in sin(x) >= 1 - 1e-6 or distance(a, b) <= 1[mm]; what turns back changes its rate there: "
                       "when der(x) < 0")


def _is_settled(condition: Flat, bounding: "_Bounding") -> bool:
    return not all(bounding.truth(condition))


def _is_always_true(condition: Flat, bounding: "_Bounding") -> bool:
    return not bounding.truth(condition)[1]


def _declared(run: Experiment) -> Bounds:
    return run.start, run.stop if run.ends else math.inf


def _interval(model: FlatModel, holds: "Callable[[_Bounding], bool]") -> Bounds | None:
    """How early runs may begin, and how late end, so that what is told of the declared one `holds`; None: whatever they do."""
    if holds(_Bounding(model, *_ANY)):
        return None
    start, stop = _declared(model.experiment)
    latest = _furthest(lambda end: holds(_Bounding(model, start, end)), stop, 1.0)
    return _furthest(lambda begin: holds(_Bounding(model, begin, latest)), start, -1.0), latest


def _furthest(holds: Callable[[float], bool], near: float, sign: float) -> float:
    """How far from `near` it holds, by halves of shares s/(1 - s) of a second."""
    if math.isinf(near) or holds(sign * math.inf):
        return sign * math.inf
    low, high = 0.0, 1.0
    for _ in range(_HALVES):
        share = (low + high) / 2
        low, high = (share, high) if holds(near + sign * share / (1 - share)) else (low, share)
    return near + sign * low / (1 - low)


def _advice(interval: Bounds | None, run: Experiment) -> str:
    if interval is None:
        return "leave it out"
    return f"the experiment begins at {run.start:g} s" + (f" and ends at StopTime = {run.stop:g} s" if run.ends else "")


class _Bounding:
    def __init__(self, model: FlatModel, start: float, stop: float) -> None:
        self.model, self.start, self.stop = model, start, stop

    def truth(self, node: Flat) -> tuple[bool, bool]:
        """Whether a condition can be true, and whether it can be false."""
        match node:
            case Boolean(value):
                return value, not value
            case Unary("not", operand):
                can_be_true, can_be_false = self.truth(operand)
                return can_be_false, can_be_true
            case Binary("and"):
                parts = list(parts_of(node))
                found = list(map(self.truth, parts))
                fight = any(exclude(a, b, self._jumps(a)) for a, b in combinations(parts, 2))
                return all(x for x, _ in found) and not fight, any(x for _, x in found)
            case Binary("or", left, right):
                one, other = self.truth(left), self.truth(right)
                return one[0] or other[0], one[1] and other[1]
            case Binary(operator, left, right) if operator in COMPARED:
                if operator in (">", ">="):
                    left, right = right, left
                (low, high), (least, most) = self.of(left), self.of(right)
                return (low < most, high >= least) if "=" not in operator else (low <= most, high > least)
        return True, True

    def touching(self, condition: Flat) -> Iterator[Binary[Flat]]:
        """Comparisons of what moves, and stays nowhere, that are true, or false, at the end of the bounds alone."""
        match condition:
            case Binary("and" | "or", left, right):
                yield from (*self.touching(left), *self.touching(right))
            case Binary(operator, left, right) if operator in COMPARED:
                if operator in (">", ">="):
                    left, right = right, left
                (low, high), (least, most) = self.of(left), self.of(right)
                end, other = (low, most) if "=" in operator else (high, least)
                side = touches_zero(Binary("-", left, right, condition.span))
                is_end = (end == other and math.isfinite(end)) or side == (1 if "=" in operator else -1)
                if not (is_end and self._moves(condition)) or self._stays(condition):
                    return
                if "=" in operator or not self._begins_there(condition):
                    yield condition

    def _bindings(self) -> dict[str, Flat | None]:
        return {name: variable.binding for name, variable in self.model.variables.items()}

    def _moves(self, condition: Flat) -> bool:
        """Whether it compares anything but parameters."""
        return any(not isinstance(node, Ref) or self.model.variables[node.name].kind not in ("parameter", "constant", "variable")
                   for node in reached([condition], self._bindings()) if isinstance(node, Ref | Time | FrameRef))

    def _jumps(self, condition: Flat) -> bool:
        """Whether it compares what jumps and stays on a value for a while."""
        return any(self._is_stepped(node) for node in reached([condition], self._bindings()))

    def _is_stepped(self, node: Flat) -> bool:
        match node:
            case IfExpression():
                return True
            case Call(function):
                return function in _JUMPING
            case Ref(name):
                return self._kind(name) == "held" or (name in self.model.states and self.model.states[name].is_kept)
        return False

    def _kind(self, name: str) -> str:
        return self.model.variables[name].kind if name in self.model.variables else ""

    def _stays(self, condition: Flat) -> bool:
        """Whether it compares what may stay on a value: what jumps, what is given from outside or as a table, and rates, which
        friction stops."""
        def may_stay(node: Flat) -> bool:
            match node:
                case Call("der" | "table" | "table2" | "delay"):
                    return True
                case Ref(name):
                    return self._kind(name) in ("input", "delayed") or self._is_stepped(node)
                case FrameRef():
                    return node.attribute in _RATES
            return self._is_stepped(node)

        return any(may_stay(node) for node in reached([condition], self._bindings()))

    def _begins_there(self, condition: Binary[Flat]) -> bool:
        """Whether both sides are equal at the start, as those of q^2 > 0 of what rests at q = 0 until a force comes, or are not
        known there."""
        known: dict[str, float | None] = {}  # None also while it is looked for: what follows from itself is not

        def begun(node: Flat) -> Flat | None:
            if isinstance(node, Time):
                return Number(self.model.experiment.start, None, node.span)
            if not isinstance(node, Ref) or node.index:
                return None
            if node.name not in known:
                known[node.name] = None
                variable = self.model.variables.get(node.name)
                if variable is not None:
                    given = variable.start if variable.binding is None else variable.binding
                    known[node.name] = 0.0 if given is None else _number(rebuilt(given, begun))
            number = known[node.name]
            return None if number is None else Number(number, None, node.span)

        sides = [_number(rebuilt(side, begun)) for side in (condition.left, condition.right)]
        return None in sides or sides[0] == sides[1]

    def of(self, node: Flat, depth: int = 0) -> Bounds:
        """The least and the largest value that a number may have."""
        if depth > _DEEPEST:
            return _ANY
        match node:
            case Number(value):
                return value, value
            case Time():
                return self.start, self.stop
            case Ref(name, ()):
                variable = self.model.variables[name]
                if variable.kind == "variable" and variable.binding is not None and not variable.shape:
                    return self.of(variable.binding, depth + 1)
                if variable.kind != "parameter":
                    return _ANY
                return (-math.inf if variable.minimum is None else variable.minimum,
                        math.inf if variable.maximum is None else variable.maximum)
            case Unary("-", operand):
                low, high = self.of(operand, depth + 1)
                return -high, -low
            case Binary(operator, left, right) if operator in _OPERATED:
                return _OPERATED[operator](self.of(left, depth + 1), self.of(right, depth + 1))
            case Call(function, arguments, (), _):
                return self._of_call(function, [self.of(x, depth + 1) for x in arguments])
        return _ANY

    def _of_call(self, function: str, arguments: Sequence[Bounds]) -> Bounds:
        if function in ("min", "max") and len(arguments) > 1:
            choose = min if function == "min" else max
            return choose(low for low, _ in arguments), choose(high for _, high in arguments)
        return _OF_CALLS.get(function, _ANY)


def _sum(a: Bounds, b: Bounds) -> Bounds:
    return _known(a[0] + b[0], a[1] + b[1])


def _difference(a: Bounds, b: Bounds) -> Bounds:
    return _known(a[0] - b[1], a[1] - b[0])


def _product(a: Bounds, b: Bounds) -> Bounds:
    found = [0.0 if 0 in (x, y) else x * y for x in a for y in b]
    return _known(min(found), max(found))


def _quotient(a: Bounds, b: Bounds) -> Bounds:
    return _product(a, (1 / b[1], 1 / b[0])) if b[0] > 0 or b[1] < 0 else _ANY


def _power(a: Bounds, b: Bounds) -> Bounds:
    is_even = b[0] == b[1] and b[0] > 0 and b[0] % 2 == 0
    return (0.0, math.inf) if is_even or (a[0] >= 0 and b[0] == b[1]) else _ANY


def _known(low: float, high: float) -> Bounds:
    return (-math.inf if math.isnan(low) else low, math.inf if math.isnan(high) else high)


_OPERATED: Mapping[str, Callable[[Bounds, Bounds], Bounds]] = {
    "+": _sum, "-": _difference, "*": _product, "/": _quotient, "^": _power}


def _number(node: Flat) -> float | None:
    """The value of an expression of numbers alone, where it has one."""
    try:
        return fold(node)
    except LagError:
        return None
