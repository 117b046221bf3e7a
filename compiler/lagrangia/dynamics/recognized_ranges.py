"""For which values of a parameter an event stays what it was taken for when its scene was compiled, a contact or a kick."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product

import numpy as np

from lagrangia.algebra.orthogonal import Vector
from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import children
from lagrangia.language.tree import Call, Flat, Ref

_STEPS = (0.5, 2.0, 11.0, 101.0)  # by the size of the declared value
_USUAL = (0.0, 1.0, -1.0)  # limits
_BESIDE, _CLOSE = 1e-6, 1e-9  # by the same size
_SHARES = (1.0, 0.9, 0.75, 0.5, 0.25)  # of how far ranges of several go
_MOST_CORNERS = 32
Range = tuple[float, float]
EVERYWHERE = (-math.inf, math.inf)


def range_of(is_same: Callable[[float], bool], declared: float, within: Range) -> Range:
    """The values about the declared one for which `is_same`, as far as those that are tried tell; infinite where all are."""
    if not is_same(declared):
        return EVERYWHERE
    return _end(is_same, declared, within[0], -1), _end(is_same, declared, within[1], 1)


def _end(is_same: Callable[[float], bool], declared: float, limit: float, side: int) -> float:
    size = abs(declared) or 1.0
    inside, beside = declared, side * _BESIDE * size
    for step in _STEPS:
        outside = side * min(side * (declared + side * step * size), side * limit)
        if not is_same(outside):
            break
        inside = outside
    else:
        if not side * declared < 0 < side * inside or is_same(0.0):
            return side * math.inf
        outside, inside = 0.0, declared  # it is another at 0 alone
    for usual in _USUAL:
        if side * inside <= side * usual < side * outside:
            if not is_same(usual):
                outside = usual
            elif not is_same(usual + beside):
                return usual
            else:
                inside = usual
    if is_same(outside - beside):
        return outside - beside
    while abs(outside - inside) > _CLOSE * size:
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if is_same(middle) else (inside, middle)
    return inside


def shared_ranges(is_same: Callable[[Vector], bool], declared: Vector, ranges: Sequence[Range]) -> list[Range]:
    """The ranges of several, each of which was found with the others as declared: nearer to these, where that does not hold for
    all that they may be together. Signs are kept where that helps; what has no end gets none. As they are where less
    than a quarter would be left: that refuses more than it finds out."""
    n, far = len(ranges), _STEPS[-1] * np.where(declared == 0, 1.0, np.abs(declared))
    own = np.array(ranges).T
    side = np.sign(declared)
    kept = np.array([np.where(side > 0, np.maximum(own[0], 0), own[0]), np.where(side < 0, np.minimum(own[1], 0), own[1])])
    cases = [*product((0, 1), repeat=n)] if 2**n <= _MOST_CORNERS else np.random.default_rng(7).integers(0, 2, (_MOST_CORNERS, n))
    for share, ends in product(_SHARES, (own, kept)):
        nearer = np.isfinite(ends)
        reach = np.clip(ends, declared - far, declared + far) - declared
        found = declared + np.where(nearer, share, 1.0) * reach
        if all(is_same(found[np.array(case, dtype=int), range(n)]) for case in cases):
            return [(float(low), float(high)) for low, high in (np.where(nearer, found, ends) if share < 1 else ends).T]
    return [*ranges]


def parameters_in(model: FlatModel, roots: Iterable[Flat]) -> frozenset[str]:
    """The parameters that are written in expressions, or in variables in them; but those that only rates, der(...), are of."""
    return frozenset(name for name in _names(model, roots) if model.variables[name].kind == "parameter")


def _names(model: FlatModel, roots: Iterable[Flat]) -> Iterator[str]:
    pending, seen = list(roots), set[str]()
    while pending:
        node = pending.pop()
        if isinstance(node, Ref) and node.name in model.variables and node.name not in seen:
            seen.add(node.name)
            yield node.name
            variable = model.variables[node.name]
            if variable.kind == "variable" and variable.binding is not None:
                pending.append(variable.binding)
        elif not (isinstance(node, Call) and node.function == "der"):
            pending.extend(children(node))
