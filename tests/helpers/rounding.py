"""Rounding of the accelerations: the same formulas in numbers of 64 bits beside them."""

from collections.abc import Iterable, Sequence

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from lagrangia.compile.numpy_module import TEXTS, number
from lagrangia.compile.statements import statements

needs_longer_numbers = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="no numbers longer than double here")


def noise(model: lag.Model, states: Iterable[Sequence[np.ndarray]], function: ca.Function | None = None) -> float:
    """The largest difference, relative to the largest acceleration. A state is t, q, v, u. The function, of these and p, is the
    model's own unless given."""
    rhs = model.functions()["rhs"] if function is None else function
    lines, (entries, *_) = statements(rhs, [f"{name}[{{}}]".format for name in "tqvup"], TEXTS, number=number)
    program = compile("\n".join([*lines, f"out = [{', '.join(entries)}]"]), "rhs", "exec")

    def evaluate(values: list[np.ndarray], number: type) -> np.ndarray:
        names = {name: list(map(number, value)) for name, value in zip("tqvup", values, strict=True)}
        exec(program, {"np": np}, names)
        return np.array(names["out"], dtype=np.longdouble)

    found = []
    for values in states:
        exact = evaluate([*values, model.parameter_values()], np.longdouble)
        rounded = evaluate([*values, model.parameter_values()], np.float64)
        found.append(float(np.abs(rounded - exact).max() / np.abs(exact).max()))
    return max(found)
