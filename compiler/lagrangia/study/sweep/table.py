"""The results of a sweep as a table: a row for each run; columns are what was varied, the measures, and why a run failed."""

import math
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.checked_values import misfit
from lagrangia.base.diagnostics import Diagnostic, fail, suggest
from lagrangia.base.html_table import headed, html_notes, html_table
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import Target, cells, quoted, require_parquet
from lagrangia.run.batch import GUARD_BITS, Ending
from lagrangia.run.guards import broken_in_general, guard_in_general
from lagrangia.run.remarks import warn_of_run, warn_of_text
from lagrangia.run.requirements import tell_requirement, tell_unmet
from lagrangia.run.runtime import Failure, Status
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import explain, start_in_general, tell_jumps
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.keeping import InMemory
from lagrangia.study.sweep.measures import unit_of
from lagrangia.study.sweep.pictures import draw_sweep
from lagrangia.study.sweep.plan import Job
from lagrangia.study.sweep.sensitivity import Index, sobol_indices
from lagrangia.study.sweep.statistics import SHARES, Statistics, statistics_of
from lagrangia.view.rows import columns

if TYPE_CHECKING:
    import numpy as np
    import pandas
    import xarray

_PORTION = 4096  # rows
_SHOWN = 20  # in a notebook


@dataclass(frozen=True)
class Sweep:
    """The result of many runs. `sweep["max(y)"]`, `sweep["k"]`: a measure, or what was varied, as an array (runs,) in SI units.

    A measure is NaN where the run failed, or has no such time. `failures` says which runs failed, and why; a run whose energy
    account is open counts as one, though it keeps its numbers. `interrupted`: some runs had no turn.
    """

    job: Job
    ledger: Ledger
    seconds: float
    interrupted: bool = False
    kept: InMemory | None = None  # whole trajectories

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.job.runs

    @property
    def names(self) -> list[str]:
        """What is varied, then what is measured."""
        return [*self.job.variations.names, *(measure.text for measure in self.job.measures)]

    def __getitem__(self, name: str) -> "np.ndarray":
        """Raises LagError L0701 for a name that the table does not have."""
        varied = self.job.variations.names
        if name in varied:
            return self._varied[:, varied.index(name)]
        texts = [measure.text for measure in self.job.measures]
        if name not in texts and f"final({name})" in texts:
            name = f"final({name})"
        if name not in texts:
            fail("L0701", f"the table has no column '{name}'", None, *filter(None, [suggest(name, self.names)]))
        column: np.ndarray = self.ledger.results[:, texts.index(name)]
        return column

    @cached_property
    def _varied(self) -> "np.ndarray":
        return self.job.variations.values(0, self.runs)

    @property
    def ok(self) -> "np.ndarray":
        """Which runs went well: bool (runs,)."""
        well: np.ndarray = self.ledger.outcomes["kind"] == Ending.DONE
        return well

    @property
    def failures(self) -> dict[int, str]:
        """Run -> why it failed."""
        return {int(k): self.message(int(k)) for k in (~self.ok).nonzero()[0]}

    def message(self, run: int) -> str:
        """Why a run failed; empty when it did not."""
        return explain_outcome(self.job, run, self.ledger.outcomes[run])

    def warn(self) -> None:
        """A RunWarning of runs whose account is open, as others that failed have no numbers; InputWarnings of odd inertias."""
        for text in self.odd_inertias():
            warn_of_text(self.job.scene, text)
        count = int((self.ledger.outcomes["kind"] == Ending.OPEN).sum())
        if count:
            warn_of_run(f"the energy account of {count} of {self.runs} runs misses by more than the tolerance explains: what the "
                        "table has of them is no motion of this scene; .failures tells which")

    def common_failures(self, most: int = 5) -> list[tuple[str, int]]:
        """What went wrong in general, and in how many runs."""
        kinds = Counter(self.ledger.outcomes[~self.ok][["kind", "status", "index", "rate"]].tolist())
        told: Counter[str] = Counter()
        for key, count in kinds.items():
            told[_in_general(self.job.scene, *key)] += count
        return told.most_common(most)

    def broken(self) -> list[Diagnostic]:
        """L0610: what assertions warned of, and in how many runs."""
        warned = self.ledger.outcomes["warned"]
        counts = [int((warned >> guard & 1).sum()) for guard in range(GUARD_BITS)] if warned.any() else []
        later = dict.fromkeys([GUARD_BITS - 1], ", or a later one")
        return [broken_in_general(self.job.scene, guard, f"{count} of {self.runs} runs: ", later.get(guard, ""))
                for guard, count in enumerate(counts) if count]

    def odd_inertias(self) -> list[str]:
        """L0746: those that what is varied makes, and in how many runs, as `lag` prints them."""
        scene = self.job.scene
        varied = [place for place in self.job.variations.places if place < len(scene.parameters)]
        if "inertias" not in scene.notes or not varied:
            return []
        from lagrangia.run.odd_inertias import odd_inertias_of_sets, reached_inertias

        job = self.job.among([place for place in varied if reached_inertias(scene, [place])])
        count, told = odd_inertias_of_sets(scene, job.parameter_sets())
        if job.runs == 1:
            return told
        runs = self.job.varied_parameters.runs
        return [f"{text}: the first of {count * (runs // job.runs)} of {runs} sets of parameters" for text in told]

    def warnings(self) -> list[str]:
        """What assertions warned of, as text."""
        return [warning.message for warning in self.broken()]

    def _rows(self) -> Iterator[list[tuple[Any, ...]]]:
        """Cells, None where there is nothing, in portions."""
        for first in range(0, self.runs, _PORTION):
            last = min(self.runs, first + _PORTION)
            values = self.job.variations.values(first, last).tolist()
            results = self.ledger.results[first:last].tolist()
            kinds = self.ledger.outcomes["kind"][first:last].tolist()
            yield [(first + k, *values[k], *((x if math.isfinite(x) else None) for x in results[k]),
                    None if kinds[k] == Ending.DONE else self.message(first + k)) for k in range(last - first)]

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Comma-separated, with a line of names and all 17 digits that matter; cells are empty where there is no number."""
        with Target(Path(path)) as target:
            for text in self.lines():
                target.put(text)

    def lines(self) -> Iterator[str]:
        """The table as lines of a CSV file."""
        yield ",".join(quoted(name) for name in ("run", *self.names, "failure")) + "\n"
        for rows in self._rows():
            yield "".join(f"{cells(numbers)},{quoted(failure or '')}\n" for *numbers, failure in rows)

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Columns of doubles with nulls where there is no number, units as metadata of the fields; pyarrow must be installed."""
        pyarrow, parquet = require_parquet()
        names = ("run", *self.names, "failure")
        units = ["", *self.units(), ""]
        types = [pyarrow.int64(), *(pyarrow.float64() for _ in self.names), pyarrow.string()]
        schema = pyarrow.schema([pyarrow.field(name, kind, metadata={"unit": unit} if unit else None)
                                 for name, kind, unit in zip(names, types, units, strict=True)])
        with Target(Path(path), binary=True) as target, parquet.ParquetWriter(target.stream, schema) as writer:
            for rows in self._rows():
                columns = zip(*rows, strict=True)
                arrays = [pyarrow.array(column, kind) for column, kind in zip(columns, types, strict=True)]
                writer.write_table(pyarrow.Table.from_arrays(arrays, schema=schema))

    def write(self, path: str | os.PathLike[str]) -> None:
        """To Parquet if the name ends in .parquet, else to CSV."""
        (self.to_parquet if is_parquet(path) else self.to_csv)(path)

    @property
    def trajectories(self) -> "np.ndarray":
        """Rows of all runs, (runs, times, columns) in the order of a Trajectory's names; NaN where a run did not come. Raises
        LagError L0712 where they were not kept."""
        if self.kept is None:
            fail("L0712", "whole trajectories were not kept", None, "simulate_many(keep=True) keeps them")
        return self.kept.rows

    def to_xarray(self) -> "xarray.Dataset":
        """The trajectories as variables over the dimensions run and time, what was varied as coordinates along run, with units;
        xarray must be installed."""
        import xarray

        shown, rows = columns(self.job.scene), self.trajectories
        varied = {name: ("run", self[name], {"units": unit}) for name, unit in zip(self.names, self.units(), strict=False)
                  if name in self.job.variations.names}
        told = {c.name: {"units": c.unit, "long_name": c.description} for c in shown}
        hidden = {"time", *self.job.scene.turned}
        found = {c.name: (("run", "time"), rows[:, :, k], told[c.name]) for k, c in enumerate(shown) if c.name not in hidden}
        times = ("time", list(self.job.sweep.row_times), told["time"])
        coordinates = {"run": range(self.runs), "time": times, **varied}
        return xarray.Dataset(found, coords=coordinates, attrs={"model": self.job.scene.name})

    def statistics(self, shares: Sequence[float] = SHARES) -> dict[str, Statistics]:
        """Of each measure over the runs that went well: mean, deviation and the quantiles of these shares, with standard
        errors, which hold for random runs. Raises LagError L0712."""
        return {m.text: statistics_of(self.ledger.results[self.ok, k], shares) for k, m in enumerate(self.job.measures)}

    def sensitivity(self) -> dict[str, dict[str, Index]]:
        """Of each measure the Sobol' indices of what is random, by name, where sampling="saltelli". Raises LagError L0712,
        L0901."""
        names = self.job.variations.names
        if self.job.sampling != "saltelli":
            fail("L0712", "Sobol' indices need runs of their own", None,
                 'sampling="saltelli", samples=1024, and random values alone')
        return {m.text: dict(zip(names, sobol_indices(self[m.text], len(names), self.job.seed), strict=True))
                for m in self.job.measures}

    def plot(self, path: str | os.PathLike[str] | None = None) -> Any:
        """Measures over what is varied, their histograms where that is random, parallel coordinates of three values or more: a
        matplotlib Figure. Raises LagError L0004."""
        return draw_sweep(self, path)

    def units(self) -> list[str]:
        """Of the columns in `names`."""
        scene = self.job.scene
        all_units = [item.unit for items in (scene.parameters, scene.coordinates, scene.rates, scene.inputs) for item in items]
        all_units.append("")  # of the number of a case of inputs
        return [*(all_units[place] for place in self.job.variations.places), *(unit_of(scene, m) for m in self.job.measures)]

    def to_pandas(self) -> "pandas.DataFrame":
        """A table with the run as its index, units by name in its attrs["units"]; pandas must be installed."""
        import pandas

        columns: dict[str, Any] = {name: self[name] for name in self.names}
        failures = self.failures
        columns["failure"] = [failures.get(k) for k in range(self.runs)]
        frame = pandas.DataFrame(columns, index=pandas.RangeIndex(self.runs, name="run"))
        frame.attrs["units"] = dict(zip(self.names, self.units(), strict=True))
        return frame

    def _repr_html_(self) -> str:
        """In a notebook: its first runs."""
        rows = next(self._rows(), [])[:_SHOWN]
        heads = ["run", *map(headed, self.names, self.units()), "failure"]
        notes = [f"{len(rows)} of {self.runs} runs"] * (len(rows) < self.runs)
        return html_table(heads, rows) + html_notes([*notes, self.experiment])

    @property
    def experiment(self) -> str:
        """From when to when, how accurate, and how closely the motions were looked at, in words."""
        settings, window = self.job.sweep.settings, self.job.sweep.window
        often = f", looked at every {window:g} s at least" if window > 0 else ""
        return f"{settings.t_start:g} to {settings.t_stop:g} s, tolerance {settings.tolerance:g}{often}"

    def __repr__(self) -> str:
        names = ", ".join([*self.names[:8], *["..."] * (len(self.names) > 8)])
        return f"<{self.runs} runs of {self.job.scene.name}, {self.experiment}: {names}>"


