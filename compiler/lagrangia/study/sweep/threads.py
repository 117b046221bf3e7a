"""A job -> its results, on all cores: one thread and one C batch each, in pieces of the length that takes a fifth of a second."""

import ctypes
import os
import queue
import threading
import time
from typing import TYPE_CHECKING

from lagrangia.base.interruptions import held_back
from lagrangia.run.batch import ABREAST, Batch, Lanes
from lagrangia.run.engines import Engine
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.keeping import InMemory, Keeper
from lagrangia.study.sweep.pieces import Pace, Pieces, Watch
from lagrangia.study.sweep.plan import Job

if TYPE_CHECKING:
    import numpy as np

_PIECE = 0.2  # s
_PAUSE = 0.1  # s between two looks at the keyboard

def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Worker(threading.Thread):
    """Runs pieces until there are none, an error occurs or `stop` is set; answers into a queue, with None at the end."""

    def __init__(self, job: Job, engine: Engine, pieces: Pieces, stop: ctypes.c_int32, answers: "queue.SimpleQueue[object]",
                 rows: "np.ndarray | None") -> None:
        super().__init__(daemon=True)
        self.job, self.engine, self.pieces, self.stop, self.answers, self.rows = job, engine, pieces, stop, answers, rows

    def run(self) -> None:
        try:
            with Batch(self.engine.runtime, self.engine.model, self.job.sweep) as batch:
                together = ABREAST if self.job.sweep.in_lanes else 1
                pace = Pace(_PIECE, together)
                while not self.stop.value and (piece := self.pieces.take(pace.count, together)) is not None:
                    begin, processor = time.perf_counter(), time.thread_time()
                    held, rows = (x if x is None else x[slice(*piece)] for x in (self.job.held, self.rows))
                    self.answers.put((piece[0], *batch.advance(self.job.variations.values(*piece), self.stop, held, rows)))
                    seconds = time.perf_counter() - begin
                    pace.learn(piece[1] - piece[0], seconds)
                    seconds = time.thread_time() - processor  # what others have it for meanwhile is no work
                    self.engine.look(seconds, seconds / (piece[1] - piece[0]) * self.pieces.left)
                self.answers.put(batch.lanes)
        except BaseException as error:
            self.answers.put(error)
        self.answers.put(None)


def run_on_threads(job: Job, engine: Engine, ledger: Ledger, threads: int, watch: Watch | None = None,
                   keeper: Keeper | None = None) -> bool:
    """Runs what the ledger misses; the keeper has a run's rows before the ledger has it. False when the keyboard interrupted it:
    what was computed is in the ledger."""
    answers: queue.SimpleQueue[object] = queue.SimpleQueue()
    stop = ctypes.c_int32(0)
    pieces = Pieces(ledger.missing(), threads)
    rows = keeper.all if isinstance(keeper, InMemory) else None
    workers = [_Worker(job, engine, pieces, stop, answers, rows) for _ in range(min(threads, job.runs))]
    for worker in workers:
        worker.start()
    failure: BaseException | None = None
    working = len(workers)
    with held_back() as interrupts:
        try:
            while working:
                if interrupts:
                    stop.value = 1
                try:
                    answer = answers.get(timeout=_PAUSE)
                except queue.Empty:
                    continue
                if answer is None:
                    working -= 1
                elif isinstance(answer, BaseException):
                    failure, stop.value = failure or answer, 1
                elif isinstance(answer, Lanes):
                    ledger.lanes = ledger.lanes.plus(answer)
                elif isinstance(answer, tuple):
                    first, results, outcomes, found = answer
                    if keeper is not None and len(found):
                        keeper.keep(first, found)
                    ledger.enter(first, results, outcomes)
                    if watch is not None:
                        watch(ledger)
        finally:
            stop.value = 1  # also when the ledger's disk is full
    if failure is not None:
        raise failure
    return not interrupts
