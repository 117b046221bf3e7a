"""Rows of results -> a file of the kind that its name says: CSV, JSON lines, Parquet, NumPy, Modelica's MATLAB file.

Each writer takes rows as they come, one flat sequence of numbers at a time, and is used in a `with` statement. The file has its
name when all is well (base/result_files.py), unless it is streamed: then the rows are there as soon as they are written.
"""

import os
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import Target, quoted, require_parquet, written
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import Progress
from lagrangia.view.rows import ENERGIES, collect, columns

if TYPE_CHECKING:
    import numpy as np

STREAMS = (".csv", ".txt", ".dat", ".jsonl")
RESULTS = (*STREAMS, ".parquet", ".pq", ".npz", ".mat")
_GROUP = 65_536  # rows of a row group


class Writer(Protocol):
    """Takes rows, and knows which cells had no finite value."""

    empty: "EmptyCells"

    def __enter__(self) -> Any: ...

    def __exit__(self, *exception: Any) -> None: ...

    def write(self, values: Sequence[float]) -> None:
        """Rows, as one flat sequence of numbers."""


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


def open_writer(path: str | os.PathLike[str], scene: Scene, progress: Progress, stream: bool = False) -> Writer:
    """For a name that ends in one of RESULTS, or says nothing: CSV. Raises LagError L0004, L0715."""
    ending = Path(path).suffix.lower()
    if stream and ending in RESULTS and ending not in STREAMS:
        fail("L0004", f"'{os.fspath(path)}' is written as a whole: it cannot be streamed", None,
             f"streams are {', '.join(STREAMS)}")
    if ending in (".parquet", ".pq"):
        return ParquetRows(Path(path), scene)
    if ending in (".npz", ".mat"):
        return WholeRows(Path(path), scene, progress)
    return TextRows(Path(path), scene, stream)


# -------------------------------------------------------------------- text


class TextRows(Target):
    """CSV, with all 17 digits that matter and empty cells where there is no finite value; or an object of JSON a line."""

    def __init__(self, path: Path, scene: Scene, stream: bool = False) -> None:
        self.names = [column.name for column in columns(scene)]
        self.is_json, self.streams = path.suffix.lower() == ".jsonl", stream
        super().__init__(path, binary=True, direct=stream)
        self.empty = EmptyCells(scene)
        if not self.is_json:
            self.put((csv_names(scene) + "\n").encode())

    def write(self, values: Sequence[float]) -> None:
        """Rows, as one flat sequence of numbers."""
        lines = (json_lines(values, self.names, self.empty) if self.is_json
                 else csv_lines(values, len(self.names), self.empty))
        self.put_all(part for line in lines for part in (line, b"\n"))
        if self.streams:
            self.stream.flush()


def csv_names(scene: Scene) -> str:
    """The line of names; those with a comma, as x[1,2] has, between quotes."""
    return ",".join(quoted(column.name) for column in columns(scene))


def csv_lines(values: Sequence[float], shown: int, empty: EmptyCells) -> Iterator[bytes]:
    """Rows of results, flat, as lines of their first `shown` columns; cells without a finite value are empty, and noted."""
    for k in range(0, len(values), shown + ENERGIES):
        line = written(values[k : k + shown])
        if b"null" in line:
            _note(values[k : k + shown], empty)
            line = line.replace(b"null", b"")
        yield line


def json_lines(values: Sequence[float], names: Sequence[str], empty: EmptyCells) -> Iterator[bytes]:
    """The same as objects, {"time":0.0,...}; what has no finite value is null."""
    import orjson

    for k in range(0, len(values), len(names) + ENERGIES):
        line = orjson.dumps(dict(zip(names, values[k : k + len(names)], strict=True)))
        if b":null" in line:
            _note(values[k : k + len(names)], empty)
        yield line


def _note(row: Sequence[float], empty: EmptyCells) -> None:
    for column, value in enumerate(row):
        if not abs(value) < float("inf"):
            empty.note(column, row[0])


# -------------------------------------------------------------------- binary


