"""Equations -> a flat Modelica model: parameters with units, start values, Lagrange's equations.

Constraints stand differentiated twice, so that a tool needs no index reduction: the accelerations and multipliers are the
unknowns of a linear system. So that they hold after a long run, what errors leave of Phi and Phi' dies out as exp(-closing t):

    q' = v + J^T mu,   J q' + Phi_t = -closing Phi,   d/dt (J v + Phi_t) = -closing (J v + Phi_t)

mu is zero on the exact motion, which is not changed (Gear, Gupta and Leimkuhler 1985, with decay in place of an index of two).
Attitudes are unit quaternions Q, their rates angular velocities w along the turned axes; Q is kept at its length alike:

    Q' = Q (0, w + J^T mu)/2 + closing (1 - |Q|^2)/2 Q
"""

import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence

import sympy as sp
from sympy.printing.precedence import PRECEDENCE, precedence
from sympy.printing.str import StrPrinter

from lagrangia.algebra.with_sympy import Expr, exact_throughout, slope, with_signs
from lagrangia.base.diagnostics import LagError
from lagrangia.base.spelling import in_ascii
from lagrangia.frames.evaluation import scalars_of
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.frame_attributes import component_named
from lagrangia.paper.book import Book
from lagrangia.paper.symbolic import SymbolicScene
from lagrangia.paper.sympy_script import identifiers

RESERVED = set("""algorithm and annotation block break class connect connector constant constrainedby der discrete each else
    elseif elsewhen encapsulated end enumeration equation expandable extends external false final flow for function if import
    impure in initial inner input loop model not operator or outer output package parameter partial protected public pure record
    redeclare replaceable return stream then true type when while within time Real Integer Boolean String""".split())
_CLOSING = 10.0  # 1/s
_MOST = 2**53  # beyond, not all integers are doubles
_NAMES = {"Abs": "abs", "ceiling": "ceil"}
_LOGARITHMS = (sp.asinh, sp.acosh, sp.atanh)  # which Modelica has not


def identifier(wanted: str) -> str:
    """Of Modelica, whose letters are those of ASCII: bär is bar, ω is omega."""
    found = re.sub(r"[^A-Za-z0-9_]+|_{2,}", "_", letters(wanted)).strip("_") or "part"
    return f"_{found}" if found[0].isdigit() else found


def letters(wanted: str) -> str:
    """Those of ASCII for others: without their accents, Greek ones by their names."""
    bare = (c for c in unicodedata.normalize("NFD", wanted) if not unicodedata.combining(c))
    return "".join(c if c.isascii() else c.casefold() if c.casefold().isascii() else in_ascii(c) for c in bare)


def write_modelica(book: Book, starts: Mapping[str, float], remarks: Iterable[str] = ()) -> str:
    """`starts` are the assembled start values by coordinate and der(coordinate), and those of the inputs."""
    e, scene = book.equations, book.equations.scene
    model = scene.kinematics.graph.model
    # names as on paper, phi_d and phi_dd for rates and accelerations
    names = identifiers(book, RESERVED, letters) | {scene.t: "time"}
    printer = Printer()

    def code(x: Expr) -> str:
        x = _without_given_rates(scene, with_signs(exact_throughout(x)))
        return str(printer.doprint(x.xreplace({s: sp.Symbol(names[s], real=True) for s in x.free_symbols if s in names})))

    told, lost = _outputs(book, names, code)
    remarks = [*([f"outputs are not written: {', '.join(lost)}"] if lost else []), *remarks]
    lines = [f"model {identifier(model.name)}{quoted(model.description)}", *(f"  // {remark}" for remark in remarks)]
    for p in (p for p in scene.parameters if p.symbol in names):
        value = code(p.formula) if p.formula is not None else repr(book.values[p.name])
        lines.append(f"  parameter Real {names[p.symbol]}{unit_of(p.unit)} = {value}{quoted(p.description)};")
    for label, x in scene.inputs.items():
        lines += [f"  input Real {names[x]}(start = {starts[label]!r}); // {label}"] if x in names else []
    lines += [f"  Real {names[g.symbol]};" for g in scene.given if g.symbol in names]
    lines += [*_states(scene, names, starts), *_attitudes(scene, names, starts), *(f"  Real {names[x]};" for x in e.multipliers)]
    closers = [_free_name(f"mu_{k + 1}", names) for k in range(scene.holonomic)]
    lines += [f"  Real {x};" for x in closers]
    closing = _free_name("closing", names)
    if e.rows or scene.turnings:
        lines.append(closing_line(closing))
    lines += [*told, "equation"]
    lines += [f"  {names[g.symbol]} = {code(g.value)};" for g in scene.given if g.symbol in names]
    steps = [sum((sp.Symbol(x, real=True) * row[k] for x, row in zip(closers, e.J, strict=False)), sp.S.Zero) for k in range(e.n)]
    for k, (q, v, a, step) in enumerate(zip(scene.q, scene.v, scene.a, steps, strict=True)):
        lines += [f"  der({names[q]}) = {code(v + step)};"] if k not in scene.turned else []
        lines.append(f"  der({names[v]}) = {names[a]};")
    lines += _turns(scene, names, steps, sp.Symbol(closing, real=True), code)
    lines += _motion(book, names, code)
    lines += _constraints(book, steps, sp.Symbol(closing, real=True), code)
    return "\n".join([*lines, experiment_line(model), f"end {identifier(model.name)};"])


