"""Rows of results -> Trajectory: NumPy columns by name, tables and pictures."""

import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from lagrangia.base.checked_values import a_path, by_name
from lagrangia.base.checked_values import names as asked_names
from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import require_kind
from lagrangia.run.moved_starts import moved_starts
from lagrangia.run.scene import ENERGY_NAMES, Column, Scene
from lagrangia.run.simulate import Progress, loss, short_steps, shortcomings
from lagrangia.view.curves import draw_panels
from lagrangia.view.result_writers import RESULTS, TextRows, Writer, open_writer
from lagrangia.view.rows import ENERGIES, columns, shown
from lagrangia.view.sight import Shown, Sight, known_column

if TYPE_CHECKING:
    import numpy as np
    import pandas
    import xarray

    from lagrangia.view.plots import Series



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
    observe: Callable[[str, "np.ndarray", float], "np.ndarray"] | None = None
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
        """NaN for the parts of an attitude, whose quaternion tells. Raises LagError L0701 for a name the scene does not know."""
        import numpy as np

        if not isinstance(name, str):
            fail("L0701", f"a quantity is asked for by its name, not by {name!r}"[:200], None, "run.names lists some")
        if name in self.scene.turned:  # against attitudes that move along as steps were taken
            return np.full(len(self.rows), np.nan)
        if name in self.names:
            return self.rows[:, self.names.index(name)]
        slot = self.scene.slot(name)
        if slot is not None:
            return self.rows[:, 1 + slot]
        if name in ENERGY_NAMES:
            return self.rows[:, ENERGY_NAMES.index(name) - ENERGIES]
        if self.observe is None:
            fail("L0701", f"the results have no column '{name}'", None, *filter(None, [suggest(name, self.names)]))
        return self.observe(name, self.rows, self.progress.experiment.start)

    @property
    def energy(self) -> EnergyAccount:
        """The energies of each row, and what is left over in their account."""
        T, V, H, dissipated, work = self.rows[:, -ENERGIES:].T
        moved = T + V - H  # what supports that move with time have put in beside the balance of H
        kept = H + dissipated - work
        return EnergyAccount(T, V, dissipated, work + moved - moved[:1], kept - kept[:1])

    def to_pandas(self) -> "pandas.DataFrame":
        """A table with time as its index, units by name in its attrs["units"]; pandas must be installed."""
        import pandas

        told = columns(shown(self.scene)[0])
        frame = pandas.DataFrame({c.name: self[c.name] for c in told[1:]}, index=pandas.Index(self.time, name="time"))
        frame.attrs["units"] = {column.name: column.unit for column in told}
        return frame

    def to_xarray(self) -> "xarray.Dataset":
        """Variables over the dimension time, with units and descriptions as attributes; xarray must be installed."""
        import xarray

        told = {c.name: {"units": c.unit, "long_name": c.description} for c in columns(shown(self.scene)[0])}
        return xarray.Dataset({name: ("time", self[name], told[name]) for name in told if name != "time"},
                              coords={"time": ("time", self.time, told["time"])}, attrs={"model": self.scene.name})

    @property
    def ended(self) -> str:
        """When terminate(...) has ended the run, and what it says; empty for a run that went on to its stop time."""
        return self.progress.ended

    @property
    def warnings(self) -> list[str]:
        """What assertions warn of, what kept the run from its tolerance, and why it cannot be right; empty when nothing did."""
        broken = [warning.message for warning in self.progress.warned]
        return [*broken, *shortcomings(self.progress), *filter(None, [loss(self.progress)])]

    @property
    def notes(self) -> list[str]:
        """What is worth knowing of a run that went well: starts that do not hold, and what limits its steps, where it took very
        many."""
        values = self.show.values if self.show is not None else None
        moved = moved_starts(self.scene, self.progress, values, self.rows[0].tolist()) if values and len(self.rows) else ()
        return [*moved, *filter(None, [short_steps(self.scene, self.progress)])]

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Comma-separated columns with a line of names; all 17 digits that matter. Where a quantity has no finite value, its
        cell is empty."""
        self._put(TextRows(a_path(path), shown(self.scene)[0]))

    def write(self, path: str | os.PathLike[str]) -> None:
        """The rows in a file of the kind its name says: .csv, .jsonl, .parquet (pyarrow), .npz, .mat (as Modelica tools read it).
        Raises LagError L0004, L0715."""
        path = a_path(path)
        require_kind(path, *RESULTS)
        self._put(open_writer(path, shown(self.scene)[0], self.progress))

    def _put(self, writer: Writer) -> None:
        with writer:
            writer.write(shown(self.scene)[1](self.rows.ravel().tolist()))

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

        sight = self._sight
        cut = (section, 0.0) if isinstance(section, str) else section
        wanted = choose(self.scene, sight, asked_names("quantities", names), asked_names("spectrum", spectrum), cut)
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

    def columns_of(self, name: str) -> tuple[Column, ...]:
        """The elements of a quantity with their units, itself for a scalar. Raises LagError L0701 for an unknown one."""
        return self._sight.columns_of(name)

    @property
    def _sight(self) -> Sight:
        return self.sight or Sight(self._known_columns, self._no_small_motion)

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
        return self.show.animate(self, path, traces=asked_names("traces", traces),
                                 quantities=asked_names("quantities", quantities),
                                 names=None if names is None else by_name("symbols", names), beside=others)

    def _repr_html_(self) -> str | None:
        """In a notebook: its animation."""
        if self.show is None or not len(self.rows):
            return None
        import html

        page = html.escape(self.animate(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:560px;border:0" title="{html.escape(repr(self))}"></iframe>'


def _numbered(runs: Iterable[Any]) -> dict[str, Any]:
    """With labels: the run itself is the first."""
    return {f"run {k}": run for k, run in enumerate(runs, 2)}
