"""Tapes -> C99: one function each, and the table `lag_model` that runtime/model/model.h describes.

A long function is cut into pieces that share the work vector: compilers take time that grows faster than a function's length.
"""

import math
from collections.abc import Collection, Mapping, Sequence

from lagrangia.base.table_data import TableData
from lagrangia.native.series import Series, find_series
from lagrangia.native.series_code import sines_together, write_series
from lagrangia.native.series_writer import NoSeriesError
from lagrangia.native.table_code import write_tables
from lagrangia.native.tapes import BINARY, SINES, Op, Tape
from lagrangia.native.wide_code import write_wide
from lagrangia.native.wide_series_code import write_wide_series

_DATA = ("linear", "waves")  # the functions that stay tapes: the run time evaluates them in double-doubles
INCLUDES = ("#include <math.h>", '#include "numbers/sines.h"', '#include "model/tape.h"')  # of what write_functions writes
_MOVES = (Op.INPUT, Op.OUTPUT, Op.CONST, Op.ASSIGN)
_QUICK, _SINE, _SLOWEST = 2, 15, 50  # _SINE: together with others
_SLOW = dict.fromkeys((Op.DIV, Op.INV, Op.SQRT), 12) | dict.fromkeys(
    (op for op in Op if Op.SIN <= op <= Op.CONSTPOW or Op.SINH <= op <= Op.ERF), _SLOWEST)
_LONGEST_SERIES = 2000  # instructions
_OF_JET_TAPES = ("n_jet_instructions", "n_jet_slots", "n_angles", "jet_code", "jet_rates", "series")  # members of LagModel
_PIECE = 3000  # instructions in one C function

_TEMPLATES: Mapping[int, str] = {
    Op.ASSIGN: "{a}", Op.ADD: "{a} + {b}", Op.SUB: "{a} - {b}", Op.MUL: "{a} * {b}", Op.DIV: "{a} / {b}", Op.NEG: "-{a}",
    Op.SQ: "{a} * {a}", Op.TWICE: "2.0 * {a}", Op.INV: "1.0 / {a}", Op.SQRT: "sqrt({a})", Op.SIN: "sin({a})", Op.COS: "cos({a})",
    Op.TAN: "tan({a})", Op.ASIN: "asin({a})", Op.ACOS: "acos({a})", Op.ATAN: "atan({a})", Op.ATAN2: "atan2({a}, {b})",
    Op.EXP: "exp({a})", Op.LOG: "log({a})", Op.POW: "pow({a}, {b})", Op.CONSTPOW: "pow({a}, {b})", Op.FABS: "fabs({a})",
    Op.SIGN: "(double)(({a} > 0.0) - ({a} < 0.0))", Op.FMIN: "fmin({a}, {b})", Op.FMAX: "fmax({a}, {b})", Op.FLOOR: "floor({a})",
    Op.CEIL: "ceil({a})", Op.FMOD: "fmod({a}, {b})", Op.COPYSIGN: "copysign({a}, {b})", Op.LT: "(double)({a} < {b})",
    Op.LE: "(double)({a} <= {b})", Op.EQ: "(double)({a} == {b})", Op.NE: "(double)({a} != {b})", Op.NOT: "(double)({a} == 0.0)",
    Op.AND: "(double)({a} != 0.0 && {b} != 0.0)", Op.OR: "(double)({a} != 0.0 || {b} != 0.0)",
    Op.IF_ELSE_ZERO: "({a} != 0.0 ? {b} : 0.0)", Op.SINH: "sinh({a})", Op.COSH: "cosh({a})", Op.TANH: "tanh({a})",
    Op.ASINH: "asinh({a})", Op.ACOSH: "acosh({a})", Op.ATANH: "atanh({a})", Op.ERF: "erf({a})",
}