def _states(scene: SymbolicScene, names: Mapping[Expr, str], starts: Mapping[str, float]) -> list[str]:
    """Coordinates and rates with their starts, and accelerations."""
    lines, variables = [], scene.kinematics.graph.model.variables
    told = {k: f"der({turning.name})[{i}]" for turning in scene.turnings for i, k in enumerate(turning.places, 1)}
    for k, name in enumerate(scene.names):
        variable = variables.get(name)
        unit = "rad" if k in scene.turned else variable.unit if variable else component_named(name).unit
        states = [(scene.q[k], name, unit), (scene.v[k], told.get(k, f"der({name})"), f"{unit}/s" if unit else "")]
        for s, source, dimension in states[k in scene.turned :]:
            start = f"start = {starts[source]!r}, fixed = true"
            lines.append(f"  Real {names[s]}({start}{f', unit = {_text(dimension)}' if dimension else ''}){quoted(source)};")
        lines.append(f"  Real {names[scene.a[k]]};")
    return lines


def _attitudes(scene: SymbolicScene, names: Mapping[Expr, str], starts: Mapping[str, float]) -> list[str]:
    """Quaternions, the real part first."""
    told = [(part, f"{turning.name}[{k}]") for turning in scene.turnings for k, part in enumerate(turning.parts, 1)]
    return [f"  Real {names[part]}(start = {starts[source]!r}, fixed = true){quoted(source)};" for part, source in told]


def _turns(scene: SymbolicScene, names: Mapping[Expr, str], steps: list[Expr], closing: Expr,
           code: Callable[[Expr], str]) -> list[str]:
    """How quaternions change, and come back to their length."""
    lines = []
    for turning in scene.turnings:
        gap = closing*(1 - sp.Add(*(part**2 for part in turning.parts)))/2
        for part, rate in turning.paced([scene.v[k] + steps[k] for k in turning.places]):
            lines.append(f"  der({names[part]}) = {code(rate)} + {code(gap)}*{names[part]};")
    return lines


def _motion(book: Book, names: Mapping[Expr, str], code: Callable[[Expr], str]) -> list[str]:
    """M a + h + J^T lambda = f row by row."""
    e, scene = book.equations, book.equations.scene
    lines = []
    for k in range(e.n):
        entries = [(x, f"({code(x)})" if x.is_Add else code(x), a) for x, a in zip(e.M[k], scene.a, strict=True)]
        terms = [names[a] if text == "1" else f"{text}*{names[a]}" for x, text, a in entries if x != 0]
        rest = e.h[k] + e.reactions[k]
        first, *others = [*terms, *([code(rest)] if rest != 0 else [])] or ["0"]
        left = first + "".join(f" - {x[1:]}" if x.startswith("-") else f" + {x}" for x in others)
        lines.append(f"  {left} = {code(e.f[k])};")
    return lines


def _constraints(book: Book, steps: list[Expr], closing: Expr, code: Callable[[Expr], str]) -> list[str]:
    """The constraints differentiated until accelerations stand in them, and what closes their gaps; `steps` are J^T mu."""
    e, scene = book.equations, book.equations.scene
    lines = []
    for k, row in enumerate(e.rows):
        rate = e.ring.along(row, scene.rates) if k < scene.holonomic else row
        lines.append(f"  {code(e.ring.along(rate, scene.rates))} = -{closing}*({code(rate)});")
        if k < scene.holonomic:
            across = sp.Add(*(slope * step for slope, step in zip(e.J[k], steps, strict=True)))
            lines.append(f"  {code(rate + across)} = -{closing}*({code(row)});")
    return lines


def _outputs(book: Book, names: Mapping[Expr, str], code: Callable[[Expr], str]) -> tuple[list[str], list[str]]:
    """Declarations of the outputs by what the model has symbols of, and the names of those that are of other quantities."""
    scene = book.equations.scene
    taken, lines, lost = dict(names), list[str](), list[str]()
    for v in (v for v in scene.kinematics.graph.model.variables.values() if v.is_output):
        try:
            values = [exact_throughout(x) for x in scalars_of(scene.kinematics.evaluator.variable(v.name, 0, v.span))]
        except LagError:
            values = []
        known = values and len(v.shape) <= 1 and all(
            {*_without_given_rates(scene, x).free_symbols} <= {*names} and not x.has(sp.nan) for x in values)  # reactions: nan
        if not known:
            lost.append(v.name)
            continue
        name = taken[sp.Dummy()] = _free_name(identifier(v.name), taken)
        lines.append(f"  {output_line(v, name, [code(x) for x in values])}")
    return lines, lost


