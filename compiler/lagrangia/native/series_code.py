"""The Taylor coefficients of the motion (series.py) as C, one order at a call.

Recurrences are those of runtime/numbers/jets.h.
"""

import re
from collections.abc import Callable, Mapping, Sequence

from lagrangia.native.rolled import Constants, find_loops, needed, write_loop
from lagrangia.native.series import ORDERS, Series, orders_apart
from lagrangia.native.series_writer import OPERANDS, Instruction
from lagrangia.native.tapes import JetOp, Op

_JET = re.compile(r"J\((\d+)\)(?:\[([0k])\])?")
_INTEGRAL, _MINUS = "lag_jet_inner({b}, {c}, k) * (1.0 / k)", "lag_jet_inner({b}, {c}, k) * (-1.0 / k)"
# C for the coefficients of order 0 and k.
_TEMPLATES: Mapping[JetOp, tuple[str, str]] = {
    JetOp.NUMBER: ("{a}", "0.0"),
    JetOp.DERIVATIVE: ("0.0", "k * {a}[k]"),
    JetOp.NEG: ("-{a}[0]", "-{a}[k]"),
    JetOp.TWICE: ("2.0 * {a}[0]", "2.0 * {a}[k]"),
    JetOp.ADD: ("{a}[0] + {b}[0]", "{a}[k] + {b}[k]"),
    JetOp.SUB: ("{a}[0] - {b}[0]", "{a}[k] - {b}[k]"),
    JetOp.ADD_NUMBER: ("{a}[0] + {b}", "{a}[k]"),
    JetOp.SUB_NUMBER: ("{a}[0] - {b}", "{a}[k]"),
    JetOp.NUMBER_SUB: ("{a} - {b}[0]", "-{b}[k]"),
    JetOp.SCALE: ("{a} * {b}[0]", "{a} * {b}[k]"),
    JetOp.OVER_NUMBER: ("{a}[0] / {b}", "{a}[k] / {b}"),
    JetOp.IF: ("{a} != 0.0 ? {b}[0] : 0.0", "{a} != 0.0 ? {b}[k] : 0.0"),
    JetOp.FIRST_AND: ("{a}[0] * {b}[0] + {c}[0]", "{a}[0] * {b}[k] + {c}[k]"),
    JetOp.OVER_REST: ("{a}[0] / ({c} - {d} * ({b}[0] * {b}[0]))", "{a}[k] * (1.0 / ({c} - {d} * ({b}[0] * {b}[0])))"),
    JetOp.SCALE_AND: ("{a} * {b}[0] + {c}[0]", "{a} * {b}[k] + {c}[k]"),
    JetOp.SCALE_FROM: ("{c}[0] - {a} * {b}[0]", "{c}[k] - {a} * {b}[k]"),
    JetOp.SCALE_LESS: ("{a} * {b}[0] - {c}[0]", "{a} * {b}[k] - {c}[k]"),
    JetOp.LOWER: ("0.0", "lag_jet_inner({a}, {b}, k)"),
    JetOp.PRODUCT: ("{a}[0] * {b}[0]", "lag_jet_product({a}, {b}, k)"),
    JetOp.SQUARE: ("{a}[0] * {a}[0]", "lag_jet_square({a}, k)"),
    JetOp.QUOTIENT: ("{a}[0] / {b}[0]", "({a}[k] - lag_jet_inner({b}, {w}, k)) * (1.0 / {b}[0])"),
    JetOp.NUMBER_OVER: ("{a} / {b}[0]", "lag_jet_inner({b}, {w}, k) * (-1.0 / {b}[0])"),
    JetOp.SQRT: ("sqrt({a}[0])", "({a}[k] - lag_jet_between({w}, k)) * (0.5 / {w}[0])"),
    JetOp.POWER: ("pow({a}[0], {b})", "lag_jet_power({a}, {w}, {b}, k)"),
    JetOp.INTEGRAL: ("{d}({a}[0])", _INTEGRAL),
    JetOp.MINUS_INTEGRAL: ("{d}({a}[0])", _MINUS),
    JetOp.SINE: ("sine[{d}]", _INTEGRAL),
    JetOp.COSINE: ("cosine[{d}]", _MINUS),
    JetOp.PRODUCT_AND: ("{a}[0] * {b}[0] + {c}[0]", "lag_jet_product({a}, {b}, k) + {c}[k]"),
    JetOp.PRODUCT_FROM: ("{c}[0] - {a}[0] * {b}[0]", "{c}[k] - lag_jet_product({a}, {b}, k)"),
    JetOp.ANGLE: ("atan2({a}[0], {b}[0])", "(lag_jet_inner({c}, {e}, k) - lag_jet_inner({d}, {f}, k)) * (1.0 / k)"),
}


def write_series(series: Series, expression: Callable[[int, str, str], str], number: Callable[[float], str]) -> str:
    """The C function `taylor`, a LagJets. `expression` writes an operation on numbers, `number` a literal."""
    names, constants = _numbers(series, expression, number)
    first, later = ([_statement(i, k, names) for i in series.instructions] for k in (0, 1))
    angles = {i.operands[3]: i.operands[0] for i in series.instructions if i.op is JetOp.SINE}
    return _text(series, first, later, constants, [f"J({angles[k]})[0]" for k in sorted(angles)])


def _numbers(series: Series, expression: Callable[[int, str, str], str], number: Callable[[float], str]
             ) -> tuple[list[str], list[str]]:
    """C for each number of the series: a literal, or c[0], c[1], ...; and the values of these."""
    names: list[str] = []
    values: list[str] = []
    for op, a, b in series.numbers:
        if op == Op.CONST:
            names.append(number(a))
            continue
        text = f"in[{int(a)}][{b}]" if op == Op.INPUT else expression(op, names[int(a)], names[b])
        names.append(f"c[{len(values)}]")
        values.append(text)
    return names, values