def write_c(
    name: str, sizes: Mapping[str, int], tapes: Mapping[str, Tape],
    coordinate_kind: Sequence[int], fixed: Sequence[int], event_kind: Sequence[int],
    patterns: Mapping[str, Sequence[int]], interpreted: Collection[str] = (), tables: Sequence[TableData] = (),
    lanes: bool = False,
) -> str:
    """The C source of a scene. Equal input gives equal text. Functions `interpreted` stay tapes: data, which compile at once.
    Without its `tables` a scene with some takes them from elsewhere. `lanes`: with what runs eight at a time ask for."""
    data = {*_DATA, *interpreted}
    series = motion_series(tapes, patterns.get("attitudes", ())) if "rhs" not in data else ""
    if isinstance(series, Series):  # in C, not as instructions
        sizes = {name: size for name, size in sizes.items() if name not in _OF_JET_TAPES} | _sizes(series, tapes)
        patterns = {name: given for name, given in patterns.items() if name not in _OF_JET_TAPES} | {"jet_places": series.places}
        tapes = {name: tape for name, tape in tapes.items() if name not in _OF_JET_TAPES}
    lines = [f"/* {_comment(name)}: generated, do not edit. */", *INCLUDES]
    lines += ['#include "numbers/jets.h"', f'#include "numbers/{"wide_jets" if lanes else "wide"}.h"']
    wide_series = write_wide_series(series, _expression, _number) if lanes and isinstance(series, Series) else []
    wide, whole = _write_abreast(tapes, lanes, bool(sizes.get("may_repeat"))) if "rhs" not in data else ([], [])
    beside = _write_beside(tapes) if wide_series else {}
    functions, initializers = write_functions(tapes, data, () if wide else (_usual(tapes),))
    lines += [*write_tables(tables), "", *functions]
    lines += [_ints(name, places) for name, places in patterns.items()]
    lines += [*wide, *whole]
    lines += [write_series(series, _expression, _number)] if isinstance(series, Series) else []
    lines += [*wide_series, *(line for text in beside.values() for line in text)]
    lines += [_ints("coordinate_kind", coordinate_kind), _ints("fixed_start", fixed), _ints("event_kind", event_kind), ""]
    lines += ["LAG_API extern const LagModel lag_model;", "const LagModel lag_model = {"]
    lines += [f"    .{key} = {value}," for key, value in sizes.items()]
    lines += ["    .coordinate_kind = coordinate_kind,", "    .fixed = fixed_start,", "    .event_kind = event_kind,"]
    lines += [f"    .{name} = {name}," for name in patterns]
    lines += [f"    .{label} = {value}," for label, value in initializers.items()]
    lines += ["    .tables = tables,"] if tables else []
    lines += ["    .taylor = taylor,"] if isinstance(series, Series) else []
    lines += ["    .wide = wide,"] if wide else []
    lines += ["    .wide_whole = wide_whole,"] if whole else []
    lines += ["    .wide_each = wide_each,"] if wide and lanes else []
    lines += ["    .wide_taylor = wide_taylor,"] if wide_series else []
    lines += [f"    .wide_{name} = wide_{name}{'_each' if name == 'roots' else ''}," for name in beside]
    return "\n".join([*lines, "};", ""])


def write_functions(
    tapes: Mapping[str, Tape], interpreted: Collection[str] = (), kept: Collection[str] = (),
) -> tuple[list[str], dict[str, str]]:
    """The C text of functions, and by name the initializer of a LagFunction. Those `interpreted` are tapes, those `kept` both."""
    lines: list[str] = []
    values = {}
    for label, tape in tapes.items():
        is_code, is_data = label not in interpreted, label in interpreted or label in kept
        lines += [_ints(f"{label}_in", tape.in_sizes), _ints(f"{label}_out", tape.out_sizes)]
        lines += [*(_data(label, tape) if is_data else []), *(_function(label, tape) if is_code else [])]
        work, how = tape.n_work if is_data else _work(tape), f"{label if is_code else 0}, {f'&{label}_tape' if is_data else 0}"
        values[label] = f"{{{len(tape.in_sizes)}, {len(tape.out_sizes)}, {label}_in, {label}_out, {work}, {how}}}"
    return lines, values


