"""Files of columns of numbers, as measuring systems write them: CSV in its dialects; MAT and Parquet by libraries for them."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import LagError, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import require_file
from lagrangia.run.library import find_runtime

if TYPE_CHECKING:
    import numpy as np

_HEADING = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))?\s*")
_REMARKS = (b"#", b"%")
_DELIMITERS = (b";", b"\t", b",")


@dataclass(frozen=True)
class Columns:
    """`values` (columns, rows); names are "" where the file has none, units where none is written."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: "np.ndarray"

    def place(self, column: str | int | None) -> int | None:
        """Of a column that is asked for by its name or its number, from 1; None asks for the second of two."""
        if column is None:
            return 1 if len(self.names) == 2 else None
        if isinstance(column, int):
            return column - 1 if 1 <= column <= len(self.names) else None
        return self.names.index(column) if column in self.names else None


def read_columns(path: Path, span: Span | None = None) -> Columns:
    """Raises LagError L0703 for what cannot be read as columns of numbers."""
    try:
        require_file(path)
        if path.suffix.lower() == ".parquet":
            return _parquet(path)
        if path.suffix.lower() == ".mat":
            return _mat(path)
        return _csv(path, path.read_bytes())
    except OSError as error:
        fail("L0703", f"the table '{path}' cannot be read: {error.strerror or error}", span)
    except LagError as error:
        raise LagError([replace(d, span=span) for d in error.diagnostics]) from None


# -------------------------------------------------------------------- CSV


def _csv(path: Path, content: bytes) -> Columns:
    import numpy as np

    content = content.removeprefix(b"\xef\xbb\xbf")
    begin = _first_line(content)
    line, _, rest = content[begin:].partition(b"\n")
    delimiter = next((d for d in _DELIMITERS if d in line), b"")
    cells = [cell.strip() for cell in (line.split(delimiter) if delimiter else line.split())]
    has_decimal_comma = delimiter != b"," and b"," in (line if not rest else rest[:4096])
    is_heading = any(_number(cell, has_decimal_comma) is None for cell in cells)
    body = rest if is_heading else content[begin:]
    first = 1 + content.count(b"\n", 0, begin) + is_heading  # line of the body
    values = _numbers(path, body, delimiter, has_decimal_comma, len(cells), first)
    headings = [_heading(path, cell) for cell in cells] if is_heading else [("", "")] * len(cells)
    if len({name for name, _ in headings if name}) < sum(bool(name) for name, _ in headings):
        fail("L0703", f"the table '{path}' has two columns of one name")
    return Columns(tuple(name for name, _ in headings), tuple(unit for _, unit in headings), np.ascontiguousarray(values.T))


def _first_line(content: bytes) -> int:
    """Where the lines begin that are neither empty nor remarks."""
    at = 0
    while at < len(content):
        end = content.find(b"\n", at)
        line = content[at : len(content) if end < 0 else end].strip()
        if line and not line.startswith(_REMARKS):
            return at
        at = len(content) if end < 0 else end + 1
    return at


def _number(cell: bytes, has_decimal_comma: bool) -> float | None:
    """None for what is no finite number."""
    try:
        value = float(cell.replace(b",", b".") if has_decimal_comma else cell)
    except ValueError:
        return None
    return value if math.isfinite(value) and b"_" not in cell else None


def _heading(path: Path, cell: bytes) -> tuple[str, str]:
    """z [m], z (m) or "z [m]": name and unit."""
    try:
        text = cell.decode().strip().strip('"').strip()
    except UnicodeDecodeError:
        fail("L0703", f"the line of names of '{path}' is no text in UTF-8")
    found = _HEADING.fullmatch(text)
    return (found[1], (found[2] or found[3] or "").strip()) if found else (text, "")