def _statement(i: Instruction, later: int, numbers: Sequence[str]) -> str:
    kinds: Mapping[str, Callable[[int], str]] = {
        "j": "J({})".format, "J": "J({})".format, "n": numbers.__getitem__, "o": lambda x: Op(x).name.lower(), "c": str}
    shown = {letter: kinds[kind](x) for letter, kind, x in zip("abcdef", OPERANDS[i.op], i.operands, strict=False)}
    return f"J({i.out})[{'k' if later else 0}] = {_TEMPLATES[i.op][later].format(w=f'J({i.out})', **shown)};"


def _text(series: Series, first: Sequence[str], later: Sequence[str], values: Sequence[str], angles: Sequence[str]) -> str:
    """A function an order, its loops unrolled: all in one, and compilers run out of registers. Where there are many products,
    code for each of the higher orders takes long to compile and does not stay near the processor: they share a function."""
    kept, pitch, accelerations, unrolled = series.kept, series.pitch, series.accelerations, _apart(series)
    constants = Constants() if series.is_long_state else Constants(list(range(len(values))))
    lines = ["#define J(slot) (jet + (slot) * LAG_JET_STRIDE)"]
    for name, statements in {"taylor_first": first, "taylor_later": later}.items():
        if series.is_long_state:
            of_slots = {i.out: statement for i, statement in zip(series.instructions, statements, strict=True)}
            body = _long_body(of_slots, accelerations, constants, kept, pitch)
        else:
            sines = sines_together(angles) if angles and statements is first else []
            body = [*_placed([*sines, *statements], kept, pitch), *_next_states(series), *_next_turns(series)]
        lines += [f"LAG_UNROLLED void {name}(const int k, const double *c, double *jet)", "{", "    (void)c;"]
        lines += [*(f"    {line}" for line in body), "}", ""]
    arguments = "(int k, const double *c, double *jet)"
    for k in range(unrolled):
        lines += [f"static void taylor_{k}{arguments} {{ (void)k; taylor_{'later' if k else 'first'}({k}, c, jet); }}"]
    if unrolled < ORDERS:
        lines += [f"static void taylor_any{arguments} {{ taylor_later(k, c, jet); }}"]
    names = [f"taylor_{k}" if k < unrolled else "taylor_any" for k in range(ORDERS)]
    given = [f"    {line}" for line in constants.written(values)]
    lines += [f"static void (*const taylor_orders[]){arguments} = {{", f"    {', '.join(names)}}};", "",
              "static void taylor(int first, int end, const double *const *in, double *jet)", "{",
              f"    double c[{max(1, len(constants.order))}] = {{0}};",
              "    (void)in;", *given, "    for (int k = first; k < end; ++k)", "        taylor_orders[k](k, c, jet);"]
    return "\n".join([*lines, "}", ""])


def _apart(series: Series) -> int:
    return max(1, orders_apart(series.n_products, len(series.instructions)))


def sines_together(angles: Sequence[str]) -> list[str]:
    """Statements that declare and fill the arrays sine and cosine, for angles as C text."""
    size = -(-len(angles) // 4) * 4
    given = [*angles, *["0.0"] * (size - len(angles))]
    calls = [f"lag_four_sines({', '.join(given[i : i + 4])}, sine + {i}, cosine + {i});" for i in range(0, size, 4)]
    return [f"double sine[{size}], cosine[{size}];", *calls]


def _next_states(series: Series) -> list[str]:
    """The coefficients of q and v of the next order."""
    accelerations, kept, pitch = series.accelerations, series.kept, series.pitch
    n = len(accelerations)
    places = [f"{_coefficient(1 + i, 'k + 1', pitch)} = {_coefficient(1 + n + i, 'k', pitch)} * (1.0 / (k + 1));"
              for i in range(n)]
    return [*places, *(_next_rate(i, n, slot, kept, pitch) for i, slot in enumerate(accelerations))]


def _next_turns(series: Series) -> list[str]:
    """Those of quaternions of attitudes, which are the last known jets."""
    first, behind, n = series.known - 4 * len(series.attitudes), len(series.kept), len(series.accelerations)
    return [f"lag_jet_turn(J({first + 4 * i}), J({behind + 4 * i}), J({1 + n + place}), k);"
            for i, place in enumerate(series.attitudes)]


def _next_rate(i: int, n: int, slot: int, kept: Mapping[int, int], pitch: int) -> str:
    return f"{_coefficient(1 + n + i, 'k + 1', pitch)} = {_latest(slot, kept, pitch)} * (1.0 / (k + 1));"


def _long_body(lines: Mapping[int, str], accelerations: Sequence[int], constants: Constants, kept: Mapping[int, int],
               pitch: int) -> list[str]:
    """One order of a long state, a line for each slot: accelerations of one form in loops, the others one by one."""
    n = len(accelerations)
    statements = {slot: line.partition(" = ")[2].removesuffix(";") for slot, line in lines.items()}
    loops = find_loops(accelerations, statements)
    looped = {i for loop in loops for i in range(loop.first, loop.first + loop.count)}
    rest = set(needed([*(slot for i, slot in enumerate(accelerations) if i not in looped), *kept], statements))
    body = [f"lag_jet_rows(jet + (k + 1) * {pitch} + 1, jet + k * {pitch} + {1 + n}, 1.0 / (k + 1), {n});"]
    for loop in loops:
        result = f"jet + (k + 1) * {pitch} + {1 + n + loop.first}"
        body += write_loop(loop, constants, lambda slot: f"jet + k * {pitch} + {kept[slot]}", result)
    body += [constants.renamed(line) for line in _placed([line for slot, line in lines.items() if slot in rest], kept, pitch)]
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
