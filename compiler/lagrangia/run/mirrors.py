"""Structures of C that ctypes mirrors, held against those of the library that is loaded.

A library and this package come from the same installation, and are not supposed to differ; where they do, every number that
crosses between them would be wrong without a word. So the library tells how large its structures and enumerations are
(runtime/run/layout.h); that every single member lies where it is looked for, a test says (tests/test_mirrors.py).
"""

import ctypes as c
from collections.abc import Mapping
from enum import IntEnum

from lagrangia.base.diagnostics import fail

Mirrored = type[c.Structure] | type[IntEnum] | list[tuple[str, str]]  # the last: a record of NumPy, its members as "<i4"


class _Size(c.Structure):
    _fields_ = (("name", c.c_char_p), ("size", c.c_int32))


def check_mirrors(library: c.CDLL, mirrors: Mapping[str, Mirrored]) -> None:
    """Raises LagError L0707 where the library's structures are not those mirrored; `mirrors` go by the names of lag_sizes."""
    there = _sizes_in(library)
    for name, mirror in mirrors.items():
        own, unit = _size(mirror)
        if there.get(name) != own:
            fail("L0722", f"the library of the run time does not belong to this Lagrangia: {name} has "
                          f"{there.get(name, 'no')} {unit} in it, and {own} here", None,
                 f"it is {library._name}", "install lagrangia anew (pip install --force-reinstall lagrangia)")


def _size(mirror: Mirrored) -> tuple[int, str]:
    if isinstance(mirror, list):
        return sum(int(form[-1]) for _, form in mirror), "bytes"
    if issubclass(mirror, IntEnum):
        return sum(kind >= 0 for kind in mirror), "numbers"
    return c.sizeof(mirror), "bytes"


def _sizes_in(library: c.CDLL) -> dict[str, int]:
    """lag_sizes of the library; empty where it has none."""
    try:
        row = c.cast(c.addressof(_Size.in_dll(library, "lag_sizes")), c.POINTER(_Size))
    except ValueError:
        return {}
    found, k = {}, 0
    while row[k].name is not None:
        found[row[k].name.decode()] = row[k].size
        k += 1
    return found