def _numbers(path: Path, body: bytes, delimiter: bytes, has_decimal_comma: bool, width: int, first: int) -> "np.ndarray":
    """(rows, columns); `first` is the number of the body's first line. The run time reads them, in a tenth of the time."""
    import ctypes as c

    import numpy as np

    found = np.empty((body.count(b"\n") + 1, width))
    runtime = find_runtime()
    if runtime is None:
        return _line_by_line(path, body, delimiter, has_decimal_comma, width, first)
    count = runtime.library.lag_read_numbers(body, delimiter[0] if delimiter else 0, ord(",") if has_decimal_comma else ord("."),
                                             width, found.ctypes.data_as(c.POINTER(c.c_double)), len(found))
    if count < 0:
        _line_by_line(path, body, delimiter, has_decimal_comma, width, first)
        fail("L0703", f"{path}:{first - 1 - count} cannot be read as numbers")
    if count == 0:
        fail("L0703", f"the table '{path}' has no rows")
    return found[:count]


def _line_by_line(path: Path, body: bytes, delimiter: bytes, has_decimal_comma: bool, width: int, first: int) -> "np.ndarray":
    """The same in Python, which says what is wrong."""
    import numpy as np

    found: list[list[float]] = []
    for number, line in enumerate(body.split(b"\n"), first):
        if not line.strip() or line.lstrip().startswith(_REMARKS):
            continue
        cells = [cell.strip() for cell in (line.split(delimiter) if delimiter else line.split())]
        if len(cells) != width:
            fail("L0703", f"{path}:{number} has {len(cells)} cells, not {width}")
        values = [_number(cell, has_decimal_comma) for cell in cells]
        wrong = next((cell for cell, value in zip(cells, values, strict=True) if value is None), None)
        if wrong is not None:
            fail("L0703", f"{path}:{number}: '{wrong.decode(errors='replace')[:40]}' is no finite number")
        found.append([value for value in values if value is not None])
    if not found:
        fail("L0703", f"the table '{path}' has no rows")
    return np.array(found)


# -------------------------------------------------------------------- other files


def _parquet(path: Path) -> Columns:
    import numpy as np

    try:
        import pyarrow.parquet as pq
    except ImportError:
        fail("L0703", f"the table '{path}' is read by pyarrow, which is not installed", None, "pip install lagrangia[parquet]")
    try:
        table = pq.read_table(path)
        values = np.array([np.asarray(column, float) for column in table.columns])
    except Exception as error:  # pyarrow has its own classes of errors, TypeError and ValueError among them
        fail("L0703", f"the table '{path}' cannot be read as columns of numbers: {error}"[:300])
    return _checked(path, [_heading(path, name.encode()) for name in table.column_names], values)


def _mat(path: Path) -> Columns:
    """Variables of one size, each a column; of a single matrix, its columns."""
    import numpy as np

    try:
        import scipy.io
    except ImportError:
        fail("L0703", f"the table '{path}' is read by SciPy, which is not installed", None, "pip install scipy")
    try:
        found = {name: np.asarray(x, float) for name, x in scipy.io.loadmat(path).items() if not name.startswith("__")}
    except NotImplementedError:
        fail("L0901", f"not supported yet: '{path}' is of MATLAB 7.3", None, "save it with -v7, or as CSV or Parquet")
    except (ValueError, TypeError) as error:
        fail("L0703", f"the table '{path}' cannot be read as columns of numbers: {error}"[:300])
    if len(found) == 1:
        (values,) = found.values()
        return _checked(path, [("", "")] * values.shape[-1], values.reshape(-1, values.shape[-1]).T)
    if len({x.size for x in found.values()}) != 1:
        sizes = ", ".join(f"{name} {x.shape}" for name, x in found.items())
        fail("L0703", f"the variables of '{path}' are not columns of one size: {sizes}"[:300])
    return _checked(path, [(name, "") for name in found], np.array([x.ravel() for x in found.values()]))


def _checked(path: Path, headings: list[tuple[str, str]], values: "np.ndarray") -> Columns:
    import numpy as np

    if values.ndim != 2 or not values.size or not np.isfinite(values).all():
        fail("L0703", f"the table '{path}' needs columns of finite numbers")
    return Columns(tuple(name for name, _ in headings), tuple(unit for _, unit in headings), np.ascontiguousarray(values))
