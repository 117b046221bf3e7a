"""The tape of the right-hand side -> C that computes Taylor coefficients of the motion, one order at a call.

Every quantity that changes in time is a jet: its coefficients w_0, w_1, ... in powers of the time since the step began. Each
operation has a recurrence for the next coefficient (A. Jorba, M. Zou, Exp. Math. 14 (2005); E. Hairer et al., Solving Ordinary
Differential Equations I, I.8), in runtime/numbers/jets.h. What is constant in a step is computed as a plain number.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from lagrangia.native.rolled import Constants, find_loops, needed, write_loop
from lagrangia.native.tapes import EXPONENTIALS, Op, Tape

_MOST_POWER = 8  # integer powers up to this one are products
_ORDERS = 18  # LAG_JET_ORDER of runtime/numbers/jets.h
_LONG = 8  # coordinates from which on loops over all of them pay
_FEW, _UNROLLED = 20, 12  # products up to which each order has a function of its own; the orders that have one otherwise
# Statements in one order, and what a product adds over all orders; more than so many take longer to compile than they save.
_PRODUCT, _MOST_STATEMENTS = 150, 4000
_JET = re.compile(r"J\((\d+)\)(?:\[([0k])\])?")
_WHOLE = re.compile(r"J\((\d+)\)(?!\[k\])")  # more than the coefficient of the present order
_TIME, _POSITIONS, _RATES, _INPUTS = 0, 1, 2, 3  # arguments of rhs that are jets


class NoSeriesError(Exception):
    """Why the motion has no Taylor series, or none that is worth its compilation."""


@dataclass(frozen=True)
class Series:
    """`places` are the jets of the accelerations, then of the powers. The first jets are t, q, v and u. `n_products` are sums of
    products, which grow with the order; `pitch` is the distance between the coefficients of a jet. Accelerations of a long state
    without products are not kept: the jets of v tell them, and `places` has the powers alone. `may_hide`: exponentials of what
    moves stand in the equations, which can be so faint that no coefficient tells of them, and large within a step: exp(-(s/w)^2),
    or tanh(s/w), which is constant but near 0."""

    source: str
    n_jets: int
    pitch: int
    n_products: int
    places: tuple[int, ...]
    is_long_state: bool
    may_hide: bool


@dataclass(frozen=True)
class _Jet:
    slot: int

    def __str__(self) -> str:
        return f"J({self.slot})"


_Value = _Jet | str  # a jet, or C text of a number


@dataclass
class _Writer:
    tape: Tape
    expression: Callable[[int, str, str], str]  # C text of an operation on numbers
    number: Callable[[float], str]
    values: dict[int, _Value] = field(default_factory=dict)
    constants: list[str] = field(default_factory=list)  # the values of c[0], c[1], ...
    named: dict[str, str] = field(default_factory=dict)  # c[...] by its value
    first: list[str] = field(default_factory=list)  # statements for order 0
    later: list[str] = field(default_factory=list)  # statements for order k > 0
    n_jets: int = 0
    pairs: dict[tuple[str, int], tuple[_Jet, _Jet]] = field(default_factory=dict)
    derivatives: dict[int, _Jet] = field(default_factory=dict)
    angles: list[_Jet] = field(default_factory=list)  # coordinates whose sines and cosines are computed together
    even: set[int] = field(default_factory=lambda: {0})  # jets that grow evenly with time
    may_hide: bool = False

    # ------------------------------------------------------------ pieces

    def jet(self, first: str, later: str) -> _Jet:
        """A new jet with C text for its coefficients of order 0 and k."""
        jet = _Jet(self.n_jets)
        self.n_jets += 1
        self.first.append(f"{jet}[0] = {first};")
        self.later.append(f"{jet}[k] = {later};")
        return jet

    def constant(self, text: str) -> str:
        if text not in self.named:
            self.named[text] = f"c[{len(self.constants)}]"
            self.constants.append(text)
        return self.named[text]

    def derivative(self, u: _Jet) -> _Jet:
        """k u_k, which the recurrences of elementary functions ask for."""
        if u.slot not in self.derivatives:
            self.derivatives[u.slot] = self.jet("0.0", f"k * {u}[k]")
        return self.derivatives[u.slot]

    def product(self, a: _Value, b: _Value) -> _Value:
        if isinstance(a, str) and isinstance(b, str):
            return self.constant(f"{a} * {b}")
        if isinstance(a, _Jet) and isinstance(b, _Jet):
            if a == b:
                return self.jet(f"{a}[0] * {a}[0]", f"lag_jet_square({a}, k)")
            return self.jet(f"{a}[0] * {b}[0]", f"lag_jet_product({a}, {b}, k)")
        scale, jet = (a, b) if isinstance(a, str) else (b, a)
        return self.jet(f"{scale} * {jet}[0]", f"{scale} * {jet}[k]")

    def quotient(self, a: _Value, b: _Jet) -> _Jet:
        if isinstance(a, _Jet):
            slot = f"J({self.n_jets})"
            return self.jet(f"{a}[0] / {b}[0]", f"({a}[k] - lag_jet_inner({b}, {slot}, k)) * (1.0 / {b}[0])")
        slot = f"J({self.n_jets})"
        return self.jet(f"{a} / {b}[0]", f"lag_jet_inner({b}, {slot}, k) * (-1.0 / {b}[0])")

    def circular(self, u: _Jet, sine: str, cosine: str, sign: str) -> tuple[_Jet, _Jet]:
        """sin and cos, or sinh and cosh, of one argument: s' = c u', c' = sign s u'."""
        if (sine, u.slot) not in self.pairs:
            du, s, c = self.derivative(u), f"J({self.n_jets})", f"J({self.n_jets + 1})"
            first = [f"{name}({u}[0])" for name in (sine, cosine)]
            if sine == "sin" and u.slot < self.n_jets - len(self.first):
                first = [f"{name}[{len(self.angles)}]" for name in ("sine", "cosine")]
                self.angles.append(u)
            one = self.jet(first[0], f"lag_jet_inner({du}, {c}, k) * (1.0 / k)")
            other = self.jet(first[1], f"lag_jet_inner({du}, {s}, k) * ({sign}1.0 / k)")
            self.pairs[(sine, u.slot)] = one, other
        return self.pairs[(sine, u.slot)]

    def integral(self, first: str, slope: _Jet, u: _Jet) -> _Jet:
        """w with w' = slope u', w_0 as given."""
        return self.jet(first, f"lag_jet_inner({self.derivative(u)}, {slope}, k) * (1.0 / k)")

    # ------------------------------------------------------------ operations

    def unary(self, op: int, a: _Jet) -> _Value:
        slot = f"J({self.n_jets})"
        if op in (Op.NEG, Op.TWICE):
            factor = "-" if op == Op.NEG else "2.0 * "
            return self.jet(f"{factor}{a}[0]", f"{factor}{a}[k]")
        if op == Op.SQ:
            return self.product(a, a)
        if op == Op.INV:
            return self.quotient("1.0", a)
        if op == Op.SQRT:
            return self.jet(f"sqrt({a}[0])", f"({a}[k] - lag_jet_between({slot}, k)) * (0.5 / {slot}[0])")
        if op in (Op.SIN, Op.COS):
            return self.circular(a, "sin", "cos", "-")[op == Op.COS]
        if op in (Op.SINH, Op.COSH):
            return self.circular(a, "sinh", "cosh", "")[op == Op.COSH]
        if op == Op.EXP:
            du = self.derivative(a)
            slot = f"J({self.n_jets})"
            return self.jet(f"exp({a}[0])", f"lag_jet_inner({du}, {slot}, k) * (1.0 / k)")
        if op == Op.LOG:
            return self.integral(f"log({a}[0])", self.quotient("1.0", a), a)
        return self.inverse_function(op, a)

    def inverse_function(self, op: int, a: _Jet) -> _Value:
        """Functions whose slope is a simpler one."""
        if op == Op.TAN:
            sine, cosine = self.circular(a, "sin", "cos", "-")
            return self.quotient(sine, cosine)
        if op == Op.TANH:
            return self.hyperbolic_tangent(a)
        square = self.product(a, a)
        assert isinstance(square, _Jet)
        if op == Op.ATAN:
            return self.integral(f"atan({a}[0])", self.quotient("1.0", self.shifted(square, "1.0 + ")), a)
        if op in (Op.ASIN, Op.ACOS):
            root = self.unary(Op.SQRT, self.shifted(square, "1.0 - "))
            assert isinstance(root, _Jet)
            name, sign = ("asin", "1.0") if op == Op.ASIN else ("acos", "-1.0")
            return self.integral(f"{name}({a}[0])", self.quotient(sign, root), a)
        raise NoSeriesError(f"'{Op(op).name.lower()}' stands in its equations, which has no Taylor series")

    def hyperbolic_tangent(self, u: _Jet) -> _Jet:
        """w' = (1 - w^2) u': no sinh and cosh, which would be infinite where w is 1."""
        du, slope = self.derivative(u), f"J({self.n_jets + 2})"
        w = self.jet(f"tanh({u}[0])", f"lag_jet_inner({du}, {slope}, k) * (1.0 / k)")
        square = self.product(w, w)
        assert isinstance(square, _Jet)
        self.shifted(square, "1.0 - ")
        return w

    def shifted(self, a: _Jet, before: str) -> _Jet:
        """1 + a or 1 - a."""
        return self.jet(f"{before}{a}[0]", f"{'-' if '-' in before else ''}{a}[k]")

    def binary(self, op: int, a: _Value, b: _Value) -> _Value:
        if op in (Op.ADD, Op.SUB):
            sign = "+" if op == Op.ADD else "-"
            later = [f"{a}[k]" if isinstance(a, _Jet) else "", f"{sign} {b}[k]" if isinstance(b, _Jet) else ""]
            return self.jet(f"{_at_start(a)} {sign} {_at_start(b)}", " ".join(filter(None, later)).removeprefix("+ "))
        if op == Op.MUL:
            return self.product(a, b)
        if op == Op.DIV:
            return self.quotient(a, b) if isinstance(b, _Jet) else self.jet(f"{a}[0] / {b}", f"{a}[k] / {b}")
        if op in (Op.POW, Op.CONSTPOW) and isinstance(a, _Jet) and isinstance(b, str):
            return self.power(a, b)
        if op == Op.ATAN2 and isinstance(a, _Jet) and isinstance(b, _Jet):
            return self.angle(a, b)
        if op == Op.IF_ELSE_ZERO and isinstance(a, str) and isinstance(b, _Jet):
            return self.jet(f"{a} != 0.0 ? {b}[0] : 0.0", f"{a} != 0.0 ? {b}[k] : 0.0")
        raise NoSeriesError(f"'{Op(op).name.lower()}' stands in its equations, which has no Taylor series")

    def power(self, a: _Jet, exponent: str) -> _Value:
        """A small whole power is a product: its recurrence would divide by the base."""
        known = self.exponent(exponent)
        if known is not None and known.is_integer() and 2 <= known <= _MOST_POWER:
            value: _Value = a
            for _ in range(int(known) - 1):
                value = self.product(value, a)
            return value
        slot = f"J({self.n_jets})"
        return self.jet(f"pow({a}[0], {exponent})", f"lag_jet_power({a}, {slot}, {exponent}, k)")

    def exponent(self, text: str) -> float | None:
        try:
            return float(text)
        except ValueError:
            return None

    def angle(self, a: _Jet, b: _Jet) -> _Jet:
        """atan2(a, b): w' = (b a' - a b')/(a^2 + b^2)."""
        aa, bb = self.product(a, a), self.product(b, b)
        radius = self.binary(Op.ADD, aa, bb)
        assert isinstance(radius, _Jet)
        x, y = self.quotient(b, radius), self.quotient(a, radius)
        da, db = self.derivative(a), self.derivative(b)
        return self.jet(f"atan2({a}[0], {b}[0])", f"(lag_jet_inner({da}, {x}, k) - lag_jet_inner({db}, {y}, k)) * (1.0 / k)")

    # ------------------------------------------------------------ the tape

    def read(self, argument: int, element: int) -> _Value:
        if argument not in (_TIME, _POSITIONS, _RATES, _INPUTS):
            return self.constant(f"in[{argument - _INPUTS - 1}][{element}]")
        return _Jet(sum(self.tape.in_sizes[:argument]) + element)

    def step(self, op: int, out: int, a: int, b: int) -> None:
        if op == Op.INPUT:
            self.values[out] = self.read(a, b)
        elif op == Op.CONST:
            self.values[out] = self.number(self.tape.constants[a])
        elif op == Op.ASSIGN:
            self.values[out] = self.values[a]
        else:
            self.values[out] = self.compute(op, self.values[a], self.values[b] if _is_binary(op) else "0.0")

    def compute(self, op: int, a: _Value, b: _Value) -> _Value:
        if isinstance(a, str) and isinstance(b, str):
            return self.constant(self.expression(op, a, b))
        jets = [x for x in (a, b) if isinstance(x, _Jet)]
        is_even = all(jet.slot in self.even for jet in jets)
        self.may_hide |= op in EXPONENTIALS and not is_even
        found = self.binary(op, a, b) if _is_binary(op) else self.unary(op, jets[0])
        scales = op == Op.MUL or (op == Op.DIV and isinstance(b, str))
        if isinstance(found, _Jet) and is_even and (op in _SUMS or (scales and len(jets) == 1)):
            self.even.add(found.slot)
        return found


