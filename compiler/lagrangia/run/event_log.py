"""The times of a run's events, as C keeps them: the first so many, in memory that is taken where a scene can have some."""

import ctypes as c

from lagrangia.run.request import Values
from lagrangia.run.runtime import Run
from lagrangia.run.scene import Scene

MOST_EVENTS = 4096  # of a run, whose times are kept
_CAUSES = ("n_events", "n_modes", "n_switches", "n_whens", "n_rubs")  # sizes of what brings events about


class EventLog:
    """Of a run that has not advanced yet."""

    def __init__(self, library: c.CDLL, run: Run) -> None:
        self._times = (c.c_double * MOST_EVENTS)()
        self._run, self._library = run, library
        library.lag_run_log_events(c.c_void_p(run.handle), self._times, MOST_EVENTS)

    def times(self) -> list[float]:
        """Those so far, s, while the run is open."""
        return self._times[: self._library.lag_run_logged(c.c_void_p(self._run.handle))]


def log_events(library: c.CDLL, run: Run, scene: Scene, values: Values) -> EventLog | None:
    """None for a motion without events."""
    has_some = any(scene.sizes.get(name) for name in _CAUSES) or len(values.input_times) > 1
    return EventLog(library, run) if has_some else None