def experiment_line(model: FlatModel) -> str:
    """The annotation that says for how long it is run."""
    run = model.experiment
    interval = "" if run.interval is None else f", Interval = {run.interval!r}"
    settings = f"StartTime = {run.start!r}, StopTime = {run.stop!r}, Tolerance = {run.tolerance!r}{interval}"
    return f"  annotation(experiment({settings}));"


def closing_line(name: str) -> str:
    """The declaration of what says how fast gaps of constraints, and of quaternions, close."""
    return f'  parameter Real {name}(unit = "1/s") = {_CLOSING!r} "how fast gaps of constraints close";'


def output_line(v: Variable, name: str, values: Sequence[str]) -> str:
    """The declaration of an output, a number or a vector, by its values."""
    unit, value = unit_of(v.unit), f"{{{', '.join(values)}}}" if v.shape else values[0]
    size, unit = (f"[{len(values)}]", unit.replace("(", "(each ", 1)) if v.shape else ("", unit)
    return f"output Real {name}{size}{unit} = {value}{quoted(v.description)};"


def _free_name(wanted: str, names: Mapping[Expr, str]) -> str:
    return wanted if wanted not in names.values() else _free_name(f"{wanted}_", names)


def _without_given_rates(scene: SymbolicScene, x: Expr) -> Expr:
    """Rates of given functions written out; the functions themselves are variables."""
    known = {}
    for g in scene.given:
        value = g.value
        for s in g.moving[1:]:
            value = slope(value, scene.t)
            known[s] = value
    return x.xreplace(known) if known else x


def unit_of(unit: str) -> str:
    """As a modification."""
    return f"(unit = {_text(unit)})" if unit else ""


def _text(words: str) -> str:
    return '"' + words.replace("\\", "\\\\").replace('"', '\\"') + '"'


def quoted(words: str) -> str:
    """As a description behind a declaration."""
    return f" {_text(words)}" if words else ""


def _is_long(x: Expr) -> bool:
    return bool(max(abs(x.p), x.q) > _MOST)


class Printer(StrPrinter):  # type: ignore[misc]
    """Modelica's operators and functions."""

    def _print_Pow(self, e: Expr, rational: bool = False) -> str:
        base = self.parenthesize(e.base, precedence(e), strict=True)
        if e.exp == sp.S.Half:
            return f"sqrt({self._print(e.base)})"
        if e.exp == -sp.S.Half:
            return f"(1/sqrt({self._print(e.base)}))"
        if e.exp == -1:
            return f"(1/{base})"
        return f"{base}^{e.exp}" if e.exp.is_Integer and e.exp > 0 else f"{base}^({self._print(e.exp)})"

    def _print_Rational(self, e: Expr) -> str:
        """Products of numbers that were rounded are fractions of integers that no tool reads."""
        return repr(float(e)) if _is_long(e) else str(super()._print_Rational(e))

    def _print_Integer(self, e: Expr) -> str:
        return repr(float(e)) if _is_long(e) else str(super()._print_Integer(e))

    def _print_Mul(self, e: Expr) -> str:
        coefficient, rest = e.as_coeff_Mul()
        if coefficient.is_Rational and _is_long(coefficient):
            return f"{float(coefficient)!r}*{self.parenthesize(rest, PRECEDENCE['Mul'])}"
        return re.sub(r"\*\*", "^", str(super()._print_Mul(e)))

    def _print_Function(self, e: Expr) -> str:
        if isinstance(e, _LOGARITHMS):
            return f"({self._print(e.rewrite(sp.log))})"
        return f"{_NAMES.get(type(e).__name__, type(e).__name__)}({', '.join(map(self._print, e.args))})"

    def _print_LatticeOp(self, e: Expr) -> str:
        """min and max take two numbers."""
        name, (*rest, last) = type(e).__name__.lower(), map(self._print, sorted(e.args, key=str))
        return f"{''.join(f'{name}({x}, ' for x in rest)}{last}{')' * len(rest)}"

    def _print_Abs(self, e: Expr) -> str:
        return f"abs({self._print(e.args[0])})"

    def _print_NumberSymbol(self, e: Expr) -> str:
        return repr(float(e))

    _print_Pi = _print_Exp1 = _print_NumberSymbol

    def _print_Piecewise(self, e: Expr) -> str:
        flat = sp.piecewise_fold(e)
        parts = [f"{'if' if k == 0 else 'elseif'} {self._print(when)} then {self._print(value)}"
                 for k, (value, when) in enumerate(flat.args[:-1])]
        return f"({' '.join(parts)} else {self._print(flat.args[-1][0])})"

    def _print_And(self, e: Expr) -> str:
        return " and ".join(f"({self._print(x)})" for x in e.args)

    def _print_Or(self, e: Expr) -> str:
        return " or ".join(f"({self._print(x)})" for x in e.args)

    def _print_Not(self, e: Expr) -> str:
        return f"not ({self._print(e.args[0])})"

    def _print_Relational(self, e: Expr) -> str:
        return f"{self._print(e.lhs)} {({'!=': '<>'}).get(e.rel_op, e.rel_op)} {self._print(e.rhs)}"
