"""What differs from run to run: lists, ranges, distributions and tables -> the values of run k, computed when they are wanted.

A factor is a table of values for some of the names. The runs are all combinations of the factors' rows, the last factor
changing fastest. So 1e9 combinations cost no memory, and run k has the same values whoever asks, in whatever order.
"""

import csv
import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

from lagrangia.base.attitude_values import read_attitude, turn_of
from lagrangia.base.cutting import cut_list
from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import open_with_care
from lagrangia.language.values import read_value
from lagrangia.study.sweep.sensitivity import saltelli_points

if TYPE_CHECKING:
    import numpy as np

ATTITUDE = "attitude"  # the unit of start values of attitudes
MOST_RUNS = 100_000_000
_MOST_VALUES = 10_000_000  # of one name
_CALL = re.compile(r"(\w+)\((.*)\)")
_NAMED = re.compile(r"\s*([A-Za-z_][\w.\[\]]*)\s*=")


@dataclass(frozen=True)
class Factor:
    """values (rows, len(places)): for the places (parameter k, or n_parameters + k for (q, v)[k]) of these names."""

    names: tuple[str, ...]
    places: tuple[int, ...]
    values: "np.ndarray"


@dataclass(frozen=True)
class Variations:
    """All combinations of the rows of the factors."""

    factors: tuple[Factor, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """What is varied, by name."""
        return tuple(name for factor in self.factors for name in factor.names)

    @property
    def places(self) -> tuple[int, ...]:
        """Where each stands among parameters and start values."""
        return tuple(place for factor in self.factors for place in factor.places)

    @property
    def runs(self) -> int:
        """The number of combinations."""
        return math.prod(len(factor.values) for factor in self.factors)

    def values(self, first: int, last: int) -> "np.ndarray":
        """Of the runs first <= k < last: (last - first, len(names))."""
        import numpy as np

        if len(self.factors) == 1:
            return self.factors[0].values[first:last].copy()
        found = np.empty((last - first, len(self.names)))
        run, column = np.arange(first, last), len(self.names)
        for factor in reversed(self.factors):
            run, row = np.divmod(run, len(factor.values))
            found[:, column - len(factor.names) : column] = factor.values[row]
            column -= len(factor.names)
        return found


# -------------------------------------------------------------------- distributions


@dataclass(frozen=True)
class Distribution:
    """A distribution by its quantile function, which takes and gives arrays."""

    name: str
    quantile: "Callable[[np.ndarray], np.ndarray]"


def _normal(mean: float, deviation: float) -> "Callable[[np.ndarray], np.ndarray]":
    import numpy as np

    standard = NormalDist()
    smallest = 2.0**-54  # random numbers are multiples of 2^-53 and may be 0
    return lambda x: mean + deviation * np.array([standard.inv_cdf(max(value, smallest)) for value in x.tolist()])


def _triangular(low: float, mode: float, high: float) -> "Callable[[np.ndarray], np.ndarray]":
    import numpy as np

    width, left = high - low, (mode - low) / (high - low)
    return lambda x: np.where(x < left, low + width * np.sqrt(x * left), high - width * np.sqrt((1 - x) * (1 - left)))


def _lognormal(median: float, deviation: float) -> "Callable[[np.ndarray], np.ndarray]":
    import numpy as np

    normal = _normal(math.log(median), deviation)
    return lambda x: np.exp(normal(x))


def _loguniform(low: float, high: float) -> "Callable[[np.ndarray], np.ndarray]":
    import numpy as np

    return lambda x: low * np.exp(x * math.log(high / low))


# name: (names of arguments, condition on them in words, the condition, quantile function)
_DISTRIBUTIONS: Mapping[str, tuple[tuple[str, ...], str, Callable[..., bool], Callable[..., Any]]] = {
    "normal": (("mean", "deviation"), "deviation > 0", lambda m, s: s > 0, _normal),
    "uniform": (("low", "high"), "low < high", lambda a, b: a < b, lambda a, b: lambda x: a + (b - a) * x),
    "lognormal": (("median", "deviation of the logarithm"), "both > 0", lambda m, s: m > 0 and s > 0, _lognormal),
    "loguniform": (("low", "high"), "0 < low < high", lambda a, b: 0 < a < b, _loguniform),
    "triangular": (("low", "mode", "high"), "low <= mode <= high, low < high",
                   lambda a, m, b: a <= m <= b and a < b, _triangular),
}
_SPACES = {"linspace": "from, to, number of values", "geomspace": "from, to, number of values"}


def sample(distributions: Sequence[Distribution], samples: int, seed: int, way: str) -> "np.ndarray":
    """(samples, len(distributions)): independent ("random"), or one in each of so many equal slices of probability ("lhs"); of
    "saltelli" (samples (len(distributions) + 2), len(distributions)), for Sobol' indices: see sensitivity.py.

    Latin hypercube: M. McKay, R. Beckman, W. Conover, Technometrics 21 (1979) 239.
    """
    import numpy as np

    if way == "saltelli":
        points = saltelli_points(samples, len(distributions), seed)
    else:
        generator = np.random.Generator(np.random.PCG64(seed))
        points = np.empty((samples, len(distributions)))
        for k in range(len(distributions)):
            x = generator.random(samples)
            points[:, k] = (np.argsort(generator.random(samples), kind="stable") + x) / samples if way == "lhs" else x
    points = np.minimum(points, 1 - 2.0**-53)
    return np.stack([distribution.quantile(x) for distribution, x in zip(distributions, points.T, strict=True)], axis=1)


# -------------------------------------------------------------------- from text


def read_variation(name: str, text: str, unit: str) -> "np.ndarray | Distribution":
    """`3`, `1,2,5`, `100:2000:50` (from:to:step), `linspace(0,1,11)`, `geomspace(1,1e6,7)`, `normal(100,5)`, ... in SI units.

    A list of vectors, `{0,-9.81},{0,-1.62}`, gives an array (rows, elements). Raises LagError L0712.
    """
    import numpy as np

    items = cut_list(text)
    if not all(items):
        fail("L0712", f"{name} = {text}: there is no value before or behind one of the commas")
    if len(items) == 1:
        match = _CALL.fullmatch(items[0])
        if match is not None:
            return _called(name, match[1], cut_list(match[2]), text, unit)
        if ":" in items[0]:
            return _range(name, items[0], unit)
    _are_values(name, items, text)
    values = [_read(name, item, unit) for item in items]
    _same_units(name, items, text, unit)
    widths = {len(value) if isinstance(value, list) else 0 for value in values}
    if len(widths) != 1:
        fail("L0712", f"{name} = {text}: the values must all be numbers, or vectors of the same size")
    return np.array(values, dtype=np.float64)


def _are_values(name: str, items: Sequence[str], whole: str) -> None:
    """In `1,k=5` another name begins, and `1,uniform(0,1)` is no list: what may be of random values is one for each run."""
    for item in items:
        if named := _NAMED.match(item):
            fail("L0712", f"{name} = {whole}: '{named[1]}' is another name", None,
                 f"each name has an option of its own: -p {name}=... -p {named[1]}=..., or --initial {named[1]}=...")
    for item in items:
        if (call := _CALL.fullmatch(item)) and (call[1] in _DISTRIBUTIONS or call[1] in _SPACES):
            fail("L0712", f"{name} = {whole}: {call[1]}(...) stands alone, in no list")


def read_attitudes(name: str, given: Any) -> "tuple[np.ndarray, bool]":
    """Start values of an attitude, (values, 3), and whether it is one alone: angles(...), axis_angle(...) or quaternion(...),
    with commas between several; or quaternions (4,), (values, 4). Raises LagError L0712."""
    import numpy as np

    if isinstance(given, str):
        items: list[Any] = cut_list(given)
        is_alone = len(items) == 1
    else:
        items = list(given) if np.iterable(given) else [given]
        is_alone = all(np.ndim(x) == 0 and not isinstance(x, str) for x in items)
        items = [items] if is_alone else items
    try:
        return np.array([turn_of(read_attitude(item)) for item in items], dtype=np.float64), is_alone
    except (ValueError, TypeError) as error:
        fail("L0712", f"{name} = {given}: {error}"[:300])


def is_single(text: str) -> bool:
    """One value, or vector, and no list, range or call that happens to give one."""
    items = cut_list(text)
    return len(items) == 1 and (items[0].startswith("{") or (":" not in items[0] and _CALL.fullmatch(items[0]) is None))


def _read(name: str, text: str, unit: str | None) -> Any:
    try:
        return read_value(text, unit)
    except ValueError as error:
        calls = [f"{kind}({', '.join(entry[0])})" for kind, entry in _DISTRIBUTIONS.items()]
        fail("L0712", f"{name} = {text}: {error}", None,
             "values are 3, or 1,2,5, or 100:2000:50 (from:to:step), or linspace(0,1,11), or geomspace(1,1e6,7)",
             f"random values are {', '.join(calls)}")


def _numbers(name: str, texts: Sequence[str], whole: str, unit: str | None) -> list[float]:
    values = [_read(name, text, unit) for text in texts]
    _same_units(name, texts, whole, unit)
    if any(isinstance(value, list) for value in values):
        fail("L0712", f"{name} = {whole}: numbers are needed, not vectors")
    return values


def _same_units(name: str, texts: Sequence[str], whole: str, unit: str | None) -> None:
    """In `1,2,5[kN/m]` the unit would belong to the 5 alone, which nobody means."""
    with_unit = [text for text in texts if text.endswith("]")]
    if 0 < len(with_unit) < len(texts):
        fail("L0712", f"{name} = {whole}: some of the numbers have a unit and some do not", None,
             f"write the unit at each of them, or at none: bare numbers are in {unit or 'SI units'}")


def _range(name: str, text: str, unit: str | None) -> "np.ndarray":
    import numpy as np

    parts = text.split(":")
    if len(parts) != 3:
        fail("L0712", f"{name} = {text}: a range is from:to:step, as in 100:2000:50")
    begin, end, step = _numbers(name, parts, text, unit)
    hint = "a range is from:to:step; for a number of values write linspace(from, to, number)"
    if step == 0 or (end - begin) / step < 0:
        fail("L0712", f"{name} = {text}: from {begin:g} to {end:g} in steps of {step:g} there is no way", None, hint)
    count = math.floor((end - begin) / step * (1 + 1e-12) + 1e-9) + 1
    _check_count(name, count)
    if count == 1 and begin != end:
        fail("L0712", f"{name} = {text}: a step of {step:g} is longer than the way from {begin:g} to {end:g}", None, hint)
    values: np.ndarray = begin + step * np.arange(count)
    if abs(values[-1] - end) < 1e-9 * abs(step):
        values[-1] = end
    return values


def range_remarks(*given: Mapping[str, Any] | None) -> list[str]:
    """Warnings, as `lag` prints them, of ranges among the values given by name that end before what is written as their end.
    Raises LagError L0712."""
    found = []
    for name, text in (item for values in given for item in (values or {}).items()):
        if isinstance(text, str) and text.count(":") == 2 and "," not in text and "(" not in text:
            last, end = _range(name, text, None)[-1], read_value(text.split(":")[1], None)
            if last != end:
                found.append(f"warning[L0748]: {name} = {text} ends at {last:.6g}, as its step does not meet {end:.6g}\n"
                             "   = a range is from:to:step; linspace(from, to, number) meets both ends")
    return found


def _called(name: str, kind: str, arguments: Sequence[str], text: str, unit: str) -> "np.ndarray | Distribution":
    import numpy as np

    known = [*_DISTRIBUTIONS, *_SPACES]
    if kind not in known:
        fail("L0712", f"{name} = {text}: there is no '{kind}'", None, *filter(None, [suggest(kind, known)]))
    names = _DISTRIBUTIONS[kind][0] if kind in _DISTRIBUTIONS else tuple(_SPACES[kind].split(", "))
    if len(arguments) != len(names):
        fail("L0712", f"{name} = {text}: {kind} takes {len(names)} numbers: {', '.join(names)}")
    if kind in _DISTRIBUTIONS:
        _, condition, holds, quantile = _DISTRIBUTIONS[kind]
        if kind == "lognormal":  # the deviation of a logarithm is a pure number
            numbers = [*_numbers(name, arguments[:1], text, unit), *_numbers(name, arguments[1:], text, "1")]
        else:
            numbers = _numbers(name, arguments, text, unit)
        if not holds(*numbers):
            fail("L0712", f"{name} = {text}: {', '.join(names)} must satisfy {condition}")
        return Distribution(name, quantile(*numbers))
    begin, end = _numbers(name, arguments[:2], text, unit)
    if not arguments[2].isdigit() or int(arguments[2]) < 1:
        fail("L0712", f"{name} = {text}: the number of values must be a whole number of at least 1, not {arguments[2]}")
    count = int(arguments[2])
    _check_count(name, count)
    if kind == "geomspace":
        if not begin * end > 0:
            fail("L0712", f"{name} = {text}: both ends of a geomspace must have the same sign, and not be 0")
        return np.geomspace(begin, end, count)
    return np.linspace(begin, end, count)


def _check_count(name: str, count: int) -> None:
    if count > _MOST_VALUES:
        fail("L0712", f"{name} has {count} values; at most {_MOST_VALUES} are possible")


# -------------------------------------------------------------------- from a table


def read_runs(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """A CSV file with a line of names and a line for each run: names, and (line number, cells). Raises LagError L0713."""
    try:
        with open(path, newline="", encoding="utf-8-sig", opener=open_with_care) as stream:
            reader = csv.reader(stream)
            rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        fail("L0713", f"the table '{path}' cannot be read: {getattr(error, 'strerror', None) or error}")
    if len(rows) < 2:
        fail("L0713", f"the table '{path}' needs a line of names and at least one row")
    names = rows[0][1]
    for number, row in rows[1:]:
        if len(row) != len(names):
            fail("L0713", f"{path}:{number} has {len(row)} cells, not {len(names)}")
    return names, rows[1:]


def columns_of_runs(given: Any) -> "dict[str, np.ndarray]":
    """A pandas DataFrame, or columns by name, in SI units but where the frame's attrs["units"] say others: {name: (runs,)}, with
    their units beside. Raises LagError L0713."""
    import numpy as np

    is_table = isinstance(given, Mapping) or (hasattr(given, "columns") and hasattr(given, "__getitem__"))
    names = [*(given if isinstance(given, Mapping) else given.columns)] if is_table else []
    if not names or not all(isinstance(name, str) for name in names):
        fail("L0713", "runs are a CSV file, a DataFrame or columns by name: a row for each run", None, "runs={'k': [100, 200]}")
    if len({*names}) < len(names):
        fail("L0713", "the table of runs has two columns of one name")
    found = {}
    for name in names:
        try:
            is_complex = np.iscomplexobj(given[name])
            found[name] = np.asarray(given[name], dtype=np.complex128 if is_complex else np.float64)
        except (TypeError, ValueError, OverflowError):
            fail("L0713", f"the table of runs: the column '{name}' holds something else than numbers")
        if is_complex:
            fail("L0713", f"the table of runs: the column '{name}' holds complex numbers")
        if np.ma.is_masked(given[name]):
            fail("L0713", f"the table of runs: the column '{name}' holds masked numbers, which have no value")
        if found[name].ndim != 1 or len(found[name]) != len(found[names[0]]):
            fail("L0713", f"the table of runs: the column '{name}' needs a number for each run")
        if not len(found[name]):
            fail("L0713", f"the table of runs has no row: the column '{name}' is empty")
    return found


def names_of_runs(given: Any) -> list[str]:
    """The names of the columns of a table of runs, of any kind; none without one. Raises LagError L0713."""
    if given is None:
        return []
    return read_runs(given)[0] if isinstance(given, Path) else list(columns_of_runs(given))


def read_cell(path: Path, line: int, name: str, cell: str, unit: str) -> float:
    """Raises LagError L0713 for a cell that is no number."""
    try:
        value = read_value(cell, unit)
    except ValueError as error:
        fail("L0713", f"{path}:{line}: '{cell}' for {name}: {error}")
    if isinstance(value, list):
        fail("L0713", f"{path}:{line}: '{cell}' for {name} is a vector", None, "give its elements columns of their own")
    return value
