"""Start values: `start`, `fixed` and initial equations -> guesses for q and v, and what remains to be solved.

An initial equation that gives one coordinate or rate a value known from parameters is taken as that value. The others are
residuals g(q, v, p) = 0, solved by the run time from the guesses, nearest to them, values given exactly not moved.
"""

from dataclasses import dataclass

import casadi as ca

from lagrangia.algebra import Scalar
from lagrangia.diagnostics import Report, Span
from lagrangia.evaluation import Value
from lagrangia.flat import Equation
from lagrangia.graph import rate_of
from lagrangia.kinematics import Kinematics
from lagrangia.tree import Call, Flat, FrameRef, Ref


@dataclass(frozen=True)
class InitialConditions:
    """q and v in SX of the parameters; `fixed` has 2 n flags, of q then of v; the residuals have the spans of their equations."""

    q: ca.SX
    v: ca.SX
    fixed: tuple[bool, ...]
    residuals: ca.SX
    residual_spans: tuple[Span, ...]


def build_initial(kinematics: Kinematics) -> InitialConditions:
    """Raises LagError (L06xx)."""
    return _Starts(kinematics).build()


class _Starts:
    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.coordinates = kinematics.graph.coordinates
        self.number = {c.name: k for k, c in enumerate(self.coordinates)}
        self.n = len(self.coordinates)
        self.report = Report()
        # q in 0 .. n-1, v in n .. 2n-1
        self.values: list[Scalar] = [0.0] * (2 * self.n)
        self.fixed: dict[int, Span | None] = {}
        self.residuals: list[tuple[Scalar, Span]] = []

    def build(self) -> InitialConditions:
        for k, coordinate in enumerate(self.coordinates):
            for slot, start in ((k, coordinate.start), (self.n + k, coordinate.rate_start)):
                if start is not None:
                    self._start(slot, start)
            if coordinate.is_fixed:
                self.fixed[k] = None
        for equation in self.kinematics.graph.model.initial_equations:
            self._equation(equation)
        self.report.raise_errors()
        n = self.n
        return InitialConditions(
            ca.vertcat(*self.values[:n]), ca.vertcat(*self.values[n:]), tuple(k in self.fixed for k in range(2 * n)),
            ca.vertcat(*[g for g, _ in self.residuals]), tuple(span for _, span in self.residuals),
        )

    def _start(self, slot: int, start: Flat) -> None:
        value = self.kinematics.evaluator.value(start)
        if isinstance(value, tuple):
            self.report.error("L0303", "a start value is one number here", start.span)
        elif self._moves(value):
            self.report.error("L0602", "a start value depends on parameters only", start.span,
                              "write an initial equation instead")
        else:
            self.values[slot] = value

    def _equation(self, equation: Equation) -> None:
        for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
            slots = self._slots(side)
            if slots is None:
                continue
            values = self.kinematics.evaluator.value(other)
            parts = list(values) if isinstance(values, tuple) else [values]
            if len(parts) != len(slots):
                self.report.error("L0303", f"{_counted(len(parts))} for {_counted(len(slots))}", equation.span)
                return
            if any(self._moves(part) for part in parts):
                continue
            for slot, part in zip(slots, parts, strict=True):
                self._fix(slot, part, equation.span)
            return
        self._residual(equation)

    def _fix(self, slot: int, value: Scalar, span: Span) -> None:
        earlier = self.fixed.get(slot)
        if earlier is not None:
            coordinate = self.coordinates[slot % self.n]
            name = coordinate.name if slot < self.n else coordinate.rate_name
            self.report.error("L0601", f"'{name}' is given two initial values", span,
                              f"the other is at {earlier}", "leave one of them out")
        self.values[slot], self.fixed[slot] = value, span

    def _residual(self, equation: Equation) -> None:
        left, right = (self.kinematics.evaluator.value(side) for side in (equation.left, equation.right))
        if isinstance(left, tuple) != isinstance(right, tuple) or (isinstance(left, tuple) and len(left) != len(right)):
            self.report.error("L0303", "the sides of this equation have different sizes", equation.span)
            return
        pairs = zip(left, right, strict=True) if isinstance(left, tuple) else ((left, right),)
        for a, b in pairs:
            gap = ca.SX(a - b)
            if not ca.depends_on(gap, self._state()):
                self.report.error("L0603", "this initial equation says nothing about positions or velocities", equation.span,
                                  "name a coordinate, its rate or a place: hinge.phi = 0.5; der(hinge.phi) = 2;")
            self.residuals.append((self._at_start(gap), equation.span))

    def _at_start(self, value: ca.SX) -> ca.SX:
        symbols, model = self.kinematics.symbols, self.kinematics.graph.model
        return ca.substitute([value], [symbols.time, symbols.tau], [ca.SX(model.experiment.start), ca.SX(1)])[0]

    # ------------------------------------------------------------ what an expression names

    def _slots(self, node: Flat) -> list[int] | None:
        """Slots of q and v that a side of an equation names: phi, der(phi), w bound to der(phi), bar.center.r when it floats."""
        if isinstance(node, Ref) and not node.index:
            return self._named(node.name)
        if isinstance(node, Call) and node.function == "der" and isinstance(node.arguments[0], Ref):
            position = self.number.get(node.arguments[0].name)
            return [self.n + position] if position is not None else None
        if isinstance(node, FrameRef):
            names = {"x": ["x"], "y": ["y"], "phi": ["phi"], "r": ["x", "y"], "v": ["x", "y"], "w": ["phi"]}[node.attribute]
            picked = [names[i - 1] for i in node.index] or names
            numbers = [self.number.get(f"{node.name}.{name}") for name in picked]
            shift = self.n if node.attribute in ("v", "w") else 0
            return None if None in numbers else [k + shift for k in numbers if k is not None]
        return None

    def _named(self, name: str) -> list[int] | None:
        if name in self.number:
            return [self.number[name]]
        variable = self.kinematics.graph.model.variables[name]
        of = rate_of(variable)
        return [self.n + self.number[of]] if of in self.number else None

    def _state(self) -> ca.SX:
        symbols = self.kinematics.symbols
        return ca.vertcat(*symbols.positions.values(), *symbols.rates.values())

    def _moves(self, value: Value) -> bool:
        moving = ca.vertcat(self.kinematics.algebra.state, self.kinematics.symbols.time)
        return isinstance(value, ca.SX) and ca.depends_on(value, moving)


def _counted(count: int) -> str:
    return "one number" if count == 1 else f"a vector of {count}"
