"""The equations as a Python script that builds them in SymPy, for people who go on computing."""

import re
from collections.abc import Iterable, Mapping
from keyword import kwlist

import sympy as sp
from sympy.printing.str import StrPrinter

from lagrangia.algebra.with_sympy import Expr, exact_throughout, slope
from lagrangia.base.spelling import python_text
from lagrangia.paper.book import Book
from lagrangia.paper.layout import Name
from lagrangia.paper.symbolic import Given

_RESERVED = {*kwlist, "T", "V", "D", "M", "h", "f", "J", "Phi", "q", "v", "a", "t", "sp", "multipliers", "equations", "given",
             "formulas", "values"}
_WIDTH = 110


def write_script(book: Book) -> str:
    """Symbols, T, V, D, f, Phi, M, h, J and the equations; exact numbers, the values of the parameters in a dictionary."""
    e, scene = book.equations, book.equations.scene
    model = scene.kinematics.graph.model
    names = identifiers(book)

    def code(x: Expr) -> str:
        x = exact_throughout(x)
        renamed = x.xreplace({s: sp.Symbol(names[s], real=True) for s in x.free_symbols if s in names})
        return str(_Printer().doprint(renamed))

    parameters = [p for p in scene.parameters if p.symbol in names]
    law = "M*a + h + J.T*multipliers == f" if e.rows else "M*a + h == f"
    told = "A support jumps at times, or its rate: there dT/dv stays as it is, but for what holds it and impulses of dampers."
    kicks = [told] * book.has_kicks
    title = f"{model.name}: {model.description}" if model.description else model.name
    lines = [f'"""{python_text(title)}.', "",
             f"Lagrange's equations: equations[k] == 0, that is {law}.", *kicks, '"""', "", "import sympy as sp", ""]
    lines += ["t = sp.Symbol('t', real=True)"]
    lines += [f"{names[s]} = {_constructor(s, names[s])}  # {what}" for s, what in _declared(book, names)]
    lines += ["", *(f"{name} = sp.Matrix([{_listed(names[x] for x in symbols)}])"
                    for name, symbols in (("q", scene.q), ("v", scene.v), ("a", scene.a))), ""]
    lines += [f"T = {code(e.T)}", f"V = {code(e.V_elastic + e.V_field)}", f"D = {code(e.D)}",
              _matrix("f", [[code(x)] for x in e.f]), _matrix("M", [[code(x) for x in row] for row in e.M]),
              _matrix("h", [[code(x)] for x in e.h])]
    if e.rows:
        lines += [_matrix("Phi", [[code(x)] for x in e.rows]), _matrix("J", [[code(x) for x in row] for row in e.J]),
                  f"multipliers = sp.Matrix([{_listed(names[x] for x in e.multipliers)}])"]
    lines += ["", f"equations = M*a + h{' + J.T*multipliers' if e.rows else ''} - f", ""]
    given = [(names[x], code(value)) for g in scene.given for x, value in _definitions(g, scene.t) if x in names]
    lines += [_dictionary("given", given, "functions of time and constant loads, in place of their symbols")] if given else []
    formulas = [(names[p.symbol], code(p.formula)) for p in parameters if p.formula is not None]
    lines += [_dictionary("formulas", formulas, "parameters that follow from others")] if formulas else []
    numbers = [(names[p.symbol], repr(book.values[p.name])) for p in parameters]
    lines += [_dictionary("values", numbers, "SI units")] if numbers else []
    lines += ["", 'if __name__ == "__main__":', "    for equation in equations:", "        sp.pprint(sp.Eq(equation, 0))"]
    return "\n".join(lines)


def _definitions(g: Given, t: Expr) -> list[tuple[Expr, Expr]]:
    value = g.value
    found = []
    for x in g.moving:
        found.append((x, value))
        value = slope(value, t)
    return found


