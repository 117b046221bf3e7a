"""Whole trajectories of a sweep's runs, where they are asked for: in memory, or as a folder of Parquet files."""

import contextlib
import re
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import Target, require_parquet
from lagrangia.run.batch import Ending
from lagrangia.run.scene import Scene
from lagrangia.study.sweep.journal import Ledger
from lagrangia.view.result_writers import parquet_fields
from lagrangia.view.rows import ENERGIES, columns

if TYPE_CHECKING:
    import numpy as np

_MOST = 1 << 31  # bytes that trajectories may take in memory
_PART = re.compile(r"part-(\d+)-(\d+)\.parquet")


class Keeper(Protocol):
    """Takes rows of runs, (runs, times, width), in any order of the runs; NaN where a run did not come."""

    def keep(self, first: int, rows: "np.ndarray") -> None:
        """Those of the runs from `first` on."""


def _hidden(scene: Scene) -> list[int]:
    """Columns of attitudes, whose numbers say nothing without what they are counted from: NaN."""
    return [k for k, column in enumerate(columns(scene)) if column.name in scene.turned]


class InMemory:
    """All rows, which runs write themselves where they are computed here."""

    def __init__(self, scene: Scene, runs: int, times: int, are_all_new: bool = False) -> None:
        """`are_all_new`: every run comes here, or nobody asks for rows. Raises LagError L0712 for what would not fit."""
        import numpy as np

        self.width = len(columns(scene))
        whole = self.width + ENERGIES
        if 8 * runs * times * whole > _MOST:
            fail("L0712", f"{runs} trajectories of {times} rows take {8e-9 * runs * times * whole:.3g} GB of memory", None,
                 "a longer interval, or fewer runs; lag sweep --keep writes them to files")
        self.all = np.empty((runs, times, whole)) if are_all_new else np.full((runs, times, whole), np.nan)
        self.hidden = _hidden(scene)

    @property
    def rows(self) -> "np.ndarray":
        """All of them, (runs, times, columns)."""
        self.all[:, :, self.hidden] = float("nan")
        return self.all[:, :, : self.width]

    def keep(self, first: int, rows: "np.ndarray") -> None:
        """Those of the runs from `first` on, unless they are in their place."""
        import numpy as np

        place = self.all[first : first + len(rows)]
        if not np.shares_memory(place, rows):
            place[:] = rows


class Dataset:
    """A folder whose Parquet files have a column `run` before those of a trajectory; pyarrow must be installed."""

    def __init__(self, folder: Path, scene: Scene, ledger: Ledger) -> None:
        """What an interrupted sweep has left of runs that are not in the ledger is removed. Raises LagError L0004, L0715."""
        self.folder = folder
        self.pyarrow, self.parquet = require_parquet()
        run = self.pyarrow.field("run", self.pyarrow.int64())
        self.hidden = _hidden(scene)
        self.schema = self.pyarrow.schema([run, *parquet_fields(self.pyarrow, scene)])
        try:
            folder.mkdir(exist_ok=True)
            others = [path.name for path in folder.iterdir() if _PART.fullmatch(path.name) is None]
        except OSError as error:
            fail("L0004", f"'{folder}' cannot be written: {error.strerror}")
        if others:
            fail("L0004", f"'{folder}' holds something else than trajectories: {others[0]}", None,
                 "move it, or choose another -o")
        for path in folder.iterdir():
            found = _PART.fullmatch(path.name)
            first, count = (int(found[1]), int(found[2])) if found else (0, 0)
            if not (ledger.outcomes["kind"][first : first + count] != Ending.NOT_RUN).all():
                with contextlib.suppress(OSError):
                    path.unlink()

    def keep(self, first: int, rows: "np.ndarray") -> None:
        """A file for these runs, in which rows that a run did not come to are left out."""
        import numpy as np

        count, width = len(rows), len(self.schema) - 1
        flat = rows[:, :, :width].reshape(-1, width).copy()
        flat[:, self.hidden] = np.nan
        there = np.isfinite(flat[:, 0])
        runs = np.repeat(np.arange(first, first + count), rows.shape[1])[there]
        arrays = [self.pyarrow.array(runs), *map(self.pyarrow.array, flat[there].T)]
        table = self.pyarrow.Table.from_arrays(arrays, schema=self.schema)
        with Target(self.folder / f"part-{first}-{count}.parquet", binary=True) as target:
            self.parquet.write_table(table, target.stream)