def _write_abreast(tapes: Mapping[str, Tape], has_each: bool, may_repeat: bool) -> tuple[list[str], list[str]]:
    """Accelerations of eight states the usual way, and, where that may fail for good, with constraints that repeat each other."""
    is_regular = "regular" in tapes
    wide = write_wide("wide", usual_rhs(tapes), is_regular, _expression, _number, has_each)
    return wide, write_wide("wide_whole", tapes["rhs"], False, _expression, _number) if is_regular and may_repeat else []


def _write_beside(tapes: Mapping[str, Tape]) -> dict[str, list[str]]:
    """What runs in lanes ask for beside series, of eight states: what stands under roots, and energies."""
    texts = {name: write_wide(f"wide_{name}", tapes[name], False, _expression, _number, name == "roots", name == "energies")
             for name in ("roots", "energies") if name in tapes}
    return {name: text for name, text in texts.items() if text}


def _cost(tape: Tape) -> int:
    """Tenths of a nanosecond, about: what matters is the proportion to the cost of series."""
    operations = [(tape.code[k], tape.code[k + 3]) for k in range(0, len(tape.code), 4)]
    return sum(0 if op in _MOVES else _SINE if op in SINES and b else _SLOW.get(Op(op), _QUICK) for op, b in operations)


def _usual(tapes: Mapping[str, Tape]) -> str:
    return "regular" if "regular" in tapes else "rhs"


def usual_rhs(tapes: Mapping[str, Tape]) -> Tape:
    """The function that gives the accelerations of nearly all states."""
    return tapes[_usual(tapes)]


def motion_series(tapes: Mapping[str, Tape], attitudes: Sequence[int] = ()) -> Series | str:
    """Taylor coefficients of the motion, or why there are none. `attitudes`: LagModel.attitudes."""
    if "delayed" in tapes:
        return "not supported yet: something acts late"
    if len(tapes["rhs"].code) // 4 > _LONGEST_SERIES:
        return f"not supported yet beyond {_LONGEST_SERIES} operations"
    try:
        return find_series(tapes["rhs"], attitudes)
    except NoSeriesError as error:
        return str(error)


def jet_tape(tapes: Mapping[str, Tape], attitudes: Sequence[int] = ()
             ) -> tuple[dict[str, int], dict[str, tuple[int, ...]], dict[str, Tape]] | str:
    """Taylor coefficients of the motion as instructions, by the members of LagModel: integers, lists and functions; or why there
    are none."""
    series = motion_series(tapes, attitudes)
    if isinstance(series, str):
        return series
    sizes, lists, numbers = series.as_tape(tapes["rhs"].in_sizes[4:])
    return {**sizes, **_sizes(series, tapes)}, {**lists, "jet_places": series.places}, {"series": numbers}


def _sizes(series: Series, tapes: Mapping[str, Tape]) -> dict[str, int]:
    return {**series.sizes, "series_rhs_cost": _cost(usual_rhs(tapes))}


def _expression(op: int, a: str, b: str) -> str:
    return _TEMPLATES[op].format(a=a, b=b)


def _comment(text: str) -> str:
    return "".join(c if c.isprintable() and c not in "*/\\" else " " for c in text)[:200]


def _ints(name: str, values: Sequence[int]) -> str:
    return f"static const int {name}[] = {{{', '.join(map(str, values)) or '0'}}};"


def _data(label: str, tape: Tape) -> list[str]:
    """A function that the run time interprets in its own arithmetic."""
    numbers = ", ".join(map(_number, tape.constants)) or "0"
    sizes = f"{len(tape.code) // 4}, {len(tape.constants)}"
    return [f"static const int32_t {label}_code[] = {{{', '.join(map(str, tape.code)) or '0'}}};",
            f"static const double {label}_constants[] = {{{numbers}}};",
            f"static const LagTape {label}_tape = {{{sizes}, {label}_code, {label}_constants}};",
            ""]


def _is_long(tape: Tape) -> bool:
    return len(tape.code) // 4 > _PIECE


def _work(tape: Tape) -> int:
    """A short function keeps its values in local variables."""
    return tape.n_work if _is_long(tape) else 0