def _at_start(value: _Value) -> str:
    return f"{value}[0]" if isinstance(value, _Jet) else value


def _is_binary(op: int) -> bool:
    return op in _BINARY


_SUMS = (Op.ADD, Op.SUB, Op.NEG, Op.TWICE)
_BINARY = frozenset((
    Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.POW, Op.CONSTPOW, Op.ATAN2, Op.FMIN, Op.FMAX, Op.FMOD, Op.COPYSIGN, Op.LT, Op.LE, Op.EQ,
    Op.NE, Op.AND, Op.OR, Op.IF_ELSE_ZERO,
))


def write_series(tape: Tape, expression: Callable[[int, str, str], str], number: Callable[[float], str]) -> Series:
    """C functions `taylor` for the tape of rhs: t, q, v, u, d, c -> a, power, lambda. `expression` writes an operation on
    numbers, `number` a literal. Raises NoSeriesError."""
    writer = _Writer(tape, expression, number, n_jets=sum(tape.in_sizes[: _INPUTS + 1]))
    wanted = _wanted(tape)
    places: dict[tuple[int, int], int] = {}
    for k in range(0, len(tape.code), 4):
        op, out, a, b = tape.code[k : k + 4]
        if k not in wanted:
            continue
        if op != Op.OUTPUT:
            writer.step(op, out, a, b)
            continue
        value = writer.values[a]
        jet = value if isinstance(value, _Jet) else writer.jet(value, "0.0")
        places[(out, b)] = jet.slot
    products = sum("lag_jet_" in line for line in writer.later)
    unrolled = _unrolled(products, len(writer.later))
    if unrolled == 0:
        raise NoSeriesError(f"its {products} products of series would take longer to compile than they save")
    n, found = tape.in_sizes[_POSITIONS], [places[key] for key in sorted(places)]
    is_long = products == 0 and n >= _LONG
    kept = _kept(writer, found[n:] if is_long else found)
    pitch = 1 if products else -(-len(kept) // 4) * 4
    source = _text(writer, found[:n], unrolled, kept, pitch, is_long)
    return Series(source, len(kept), pitch, products, tuple(kept[slot] for slot in (found[n:] if is_long else found)), is_long,
                  writer.may_hide)


def _unrolled(products: int, statements: int) -> int:
    """How many orders have a function of their own; 0: there are too many products."""
    for orders in (_ORDERS if products <= _FEW else _UNROLLED, _UNROLLED):
        if products * _PRODUCT + statements * (orders + 1) <= _MOST_STATEMENTS:
            return orders
    return 1 if products == 0 else 0


def _kept(writer: _Writer, places: Iterable[int]) -> dict[int, int]:
    """The place in memory of each jet whose lower orders are asked for again; the others pass by as local variables."""
    known = range(writer.n_jets - len(writer.later))
    again = (int(slot) for line in writer.later for slot in _WHOLE.findall(line))
    return {slot: k for k, slot in enumerate(sorted({*known, *places, *again}))}


def _wanted(tape: Tape) -> set[int]:
    """Instructions that accelerations and powers depend on; multipliers are left out."""
    needed: set[int] = set()
    wanted: set[int] = set()
    for k in range(len(tape.code) - 4, -1, -4):
        op, out, a, b = tape.code[k : k + 4]
        if op == Op.OUTPUT:
            if out < 2:
                wanted.add(k)
                needed.add(a)
        elif out in needed:
            wanted.add(k)
            needed.discard(out)
            if op not in (Op.INPUT, Op.CONST):
                needed.update((a, b) if _is_binary(op) else (a,))
    return wanted


def _text(writer: _Writer, accelerations: Sequence[int], unrolled: int, kept: Mapping[int, int], pitch: int,
          is_long: bool) -> str:
    """A function an order, its loops unrolled: all in one, and compilers run out of registers. Where there are many products,
    code for each of the higher orders takes long to compile and does not stay near the processor: they share a function."""
    constants = Constants() if is_long else Constants(list(range(len(writer.constants))))
    lines = ["#define J(slot) (jet + (slot) * LAG_JET_STRIDE)"]
    for name, statements in {"taylor_first": writer.first, "taylor_later": writer.later}.items():
        if is_long:
            body = _long_body(statements, accelerations, writer.n_jets - len(statements), constants, kept, pitch)
        else:
            angles = _sines(writer.angles) if statements is writer.first else []
            body = [*_placed([*angles, *statements], kept, pitch), *_next_states(accelerations, kept, pitch)]
        lines += [f"LAG_UNROLLED void {name}(const int k, const double *c, double *jet)", "{", "    (void)c;"]
        lines += [*(f"    {line}" for line in body), "}", ""]
    arguments = "(int k, const double *c, double *jet)"
    for k in range(unrolled):
        lines += [f"static void taylor_{k}{arguments} {{ (void)k; taylor_{'later' if k else 'first'}({k}, c, jet); }}"]
    if unrolled < _ORDERS:
        lines += [f"static void taylor_any{arguments} {{ taylor_later(k, c, jet); }}"]
    names = [f"taylor_{k}" if k < unrolled else "taylor_any" for k in range(_ORDERS)]
    given = [f"    {line}" for line in constants.written(writer.constants)]
    lines += [f"static void (*const taylor_orders[]){arguments} = {{", f"    {', '.join(names)}}};", "",
              "static void taylor(int first, int end, const double *const *in, double *jet)", "{",
              f"    double c[{max(1, len(constants.order))}] = {{0}};",
              "    (void)in;", *given, "    for (int k = first; k < end; ++k)", "        taylor_orders[k](k, c, jet);"]
    return "\n".join([*lines, "}", ""])


def _sines(angles: Sequence[_Jet]) -> list[str]:
    """Statements for their sines and cosines. Four take as long as one of a mathematical library, one alone takes longer."""
    if len(angles) < 2:
        return [f"const double sine[] = {{sin({u}[0])}}, cosine[] = {{cos({u}[0])}};" for u in angles]
    return sines_together([f"{u}[0]" for u in angles])


def sines_together(angles: Sequence[str]) -> list[str]:
    """Statements that declare and fill the arrays sine and cosine, for angles as C text."""
    size = -(-len(angles) // 4) * 4
    given = [*angles, *["0.0"] * (size - len(angles))]
    calls = [f"lag_four_sines({', '.join(given[i : i + 4])}, sine + {i}, cosine + {i});" for i in range(0, size, 4)]
    return [f"double sine[{size}], cosine[{size}];", *calls]


def _next_states(accelerations: Sequence[int], kept: Mapping[int, int], pitch: int) -> list[str]:
    """The coefficients of q and v of the next order."""
    n = len(accelerations)
    places = [f"{_coefficient(1 + i, 'k + 1', pitch)} = {_coefficient(1 + n + i, 'k', pitch)} * (1.0 / (k + 1));"
              for i in range(n)]
    return [*places, *(_next_rate(i, n, slot, kept, pitch) for i, slot in enumerate(accelerations))]


def _next_rate(i: int, n: int, slot: int, kept: Mapping[int, int], pitch: int) -> str:
    return f"{_coefficient(1 + n + i, 'k + 1', pitch)} = {_latest(slot, kept, pitch)} * (1.0 / (k + 1));"


def _long_body(lines: Sequence[str], accelerations: Sequence[int], known: int, constants: Constants, kept: Mapping[int, int],
               pitch: int) -> list[str]:
    """One order of a long state: accelerations of one form in loops, the others one by one."""
    n = len(accelerations)
    statements = {known + k: line.partition(" = ")[2].removesuffix(";") for k, line in enumerate(lines)}
    loops = find_loops(accelerations, statements)
    looped = {i for loop in loops for i in range(loop.first, loop.first + loop.count)}
    rest = needed([*(slot for i, slot in enumerate(accelerations) if i not in looped), *kept], statements)
    body = [f"lag_jet_rows(jet + (k + 1) * {pitch} + 1, jet + k * {pitch} + {1 + n}, 1.0 / (k + 1), {n});"]
    for loop in loops:
        result = f"jet + (k + 1) * {pitch} + {1 + n + loop.first}"
        body += write_loop(loop, constants, lambda slot: f"jet + k * {pitch} + {kept[slot]}", result)
    body += [constants.renamed(line) for line in _placed([lines[slot - known] for slot in sorted(rest)], kept, pitch)]
    return [*body, *(_next_rate(i, n, slot, kept, pitch) for i, slot in enumerate(accelerations) if i not in looped)]


def _coefficient(slot: int, order: str, pitch: int) -> str:
    """Jets lie one after another for the sake of their products, else order by order."""
    return f"J({slot})[{order}]" if pitch == 1 else f"jet[({order}) * {pitch} + {slot}]"


def _latest(slot: int, kept: Mapping[int, int], pitch: int) -> str:
    """The coefficient of the present order, of which no others may be kept."""
    return _coefficient(kept[slot], "k", pitch) if slot in kept else f"x{slot}"


def _placed(statements: Sequence[str], kept: Mapping[int, int], pitch: int) -> list[str]:
    """The statements with jets in their places, and one coefficient of the others in a variable."""
    def name(match: re.Match[str]) -> str:
        slot = int(match[1])
        if slot not in kept:
            return f"x{slot}"
        return _coefficient(kept[slot], match[2], pitch) if match[2] else f"J({kept[slot]})"

    found = [_JET.sub(name, statement) for statement in statements]
    return [f"const double {statement}" if statement.startswith("x") else statement for statement in found]
