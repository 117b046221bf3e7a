"""What Python code gives by name: numbers, counts and mappings, or a diagnostic in place of a TypeError deep below."""

import math
import operator
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import fail

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MOST_STARTS, MOST_POINTS = 10_000, 200_000
_HIGHEST = 1e100  # Hz: its square is still a number


def a_number(what: str, value: Any, hint: str = "") -> float:
    """Of anything that is a real one, NumPy's too. Raises LagError L0702, with what to do."""
    if type(value) is float:
        return value
    if hasattr(value, "mask"):  # NumPy's masked numbers become nan
        _refuse_masked(f"the {what}", value)
    is_no_number = getattr(getattr(value, "dtype", None), "kind", "") in ("b", "c")  # NumPy drops what is imaginary
    if not is_no_number and not isinstance(value, str | bytes | bool):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    fail("L0702", f"the {what} must be a number, not {value!r}"[:200], None, *([hint] if hint else []))


def misfit(value: float, unit: str, minimum: float | None, maximum: float | None) -> str:
    """What is wrong with a value that has limits, in words behind its name; nothing where it is possible. `unit` with a space."""
    if not math.isfinite(value):
        return f"has no finite value: {value}"
    if minimum is not None and value < minimum:
        return f"is {value:g}{unit}, less than its minimum {minimum:g}{unit}"
    if maximum is not None and value > maximum:
        return f"is {value:g}{unit}, more than its maximum {maximum:g}{unit}"
    return ""


def a_length(value: Any) -> float:
    """In m, more than 0. Raises LagError L0702."""
    length = a_number("length", value)
    if not 0.0 < length < math.inf:
        fail("L0702", f"the length must be more than 0 and finite, not {length:g}")
    return length


def a_count(what: str, value: Any) -> int:
    """Raises LagError L0702."""
    if not isinstance(value, bool):
        try:
            return operator.index(value)
        except TypeError:
            pass
    fail("L0702", f"the {what} must be a whole number, not {value!r}"[:200])


def a_count_within(what: str, value: Any, least: int, most: int) -> int:
    """Raises LagError L0702."""
    count = a_count(what, value)
    if not least <= count <= most:
        fail("L0702", f"the {what} must lie between {least} and {most}, not be {count}")
    return count


def numbers(what: str, given: Any) -> list[float]:
    """Raises LagError L0702."""
    found = None if isinstance(given, str | bytes | Mapping) else _listed(given)
    if found is None:
        fail("L0702", f"the {what} must be a sequence of numbers, not {given!r}"[:200])
    return [a_number(what, value) for value in found]


def _listed(given: Any) -> list[Any] | None:
    """What is in it; None where nothing can be, as in an array of no dimension, which says that it can be iterated over."""
    try:
        return list(given)
    except TypeError:
        return None


def an_array(what: str, given: Any) -> "NDArray[np.float64]":
    """Of real numbers, in any dimensions, none of them masked. Raises LagError L0702."""
    import numpy as np

    _refuse_masked(what, given)
    try:
        found = np.asarray(given)
    except ValueError:  # rows of several lengths
        found = np.asarray(None)
    if found.dtype == object and found.ndim:  # fractions, long integers
        found = np.array([a_number(f"element of {what}", x) for x in found.ravel()]).reshape(found.shape)
    if found.dtype.kind not in "biuf":
        shown = f"one of {given.dtype}" if isinstance(given, np.ndarray) else repr(given)
        fail("L0702", f"{what} must be an array of real numbers, not {shown}"[:200])
    return found.astype(np.float64, copy=False)


def _refuse_masked(what: str, given: Any) -> None:
    import numpy as np

    if np.ma.is_masked(given):
        wanted = "an array of numbers" if given.ndim else "a number"
        found = f"{int(np.sum(given.mask))} of it are" if given.ndim else "it is"
        fail("L0702", f"{what} must be {wanted}, and {found} masked", None,
             "what is masked has no value: .filled(...) gives it one, .compressed() leaves it out")


def names(what: str, given: Any) -> tuple[str, ...]:
    """A text alone is one name. Raises LagError L0702."""
    found = [given] if isinstance(given, str) else _listed(given)
    if found is None or not all(isinstance(name, str) for name in found):
        fail("L0702", f"the {what} must be names, not {given!r}"[:200])
    return tuple(found)


def a_text(what: str, given: Any) -> str:
    """Raises LagError L0702."""
    if not isinstance(given, str):
        fail("L0702", f"the {what} must be a text, not {given!r}"[:200])
    return given


def a_path(given: Any) -> Path:
    """Of a file. Raises LagError L0702."""
    try:
        return Path(given)
    except TypeError:
        fail("L0702", f"a path must be a text or a pathlib.Path, not {given!r}"[:200])


def a_frequency(value: Any) -> float:
    """In Hz. Raises LagError L0702."""
    frequency = a_number("frequency", value)
    if not 0 < frequency < _HIGHEST:
        fail("L0702", f"a frequency is a positive number of Hz, not {frequency:g}")
    return frequency


def a_span(given: Any) -> tuple[float, float]:
    """Of frequencies, rising. Raises LagError L0702."""
    ends = [a_frequency(value) for value in numbers("span", given)]
    if len(ends) != 2:
        fail("L0702", f"the span must be two frequencies, not {len(ends)}")
    if not ends[0] < ends[1]:
        fail("L0702", f"the frequencies must rise, not go from {ends[0]:g} to {ends[1]:g}")
    return ends[0], ends[1]


def by_name(what: str, given: Any) -> Mapping[str, Any]:
    """Nothing given is nothing. Raises LagError L0702."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        fail("L0702", f"the {what} must be a mapping of names to values, not {given!r}"[:200])
    for name in given:
        if not isinstance(name, str):
            fail("L0702", f"the {what} must have names, not {name!r}"[:200])
    return given


def any_names(what: str, given: Any) -> tuple[str, ...] | None:
    """`names`, or None where nothing is given. Raises LagError L0702."""
    return None if given is None else names(what, given)