class _Rows:
    """Rows that are kept as they come, with what is empty in them noted."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.columns = scene, columns(scene)
        self.empty = EmptyCells(scene)
        self.kept: list[Sequence[float]] = []
        self.count = 0

    def write(self, values: Sequence[float]) -> None:
        """Rows, as one flat sequence of numbers."""
        self.kept.append(values)
        self.count += len(values) // (len(self.columns) + ENERGIES)

    def table(self) -> "np.ndarray":
        """(rows, columns) of what is kept, which is then forgotten."""
        import numpy as np

        rows = collect(self.scene, self.kept)[:, : len(self.columns)]
        for k in np.flatnonzero(~np.isfinite(rows).all(axis=1)):
            _note(rows[k].tolist(), self.empty)
        self.kept, self.count = [], 0
        return rows


def parquet_fields(pyarrow: Any, scene: Scene) -> list[Any]:
    """The columns of a trajectory, as doubles, with unit and description as metadata."""
    shown = columns(scene)
    told = [{key: text for key, text in (("unit", c.unit), ("description", c.description)) if text} for c in shown]
    return [pyarrow.field(c.name, pyarrow.float64(), metadata=words or None) for c, words in zip(shown, told, strict=True)]


class ParquetRows(_Rows):
    """Columns of doubles, with units and descriptions as metadata of the fields; pyarrow must be installed."""

    def __init__(self, path: Path, scene: Scene) -> None:
        super().__init__(scene)
        self.pyarrow, parquet = require_parquet()
        self.schema = self.pyarrow.schema(parquet_fields(self.pyarrow, scene))
        self.target = Target(path, binary=True)
        self.file = parquet.ParquetWriter(self.target.stream, self.schema)

    def __enter__(self) -> "ParquetRows":
        return self

    def write(self, values: Sequence[float]) -> None:
        """Rows, as one flat sequence of numbers."""
        super().write(values)
        if self.count >= _GROUP:
            self._flush()

    def _flush(self) -> None:
        table = self.table()
        self.file.write_table(self.pyarrow.Table.from_arrays([self.pyarrow.array(x) for x in table.T], schema=self.schema))

    def __exit__(self, *exception: Any) -> None:
        if exception[0] is None:
            self._flush()
        self.file.close()
        self.target.__exit__(*exception)


class WholeRows(_Rows):
    """Files that are written at the end: NumPy's archive of columns by name, and Modelica's results for MATLAB."""

    def __init__(self, path: Path, scene: Scene, progress: Progress) -> None:
        super().__init__(scene)
        self.progress = progress
        self.target = Target(path, binary=True)

    def __enter__(self) -> "WholeRows":
        return self

    def __exit__(self, *exception: Any) -> None:
        try:
            if exception[0] is None:
                (self._put_mat if self.target.path.suffix.lower() == ".mat" else self._put_arrays)(self.table())
        except BaseException:
            self.target.abandon()
            raise
        self.target.__exit__(*exception)

    def _put_arrays(self, table: "np.ndarray") -> None:
        import numpy as np

        named: dict[str, Any] = {column.name: table[:, k] for k, column in enumerate(self.columns)}
        np.savez(self.target.stream, __units__=np.array([column.unit for column in self.columns]), **named)

    def _put_mat(self, table: "np.ndarray") -> None:
        """The trajectory file of Dymola and OpenModelica, transposed: names, descriptions, where each is found (1: what does not
        change, with its values at both ends; 2: columns over time), as version 4 of MATLAB's files has them."""
        import numpy as np

        known = list(zip(self.scene.parameters, self.progress.parameters, strict=True))
        count = len(self.columns)
        told = [(c.description, c.unit) for c in self.columns] + [(p.description, p.unit) for p, _ in known]
        ends = table[[0, -1], :1].T if len(table) else np.zeros((1, 2))
        still = np.vstack([ends, *[np.full((1, 2), value) for _, value in known]])
        places = [(0 if k == 0 else 2, k + 1, 0, -1) for k in range(count)] + [(1, k + 2, 0, -1) for k in range(len(known))]
        put = self.target.stream.write
        put(_matrix("Aclass", _letters(["Atrajectory", "1.1", "", "binTrans"]).T))
        put(_matrix("name", _letters([c.name for c in self.columns] + [p.name for p, _ in known])))
        put(_matrix("description", _letters([f"{text} [{unit}]".strip() if unit else text for text, unit in told])))
        put(_matrix("dataInfo", np.array(places, dtype="<i4").T))
        put(_matrix("data_1", still))
        put(_matrix("data_2", table.T))


def _letters(texts: Sequence[str]) -> "np.ndarray":
    """A text in each column, in UTF-8."""
    import numpy as np

    lines = [text.encode() for text in texts]
    width = max(map(len, lines), default=1) or 1
    return np.frombuffer(b"".join(line.ljust(width, b" ") for line in lines), np.uint8).reshape(-1, width).T


def _matrix(name: str, values: "np.ndarray") -> bytes:
    """Of version 4: a header of five numbers, the name, the elements column by column."""
    import numpy as np

    kinds = {"f": (0, "<f8"), "i": (20, "<i4"), "u": (51, "u1")}  # doubles, integers, letters
    number, form = kinds[values.dtype.kind]
    head = struct.pack("<5i", number, *values.shape, 0, len(name) + 1)
    return head + name.encode() + b"\0" + np.asfortranarray(values, dtype=form).tobytes(order="F")
