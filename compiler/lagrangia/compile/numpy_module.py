"""CasADi Functions -> a Python module that needs NumPy alone: one assignment an operation."""

import math
from collections.abc import Mapping

import casadi as ca

from lagrangia.compile.statements import statements, texts_of

_BINARY = {"ADD": "{0} + {1}", "SUB": "{0} - {1}", "MUL": "{0}*{1}", "DIV": "{0}/{1}", "POW": "{0}**{1}", "CONSTPOW": "{0}**{1}",
           "LT": "1.0*({0} < {1})", "LE": "1.0*({0} <= {1})", "EQ": "1.0*({0} == {1})", "NE": "1.0*({0} != {1})",
           "AND": "1.0*(({0} != 0) & ({1} != 0))", "OR": "1.0*(({0} != 0) | ({1} != 0))", "FMIN": "np.minimum({0}, {1})",
           "FMAX": "np.maximum({0}, {1})", "ATAN2": "np.arctan2({0}, {1})", "FMOD": "np.fmod({0}, {1})",
           "COPYSIGN": "np.copysign({0}, {1})", "IF_ELSE_ZERO": "np.where({0} != 0, {1}, 0.0)", "HYPOT": "np.hypot({0}, {1})"}
_UNARY = {"ASSIGN": "{0}", "NEG": "-{0}", "SQ": "{0}*{0}", "TWICE": "2.0*{0}", "INV": "1.0/{0}", "NOT": "1.0*({0} == 0)",
          **{op: f"np.{name}({{0}})" for op, name in (
              ("SQRT", "sqrt"), ("SIN", "sin"), ("COS", "cos"), ("TAN", "tan"), ("ASIN", "arcsin"), ("ACOS", "arccos"),
              ("ATAN", "arctan"), ("SINH", "sinh"), ("COSH", "cosh"), ("TANH", "tanh"), ("ASINH", "arcsinh"),
              ("ACOSH", "arccosh"),
              ("ATANH", "arctanh"), ("EXP", "exp"), ("LOG", "log"), ("FABS", "abs"), ("SIGN", "sign"), ("FLOOR", "floor"),
              ("CEIL", "ceil"))}}
TEXTS = texts_of(_BINARY | _UNARY)


def number(value: float) -> str:
    """A constant, or what is none."""
    return repr(value) if math.isfinite(value) else f"{'-' * (value < 0)}np.{abs(value)!r}"


def write_function(name: str, function: ca.Function, arguments: Mapping[str, str], doc: str,
                   shape: tuple[int, int] | None) -> str:
    """A Python function of the arguments: a vector, or with `shape` a matrix."""
    lines, (entries,) = statements(function, [text.format for text in arguments.values()], TEXTS, number=number)
    body = "".join(f"    {line}\n" for line in lines)
    if shape is None:
        result = f"np.array([{', '.join(entries)}], dtype=float)"
    else:
        rows = [f"[{', '.join(entries[i + j * shape[0]] for j in range(shape[1]))}]" for i in range(shape[0])]
        result = f"np.array([{', '.join(rows)}], dtype=float).reshape({shape[0]}, {shape[1]})"
    return f"def {name}({', '.join(arguments)}):\n    \"\"\"{doc}\"\"\"\n{body}    return {result}\n"
