"""A student's equation against the scene's: whether it follows from Lagrange's equations, and what is amiss; see follows.py."""

import ast
import re
from collections.abc import Callable, Mapping
from typing import NoReturn

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.diagnostics import fail, suggest
from lagrangia.paper.book import Book
from lagrangia.paper.follows import Follows, closed_points
from lagrangia.paper.layout import LETTERS, Name
from lagrangia.paper.rest_points import Begin
from lagrangia.paper.typeset import line

_BESIDE = 1e-9  # of the scene's equations in it
_HIGHEST = 20  # of powers
_DIGITS = str.maketrans("₀₁₂₃₄₅₆₇₈₉²³−", "012345678923-")
_FUNCTIONS: Mapping[str, Callable[..., Expr]] = {"sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "exp": sp.exp, "log": sp.log,
                                                 "sqrt": sp.sqrt, "abs": sp.Abs, "sign": sp.sign}
_OPERATORS: Mapping[type, Callable[[Expr, Expr], Expr]] = {
    ast.Add: lambda x, y: x + y, ast.Sub: lambda x, y: x - y, ast.Mult: lambda x, y: x * y, ast.Div: lambda x, y: x / y,
    ast.Pow: lambda x, y: x**y}


def check_equation(book: Book, text: str, begin: Callable[[], Begin]) -> tuple[bool, str]:
    """Whether the equation is the scene's, and what to say. Points of scenes with constraints lie near their start.

    Raises LagError L0706 for what cannot be read or has no value, L0912 where M and J leave accelerations open.
    """
    e = book.equations
    mine = _Reader(book).equation(text)
    scene = [e.ring.tidy(e.left[k] + e.reactions[k] - e.f[k]) for k in range(e.n)]
    if not any(sp.sympify(mine).diff(x) != 0 for x in (*e.scene.a, *e.multipliers)):
        return False, "No acceleration stands in it: it is no equation of motion."
    system = Follows(book, mine, scene)
    points = closed_points(book, system, begin()) if e.rows else system.points()
    shares = [system.shares(at) for at in points]
    if any(x is None for x in shares):
        return False, "\n".join(["It is no equation of the scene.", *_amiss(book, mine, scene)])
    if not any(abs(x) > _BESIDE for share in shares if share is not None for x in share):
        return False, "It follows from the constraints alone: it says nothing of forces."
    return True, "It is an equation of the scene: it follows from Lagrange's equations."


def _amiss(book: Book, mine: Expr, scene: list[Expr]) -> list[str]:
    """Which terms differ from the equation of one coordinate, where the accelerations are those of one."""
    e, tidy = book.equations, book.equations.ring.tidy
    factors = [sp.sympify(mine).diff(a) for a in e.scene.a]
    for k in range(e.n):
        if e.M[k][k] == 0 or factors[k] == 0:
            continue
        c = sp.cancel(factors[k] / e.M[k][k])
        if c.free_symbols & {*e.scene.q, *e.scene.v} or any(tidy(c * x - r) != 0 for x, r in zip(e.M[k], factors, strict=True)):
            continue
        gap = tidy(mine / c - scene[k])
        told = f"With the accelerations as in the equation for {line(book.q[k])}, too much on its left-hand side is"
        return [told, f"  {line(book.sum(gap))}", "(what is missing has the other sign)."]
    return ["Its accelerations are not those of any one coordinate's equation: look at T first."]


class _Reader:
    """m*x'' + k*x = P(t), in names of the page or of the model; theta or θ, k1 or k_1."""

    def __init__(self, book: Book) -> None:
        self.known: dict[str, Expr] = {"t": book.equations.scene.t, "pi": sp.pi, "π": sp.pi}
        scene = book.equations.scene
        for x, name in book.names.items():
            for label in _spellings(name):
                self.known.setdefault(label, x)
        for source, group in zip(scene.names, zip(scene.q, scene.v, scene.a, strict=True), strict=True):
            for marks, x in enumerate(group):
                self.known[_plain(source) + "__d" * marks] = x
        for p in scene.parameters:
            self.known.setdefault(_plain(p.name), p.symbol)
        for x in book.equations.multipliers:
            for label in _spellings(book.presentation.symbols.names[x]):
                self.known.setdefault(label, x)

    def equation(self, text: str) -> Expr:
        """left - right."""
        sides = text.split("=")
        if len(sides) != 2:
            fail("L0706", f"--check: '{text}' is no equation", None, "two sides with = between them: m*x'' + k*x = P(t)")
        left, right = (self._side(side) for side in sides)
        return left - right

    def _side(self, text: str) -> Expr:
        plain = re.sub(r"([\w\]])²", r"\1**2", text).translate(_DIGITS).replace("^", "**")
        plain = re.sub(r"\b(\w+)\(t\)", r"\1", plain)
        plain = re.sub(r"\blambda", "λ", plain)  # a word of Python's own
        plain = re.sub(r"([\w\].]+)('+)", lambda m: _plain(m[1]) + "__d" * len(m[2]), plain)
        try:
            tree = ast.parse(plain.strip(), mode="eval").body
        except SyntaxError:
            fail("L0706", f"--check: '{text.strip()}' cannot be read", None, "products with *, powers with ^: (k1 + k2)*x^2")
        return self._value(tree)

    def _value(self, node: ast.expr) -> Expr:
        match node:
            case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
                x, y = self._value(left), self._value(right)
                if isinstance(operator, ast.Pow) and y.is_number and abs(y) > _HIGHEST:
                    fail("L0706", f"--check: a power of more than {_HIGHEST}")
                return _OPERATORS[type(operator)](x, y) if not isinstance(operator, ast.Div) or y != 0 else _by_zero()
            case ast.UnaryOp(ast.USub(), operand):
                return -self._value(operand)
            case ast.UnaryOp(ast.UAdd(), operand):
                return self._value(operand)
            case ast.Constant(value) if isinstance(value, int | float) and not isinstance(value, bool):
                return sp.Rational(repr(value))
            case ast.Call(ast.Name(name), [argument], []) if name in _FUNCTIONS:
                return _FUNCTIONS[name](self._value(argument))
        name = _plain(ast.unparse(node))
        if name not in self.known:
            fail("L0706", f"--check: '{ast.unparse(node).replace('__d', chr(39))}' is no name of the scene", None,
                 *filter(None, [suggest(name, list(self.known))]))
        return self.known[name]


def _by_zero() -> NoReturn:
    fail("L0706", "--check: a quotient by 0")


def _plain(source: str) -> str:
    return re.sub(r"\W", "_", source)


def _spellings(name: Name) -> list[str]:
    """theta_1 as theta_1, theta1, θ_1, θ1."""
    bases = [name.base, LETTERS.get(name.base, name.base)]
    sub = name.sub.replace(" ", "_")
    ends = [f"_{sub}", sub] if sub else [""]
    return [base + end + "__d" * name.marks for base in bases for end in ends]