def is_parquet(path: str | os.PathLike[str]) -> bool:
    """Whether a file's name asks for Parquet."""
    return Path(path).suffix.lower() in (".parquet", ".pq")


# -------------------------------------------------------------------- why a run failed


def explain_outcome(job: Job, run: int, outcome: Any) -> str:
    """When, where and what to try; empty for a run that went well."""
    scene = job.scene
    kind, index, value, time = Ending(outcome["kind"]), int(outcome["index"]), float(outcome["value"]), float(outcome["time"])
    if kind is Ending.DONE:
        return ""
    if kind is Ending.NOT_RUN:
        return "not run"
    if kind is Ending.OVERTIME:
        return f"out of time at t = {time:.6g}"
    if kind is Ending.PARAMETER:
        own = index - len(scene.parameters)
        return _wrong_parameter(scene, index, value) if own < 0 else tell_unmet(scene, own, job.parameters_of(run))
    if kind is Ending.OPEN:
        jumps = f": {tell_jumps(places)}" if (places := scene.notes["jumping"]) else ""
        share = f"{value:.1e} of its size, more than the tolerance explains"
        return f"the energy account misses by {share}, from t = {time:.6g} on{jumps}"
    failure = Failure(Status(outcome["status"]), index, bool(outcome["rate"]), time, value)
    return explain(scene, failure, job.parameters_of(run) if failure.status is Status.NOT_FINITE else ())


