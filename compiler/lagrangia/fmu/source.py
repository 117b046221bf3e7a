"""FmuModel -> C: the scene's functions, and the table `lag_fmu` that runtime/fmi/fmu.h describes."""

import math
from collections.abc import Sequence

from lagrangia.fmu.elements import provides_elements
from lagrangia.fmu.tables import constants, guards_of, integers, requirements_of, sizes_of, vectors
from lagrangia.fmu.variables import FmuModel
from lagrangia.native.c_code import INCLUDES, write_c, write_functions
from lagrangia.native.tapes import Tape

_TEXTS = ("names", "strings", "guards", "requirements")
# Scenes with more operations than this stay tapes, as data: a C compiler takes some 0.2 ms an operation, for each platform.
_LARGEST_COMPILED = 3_000


def scene_source(model: FmuModel) -> str:
    """The scene as `lag simulate` compiles it."""
    scene = model.scene
    long = [name for name, tape in scene.tapes.items() if _is_long(tape)]
    return write_c(scene.name, sizes_of(model), scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                   long, scene.tables)


def _is_long(tape: Tape) -> bool:
    return len(tape.code) // 4 > _LARGEST_COMPILED


def table_source(model: FmuModel, token: str) -> str:
    """What the FMU knows beside the scene. Equal input gives equal text."""
    scene = model.scene
    tapes = {"forward": model.forward, "adjoint": model.adjoint}
    functions, initializers = write_functions(tapes, [name for name, tape in tapes.items() if _is_long(tape)])
    given, numbers, whole = constants(model), vectors(model), integers(model)
    lines = ["/* Generated, do not edit. */", *INCLUDES, '#include "fmi/fmu.h"', "",
             "LAG_API extern const LagModel lag_model;", "", *functions]
    lines += [f"static const double {name}[] = {{{', '.join(map(_number, values)) or '0'}}};" for name, values in numbers.items()]
    lines += [_integers(name, values) for name, values in whole.items()]
    lines += [_texts("names", [v.name for v in model.variables]), _texts("strings", [str(x) for x in given["string"]])]
    lines += [_texts("guards", guards_of(model)), _texts("requirements", requirements_of(model)), ""]
    lines += ["const LagFmu lag_fmu = {", "    .model = &lag_model,", f"    .token = {_quoted(token)},",
              f"    .start = {_number(scene.start)},", f"    .tolerance = {_number(scene.tolerance)},",
              f"    .stabilisation = {_number(model.stabilisation)},"]
    lines += [f"    .n_{group}s = {len(values)}," for group, values in given.items()]
    lines.append(f"    .has_knowns = {int(provides_elements(model))},")
    lines += [f"    .{name} = {name}," for name in (*numbers, *whole, *_TEXTS)]
    lines += [f"    .{name} = {value}," for name, value in initializers.items()]
    return "\n".join([*lines, "};", ""])


def _number(value: float) -> str:
    if math.isinf(value):
        return "HUGE_VAL" if value > 0 else "-HUGE_VAL"
    return "NAN" if math.isnan(value) else repr(float(value))


def _integers(name: str, values: Sequence[int]) -> str:
    return f"static const int {name}[] = {{{', '.join(str(int(x)) for x in values) or '0'}}};"


def _texts(name: str, values: Sequence[str]) -> str:
    return f"static const char *const {name}[] = {{{', '.join(map(_quoted, values)) or '0'}}};"


def _quoted(text: str) -> str:
    """A C string of the bytes in UTF-8; octal escapes, which end after three digits, for all that is not plain."""
    plain = "".join(chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode())
    return f'"{plain}"'
