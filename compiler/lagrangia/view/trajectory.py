"""Rows of results -> Trajectory: NumPy columns by name, tables and pictures."""

import html
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import Target, cells, quoted
from lagrangia.run.request import Values
from lagrangia.run.scene import Column, Scene
from lagrangia.run.simulate import Progress, loss, shortcomings
from lagrangia.view.curves import draw_panels
from lagrangia.view.sight import Shown, Sight, known_column

if TYPE_CHECKING:
    import numpy as np
    import pandas

    from lagrangia.view.plots import Series

_ENERGIES = ("kinetic", "potential", "total", "dissipated", "work")
ENERGIES = 5  # T, V, H, dissipated, work: the last of each row


@dataclass(frozen=True)
class EnergyAccount:
    """Energies over time in J: arrays of the length of `time`.

    `work` is what loads, prescribed motions and moving supports have put in, `dissipated` what dampers have taken out;
    residual = total + dissipated - work, less its first value: 0 but for errors.
    """

    kinetic: "np.ndarray"
    potential: "np.ndarray"
    dissipated: "np.ndarray"
    work: "np.ndarray"
    residual: "np.ndarray"

    @property
    def total(self) -> "np.ndarray":
        """T + V, J."""
        total: np.ndarray = self.kinetic + self.potential
        return total


