"""Taylor coefficients of motions with attitudes: what their tapes say of a step's beginning, by quaternions."""

import operator
from collections.abc import Callable, Mapping
from dataclasses import field

from lagrangia.base.records import dataclass
from lagrangia.native.series_writer import MODES, POSITIONS, Jet, Number, Value, Writer
from lagrangia.native.tapes import JetOp, Op

# Operations on literals.
_FOLDED: Mapping[int, Callable[[float, float], float]] = {
    Op.ADD: operator.add, Op.SUB: operator.sub, Op.MUL: operator.mul, Op.DIV: operator.truediv, Op.NEG: lambda x, _: -x,
    Op.SQ: lambda x, _: x * x, Op.TWICE: lambda x, _: 2 * x, Op.INV: lambda x, _: 1 / x,
}


@dataclass
class TurnedWriter(Writer):
    """Of motions with attitudes. A step begins where the positions of an attitude are 0 (runtime/state/attitudes.c), and its
    reference is the attitude there: the jets of its four parts take the place of both, Q' = Q (0, w)/2. What 0 and 1 make
    superfluous is left out, and products of the same jets with different factors are one."""

    attitudes: Mapping[int, tuple[int, int]] = field(default_factory=dict)  # by first positions, the first mode and jet
    scaled: dict[int, tuple[Number, Jet]] = field(default_factory=dict)
    known: dict[tuple[int, ...], Jet] = field(default_factory=dict)

    def read(self, argument: int, element: int) -> Value:
        """Positions of attitudes are 0, and their references jets."""
        for place, (mode, slot) in self.attitudes.items():
            if argument == POSITIONS and place <= element < place + 3:
                return self.literal(0.0)
            if argument == MODES and mode <= element < mode + 4:
                return Jet(slot + element - mode)
        return super().read(argument, element)

    def value_of(self, x: Value | None) -> float | None:
        """Of a literal."""
        op, value, _ = self.numbers[x.place] if isinstance(x, Number) else (int(Op.INPUT), 0.0, 0)
        return value if op == Op.CONST else None

    def compute(self, op: int, a: Value, b: Value | None) -> Value:
        """Without what literals 0 and 1 make superfluous."""
        x, y = self.value_of(a), self.value_of(b)
        if x is not None and (y is not None or b is None) and op in _FOLDED:
            return self.literal(_FOLDED[op](x, 0.0 if y is None else y))
        if (op in (Op.MUL, Op.DIV) and x == 0) or (op == Op.MUL and y == 0):
            return self.literal(0.0)
        if b is not None and ((op in (Op.ADD, Op.SUB) and y == 0) or (op in (Op.MUL, Op.DIV) and y == 1)):
            return a
        if b is not None and ((op == Op.ADD and x == 0) or (op == Op.MUL and x == 1)):
            return b
        if b is not None and op == Op.SUB and x == 0:
            return self.compute(Op.NEG, b, None)
        return super().compute(op, a, b)

    def unary(self, op: int, a: Jet) -> Value:
        """Signs and twos are factors."""
        if op in (Op.NEG, Op.TWICE):
            return self.product(self.literal(-1.0 if op == Op.NEG else 2.0), a)
        return super().unary(op, a)

    def parts(self, x: Value) -> tuple[Value, Jet | None]:
        """Its factor, and what is a jet in it."""
        if isinstance(x, Number):
            return x, None
        return self.scaled.get(x.slot, (self.literal(1.0), x))

    def product(self, a: Value, b: Value) -> Value:
        """One for all factors."""
        (factor, u), (other, v) = self.parts(a), self.parts(b)
        scale = self.compute(Op.MUL, factor, other)
        if u is None or v is None:
            jet = u or v
        else:
            key = min(u.slot, v.slot), max(u.slot, v.slot)
            if key not in self.known:
                self.known[key] = self.jet(JetOp.SQUARE, u) if u == v else self.jet(JetOp.PRODUCT, u, v)
            jet = self.known[key]
        return scale if jet is None else self.times(scale, jet)

    def times(self, factor: Value, jet: Jet) -> Value:
        """A jet by a factor."""
        assert isinstance(factor, Number)
        if self.value_of(factor) in (0.0, 1.0):
            return jet if self.value_of(factor) else self.literal(0.0)
        key = -1 - factor.place, jet.slot
        if key not in self.known:
            self.known[key] = self.jet(JetOp.SCALE, factor, jet)
            self.scaled[self.known[key].slot] = factor, jet
        return self.known[key]

    def sum(self, op: int, a: Value, b: Value) -> Value:
        """Of the same jet with two factors: the jet with their sum."""
        (factor, u), (other, v) = self.parts(a), self.parts(b)
        if u is not None and u == v:
            return self.times(self.compute(op, factor, other), u)
        return super().sum(op, a, b)
