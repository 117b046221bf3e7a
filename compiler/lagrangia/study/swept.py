"""Many runs of a model and what is measured of them, as Python asks for them."""

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from lagrangia.base.checked_values import by_name
from lagrangia.base.diagnostics import fail
from lagrangia.run.engines import Engine
from lagrangia.run.formulas import Compute, Sets
from lagrangia.run.interpret import evaluate, evaluate_each
from lagrangia.run.origin import Origin
from lagrangia.run.remarks import warn_of_given
from lagrangia.run.request import Request, check_values
from lagrangia.run.scene import Scene

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from lagrangia.study.rollout import Rollout
    from lagrangia.study.sweep.measures import Measure
    from lagrangia.study.sweep.plan import Design, Job
    from lagrangia.study.sweep.table import Sweep


class Swept(ABC):
    """What can be run many times."""

    origin: Origin
    scene: Scene
    native: bool | None  # as in `load_engine`

    @abstractmethod
    def reporting(self, names: Sequence[str]) -> Self:
        """The one that reports these names too."""

    @property
    @abstractmethod
    def readers(self) -> Mapping[str, list[str]]:
        """What reads the parameters that only other parameters and starts read."""

    @property
    def path(self) -> Path:
        """Of the file it was loaded from."""
        return self.origin.path

    @abstractmethod
    def completed(self) -> Self:
        """Itself, with what large scenes get when it is first asked for."""

    @abstractmethod
    def _suited(self, sets: Sets, compute: Compute) -> Self:
        """The one whose formulas hold for these sets of parameters."""

    @cached_property
    def _holds_as_declared(self) -> bool:
        """Whether its formulas are those of the parameters as they are declared."""
        values = check_values(self.scene)
        return self._suited(lambda: [(values.parameters, values.mask)], evaluate) is self

    def prepared_for(self, measures: "Sequence[Measure]", request: Request, design: "Design") -> "tuple[Self, Job]":
        """All runs of a sweep, and the model whose formulas hold for the parameters of each."""
        from lagrangia.study.sweep.measures import usual_measures
        from lagrangia.study.sweep.plan import build_job

        job = build_job(self.completed().scene, measures or usual_measures(self.scene), request, design)
        is_declared = not request.parameters and not job.varied_parameters.factors
        suited = self if is_declared and self._holds_as_declared else self._suited(job.parameter_sets, evaluate_each)
        return (self, job) if suited is self else suited.prepared_for(measures, request, design)

    @abstractmethod
    def engine_for(self, solver: str) -> Engine | None:
        """The engine that a solver wants; None without a C compiler."""

    def simulate_many(
        self, *, parameters: Mapping[str, Any] | None = None, initial: Mapping[str, Any] | None = None,
        outputs: str | Sequence[str] = (), runs: Any = None, samples: int | None = None, seed: int = 0,
        sampling: str = "random", together: bool = False, stop: float | None = None, start: float | None = None,
        tolerance: float | None = None, interval: float | None = None, inputs: Any = None, solver: str = "auto",
        max_step: float = 0.0, max_steps: int = 0, seconds_per_run: float = 0.0, jobs: int | None = None, dask: str | None = None,
        path: str | os.PathLike[str] | None = None, restart: bool = False, keep: bool = False, progress: bool | None = None,
        until: str | None = None,
    ) -> "Sweep":
        """Many runs on all cores, or on a Dask cluster: all combinations of the values given, nothing compiled again.
        Trees of bodies without events go on together, eight on each core, as exactly as alone; so do loops by erk, erk5 and erk9.

        Values are numbers, sequences, or text: "100:2000:50" (from:to:step), "linspace(0, 1, 11)", "normal(100, 5)", of which
        `samples` are taken; a list of `inputs` has some for each run. `runs` has a row for each run: a CSV file, a DataFrame, or
        columns by name. `together` takes sequences side by side. `outputs` are measures: "max(y)", "at(0.5, y)",
        "first_time(abs(y) > 3)", ...; final values by default (`lag help sweep`). The motion is looked at every `interval` (s) at
        least. A run that fails is told in `.failures`, and no error; of open energy accounts, where numbers stand all the same, a
        RunWarning tells. `keep` keeps whole trajectories, rows an `interval` apart: `.trajectories`, `.to_xarray()`. With a
        `path` (.csv, .parquet) the table is written there, and a sweep that was killed goes on from `path`.part. `progress`: a
        bar, by default where somebody looks. `until` ends random runs early, once "se(mean(max(y))) < 1e-3". Raises LagError,
        Interrupted.
        """
        from lagrangia.study.sweep.plan import Design
        from lagrangia.study.sweep.run import run_many
        from lagrangia.study.sweep.values import names_of_runs, range_remarks

        request = Request(start, stop, tolerance, interval, None, solver, max_step, max_steps, parameters, initial, inputs)
        table = Path(runs) if isinstance(runs, str | os.PathLike) else runs
        design = Design(table, samples, seed, sampling, together, seconds_per_run, keep, until)
        ranges = range_remarks(by_name("parameters", parameters), by_name("start values", initial))
        warn_of_given(self, request, names_of_runs(table), others=ranges)
        return run_many(self, outputs, request, design, path, restart=restart, jobs=jobs, dask=dask, progress=progress)

    def measure(self, measures: str | Sequence[str], **asked: Any) -> dict[str, float]:
        """Numbers of one run that is `asked` for as of `simulate`, exact between its rows: measure("max(y, from=2), rms(y)"). NaN
        where there is none. Raises LagError, RunError, Interrupted. See `lag help sweep`."""
        from lagrangia.study.measuring import prepare_measures

        warn_of_given(self, request := Request(**asked))
        sweep = prepare_measures(self, measures, request)()
        return {measure.text: float(sweep[measure.text][0]) for measure in sweep.job.measures}

    def rainflow(self, quantity: str, **asked: Any) -> "np.ndarray":
        """Cycles of a quantity, "y" or "y, from=2", by ASTM E1049: (cycles, 3) of range, mean (SI units) and count, 1 or 1/2.
        Raises LagError, RunError, Interrupted."""
        from lagrangia.study.measuring import take_cycles

        if not isinstance(quantity, str):
            fail("L0702", f"rainflow takes a quantity, as \"y\" or \"y, from=2\", not {quantity!r}"[:200])
        warn_of_given(self, request := Request(**asked))
        return take_cycles(self, quantity, request)

    def rollout(self, q0: "ArrayLike | None" = None, v0: "ArrayLike | None" = None,
                p: "Mapping[str, ArrayLike] | None" = None, u: "ArrayLike | None" = None, *, times: "ArrayLike",
                tolerance: float | None = None, solver: str = "auto", jobs: int | None = None) -> "Rollout":
        """Many motions from arrays to arrays, on all cores: `.q` and `.v` (runs, times, n), ["x"] (runs, times), `.ok` (runs,).

        q0, v0: starts (runs, n) or (n,), in the order of `coordinate_names`; p: numbers or (runs,) by name; u: inputs (runs,
        times - 1, inputs), each held from one of the times (s) to the next. What is None is as declared. Runs that fail are NaN
        from there on, and told in `.failures`; of open energy accounts a RunWarning tells. Raises LagError, Interrupted.
        """
        from lagrangia.study.rollout import roll_out

        starts = [c.name for x, known in ((q0, self.scene.coordinates), (v0, self.scene.rates)) if x is not None for c in known]
        later = () if u is None else [known.name for known in self.scene.inputs]
        given = by_name("parameters", p)
        warn_of_given(self, Request(), [*given, *starts] if given else (), later)
        return roll_out(self, q0, v0, p, u, times, tolerance=tolerance, solver=solver, jobs=jobs)
