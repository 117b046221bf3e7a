"""How far a sweep is, for somebody who watches: tqdm's bar in Python where it is installed, else our own."""

import sys
import time
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Protocol

from lagrangia.study.sweep.journal import Ledger

_BAR_AFTER = 2.0  # seconds


class Shown(Protocol):
    """A bar."""

    def __call__(self, ledger: Ledger) -> None:
        """What is done by now."""

    def close(self) -> None:
        """The sweep has ended."""


class Bar:
    """A progress bar with the time left, on sweeps over two seconds, where somebody watches."""

    def __init__(self, ledger: Ledger, runs: int, stream: Any, always: bool = False) -> None:
        """`always`: on streams that are no terminals, too."""
        self.runs, self.stream, self.is_wanted = runs, stream, always or stream.isatty()
        self.before, self.begin = ledger.entered, time.perf_counter()
        self.is_shown = False

    def __call__(self, ledger: Ledger) -> None:
        elapsed, now = time.perf_counter() - self.begin, ledger.entered - self.before
        if elapsed < _BAR_AFTER or not self.is_wanted or not now:
            return
        done = ledger.entered / self.runs
        filled, left = int(30 * done), elapsed * (self.runs - ledger.entered) / now
        self.stream.write(f"\r[{'#' * filled}{'.' * (30 - filled)}] {100 * done:5.1f} %  {ledger.entered} of {self.runs} runs  "
                          f"{left:.0f} s left   ")
        self.stream.flush()
        self.is_shown = True

    def close(self) -> None:
        """Clears its line."""
        if self.is_shown:
            self.stream.write("\r" + " " * 90 + "\r")


class TqdmBar:
    """The same by tqdm, which draws itself in notebooks."""

    def __init__(self, ledger: Ledger, runs: int) -> None:
        self.bar = import_module("tqdm.auto").tqdm(total=runs, initial=ledger.entered, unit=" runs", delay=_BAR_AFTER)

    def __call__(self, ledger: Ledger) -> None:
        self.bar.update(ledger.entered - self.bar.n)

    def close(self) -> None:
        """Stays as it is."""
        self.bar.close()


def bar_in_python(ledger: Ledger, runs: int, wanted: bool | None) -> Shown | None:
    """None where none is wanted: by default where neither a terminal nor a notebook is there to be looked at."""
    is_notebook = "ipykernel" in sys.modules
    if not (wanted if wanted is not None else is_notebook or sys.stderr.isatty()):
        return None
    if find_spec("tqdm"):
        return TqdmBar(ledger, runs)
    return Bar(ledger, runs, sys.stderr, always=True)
