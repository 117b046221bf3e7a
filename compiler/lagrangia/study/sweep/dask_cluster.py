"""A job -> its results on a Dask cluster: pieces are tasks, and each worker builds or finds the scene's library in its own cache.

A task gets the scene as JSON and the values of its runs; it answers with bytes. A worker that dies takes its pieces with it, and
Dask gives them to another one; the JSON is itself a task's result, so that it can be had again as well.
"""

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from lagrangia.base.diagnostics import Error, RunError, fail
from lagrangia.base.folders import data_folder
from lagrangia.native.prebuilt import digest
from lagrangia.run.batch import ABREAST, Batch, Lanes, Reduction, Sweep, outcome_type
from lagrangia.run.engines import Engine, load_engine
from lagrangia.run.runtime import Settings, Solver
from lagrangia.run.scene import from_json, to_json
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.keeping import Keeper
from lagrangia.study.sweep.pieces import Pace, Pieces, Watch
from lagrangia.study.sweep.plan import Job

_PIECE = 1.0  # s, on few threads
_PIECE_A_THREAD = 0.01  # s: a task costs the scheduler a millisecond, so that it is busy for a tenth of its time at most
_GONE = ("CommClosedError", "CancelledError", "FutureCancelledError", "StreamClosedError", "TimeoutError")
_TIMEOUT = 15  # s, to reach the scheduler and the first worker
_SILENT = 60  # s without an answer of the scheduler or a worker: it hangs, or its machine does, as the connection stays
_AHEAD = 2  # tasks for each thread of the cluster
_RETRIES = 2

_loading = threading.Lock()


# -------------------------------------------------------------------- in the worker


Answer = tuple[bytes, bytes, bytes, float, tuple[int, ...]]  # results, outcomes, kept rows, seconds, and how full lanes were


def run_there(text: str, runs: int, values: bytes) -> Answer:
    """What the runs with these values come to."""
    import numpy as np

    engine, sweep = _loaded(text)
    begin, processor = time.perf_counter(), time.thread_time()
    with Batch(engine.runtime, engine.model, sweep) as batch:
        results, outcomes, rows = batch.advance(np.frombuffer(values, dtype="<f8").reshape(runs, len(sweep.varied)))
        lanes = tuple(batch.lanes)
    seconds = time.perf_counter() - begin
    engine.look(time.thread_time() - processor, 0.0)  # nobody knows here how many are left
    return results.astype("<f8").tobytes(), outcomes.tobytes(), rows.astype("<f8").tobytes(), seconds, lanes


def _loaded(text: str) -> tuple[Engine, Sweep]:
    with _loading:  # the threads of a worker share what one of them has built
        return _load(text)


@lru_cache(maxsize=8)
def _load(text: str) -> tuple[Engine, Sweep]:
    plain = json.loads(text)
    if plain["runtime"] != digest(data_folder("runtime")):
        raise RuntimeError("the worker has another version of lagrangia")
    given = plain["sweep"]
    given["settings"] = Settings(**given["settings"])
    engine = load_engine(from_json(plain["scene"]), native=plain["native"], solver=Solver(given["settings"].solver))
    if engine is None:
        raise RuntimeError("the worker has neither a run time nor a C compiler (pip install ziglang brings one)")
    given["reductions"] = [Reduction(**reduction) for reduction in given["reductions"]]
    return engine, Sweep(**given)


# -------------------------------------------------------------------- here


def pack(job: Job, native: bool | None) -> str:
    """What `run_there` needs of a job; `native` as in `load_engine`."""
    return json.dumps({"runtime": digest(data_folder("runtime")), "scene": to_json(job.scene), "sweep": asdict(job.sweep),
                       "native": native})


def run_on_dask(job: Job, address: str, ledger: Ledger, watch: Watch | None = None, keeper: Keeper | None = None,
                native: bool | None = None) -> bool:
    """Runs what the ledger misses on the cluster of the scheduler at this address; the keeper has a run's rows before the ledger.
    `native`: as in `load_engine`. False when the keyboard interrupted it.

    Raises LagError L0716 when there is no such cluster, RunError when the workers cannot do it or the cluster goes away; the
    ledger keeps what was done.
    """
    with _connected(address) as client, _there(client, address, ledger):
        tasks = _Tasks(job, client, ledger, keeper, native)
        try:
            while tasks.submit():
                tasks.collect()
                if watch is not None:
                    watch(ledger)
        except KeyboardInterrupt:
            return False
    return True


