"""The equations as a Python script that builds them in SymPy, for people who go on computing.

Run, it derives them once more from T, V, D and the forces, and asserts that both agree, by value to 20 digits.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from keyword import kwlist

import sympy as sp
from sympy.printing.str import StrPrinter

from lagrangia.algebra.with_sympy import Expr, exact_throughout, slope, with_signs
from lagrangia.base.spelling import python_text
from lagrangia.paper.book import Book
from lagrangia.paper.layout import Name
from lagrangia.paper.linear_matrices import Linear
from lagrangia.paper.numbered import NUMBERED, sides_of
from lagrangia.paper.symbolic import Given

_RESERVED = {*kwlist, "T", "V", "D", "M", "h", "f", "J", "Phi", "q", "v", "a", "t", "sp", "multipliers", "equations", "given",
             "formulas", "values", "left", "right", "rates", "rate", "derived", "points", "point", "random", "sides", "chance",
             "L_e", "V_e", "V_f"}
_WIDTH = 110
_SOLVED = 2  # coordinates: more have accelerations nobody reads


def write_script(book: Book, word: str = "lagrange", linear: Linear | None = None) -> str:
    """Symbols, T, V, D, f, Phi, M, h, J and the equations; exact numbers, the values of the parameters in a dictionary.

    Of a numbered form also its functions, and each side of its equations; of the first-order form the accelerations, of the
    linear one the matrices about its point.
    """
    e, scene = book.equations, book.equations.scene
    names = identifiers(book, {NUMBERED[word].function} if word in NUMBERED else set())

    def code(x: Expr) -> str:
        x = with_signs(exact_throughout(x))
        renamed = x.xreplace({s: sp.Symbol(names[s], real=True) for s in x.free_symbols if s in names})
        return str(_Printer().doprint(renamed))

    parameters = [p for p in scene.parameters if p.symbol in names]
    lines = [*_head(book), "import random", "", "import sympy as sp", "", "t = sp.Symbol('t', real=True)"]
    lines += [f"{names[s]} = {_constructor(s, names[s])}  # {what}" for s, what in _declared(book, names)]
    lines += ["", *(f"{name} = sp.Matrix([{_listed(names[x] for x in symbols)}])"
                    for name, symbols in (("q", scene.q), ("v", scene.v), ("a", scene.a))), ""]
    lines += [f"{letter} = {code(x) if x.free_symbols else f'sp.S({code(x)})'}"
              for letter, x in (("T", e.T), ("V", e.V_elastic + e.V_field), ("D", e.D))]
    lines += [_matrix("f", [[code(x)] for x in e.f]), _matrix("M", [[code(x) for x in row] for row in e.M]),
              _matrix("h", [[code(x)] for x in e.h])]
    if e.rows:
        lines += [_matrix("Phi", [[code(x)] for x in e.rows]), _matrix("J", [[code(x) for x in row] for row in e.J]),
                  f"multipliers = sp.Matrix([{_listed(names[x] for x in e.multipliers)}])"]
    lines += ["", f"equations = M*a + h{' + J.T*multipliers' if e.rows else ''} - f", ""]
    lines += _form(book, word, code) if word in NUMBERED else []
    given = [(names[x], code(value)) for g in scene.given for x, value in _definitions(g, scene.t) if x in names]
    lines += [_dictionary("given", given, "functions of time and constant loads, in place of their symbols")] if given else []
    formulas = [(names[p.symbol], code(p.formula)) for p in parameters if p.formula is not None]
    lines += [_dictionary("formulas", formulas, "parameters that follow from others")] if formulas else []
    numbers = [(names[p.symbol], repr(book.values[p.name])) for p in parameters]
    lines += [_dictionary("values", numbers, "SI units")] if numbers else []
    more = _accelerations(book) if word == "first-order" else _small_motion(book, linear, names, code) if linear else ([], [])
    lines += [*more[0], ""]
    return "\n".join([*lines, *_derived_again(book, names, word in NUMBERED), *more[1]])


def _accelerations(book: Book) -> tuple[list[str], list[str]]:
    """What computes them where they follow from forces and are few, and what asserts it."""
    e = book.equations
    forces = f"f - h{' - J.T*multipliers' if e.rows else ''}"
    if e.n > _SOLVED or any(e.M[k][k] == 0 for k in range(e.n)):
        return [f"r = {forces}  # M*a == r gives the accelerations: v' = a, q' = v"], []
    return ([f"r = {forces}", "rates_of_v = M.LUsolve(r)  # q' = v"],
            ["    symbols = sorted(M.free_symbols | r.free_symbols, key=str)",
             "    point = {x: sp.Rational(chance.randint(50, 150), 100) for x in symbols}",
             "    assert all(abs(sp.N(x, 30)) < 1e-20 for x in (M*rates_of_v - r).subs(point))"])


def _small_motion(book: Book, linear: Linear, names: Mapping[Expr, str], code: Callable[[Expr], str]
                  ) -> tuple[list[str], list[str]]:
    """The point and its matrices, M_0 q'' + C_0 q' + K_0 q = f_0 of what deviates from it; and what asserts them, where nothing
    moves the supports."""
    e, scene = book.equations, book.equations.scene
    point = [(names[x], code(at)) for x, at in zip((*scene.q, *e.multipliers), (*linear.point, *linear.multipliers), strict=True)]
    lines = ["", _dictionary("point_of_rest", point, "about which motion is small")]
    for name, table in (("M_0", linear.M), ("C_0", linear.C), ("K_0", linear.K), ("J_0", linear.J)):
        lines += [_matrix(name, [[code(x) for x in row] for row in table])] if table else []
    lines += [_matrix("f_0", [[code(x)] for x in linear.load])]
    if linear.varies or any(g.what in ("coordinate", "support") for g in scene.given) or scene.events:
        return lines, []
    still = [names[x] for x in (*scene.v, *scene.inputs.values(), *(y for g in scene.given for y in g.moving)) if x in names]
    lines += ["at_rest = {**point_of_rest, " + ", ".join(f"{name}: 0" for name in still) + "}",
              f"force = h - f{' + J.T*multipliers' if e.rows else ''}"]
    tables = ["(M, M_0)", "(force.jacobian(v), C_0)", "(force.jacobian(q), K_0)", *(["(J, J_0)"] if e.rows else [])]
    has_formulas = any(p.formula is not None and p.symbol in names for p in scene.parameters)
    known = ["formulas"] * has_formulas + ["values"] * any(p.symbol in names for p in scene.parameters)
    return lines, [f"    for full, small in ({', '.join(tables)}):",
                   "        for x in full.subs(at_rest) - small:",
                   *([f"            for known in ({', '.join(known)},):", "                x = x.subs(known)"] if known else []),
                   f"            largest = max(abs(sp.N(y, 30)) for y in small{'.subs(values)' if known else ''})",
                   "            assert abs(sp.N(x, 30)) < 1e-9*(1 + largest)"]


def _head(book: Book) -> list[str]:
    """What the script is, in its docstring."""
    model = book.equations.scene.kinematics.graph.model
    law = "M*a + h + J.T*multipliers == f" if book.equations.rows else "M*a + h == f"
    told = "A support jumps at times, or its rate: there dT/dv stays as it is, but for what holds it and impulses of dampers."
    title = f"{model.name}: {model.description}" if model.description else model.name
    return [f'"""{python_text(title)}.', "", f"Lagrange's equations: equations[k] == 0, that is {law}.",
            *([told] if book.has_kicks else []), '"""', ""]


