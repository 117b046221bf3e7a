"""Any FMU -> its motion at given times: what `lag simulate X.fmu` computes."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, pairwise
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.fmu.archive import DESCRIPTION, Archive, open_archive
from lagrangia.fmu.build import PLATFORMS, host_platform
from lagrangia.fmu.description import Description, read_description
from lagrangia.fmu.importer import is_recorded
from lagrangia.fmu.process import SPOKEN, Inputs, Job, Outcome, require_fmpy, run_job
from lagrangia.fmu.settable import check_values, refuse_unknown, shape_of, whole_values
from lagrangia.run.request import Default, Request, instead_of
from lagrangia.run.scene import Column

_USUAL_TOLERANCE = 1e-6
_MOST_ROWS = 10_000_000
_MOST_COLUMNS = 100  # of an FMU without states and outputs
_MOST_NUMBERS = 1_000_000  # a row
_LONGEST_TEXT = 500  # characters of what an FMU says of itself


@dataclass(frozen=True)
class Opened:
    """An FMU whose description is read."""

    archive: Archive
    description: Description

    @property
    def name(self) -> str:
        """The model's, or the file's where it has none; the begin of a very long one."""
        return (self.description.root.get("modelName") or self.archive.path.stem)[:_LONGEST_TEXT]

    @property
    def text(self) -> str:
        """What it says that it is."""
        return (self.description.root.get("description") or "")[:_LONGEST_TEXT]

    @property
    def offers(self) -> list[str]:
        """Of "me" and "cs"."""
        return [kind for kind in SPOKEN if kind in self.description.interfaces]

    @property
    def platforms(self) -> list[str]:
        """Folders of binaries."""
        files = [name.split("/") for name in self.archive.names if name.startswith("binaries/")]
        return sorted({parts[1] for parts in files if len(parts) > 2})

    @property
    def has_sources(self) -> bool:
        """Whether C sources are in it."""
        return any(name.startswith("sources/") for name in self.archive.names)

    def column(self, name: str) -> Column:
        """Of a variable or of an element of one."""
        element = self.description.element(name)
        found = element[0] if element is not None else self.description.by_name.get(name)
        if found is None:
            return Column(name, "", "", "")
        return Column(name, found.get("unit") or "", found.get("displayUnit") or "", "")

    def number(self, name: str) -> float | None:
        """Of the default experiment, when it is finite."""
        experiment = self.description.root.first("DefaultExperiment")
        try:
            value = float((experiment.get(name) if experiment is not None else None) or "nan")
        except ValueError:
            return None
        return value if math.isfinite(value) else None


@dataclass(frozen=True)
class FmuRun:
    """`columns` after the time."""

    opened: Opened
    job: Job
    outcome: Outcome
    columns: tuple[Column, ...]

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self.outcome.rows) // self.outcome.width

    def lines(self) -> Iterator[list[float]]:
        """Row by row: the time and the columns."""
        width = self.outcome.width
        for k in range(0, len(self.outcome.rows), width):
            yield self.outcome.rows[k : k + width].tolist()

    def __getitem__(self, name: str) -> Any:
        """A NumPy array. Raises LagError L0701 for a column that is not there."""
        import numpy as np

        names = ["time", *self.outcome.columns]
        if name not in names:
            fail("L0701", f"the results have no column '{name}'", None, *filter(None, [suggest(name, names)]))
        return np.frombuffer(self.outcome.rows).reshape(-1, len(names))[:, names.index(name)]


def open_fmu(path: Path) -> Opened:
    """Raises LagError for what is no FMU of version 2.0 or 3.0."""
    archive = open_archive(path)
    return Opened(archive, read_description(archive.read_xml(DESCRIPTION)))


@contextmanager
def unpacked(opened: Opened) -> Iterator[str]:
    """Raises LagError L0731."""
    with TemporaryDirectory(prefix="lagrangia-fmu-", ignore_cleanup_errors=True) as folder:
        opened.archive.extract(Path(folder))
        yield folder


def simulate_fmu(opened: Opened, request: Request, kind: str | None = None) -> FmuRun:
    """`kind` is "me" or "cs", by itself Co-Simulation where there is one; values are in the FMU's own units.

    Raises LagError for what the FMU does not have or cannot do. A run that ends early is told in the outcome.
    """
    require_fmpy()
    kind = choose_kind(opened, kind)
    values = {**(request.parameters or {}), **(request.initial or {})}
    require_binary(opened)
    times, stop, tolerance = _plan(opened, request)
    if kind == "cs":
        _check_steps(opened, times)
    check_values(opened.description, values)
    values = whole_values(opened.description, values)
    names = _columns(opened, request.outputs)
    with unpacked(opened) as folder:
        job = Job(folder, kind, times, stop, tolerance, names, values, request.inputs or Inputs())
        outcome = run_job(job)
    return FmuRun(opened, job, outcome, tuple(opened.column(name) for name in outcome.columns or names))


def choose_kind(opened: Opened, wanted: str | None) -> str:
    """Co-Simulation where there is one. Raises LagError L0706."""
    offers = opened.offers
    if wanted is not None and wanted not in SPOKEN:
        fail("L0706", f"there is no kind of FMU '{wanted}'", None, f"there are {', '.join(SPOKEN)}")
    if not offers:
        fail("L0706", f"{opened.archive.path} offers neither Model Exchange nor Co-Simulation", None,
             "not supported yet: Scheduled Execution")
    if wanted is not None and wanted not in offers:
        fail("L0706", f"{opened.archive.path} offers no {SPOKEN[wanted]}", None,
             f"it offers {SPOKEN[offers[0]]}: --kind {offers[0]}")
    return wanted or ("cs" if "cs" in offers else "me")


def has_binary(opened: Opened) -> bool:
    """Whether it has one for this machine."""
    host = host_platform()
    if host is None:
        return False
    folder = PLATFORMS[host].fmi2 if opened.description.version == "2" else PLATFORMS[host].fmi3
    return folder in opened.platforms


def require_binary(opened: Opened) -> None:
    """Raises LagError L0735 and L0737."""
    if (interface := opened.description.bad_identifier) is not None:
        fail("L0735", f"'{interface.get('modelIdentifier') or ''}' is no C identifier"[:200], interface.span("modelIdentifier"),
             "it names the library to be loaded, which lies in the FMU")
    if not has_binary(opened):
        has = f"it has binaries for {', '.join(opened.platforms)}" if opened.platforms else "it has no binaries at all"
        machine = host_platform() or "which FMI does not know"
        fail("L0737", f"{opened.archive.path} has no binary for this machine, {machine}", None, has,
             "its sources can be compiled by `fmpy compile`" if opened.has_sources else "ask who made it for one")


def _plan(opened: Opened, request: Request) -> tuple[list[float], float, float]:
    """Times of the rows, the stop time, the tolerance. Raises LagError L0702."""
    own = {name: opened.number(name) for name in ("startTime", "stopTime", "tolerance", "stepSize")}
    start = own["startTime"] or 0.0
    stop = own["stopTime"] if own["stopTime"] is not None else 1.0 + (start if request.start is None else request.start)
    default = Default(start, stop, _USUAL_TOLERANCE if own["tolerance"] is None else own["tolerance"], own["stepSize"] or None)
    experiment = instead_of(default, request)
    if experiment.count() > _MOST_ROWS:
        fail("L0702", f"{experiment.count()} rows are more than {_MOST_ROWS}", None, "choose a longer interval")
    times = list(chain.from_iterable(experiment.times()))
    return times if times[0] == experiment.start else [experiment.start, *times], experiment.stop, experiment.tolerance


def _check_steps(opened: Opened, times: Sequence[float]) -> None:
    """FMUs that take steps of one length alone. Raises LagError L0702."""
    interface = opened.description.interfaces["cs"]
    if interface.get("canHandleVariableCommunicationStepSize") in ("true", "1"):
        return
    steps = [b - a for a, b in pairwise(times)]
    if steps and max(steps) - min(steps) > 1e-6 * max(steps):
        fail("L0702", "the FMU takes communication steps of one length alone", None,
             f"these are of {min(steps):g} to {max(steps):g} s; choose an interval that divides the time")


def _is_wanted(description: Description, name: str, names: Sequence[str]) -> bool:
    """Not the time, which stands in each row, nor an element of an array that is there as a whole."""
    element = description.element(name)
    return element[0].name not in names if element is not None else description.by_name[name].causality != "independent"


def _columns(opened: Opened, outputs: Sequence[str]) -> list[str]:
    """States, outputs, and what is asked for. Raises LagError L0701."""
    description = opened.description
    for name in outputs:
        element = description.element(name)
        found = element[0] if element is not None else description.by_name.get(name)
        if found is None:
            refuse_unknown(description, name, description.by_name)
        if not is_recorded(found.kind):
            fail("L0701", f"'{name}' is of the type {found.kind}, which is no number to report")
    states = [state.name for state, _ in description.states()]
    declared = [q.name for q in description.quantities if q.causality == "output" and is_recorded(q.kind)]
    names = [*states, *declared, *outputs]
    if not names:
        names = [q.name for q in description.quantities if q.variability in ("continuous", "discrete") and is_recorded(q.kind)
                 and q.causality == "local"][:_MOST_COLUMNS]
    wanted = [name for name in dict.fromkeys(names) if _is_wanted(description, name, names)]
    arrays = [q for name in wanted if (q := description.by_name.get(name)) is not None and q.has_dimensions]
    if sum(prod(shape_of(description, q)) for q in arrays) > _MOST_NUMBERS:
        fail("L0702", f"a row would have more than {_MOST_NUMBERS} numbers", None, "choose with --outputs")
    return wanted