def _function(label: str, tape: Tape) -> list[str]:
    signature = "(const double *const *in, double *const *out, double *w)"
    count = len(tape.code) // 4
    if not _is_long(tape):
        body = _body(tape, 0, count, set())
        opening = [f"static int {label}{signature}", "{", "    (void)in; (void)out; (void)w;"]
        return [*opening, *body, "    return 0;", "}", ""]
    starts = range(0, count, _PIECE)
    needed = _needed_after(tape, [*starts[1:], count])
    pieces, calls = [], []
    for number, (start, later) in enumerate(zip(starts, needed, strict=True)):
        body = _body(tape, start, min(count, start + _PIECE), later)
        pieces += [f"static void {label}_{number}{signature}", "{", "    (void)in; (void)out; (void)w;", *body, "}", ""]
        calls.append(f"    {label}_{number}(in, out, w);")
    return [*pieces, f"static int {label}{signature}", "{", *calls, "    return 0;", "}", ""]


def _needed_after(tape: Tape, ends: Sequence[int]) -> list[set[int]]:
    """The places of the work vector that hold, at each of these instructions, something still to be read."""
    found: list[set[int]] = []
    needed: set[int] = set()
    stops = set(ends)
    for k in range(len(tape.code) // 4, -1, -1):
        if k in stops:
            found.append(set(needed))
        if k > 0:
            op, out, a, b = tape.code[4 * k - 4 : 4 * k]
            if op != Op.OUTPUT:
                needed.discard(out)
            needed.update(_operands(op, a, b))
    return found[::-1]


def _operands(op: int, a: int, b: int) -> tuple[int, ...]:
    """The places that an instruction reads."""
    if op in (Op.INPUT, Op.CONST):
        return ()
    return (a, b) if op in BINARY else (a,)


def _body(tape: Tape, start: int, stop: int, later: set[int]) -> list[str]:
    """The statements from start to stop on local variables: read from the work vector at first use, and stored when they are
    needed `later`."""
    local: set[int] = set()
    written: set[int] = set()
    lines: list[str] = []
    run: list[tuple[int, int, int]] = []
    for k in range(4 * start, 4 * stop, 4):
        op, out, a, b = tape.code[k : k + 4]
        for place in _operands(op, a, b):
            if place not in local:
                local.add(place)
                lines.append(f"    w{place} = w[{place}];")
        if op != Op.OUTPUT:
            local.add(out)
            written.add(out)
        if op in SINES and b > 0:
            run.append((op, out, a))
            if b == 1 or k + 4 == 4 * stop:
                lines += [f"    {line}" for line in _sines(run)]
                run = []
        else:
            lines.append(f"    {_statement(op, out, a, b, tape.constants)}")
    names = sorted(local)
    declared = [f"    double {', '.join(f'w{n}' for n in names[i : i + 20])};" for i in range(0, len(names), 20)]
    return [*declared, *lines, *(f"    w[{place}] = w{place};" for place in sorted(written & later))]


def _sines(run: Sequence[tuple[int, int, int]]) -> list[str]:
    """Sines and cosines that are computed together: (op, out, a)."""
    angles = {a: i for i, a in enumerate(dict.fromkeys(a for _, _, a in run))}
    found = [f"w{out} = {'sine' if op == Op.SIN else 'cosine'}[{angles[a]}];" for op, out, a in run]
    return ["{", *(f"    {line}" for line in (*sines_together([f"w{a}" for a in angles]), *found)), "}"]


def _statement(op: int, out: int, a: int, b: int, constants: Sequence[float]) -> str:
    if op == Op.INPUT:
        return f"w{out} = in[{a}][{b}];"
    if op == Op.OUTPUT:
        return f"out[{out}][{b}] = w{a};"
    if op == Op.CONST:
        return f"w{out} = {_number(constants[a])};"
    return f"w{out} = {_TEMPLATES[op].format(a=f'w{a}', b=f'w{b}')};"


def _number(value: float) -> str:
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "HUGE_VAL" if value > 0 else "-HUGE_VAL"
    return repr(float(value))
