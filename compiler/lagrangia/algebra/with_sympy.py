"""The second algebra: SymPy, for people. Numbers are exact, conditions become Piecewise.

Imported only when equations are asked for.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import sympy as sp

from lagrangia.algebra.duals import Scalar, nested_lines, times
from lagrangia.base.diagnostics import Span
from lagrangia.base.table_data import Beyond, TableData

Expr = Any  # sp.Expr, whose type hints are not complete
_STEPS = (sp.sign, sp.floor, sp.ceiling)
TIME = sp.Symbol("time", real=True)  # a word of the language: no quantity of a model is called so


class SympyAlgebra:
    """Scalars are SymPy expressions; a distance needs no guard against its zero."""

    tiny = 0
    most_points = 100  # nobody reads so many cases, and they take seconds

    def __init__(self) -> None:
        self.sizes: list[Expr] = []  # squares of what roots and sizes were taken of

    def number(self, value: float) -> Scalar:
        """The exact number that was meant."""
        return exact(value)

    def slope(self, f: Scalar, x: Scalar) -> Scalar:
        """df/dx."""
        return sp.sympify(f).diff(x)

    def at_rest(self, f: Scalar, rates: Sequence[Scalar]) -> Scalar:
        """f without these rates."""
        return sp.sympify(f).xreplace(dict.fromkeys(rates, sp.S.Zero))

    def product(self, x: Scalar, y: Scalar) -> Scalar:
        """The same."""
        return times(x, y)

    def quotient(self, x: Scalar, y: Scalar, place: Span) -> Scalar:
        """The same: no steps are taken."""
        return x / y

    def note_length(self, x: Scalar) -> None:
        """Nothing is noted: SymPy keeps corners as they are."""
        pass

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        """SymPy's function of that name."""
        if function in ("sqrt", "abs"):
            self.sizes.append(sp.sympify(arguments[0]) ** (1 if function == "sqrt" else 2))
        return _FUNCTIONS[function](*(sp.sympify(a) for a in arguments))

    def compare(self, operator: str, a: Scalar, b: Scalar, of_rates: bool = False) -> Scalar:
        """SymPy's relation."""
        return _COMPARE[operator](sp.sympify(a), sp.sympify(b))

    def side(self, x: Scalar) -> Scalar:
        """SymPy's sign."""
        return self.call("sign", x)

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        """A Piecewise of both."""
        return sp.Piecewise((then, _truth(condition)), (otherwise, True))

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        """SymPy's operators of conditions."""
        return _LOGIC[operator](*(_truth(c) for c in conditions))

    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        """The table as nested choices, and its slope."""
        return nested_lines(self, x, xs, ys)

    def pieces(self, x: Scalar, table: TableData) -> list[Scalar]:
        """Each as a Piecewise of x."""
        x, n = sp.sympify(x), table.n
        moved = exact(table.period) * sp.floor((x - exact(table.knot(0))) / exact(table.period)) \
            if table.beyond is Beyond.PERIODIC else sp.S.Zero
        columns = zip(*(map(exact, table.piece_number(k)) for k in range(n + 1)), strict=True)
        cases = [sp.Lt(x - moved, exact(table.knot(k))) for k in range(n)]
        place, *others = [sp.Piecewise(*zip(column, (*cases, True), strict=True)) for column in columns]
        return [place + moved, *others]


def _truth(condition: Scalar) -> Any:
    """A condition may be the number 1 or 0."""
    return sp.Ne(condition, 0) if isinstance(condition, sp.Expr | float | int) else condition


_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: getattr(sp, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh",
                                            "atanh", "exp", "log", "sqrt", "floor", "sign", "atan2")},
    "log10": lambda x: sp.log(x, 10), "ceil": sp.ceiling, "abs": sp.Abs, "fmin": sp.Min, "fmax": sp.Max, "pow": sp.Pow,
    "mod": lambda a, b: a - b * sp.floor(a / b),
}
_COMPARE: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": sp.StrictLessThan, "<=": sp.LessThan, ">": sp.StrictGreaterThan, ">=": sp.GreaterThan, "==": sp.Eq, "<>": sp.Ne,
}
_LOGIC: Mapping[str, Callable[..., Any]] = {"and": sp.And, "or": sp.Or, "not": sp.Not}


