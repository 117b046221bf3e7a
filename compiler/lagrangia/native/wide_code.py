"""The accelerations of eight states at once, as C (runtime/numbers/wide.h): operations of the tape, each on as many states as a
register holds.

The digits are those of one state after another, unless all sines are made at once.
"""

from collections.abc import Callable, Mapping, Sequence

from lagrangia.native.tapes import SINES, Op, Tape

_LONGEST = 10_000  # instructions: compilers take time that grows faster than a function's length
_SHARED = (4, 5)  # inputs that may be the same for all states: modes, and what was hoisted
_KEPT = 2  # outputs: accelerations and powers
_DOUBT = "doubt"

_TEMPLATES: Mapping[int, str] = {
    Op.ASSIGN: "{a}", Op.ADD: "{a} + {b}", Op.SUB: "{a} - {b}", Op.MUL: "{a} * {b}", Op.DIV: "{a} / {b}", Op.NEG: "-{a}",
    Op.SQ: "{a} * {a}", Op.TWICE: "2.0 * {a}", Op.INV: "1.0 / {a}", Op.FABS: "LAG_WIDE_ABS({a})",
    Op.LT: "LAG_WIDE_SELECT({a} < {b}, one, zero)", Op.LE: "LAG_WIDE_SELECT({a} <= {b}, one, zero)",
    Op.IF_ELSE_ZERO: "LAG_WIDE_SELECT({a} != 0.0, {b}, zero)",
}


def write_wide(
    name: str, tape: Tape, has_doubt: bool, expression: Callable[[int, str, str], str], number: Callable[[float], str],
    each: bool = False, all_sines: bool = False,
) -> list[str]:
    """C text of a LagWideCode of this name; nothing where the tape is long. `each`: and of `{name}_each`, for states whose
    parameters differ. `all_sines`: those that one state has from a mathematical library, too, are made of all states at once.

    `has_doubt`: the tape's third output tells where it does not hold. `expression` is C for an operation on numbers of one state.
    """
    if len(tape.code) // 4 > _LONGEST:
        return []
    body, written = _body(tape, has_doubt, expression, number, all_sines)
    names = sorted(written)
    declared = [f"LagWide {', '.join(f'w{n}' for n in names[i : i + 20])};" for i in range(0, len(names), 20)]
    lines = [*declared, f"LagWide largest = zero, {_DOUBT} = zero;", *body,
             f"{_DOUBT} = LAG_WIDE_SELECT(largest > LAG_WIDE_OF(LAG_LARGEST_ANGLE), one, {_DOUBT});",
             f"lag_wide_write(out[{_KEPT}] + lane, {_DOUBT});"]
    arguments = "const double *const *in, double *const *out"
    wide = [f"static void {name}({arguments}) {{ {name}_of(in, out, 1); }}"]
    wide += [f"static void {name}_each({arguments}) {{ {name}_of(in, out, 0); }}"] if each else []
    return [f"LAG_UNROLLED void {name}_of({arguments}, const int is_shared)", "{",
            "    const LagWide zero = LAG_WIDE_OF(0.0), one = LAG_WIDE_OF(1.0);", "    (void)in; (void)one; (void)is_shared;",
            "    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {", *(f"        {line}" for line in lines), "    }",
            "}", "", *wide, ""]


def _body(tape: Tape, has_doubt: bool, expression: Callable[[int, str, str], str], number: Callable[[float], str],
          all_sines: bool) -> tuple[list[str], set[int]]:
    """The statements, and the places of work that they write."""
    body: list[str] = []
    written: set[int] = set()
    angles: dict[int, list[str]] = {}
    for k in range(0, len(tape.code), 4):
        op, out, a, b = tape.code[k : k + 4]
        if op == Op.OUTPUT:
            body += _output(out, a, b, has_doubt)
            continue
        written.add(out)
        if op in SINES and b > 0:
            angles.setdefault(a, []).append(f"w{out} = {'sine' if op == Op.SIN else 'cosine'};")
            if b == 1:
                body += [line for angle, found in angles.items() for line in _sines(angle, found)]
                angles = {}
        elif op in SINES and all_sines:
            body += _sines(a, [f"w{out} = {'sine' if op == Op.SIN else 'cosine'};"])
        else:
            body += _statement(op, out, a, b, tape.constants, expression, number)
    return body, written


def _output(out: int, a: int, b: int, has_doubt: bool) -> list[str]:
    if out < _KEPT:
        return [f"lag_wide_write(out[{out}] + {b} * LAG_ABREAST + lane, w{a});"]
    return [f"{_DOUBT} = w{a};"] if has_doubt else []


def _sines(angle: int, found: Sequence[str]) -> list[str]:
    return ["{", "    LagWide sine, cosine;", f"    lag_sines_of_wide(&w{angle}, &sine, &cosine);",
            f"    largest = LAG_WIDE_SELECT(LAG_WIDE_ABS(w{angle}) > largest, LAG_WIDE_ABS(w{angle}), largest);",
            *(f"    {line}" for line in found), "}"]


def _statement(op: int, out: int, a: int, b: int, constants: Sequence[float], expression: Callable[[int, str, str], str],
               number: Callable[[float], str]) -> list[str]:
    if op == Op.INPUT:
        own = f"lag_wide_read(in[{a}] + {b} * LAG_ABREAST + lane)"
        return [f"w{out} = is_shared ? LAG_WIDE_OF(in[{a}][{b}]) : {own};" if a in _SHARED else f"w{out} = {own};"]
    if op == Op.CONST:
        return [f"w{out} = LAG_WIDE_OF({number(constants[a])});"]
    if op in _TEMPLATES:
        return [f"w{out} = {_TEMPLATES[op].format(a=f'w{a}', b=f'w{b}')};"]
    second = "y" if "y[i]" in expression(op, "x[i]", "y[i]") else "x"
    return ["{", "    double x[LAG_WIDE], y[LAG_WIDE];", f"    memcpy(x, &w{a}, sizeof x);",
            f"    memcpy(y, &w{b if second == 'y' else a}, sizeof y);", "    for (int i = 0; i < LAG_WIDE; ++i)",
            f"        x[i] = {expression(op, 'x[i]', 'y[i]')};", f"    memcpy(&w{out}, x, sizeof x);", "}"]
