"""A job -> its table, here on all cores or on a cluster; in memory, or with a journal from which a killed sweep goes on."""

import os
import time
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Protocol

from lagrangia.base.checked_values import a_count
from lagrangia.base.diagnostics import Interrupted, fail
from lagrangia.base.result_files import keep_apart, require_kind, require_parquet
from lagrangia.run.engines import Engine
from lagrangia.run.request import Request
from lagrangia.run.scene import Scene
from lagrangia.run.solvers import name_of
from lagrangia.study.sweep.dask_cluster import run_on_dask
from lagrangia.study.sweep.journal import Journal, Ledger
from lagrangia.study.sweep.keeping import InMemory, Keeper
from lagrangia.study.sweep.measures import Measure, quantities, read_measures
from lagrangia.study.sweep.pieces import Watch
from lagrangia.study.sweep.plan import Design, Job
from lagrangia.study.sweep.progress import bar_in_python
from lagrangia.study.sweep.table import Sweep, is_parquet
from lagrangia.study.sweep.threads import cores, run_on_threads
from lagrangia.study.sweep.until import looks

_TABLES = (".csv", ".txt", ".dat", ".parquet", ".pq")


class Loaded(Protocol):
    """A model, of which only the native code is wanted, and only where it is used."""

    native: bool | None  # as in `load_engine`

    def engine_for(self, solver: str) -> Engine | None:
        """The engine that a solver wants; None without a C compiler."""


class Asked(Loaded, Protocol):
    """A model whose runs are measured."""

    scene: Scene

    @property
    def path(self) -> Path:
        """Of its file."""

    def reporting(self, names: Sequence[str]) -> "Asked":
        """The one that reports these names too."""

    def prepared_for(self, measures: Sequence[Measure], request: Request, design: Design) -> "tuple[Asked, Job]":
        """All runs of a sweep, and the model for them."""


def run_job(job: Job, model: Loaded, ledger: Ledger, *, jobs: int | None = None, dask: str | None = None,
            watch: Watch | None = None, keeper: Keeper | None = None) -> Sweep:
    """What the ledger misses, on so many threads (all cores), or on the cluster of a Dask scheduler; of a job that ends early the
    first runs alone.

    KeyboardInterrupt ends it, and marks the table as interrupted. Raises LagError L0712, L0716, L0901.
    """
    if jobs is not None and a_count("number of jobs", jobs) < 1:
        fail("L0712", f"the number of jobs must be positive, not {jobs}")
    engine = model.engine_for(name_of(job.sweep.settings.solver)) if dask is None else None
    if dask is None and engine is None:
        fail("L0901", "not supported yet: many runs without a C compiler", None, "pip install ziglang brings one")
    begin = time.perf_counter()
    for last in looks(job.runs) if job.until is not None else (job.runs,):
        ledger.wanted = last
        is_whole = (run_on_threads(job, engine, ledger, jobs or cores(), watch, keeper) if engine is not None
                    else run_on_dask(job, str(dask), ledger, watch, keeper, model.native))
        if not is_whole or (job.until is not None and job.until.holds(ledger.results[:last])):
            break
    if is_whole and last < job.runs:
        job = job.first(last)
        ledger = ledger.first(job)
    kept = keeper if isinstance(keeper, InMemory) else None
    return Sweep(job, ledger, time.perf_counter() - begin, not is_whole, kept)


def require_place(path: str | os.PathLike[str], read: Iterable[str | os.PathLike[str]]) -> None:
    """Whether the table may be written there, and its journal beside it. Raises LagError L0004, L0715."""
    require_kind(path, *_TABLES)
    keep_apart([path, f"{os.fspath(path)}.part"], read)
    if is_parquet(path):
        require_parquet()


def run_many(model: Asked, outputs: str | Sequence[str], request: Request, design: Design, path: str | os.PathLike[str] | None,
             *, restart: bool, jobs: int | None, dask: str | None, progress: bool | None) -> Sweep:
    """What Model.simulate_many does. Raises LagError, Interrupted with what was computed."""
    if path is not None:
        require_place(path, [model.path, *model.scene.notes["files"], *([design.runs] if isinstance(design.runs, Path) else [])])
    if path is not None and design.keeps:
        fail("L0901", "not supported yet: trajectories in memory beside a table in a file", None,
             "leave path out, or use the command lag sweep --keep, which writes both to files")
    measures = read_measures(outputs)
    suited, job = model.reporting(quantities(measures)).prepared_for(measures, request, design)
    sweep = run_into(job, suited, path, restart=restart, jobs=jobs, dask=dask, progress=progress)
    if sweep.interrupted:
        raise Interrupted.with_result(sweep, f"after {sweep.ledger.entered} of {sweep.runs} runs")
    sweep.warn()
    return sweep


def run_into(job: Job, model: Loaded, path: str | os.PathLike[str] | None, *, restart: bool = False, jobs: int | None = None,
             dask: str | None = None, progress: bool | None = False) -> Sweep:
    """Like `run_job`, and writes the table to the path, if there is one; `path`.part is the journal meanwhile. `progress`:
    whether a bar shows how far it is; None: where somebody looks."""
    with Journal(job, Path(f"{os.fspath(path)}.part"), restart) if path is not None else nullcontext(Ledger(job)) as ledger:
        keeper = InMemory(job.scene, job.runs, len(job.sweep.row_times)) if job.sweep.row_times else None
        bar = bar_in_python(ledger, job.runs, progress)
        try:
            sweep = run_job(job, model, ledger, jobs=jobs, dask=dask, watch=bar, keeper=keeper)
        finally:
            if bar is not None:
                bar.close()
        if path is not None and not sweep.interrupted and isinstance(ledger, Journal):
            sweep.write(path)
            ledger.remove()
        return sweep