def _form(book: Book, word: str, code: Callable[[Expr], str]) -> list[str]:
    """The functions of a numbered form, and its equations side by side."""
    p = book.parts
    form, (left, right) = NUMBERED[word], sides_of(book, word)
    lines = [f"V_e = {code(p.V_elastic)}", f"V_f = {code(p.V_field)}"]
    lines += [f"{form.function} = T - {'V' if form.function == 'L' else 'V_e'}"] if form.function.startswith("L") else []
    return [f"# form {form.number}, {word}", *lines, _matrix("left", [[code(x)] for x in left]),
            _matrix("right", [[code(x)] for x in right]), ""]


def _derived_again(book: Book, names: Mapping[Expr, str], is_form: bool) -> list[str]:
    """Lagrange's equations once more from T, V, D and f; shown and compared where the script is run."""
    e, scene = book.equations, book.equations.scene
    chains = [*zip(scene.q, scene.v, scene.a, strict=True), *(g.moving for g in scene.given)]
    pairs = [(names[x], names[y]) for chain in chains for x, y in pairwise(chain) if x in names and y in names]
    left, shown = ("left - right", "zip(left, right)") if is_form else ("equations", "((equation, 0) for equation in equations)")
    return [_dictionary("rates", pairs, "the rate of each symbol"), "", "", "def rate(x):", '    """dx/dt."""',
            "    return x.diff(t) + sum((x.diff(y)*rates[y] for y in rates), sp.S.Zero)", "", "",
            "derived = sp.Matrix([rate(T.diff(v[k])) - T.diff(q[k]) + V.diff(q[k]) + D.diff(v[k]) - f[k] for k in range(len(q))])"
            + (" + J.T*multipliers" if e.rows else ""), "",
            'if __name__ == "__main__":', f"    for sides in {shown}:", "        sp.pprint(sp.Eq(*sides))",
            "    chance = random.Random(1)",
            f"    symbols = sorted(({left} - derived).free_symbols, key=str)",
            "    points = [{x: sp.Rational(chance.randint(50, 150), 100) for x in symbols} for _ in range(3)]",
            f"    assert all(abs(sp.N(x.subs(point), 30)) < 1e-20 for x in {left} - derived for point in points)"]


def _definitions(g: Given, t: Expr) -> list[tuple[Expr, Expr]]:
    value = g.value
    found = []
    for x in g.moving:
        found.append((x, value))
        value = slope(value, t)
    return found


def identifiers(book: Book, others: Iterable[str] = (), spelt: Callable[[str], str] = str) -> dict[Expr, str]:
    """A Python name for each symbol: as on paper, with _d and _dd for rates and accelerations; `others` are taken, `spelt` is how
    letters are written. Angular velocities are the rates of nothing that has one."""
    e = book.equations
    without = {e.scene.q[k] for k in e.scene.turned}
    found: dict[Expr, str] = {}
    taken = {*_RESERVED, *others}
    named: Mapping[Expr, Name] = dict(book.names) | {x: book.presentation.symbols.names[x] for x in e.multipliers}
    for s, name in named.items():
        if s in without:
            continue
        if s == e.scene.t:
            found[s] = "t"
            continue
        base = re.sub(r"\W", "_", spelt("_".join(filter(None, (name.base, name.sub))))) + {0: "", 1: "_d", 2: "_dd"}[name.marks]
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