@dataclass(frozen=True)
class Trajectory:
    """The result of a run. `run["hinge.phi"]`: a coordinate, its rate `der(hinge.phi)`, an output, or any other quantity of the
    scene, which is then computed from the states. Arrays are float64 of shape (rows,), in SI units."""

    scene: Scene
    rows: "np.ndarray"  # (rows, width)
    progress: Progress
    observe: Callable[[str, "np.ndarray"], "np.ndarray"] | None = None
    show: Shown | None = None  # as an animation
    sight: Sight | None = None  # what pictures ask of its model

    def __repr__(self) -> str:
        names = self.names[1:]
        span = f", t = {self.time[0]:g} to {self.time[-1]:g} s" if len(self.rows) else ""
        return f"<{self.scene.name}: {len(self.rows)} rows{span}: {', '.join(names[:6])}{', ...' if len(names) > 6 else ''}>"

    @property
    def time(self) -> "np.ndarray":
        """(rows,), s."""
        return self.rows[:, 0]

    @property
    def columns(self) -> tuple[Column, ...]:
        """Name, unit and meaning of each column."""
        return columns(self.scene)

    @property
    def statistics(self) -> Any:
        """What the run has done: steps, evaluations, events, the method at the end."""
        return self.progress.statistics

    @property
    def events(self) -> "np.ndarray":
        """Times of impacts, switches and corners of inputs, s, rising: of the first 4096; `statistics.events` counts them all."""
        import numpy as np

        return np.unique(np.array(self.progress.events, dtype=float))

    @property
    def engine(self) -> str:
        """What ran: native, tape, "tape, then native", or an integrator of CasADi (casadi:cvodes)."""
        return self.progress.engine

    @property
    def names(self) -> list[str]:
        """Of the columns, the first is the time."""
        return [column.name for column in self.columns]

    def __getitem__(self, name: str) -> "np.ndarray":
        """Raises LagError L0701 for a name the scene does not know."""
        if not isinstance(name, str):
            fail("L0701", f"a quantity is asked for by its name, not by {name!r}"[:200], None, "run.names lists some")
        if name in self.names:
            return self.rows[:, self.names.index(name)]
        slot = self.scene.slot(name)
        if slot is not None:
            return self.rows[:, 1 + slot]
        if self.observe is None:
            fail("L0701", f"the results have no column '{name}'", None, *filter(None, [suggest(name, self.names)]))
        return self.observe(name, self.rows)

    @property
    def energy(self) -> EnergyAccount:
        """The energies of each row, and what is left over in their account."""
        T, V, H, dissipated, work = self.rows[:, -ENERGIES:].T
        moved = T + V - H  # what supports that move with time have put in beside the balance of H
        kept = H + dissipated - work
        return EnergyAccount(T, V, dissipated, work + moved - moved[:1], kept - kept[:1])

    def to_pandas(self) -> "pandas.DataFrame":
        """A table with time as its index; pandas must be installed."""
        import pandas

        names = self.names
        return pandas.DataFrame(self.rows[:, 1 : len(names)], columns=names[1:], index=pandas.Index(self.time, name="time"))

    @property
    def warnings(self) -> list[str]:
        """What kept the run from its tolerance, in words, and why it cannot be right; empty when nothing did."""
        return [*shortcomings(self.progress), *filter(None, [loss(self.progress)])]

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Comma-separated columns with a line of names; all 17 digits that matter. Where a quantity has no finite value, its
        cell is empty."""
        with CsvWriter(Path(path), self.scene) as writer:
            writer.write(self.rows.ravel().tolist())

    def plot(self, *names: str, path: str | os.PathLike[str] | None = None, spectrum: Sequence[str] = (),
             section: str | tuple[str, float] | None = None,
             overlay: "Mapping[str, Trajectory] | Sequence[Trajectory | str | os.PathLike[str]]" = (),
             linear: bool = False) -> Any:
        """A picture of quantities over time (all coordinates by default), or of one against another, "theta:theta'"; saved when a
        path is given. Returns the figure.

        `spectrum` names quantities whose amplitudes are shown over frequency; `section` is one, or a pair of one with a value in
        SI units, through which it rises in the states that are shown; `overlay` are other runs (with labels, in a mapping) and
        CSV files; `linear` shows small motion beside. Raises LagError, RunError.
        """
        from lagrangia.view.run_pictures import choose, picture_of, table_series

        sight = self.sight or Sight(self._known_columns, self._no_small_motion)
        cut = (section, 0.0) if isinstance(section, str) else section
        wanted = choose(self.scene, sight, names, (spectrum,) if isinstance(spectrum, str) else spectrum, cut)
        pairs = overlay.items() if isinstance(overlay, Mapping) else _numbered(overlay).items()
        beside = [x.series(label) if isinstance(x, Trajectory) else table_series(Path(x), sight, wanted)
                  for label, x in pairs]
        picture = picture_of(self.series(), self.rows, sight, wanted, beside, linear)
        for note in picture.notes:
            warnings.warn(note, stacklevel=2)
        return draw_panels(self.scene.description or self.scene.name, picture.panels, path)

    def series(self, label: str = "this run") -> "Series":
        """All quantities of its scene, for a picture of several runs."""
        from lagrangia.view.plots import Series

        events = self.events
        inside = events[(events >= self.time[0]) & (events <= self.time[-1])] if len(self.rows) else events
        return Series(label, self.time, cache(self.__getitem__), events=inside)

    def _known_columns(self, name: str) -> tuple[Column, ...]:
        return (known_column(self.scene, name) or Column(name, "", "", ""),)

    def _no_small_motion(self, rows: "np.ndarray", names: Sequence[str]) -> NoReturn:
        fail("L0918", "not supported yet: the small motion of a run without its model", None, "plot what simulate returned")

    def animate(self, path: str | os.PathLike[str] | None = None, *, traces: Sequence[str] = (), quantities: Sequence[str] = (),
                names: Mapping[str, str] | None = None, beside: "Mapping[str, Trajectory] | Sequence[Trajectory]" = ()) -> str:
        """The motion as a page of its own: the text of the HTML; a path (.html, .svg, .gif, .webp, .mp4) is written as well.

        `traces` are frames whose ways are drawn, `quantities` the curves beside the picture (the coordinates and outputs by
        default), `names` symbols of your own, `beside` other runs with the same times (with labels, in a mapping).
        Raises LagError.
        """
        if self.show is None:
            fail("L0918", "not supported yet: the animation of a run without its model", None, "animate what simulate returned")
        others = beside if isinstance(beside, Mapping) else _numbered(beside)
        return self.show.animate(self, path, traces=traces, quantities=quantities, names=names, beside=others)

    def _repr_html_(self) -> str | None:
        """In a notebook: its animation."""
        if self.show is None or not len(self.rows):
            return None
        page = html.escape(self.animate(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:560px;border:0" title="{html.escape(repr(self))}"></iframe>'


def _numbered(runs: Iterable[Any]) -> dict[str, Any]:
    """With labels: the run itself is the first."""
    return {f"run {k}": run for k, run in enumerate(runs, 2)}


def columns(scene: Scene) -> tuple[Column, ...]:
    """Names and units of the first columns of a row; five energies follow them."""
    return (Column("time", "s", "", ""), *scene.coordinates, *scene.rates, *scene.outputs)


class CsvWriter(Target):
    """Writes rows as they come. Raises LagError L0004 when the place cannot be written."""

    def __init__(self, path: Path, scene: Scene) -> None:
        self.shown = len(columns(scene))
        super().__init__(path)
        self.empty = EmptyCells(scene)
        self.put(csv_names(scene) + "\n")

    def write(self, values: Sequence[float]) -> None:
        """Rows, as one flat sequence of numbers."""
        self.put("\n".join(csv_lines(values, self.shown, self.empty)) + "\n")


class EmptyCells:
    """Which columns had no finite value, in how many rows, and when first: the square root of what became negative, 1/0."""

    def __init__(self, scene: Scene) -> None:
        self.names = [column.name for column in columns(scene)]
        self.rows: dict[str, int] = {}
        self.first: dict[str, float] = {}

    def note(self, column: int, t: float) -> None:
        """A cell without a finite value."""
        name = self.names[column]
        self.rows[name] = self.rows.get(name, 0) + 1
        self.first.setdefault(name, t)

    def describe(self) -> list[str]:
        """A sentence for each column that has some."""
        return [f"'{name}' has no finite value in {count} row{'s' if count != 1 else ''}, first at t = {self.first[name]:.6g}: "
                "these cells are empty" for name, count in self.rows.items()]


def csv_names(scene: Scene) -> str:
    """The line of names; those with a comma, as x[1,2] has, between quotes."""
    return ",".join(quoted(column.name) for column in columns(scene))


def csv_lines(values: Sequence[float], shown: int, empty: EmptyCells) -> list[str]:
    """Rows of results, flat, as lines of their first `shown` columns; cells without a finite value are empty, and noted."""
    starts = range(0, len(values), shown + ENERGIES)
    lines = [cells(values[k : k + shown]) for k in starts]
    for k, line in zip(starts, lines, strict=True):
        if ",," in line or line.endswith(","):
            for column in (column for column, cell in enumerate(line.split(",")) if not cell):
                empty.note(column, values[k])
    return lines


def moments(scene: Scene, parameters: "np.ndarray", values: Values, rows: "np.ndarray") -> "tuple[np.ndarray, ...]":
    """t, q, v and u, (., T) each, and p, (n_p, 1), of rows of results."""
    import numpy as np

    n, count = scene.n, len(values.input_values) // len(values.input_times)
    t, q, v = rows[:, :1].T, rows[:, 1 : 1 + n].T, rows[:, 1 + n : 1 + 2 * n].T
    table = np.asarray(values.input_values).reshape(len(values.input_times), count)
    u = np.array([np.interp(t[0], values.input_times, table[:, k]) for k in range(len(scene.inputs))]).reshape(-1, t.size)
    return t, q, v, u, parameters.reshape(-1, 1)


def collect(scene: Scene, portions: Iterable[Sequence[float]]) -> "np.ndarray":
    """All rows as one array of shape (rows, width)."""
    import numpy as np

    width = len(columns(scene)) + len(_ENERGIES)
    parts = [np.asarray(portion, dtype=np.float64).reshape(-1, width) for portion in portions]
    return np.concatenate(parts) if parts else np.empty((0, width))
