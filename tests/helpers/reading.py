"""Printed formulas read back: text in Unicode -> SymPy, with a symbol for every name as it is printed.

δ(...) is the virtual change of what stands in it, d/dt (...) its rate; ∂T/∂x', f_nc,x and the like are names.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import sympy as sp

_VULGAR = {"½": "1/2", "⅓": "1/3", "⅔": "2/3", "¼": "1/4", "¾": "3/4", "⅕": "1/5", "⅙": "1/6", "⅛": "1/8", "⅜": "3/8"}
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_FUNCTIONS = {"sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "exp": sp.exp, "ln": sp.log, "sgn": sp.sign, "tanh": sp.tanh,
              "arcsin": sp.asin, "arccos": sp.acos, "arctan": sp.atan, "atan2": sp.atan2, "min": sp.Min, "max": sp.Max}
_RAISES = "⁰¹²³⁴⁵⁶⁷⁸⁹"  # which \w takes for digits of a word
_WORD = rf"[^\W\d{_RAISES}][^\W{_RAISES}]*"
_TOKENS = re.compile(rf"""\s*(?:
    (?P<number>\d+(?:\.\d+)?(?:e-?\d+)?(?:/\d+(?![\w(]))?|[{''.join(_VULGAR)}])
  | (?P<slope>(?:d/dt\s)?[∂]{_WORD}(?:,[^\W{_RAISES}]+)*'*/∂{_WORD}(?:,[^\W{_RAISES}]+)*'*)
  | (?P<rate>d/dt)
  | (?P<name>[δΔ]?{_WORD}(?:,[^\W{_RAISES}]+)*'*(?:\(t\))?)
  | (?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)
  | (?P<sign>[-−+/()|√,^·δ])
)""", re.VERBOSE)


class NotRead(Exception):
    """The text is no formula of this grammar: a matrix, words, a general formula."""


@dataclass
class Motion:
    """What names stand for: coordinates with their rates, rates with their accelerations, and virtual displacements."""

    rates: Mapping[str, str]  # x: x', x': x''
    virtual: Mapping[str, str]  # x: δx


def read(text: str, motion: Motion) -> sp.Expr:
    """Raises NotRead."""
    tokens, at = [], 0
    text = text.strip()
    while at < len(text):
        match = _TOKENS.match(text, at)
        if match is None or match.end() == at:
            raise NotRead(text[at:])
        tokens.append((match.lastgroup, match[match.lastgroup]))
        at = match.end()
    reader = _Reader(tokens, motion)
    found = reader.sum()
    if reader.at < len(tokens):
        raise NotRead(f"{tokens[reader.at]} in {text}")
    return found


@dataclass
class _Reader:
    tokens: list[tuple[str, str]]
    motion: Motion
    at: int = 0

    def peek(self) -> tuple[str, str]:
        return self.tokens[self.at] if self.at < len(self.tokens) else ("", "")

    def take(self, text: str = "") -> str:
        kind, here = self.peek()
        if not kind or (text and here != text):
            raise NotRead(f"{here} where {text} was expected")
        self.at += 1
        return here

    def sum(self) -> sp.Expr:
        total = sp.S.Zero
        sign = -1 if self.peek()[1] in "-−" and self.peek()[1] else 1
        if sign < 0:
            self.take()
        total = sign * self.term()
        while self.peek()[1] in ("+", "-", "−"):
            sign = 1 if self.take() == "+" else -1
            total += sign * self.term()
        return total

    def term(self) -> sp.Expr:
        total = self.factor()
        while True:
            kind, text = self.peek()
            if text == "/":
                self.take()
                total = total / self.factor()
            elif text == "·":
                self.take()
                total *= self.factor()
            elif kind in ("number", "name", "slope", "rate") or text in ("(", "√", "δ") or (text == "|" and not self.inside):
                total *= self.factor()
            else:
                return total

    inside: int = 0

    def factor(self) -> sp.Expr:
        return self.raised(self.base())

    def raised(self, base: sp.Expr) -> sp.Expr:
        kind, text = self.peek()
        if kind == "raised":
            self.take()
            return base ** sp.Integer(int(text.translate(_RAISED)))
        if text == "^":
            self.take()
            return base ** self.base()
        return base

    def base(self) -> sp.Expr:
        kind, text = self.tokens[self.at] if self.at < len(self.tokens) else ("", "")
        if not kind:
            raise NotRead("the end")
        self.at += 1
        if kind == "number":
            fraction = Fraction(_VULGAR.get(text, text)) if "e" not in text else Fraction(text)
            return sp.Rational(fraction.numerator, fraction.denominator)
        if kind == "name" and text in _FUNCTIONS:
            return self.function(text)
        if kind == "name" and text == "δ":
            return self.enclosed(text)
        if kind == "name" and text == "π":
            return sp.pi
        if kind in ("name", "slope"):
            return sp.Symbol(re.sub(r"\s+", " ", text), real=True)
        if kind == "rate":
            inner = self.base()
            return sum((inner.diff(sp.Symbol(x, real=True)) * sp.Symbol(v, real=True) for x, v in self.motion.rates.items()),
                       sp.S.Zero)
        return self.enclosed(text)

    def enclosed(self, text: str) -> sp.Expr:
        if text == "(":
            was, self.inside = self.inside, 0
            found = self.sum()
            self.inside = was
            self.take(")")
            return found
        if text == "|":
            self.inside += 1
            found = self.sum()
            self.inside -= 1
            self.take("|")
            return sp.Abs(found)
        if text == "√":
            return sp.sqrt(self.base())
        if text == "δ":
            inner = self.base()
            return sum((inner.diff(sp.Symbol(x, real=True)) * sp.Symbol(d, real=True) for x, d in self.motion.virtual.items()),
                       sp.S.Zero)
        raise NotRead(text)

    def function(self, name: str) -> sp.Expr:
        power = int(self.take().translate(_RAISED)) if self.peek()[0] == "raised" else 1
        arguments = []
        if self.peek()[1] == "(":
            self.take()
            arguments.append(self.sum())
            while self.peek()[1] == ",":
                self.take()
                arguments.append(self.sum())
            self.take(")")
        else:
            arguments.append(self.base())
        return _FUNCTIONS[name](*arguments) ** power