@cache
def exact(value: float) -> Expr:
    """The number that a person meant: a short decimal, a fraction, or a multiple of pi (angles come in degrees).

    Differs from `value` by a rounding error at most.
    """
    if value == int(value) if math.isfinite(value) else False:
        return sp.Integer(int(value))
    if not math.isfinite(value):
        return sp.oo if value > 0 else -sp.oo if value < 0 else sp.nan
    digits = repr(value).partition("e")[0].replace(".", "").strip("-0")
    if len(digits) <= 12:
        return sp.Rational(repr(value))
    for unit, size in ((sp.S.One, 1.0), (sp.pi, math.pi)):
        fraction = Fraction(value / size).limit_denominator(3600)
        if abs(float(fraction) * size - value) <= 4e-16 * abs(value):
            return sp.Rational(fraction.numerator, fraction.denominator) * unit
    short = f"{value:.15g}"
    return sp.Rational(short if len(short) < len(repr(value)) - 2 else repr(value))


def slope(expression: Expr, x: Expr) -> Expr:
    """d/dx, of minima and maxima by cases, of what jumps zero but at one point."""
    found = with_signs(sp.sympify(expression)).diff(x)
    found = found.replace(lambda e: isinstance(e, sp.Heaviside | sp.DiracDelta | sp.Derivative | sp.Subs), _plain_slope)
    if not found.has(sp.sign):
        return found
    found = found.replace(lambda e: e.is_Pow and isinstance(e.base, sp.sign) and e.exp == -1, lambda e: e.base)  # no 0/0 at 0
    return found.replace(lambda e: e.is_Mul and any(isinstance(y, sp.sign) for y in e.args), _with_sizes)


def with_signs(e: Expr) -> Expr:
    """x/|x| as sgn x, which jumps at 0 and has no slope beside it; sgn^2 x, of these alone, as 1."""
    if not e.has(sp.Abs):
        return e
    found = e.replace(lambda y: y.is_Mul and any(_is_inverse_size(z) for z in y.args), _directed)
    is_square = lambda y: y.is_Pow and isinstance(y.base, sp.sign) and y.exp == 2  # noqa: E731
    return found if found == e else found.replace(is_square, lambda y: sp.S.One)


def _is_inverse_size(e: Expr) -> bool:
    return bool(e.is_Pow and isinstance(e.base, sp.Abs) and e.exp.is_number and e.exp.is_negative)


def _directed(e: Expr) -> Expr:
    for size in [z.base for z in e.args if _is_inverse_size(z)]:
        if e.as_powers_dict().get(size.args[0], sp.S.Zero) == 1:
            e = e * size / size.args[0] * sp.sign(size.args[0])
    return e


def _plain_slope(e: Expr) -> Expr:
    if isinstance(e, sp.Heaviside):
        return sp.Piecewise((sp.S.One, e.args[0] > 0), (sp.S.Zero, True))
    inner = e.expr if isinstance(e, sp.Subs) else e  # of a step of a formula
    is_step = isinstance(inner, sp.Derivative) and isinstance(inner.expr, _STEPS)
    return sp.S.Zero if is_step or inner == 0 or isinstance(inner, sp.DiracDelta) else e


def _with_sizes(e: Expr) -> Expr:
    """x sgn x as |x|, |x| sgn x as x, sgn(x sgn y) sgn y as sgn x."""
    signs = [y for y in e.args if isinstance(y, sp.sign)]
    for s in signs:
        if (inner := next((y for y in signs if y is not s and y in s.args[0].as_powers_dict()), None)) is not None:
            return e / s / inner * sp.sign(s.args[0] / inner)
        x = s.args[0]
        powers = e.as_powers_dict()
        for here, there in ((x, sp.Abs(x)), (sp.Abs(x), x)):
            if powers.get(s, 0) == 1 and powers.get(here, sp.S.Zero).is_positive:
                e = e / s / here * there
                break
    return e


def exact_throughout(expression: Expr) -> Expr:
    """The expression without binary fractions."""
    expression = sp.sympify(expression)
    floats = expression.atoms(sp.Float)
    return expression.xreplace({f: exact(float(f)) for f in floats}) if floats else expression