@contextmanager
def _there(client: Any, address: str, ledger: Ledger) -> "Iterator[None]":
    """What Dask says in many ways of a scheduler that is no more is said in one. Raises RunError."""
    try:
        yield
    except BaseException as error:
        is_ours = isinstance(error, Error | KeyboardInterrupt)
        if is_ours or (type(error).__name__ not in _GONE and client.status == "running"):
            raise
        what = ", or a worker of it, does not answer" if type(error).__name__ == "TimeoutError" else " has gone away"
        raise RunError(f"the Dask scheduler at '{address}'{what}: {ledger.entered} of {len(ledger.outcomes)} runs are "
                       "done; the same command goes on with the others") from None


@contextmanager
def _connected(address: str) -> "Iterator[Any]":
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        fail("L0716", "--dask needs Dask, which is not installed", None, "pip install dask distributed")
    try:
        get_address_host_port(address)  # a client that refuses it leaves threads behind
        client = Client(address, timeout=_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        fail("L0716", f"there is no Dask scheduler at '{address}': {str(error) or type(error).__name__}", None,
             "`dask scheduler` starts one, and says its address: tcp://host:8786")
    with _silence(), _closed(client), client.as_current():  # `wait` looks for the current one
        try:
            client.wait_for_workers(1, timeout=_TIMEOUT)
        except TimeoutError:
            fail("L0716", f"the Dask scheduler at '{address}' has no workers", None, f"`dask worker {address}` starts one")
        yield client


@contextmanager
def _closed(client: Any) -> "Iterator[None]":
    """Closes the client at last, by which the scheduler drops its tasks; one that hangs hears of it when it goes on."""
    try:
        yield
    finally:
        with suppress(TimeoutError):
            client.close()


@contextmanager
def _silence() -> "Iterator[None]":
    """Dask's own words about a lost connection, with its source, come on top of ours."""
    import logging

    names = ("distributed.client", "distributed.core", "distributed.comm", "distributed.comm.core", "distributed.comm.tcp",
             "distributed.batched", "distributed.utils", "tornado.application", "asyncio")
    loggers = [logging.getLogger(name) for name in names]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


class _Tasks:
    """The pieces that are on their way."""

    def __init__(self, job: Job, client: Any, ledger: Ledger, keeper: Keeper | None, native: bool | None) -> None:
        self.job, self.client, self.ledger, self.keeper = job, client, ledger, keeper
        self.text = client.submit(str, pack(job, native), pure=False)
        self.together = ABREAST if job.sweep.in_lanes else 1
        self.pace = Pace(max(_PIECE, _PIECE_A_THREAD * self._threads()), self.together)
        self.pieces = Pieces(ledger.missing(), self._threads())
        self.flying: dict[Any, tuple[int, int]] = {}

    def _threads(self) -> int:
        threads: int = sum(self.client.nthreads(callback_timeout=_SILENT).values())
        return max(1, threads)

    def submit(self) -> bool:
        """Keeps the cluster busy. False when nothing is left to wait for."""
        while len(self.flying) < _AHEAD * self._threads():
            piece = self.pieces.take(self.pace.count, self.together)
            if piece is None:
                break
            values = self.job.variations.values(*piece).astype("<f8")
            future = self.client.submit(run_there, self.text, len(values), values.tobytes(), pure=False, retries=_RETRIES)
            self.flying[future] = piece
        return bool(self.flying)

    def collect(self) -> None:
        """Enters what has arrived, after at most a second."""
        import numpy as np
        from distributed import wait

        try:
            wait(list(self.flying), timeout=1, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return
        for future in [future for future in self.flying if future.done()]:
            first, last = self.flying.pop(future)
            results, outcomes, rows, seconds, lanes = self._result(future)
            self.ledger.lanes = self.ledger.lanes.plus(Lanes(*lanes))
            if self.keeper is not None and rows:
                kept = np.frombuffer(rows, dtype="<f8")
                self.keeper.keep(first, kept.reshape(last - first, len(self.job.sweep.row_times), -1))
            self.ledger.enter(first, np.frombuffer(results, dtype="<f8").reshape(last - first, len(self.job.measures)),
                              np.frombuffer(outcomes, dtype=outcome_type()))
            self.pace.learn(last - first, seconds)

    def _result(self, future: Any) -> Answer:
        if future.status == "error":
            error = future.exception(timeout=_SILENT)
            raise RunError(f"the workers cannot run it: {type(error).__name__}: {error}") from None
        if future.status != "finished":
            raise RunError("the Dask cluster has gone away; the same command continues the sweep")
        found: Answer = future.result(timeout=_SILENT)
        return found