def _wrong_parameter(scene: Scene, index: int, value: float) -> str:
    known = scene.parameters[index]
    return f"the parameter '{known.name}' {misfit(value, f' {known.unit}' if known.unit else '', known.minimum, known.maximum)}"


def _in_general(scene: Scene, kind: int, status: int, index: int, rate: int) -> str:
    ending = Ending(kind)
    if ending is Ending.PARAMETER:
        if index >= len(scene.parameters):
            return tell_requirement(scene.notes["requirements"][index - len(scene.parameters)])
        return f"the parameter '{scene.parameters[index].name}' has no value within its limits"
    if ending is Ending.OPEN:
        places = scene.notes["jumping"]
        why = tell_jumps(places) if places else "a smaller tolerance or another solver is needed"
        return f"the energy account is open: {why}"
    if ending is not Ending.FAILED:
        return "not run" if ending is Ending.NOT_RUN else "out of time"
    if status == Status.INITIAL_FAILED:
        return start_in_general(scene, index)
    what = {Status.NOT_FINITE: "the accelerations are not finite", Status.STEP_TOO_SMALL: "the motion cannot be continued",
            Status.TOO_MANY_STEPS: "the limit of steps is reached", Status.EVENTS_GO_ON: "events do not end",
            Status.NO_IMPULSE: "a contact turns nothing back" if rate else "friction jams",
            Status.CONSTRAINTS_OPEN: "the constraints do not close",
            Status.NO_PROGRESS: "there is no progress", Status.TABLE_ENDED: "a table ends",
            Status.INPUT_JUMPS: "an input that moves places jumps",
            Status.TURNED_OFF: "two ways of moving meet",
            Status.BAD_INTERVAL: "an interval between instants is not positive", Status.BAD_DELAY: "a delay is not positive"}
    if status == Status.ASSERTED:
        return guard_in_general(scene, index)
    column = (scene.rates if rate else scene.coordinates)[index].name if 0 <= index < scene.n else ""
    where = f" ({column})" if column else ""
    return what.get(Status(status), Status(status).name.lower().replace("_", " ")) + where
