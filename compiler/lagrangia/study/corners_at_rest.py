"""Small motion about a place where forces bend: stiffness, or damping, is another one to either side, and no linear motion tells.

A spring that acts one way, play, abs(x) and max(x, 0) in an energy bend where they are 0, and machines like to rest there. What
is linearised there is of neither side: which slope a corner has is a convention. So forces and slopes are looked at a little to
both sides: they jump where they change more between these than beyond them.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Slopes = Callable[[Vector, bool], list[Vector]]  # of a displacement, m or rad, and the side on which rates are: forces, matrices

BENT = ("warning[L0743]: forces bend just here: stiffness or damping is another one to either side, as of a spring that acts one "
        "way, and frequencies, damping and stability are of neither; lag simulate has the motion itself")
BARRED = ("warning[L0743]: something that just touches bars the way back: what moves it does not swing through, and frequencies "
          "and damping are of the motion away from it; lag simulate has the motion itself")
_ASIDE = 1e-6  # of how far coordinates reach
_JUMP, _NOTHING = 10.0, 1e-7  # between both sides, by the changes beyond them; relative
_WAYS = 3


def bends_at(slopes: Slopes, N: Vector, reach: Vector) -> bool:
    """Whether the slopes jump, of displacements along N (n, f), or from one side of rates to the other."""
    random, still = np.random.default_rng(3), np.zeros(N.shape[0])
    if _is_jump(slopes(still, False), slopes(still, True), None):
        return True
    for _ in range(_WAYS if N.shape[1] else 0):
        way = N @ random.uniform(-1, 1, N.shape[1])
        way *= _ASIDE * float(np.min(reach[way != 0] / np.abs(way[way != 0]), initial=1.0))
        far_back, back, ahead, far_ahead = (slopes(k * way, True) for k in (-2, -1, 1, 2))
        if _is_jump(back, ahead, [max(x, y) for x, y in zip(_changes(far_back, back), _changes(ahead, far_ahead), strict=True)]):
            return True
    return False


def _changes(one: list[Vector], other: list[Vector]) -> list[float]:
    return [float(np.abs(a - b).max(initial=0.0)) for a, b in zip(one, other, strict=True)]


def _is_jump(one: list[Vector], other: list[Vector], beyond: list[float] | None) -> bool:
    """Of forces or of a matrix; `beyond`: the changes of each where there is no corner."""
    sizes = [float(np.abs([a, b]).max(initial=0.0)) for a, b in zip(one, other, strict=True)]
    return any(change > _JUMP * usual + _NOTHING * size
               for change, usual, size in zip(_changes(one, other), beyond or [0.0] * len(sizes), sizes, strict=True))
