"""Does a value change with a quantity? By derivatives at a random point: sin^2 + cos^2 of an angle does not, though both stand
in it."""

from collections.abc import Sequence

import casadi as ca
import numpy as np

_ROUNDING = 1e-9  # of the scale


def changes(expression: ca.SX, groups: Sequence[ca.SX], scale: ca.SX) -> list[bool]:
    """Of each group of symbols, whether the expression changes with it for some values of all symbols, by more than rounding
    of what is as large as `scale`. Where it has no value at the random point, what stands in it decides."""
    numbers = np.random.default_rng(1)

    def some(count: int) -> ca.DM:
        return ca.DM(numbers.uniform(0.3, 1.7, count))

    slopes = [ca.jtimes(expression, group, some(group.numel())) for group in groups]
    symbols = ca.vertcat(*ca.symvar(ca.vertcat(scale, *slopes)))
    found = ca.Function("slopes", [symbols], [scale, *slopes])(some(symbols.numel()))
    size, *sizes = (np.abs(x.full()).max(initial=0.0) for x in (found if isinstance(found, tuple | list) else [found]))
    if not np.all(np.isfinite([size, *sizes])):
        return [bool(ca.depends_on(expression, group)) for group in groups]
    return [bool(x > _ROUNDING * size) for x in sizes]
