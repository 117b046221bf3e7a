"""A sweep in pieces: runs that are handed out together, so many that a piece takes about the same time everywhere."""

import math
import threading
from collections.abc import Callable, Sequence

from lagrangia.study.sweep.journal import Ledger

_GROWTH = 512  # of a piece over the one before, at most: each costs as much as some fifty short runs
_LONGEST = 100_000  # runs
_FEWEST = 4  # times as many as go on together
_SHARE = 0.7  # of what a worker would have of all that is left: the rest makes up for runs that take longer than others

Watch = Callable[[Ledger], None]


class Pieces:
    """Hands out the runs that are missing; may be asked from several threads."""

    def __init__(self, missing: Sequence[tuple[int, int]], workers: int) -> None:
        self._missing = list(reversed(missing))
        self._left = sum(last - first for first, last in missing)
        self._workers = workers
        self._lock = threading.Lock()

    @property
    def left(self) -> int:
        """Runs that are still to be handed out."""
        return self._left

    def take(self, most: int, together: int = 1) -> tuple[int, int] | None:
        """At most so many; fewer towards the end, so that all workers end together, but not so few that the places of those
        `together` stay empty for long."""
        with self._lock:
            if not self._missing:
                return None
            first, last = self._missing.pop()
            share = self._left if self._workers == 1 else math.ceil(_SHARE * self._left / self._workers)
            count = min(most, last - first, max(share, _FEWEST * together if together > 1 else 1))
            count -= count % together if count > together else 0
            if first + count < last:
                self._missing.append((first + count, last))
            self._left -= count
            return first, first + count


class Pace:
    """How many runs take so many seconds, learnt from those before."""

    def __init__(self, seconds: float, first: int = 1) -> None:
        self.seconds, self.count = seconds, first

    def learn(self, runs: int, seconds: float) -> None:
        """How many runs to take next, from what so many took."""
        fitting = runs * self.seconds / max(seconds, 1e-6)
        self.count = max(1, min(int(fitting), self.count * _GROWTH, _LONGEST))
