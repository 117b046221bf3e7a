"""Conditions on rates: whether a reset ends where its condition does, so that a rate may go one way (arms.py)."""

import numpy as np

from lagrangia.dynamics.arms import SAME, Look, State


def side_of(look: Look) -> int:
    """On which side of what the rate is reset to a level is positive: 1 above, -1 below, 0 if it does not end there. `look` gives
    the level, the rate less what it is reset to, and the slopes of both, of the rate, and of what it is reset to."""
    sides = {_side(look, state) for states in look.states() for state in states}
    return sides.pop() if len(sides) == 1 else 0


def _side(look: Look, state: State) -> int:
    """The sign of the factor by which the level is the rate less what it is reset to; 0 where there is none, or where that goes
    with the rate."""
    (g,), (beyond,), slope, own, rate, wanted = (x.ravel() for x in look.at(*state))
    square = np.dot(own, own)
    if not (np.isfinite([g, beyond, *slope, *own]).all() and square > 0 and np.dot(slope, slope) > 0):
        return 0
    factor, size = np.dot(slope, own) / square, np.abs(own) @ np.abs(state[0]) + abs(beyond)
    is_same = (np.linalg.norm(slope - factor * own) <= SAME * np.linalg.norm(slope)
               and abs(g - factor * beyond) <= SAME * abs(factor) * size)
    follows = abs(np.dot(rate, wanted)) > (1 - SAME) * np.linalg.norm(rate) * np.linalg.norm(wanted) > 0
    return int(np.sign(factor)) if is_same and not follows else 0


def changes_nothing(look: Look) -> bool:
    """Whether a rate is reset to where its condition changes, and goes on from there. `look` gives the level, the rate less what
    it is reset to, and the slopes of the level and of the rate."""
    return all(_stays(look, state) for states in look.states() for state in states)


def _stays(look: Look, state: State) -> bool:
    v, *known = state
    (g,), _, slope, own = (x.ravel() for x in look.at(*state))
    along = float(np.dot(slope, own))
    if not (np.isfinite([g, along]).all() and abs(along) > SAME * np.linalg.norm(slope) * np.linalg.norm(own) > 0):
        return False
    there = v - own * g / along
    (left,), (change,), *_ = (x.ravel() for x in look.at(there, *known))
    return bool(abs(left) <= SAME * (abs(g) + np.abs(slope) @ np.abs(v))
                and abs(change) <= SAME * (np.abs(own) @ (np.abs(v) + np.abs(there))))
