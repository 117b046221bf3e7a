"""SymPy expressions as numbers: for thousands that are evaluated once each, of which sympy.lambdify would write a function."""

from collections.abc import Callable, Mapping
from functools import reduce

import numpy as np
import sympy as sp

_FUNCTIONS: Mapping[type, Callable[..., np.ndarray]] = {
    sp.sin: np.sin, sp.cos: np.cos, sp.tan: np.tan, sp.exp: np.exp, sp.log: np.log, sp.sign: np.sign, sp.tanh: np.tanh,
    sp.Abs: np.abs, sp.asin: np.arcsin, sp.acos: np.arccos, sp.atan: np.arctan, sp.atan2: np.arctan2, sp.Pow: np.power,
    sp.Add: lambda *terms: sum(terms), sp.Mul: lambda *factors: reduce(np.multiply, factors),
    sp.Min: lambda *values: reduce(np.minimum, values), sp.Max: lambda *values: reduce(np.maximum, values),
}


def evaluated(x: sp.Expr, values: Mapping[str, np.ndarray], known: dict[sp.Expr, np.ndarray]) -> np.ndarray:
    """The value of an expression where symbols have these values, by name; `known` keeps those of its parts.

    Raises KeyError for a symbol without a value, or a function that is none of these."""
    if x not in known:
        if x.is_Symbol:
            known[x] = values[x.name]
        elif x.is_number:
            known[x] = np.float64(x)
        else:
            known[x] = _FUNCTIONS[x.func](*(evaluated(part, values, known) for part in x.args))
    return known[x]
