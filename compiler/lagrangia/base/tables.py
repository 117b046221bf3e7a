"""Tables of numbers over time, as people give them."""

from pathlib import Path

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import open_with_care
from lagrangia.base.spelling import read_number


def read_table(path: Path) -> tuple[list[float], dict[str, list[float]]]:
    """A CSV file with a line of names, one of them time. Raises LagError L0703."""
    import csv

    try:
        with open(path, newline="", encoding="utf-8-sig", opener=open_with_care) as stream:
            reader = csv.reader(stream)
            rows = [(reader.line_num, row) for row in reader if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        fail("L0703", f"the table '{path}' cannot be read: {getattr(error, 'strerror', None) or error}")
    if len(rows) < 2 or "time" not in [cell.strip() for cell in rows[0][1]]:
        fail("L0703", f"the table '{path}' needs a line of names, one of them time, and at least one row")
    names = [cell.strip() for cell in rows[0][1]]
    if (twice := next((name for name in names if names.count(name) > 1), None)) is not None:
        fail("L0703", f"the table '{path}' has two columns '{twice}'")
    columns: dict[str, list[float]] = {name: [] for name in names}
    for number, row in rows[1:]:
        if len(row) != len(names):
            fail("L0703", f"{path}:{number} has {len(row)} cells, not {len(names)}")
        for name, cell in zip(names, row, strict=True):
            columns[name].append(_number(path, number, cell))
    return columns.pop("time"), columns


def _number(path: Path, line: int, cell: str) -> float:
    try:
        return read_number(cell)
    except ValueError:
        fail("L0703", f"{path}:{line}: '{cell}' is no number")


def read_input_table(path: Path) -> tuple[list[float], dict[str, list[float]]]:
    """The same, of inputs: one at least. Raises LagError L0703."""
    times, columns = read_table(path)
    if not columns:
        fail("L0703", f"the table '{path}' has no column beside its time", None, "each input has one, by its name: time,F")
    return times, columns