def identifiers(book: Book) -> dict[Expr, str]:
    """A Python name for each symbol: as on paper, with _d and _dd for rates and accelerations."""
    e = book.equations
    found: dict[Expr, str] = {}
    taken = set(_RESERVED)
    named: Mapping[Expr, Name] = dict(book.names) | {x: book.presentation.symbols.names[x] for x in e.multipliers}
    for s, name in named.items():
        if s == e.scene.t:
            found[s] = "t"
            continue
        base = re.sub(r"\W", "_", "_".join(filter(None, (name.base, name.sub)))) + {0: "", 1: "_d", 2: "_dd"}[name.marks]
        while base in taken:
            base += "_"
        taken.add(base)
        found[s] = base
    return found


def _declared(book: Book, names: Mapping[Expr, str]) -> list[tuple[Expr, str]]:
    scene = book.equations.scene
    found: list[tuple[Expr, str]] = []
    for name, q, v, a in zip(scene.names, scene.q, scene.v, scene.a, strict=True):
        found += [(q, name), (v, f"der({name})"), (a, f"der(der({name}))")]
    found += [(p.symbol, f"{p.name}{f', {p.unit}' if p.unit else ''}") for p in scene.parameters]
    found += [(x, str(x)) for g in scene.given for x in g.moving] + [(x, f"input {label}") for label, x in scene.inputs.items()]
    found += [(x, "multiplier") for x in book.equations.multipliers]
    return [(s, what) for s, what in found if s in names]


def _constructor(s: Expr, name: str) -> str:
    return f"sp.Symbol('{name}', {'nonnegative' if s.is_nonnegative else 'real'}=True)"


class _Printer(StrPrinter):  # type: ignore[misc]
    """SymPy's functions by their module, fractions that stay exact in Python."""

    def _print_Rational(self, e: Expr) -> str:
        return f"sp.Rational({e.p}, {e.q})"

    def _print_Function(self, e: Expr) -> str:
        return f"sp.{type(e).__name__}({', '.join(map(self._print, e.args))})"

    def _print_Pow(self, e: Expr, rational: bool = False) -> str:
        return f"sp.sqrt({self._print(e.base)})" if e.exp == sp.S.Half else str(super()._print_Pow(e, rational=True))

    def _print_LatticeOp(self, e: Expr) -> str:
        return f"sp.{type(e).__name__}({', '.join(map(self._print, sorted(e.args, key=str)))})"

    _print_And = _print_Or = _print_Not = _print_LatticeOp

    def _print_Relational(self, e: Expr) -> str:
        return f"sp.{type(e).__name__}({self._print(e.lhs)}, {self._print(e.rhs)})" if e.rel_op in ("==", "!=") \
            else str(super()._print_Relational(e))

    def _print_Pi(self, e: Expr) -> str:
        return "sp.pi"

    def _print_Exp1(self, e: Expr) -> str:
        return "sp.E"

    def _print_Abs(self, e: Expr) -> str:
        return f"sp.Abs({self._print(e.args[0])})"

    def _print_Piecewise(self, e: Expr) -> str:
        return f"sp.Piecewise({', '.join(f'({self._print(value)}, {self._print(when)})' for value, when in e.args)})"


def _listed(items: Iterable[str]) -> str:
    return ", ".join(items)


def _matrix(name: str, rows: list[list[str]]) -> str:
    body = [f"[{', '.join(row)}]" for row in rows]
    whole = f"{name} = sp.Matrix([{', '.join(body)}])"
    return whole if len(whole) <= _WIDTH else f"{name} = sp.Matrix([\n    " + ",\n    ".join(body) + ",\n])"


def _dictionary(name: str, items: list[tuple[str, str]], words: str) -> str:
    pairs = [f"{k}: {v}" for k, v in items]
    whole = f"{name} = {{{', '.join(pairs)}}}  # {words}"
    return whole if len(whole) <= _WIDTH else f"{name} = {{  # {words}\n    " + ",\n    ".join(pairs) + ",\n}"
