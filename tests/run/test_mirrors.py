"""What stands in C and in Python is the same in both: structures, enumerations, constants."""

import ctypes as c
import re
import shutil
from collections.abc import Mapping
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command import summary
from lagrangia.constraints import assembly, initial, metric, newton
from lagrangia.dynamics import guarding, impacts
from lagrangia.native.build import build
from lagrangia.run import batch, moved_starts, runtime, simulate
from lagrangia.run.library import start_runtime
from lagrangia.run.mirrors import check_mirrors

FOLDER = data_folder("runtime")
MIRRORS = runtime.MIRRORS | batch.MIRRORS
# Of the numbers; those of enumerations without a name begin with it.
PREFIXES = {"LagStatus": "LAG_", "LagOp": "LAG_OP_", "LagJetOp": "LAG_JET_"}
_NAMES = ("model/tape", "model/table", "model/jet_tape", "run/batch", "run/run", "choice/choice", "start/metric")
HEADERS = "\n".join(f'#include "{name}.h"' for name in _NAMES)


def members(mirror: Any) -> dict[str, int]:
    """Where every member lies, and the whole ends."""
    if isinstance(mirror, list):
        record = np.dtype(mirror)
        return {name: record.fields[name][1] for name, _ in mirror} | {"": record.itemsize}
    return {name: getattr(mirror, name).offset for name, *_ in mirror._fields_} | {"": c.sizeof(mirror)}


def in_c(name: str, mirror: Any) -> dict[str, int]:
    """The same as a C compiler has it. LagOutcome has the members of its failure one by one."""
    failure = "failure." if name == "LagOutcome" else ""
    inner = ("status", "index", "rate", "time", "value")
    names = [member for member in members(mirror) if member and not member.startswith("padding2")]
    places = [f"offsetof({name}, {failure if member in inner else ''}{member})" for member in names]
    found = numbers([*places, f"sizeof({name})"])
    return dict(zip([*names, ""], found, strict=True))


def numbers(expressions: list[str], headers: str = HEADERS) -> list[int]:
    """Their values in C."""
    rows = ", ".join(f"(long long)({text})" for text in expressions)
    text = f"{headers}\n#include <stddef.h>\nLAG_API extern const long long found[];\nconst long long found[] = {{{rows}}};\n"
    library = c.CDLL(str(build("mirror", text, include=[FOLDER])))
    return list((c.c_longlong * len(expressions)).in_dll(library, "found"))


STRUCTURES = sorted(name for name, mirror in MIRRORS.items() if isinstance(mirror, list) or issubclass(mirror, c.Structure))


@pytest.mark.parametrize("name", STRUCTURES)
def test_every_member_lies_where_c_has_it(name: str) -> None:
    own = members(MIRRORS[name])
    assert in_c(name, MIRRORS[name]) == {member: place for member, place in own.items() if member != "padding2"}


@pytest.mark.parametrize("name", [name for name in MIRRORS if name not in STRUCTURES])
def test_every_number_has_the_value_it_has_in_c(name: str) -> None:
    mirror = MIRRORS[name]
    assert isinstance(mirror, type) and issubclass(mirror, IntEnum)
    kinds = [kind for kind in mirror if kind >= 0]
    assert numbers([f"{PREFIXES.get(name, name + '_')}{kind.name}" for kind in kinds]) == [int(kind) for kind in kinds]
    header = {"LagStatus": "base/status", "LagOp": "model/tape", "LagJetOp": "model/jet_tape", "LAG_SOLVER": "state/settings",
              "LAG_REDUCE": "run/reduce", "LAG_RUN": "run/batch"}[name]
    text = re.sub(r"/\*.*?\*/", "", (FOLDER / f"{header}.h").read_text(), flags=re.S)
    (block,) = (body for body in re.findall(r"enum \{(.*?)\}", text, re.S) if kinds[0].name in body)
    counts = name in ("LAG_SOLVER", "LagOp", "LagJetOp")  # whose last number is how many there are
    assert len(re.findall(r"\bLAG_\w+", block)) == len(kinds) + counts


def test_a_member_that_moved_is_found() -> None:
    """The test above would see two members change places, which no size tells of."""
    fields = list(runtime.MIRRORS["LagFailure"]._fields_)  # type: ignore[union-attr]
    fields[0], fields[1] = fields[1], fields[0]
    swapped = type("Swapped", (c.Structure,), {"_fields_": fields})
    assert in_c("LagFailure", swapped) != members(swapped)


def test_small_numbers_are_those_of_c() -> None:
    starts = {"GUESS": initial.GUESS, "FIXED": initial.FIXED, "FREE": initial.FREE, "LOOSE": initial.LOOSE}
    assert numbers([f"LAG_START_{name}" for name in starts]) == list(starts.values())
    assert (moved_starts.GUESS, moved_starts.FIXED, moved_starts.FREE) == (initial.GUESS, initial.FIXED, initial.FREE)
    assert numbers(["LAG_KICK", "LAG_CONTACT", "LAG_ONE_WAY"]) == [impacts.KICK, impacts.CONTACT, impacts.ONE_WAY]
    kinds = ["ERROR", "WARNING", "END", "OF_PARAMETERS", "HOLDS_ON_LEVEL", "BREAKS_ON_LEVEL"]
    assert numbers([f"LAG_GUARD_{name}" for name in kinds]) == [
        *guarding.KINDS.values(), guarding.OF_PARAMETERS, guarding.HOLDS_ON_LEVEL, guarding.BREAKS_ON_LEVEL]
    assert numbers([f"LAG_METRIC_{way.name}" for way in metric.Way]) == [way.value for way in metric.Way]


# ---------------------------------------------------------------- at load


@pytest.mark.parametrize(
    ("file", "change", "said"),
    [
        ("state/settings.h", ("double max_step;", "double max_step, more;"), "LagSettings has 64 bytes in it, and 56 here"),
        ("base/status.h", ("    LAG_PAUSED,", "    LAG_PAUSED, LAG_MORE,"), "LagStatus has 25 numbers in it, and 24 here"),
        ("run/batch.h", ("    int32_t warned; ", "    int32_t warned, more[2]; "), "LagOutcome has 72 bytes in it, and 64 here"),
    ],
)
def test_a_library_of_another_version_is_refused(tmp_path: Path, file: str, change: tuple[str, str], said: str) -> None:
    other = tmp_path / "runtime"
    shutil.copytree(FOLDER, other)
    text = (other / file).read_text()
    assert text.count(change[0]) == 1
    (other / file).write_text(text.replace(*change))
    mirrors = batch.MIRRORS if file == "run/batch.h" else runtime.MIRRORS
    with pytest.raises(lag.LagError, match="L0722") as refused:
        check_mirrors(c.CDLL(str(build("other", [other / "run" / "layout.c"], include=[other]))), mirrors)
    assert said in str(refused.value)
    assert "install lagrangia anew" in str(refused.value)


def test_a_library_that_is_none_is_refused() -> None:
    path = build("none", "int none(void);\nint none(void) { return 0; }\n")
    with pytest.raises(lag.LagError, match="LagTape has no bytes in it"):
        runtime.load_runtime(path)


def test_the_library_in_use_tells_all_that_is_mirrored() -> None:
    for mirrors in (runtime.MIRRORS, batch.MIRRORS):
        check_mirrors(c.CDLL(str(start_runtime().path())), mirrors)


# ---------------------------------------------------------------- the same algorithm in both languages


def constants_of(file: str) -> dict[str, float | tuple[float, ...]]:
    """What is constant in a C source, by names in capitals."""
    text = re.sub(r"/\*.*?\*/", "", (FOLDER / file).read_text(), flags=re.S)
    found: dict[str, float | tuple[float, ...]] = {}
    for line in re.findall(r"^(?:static const \w+|enum) ?\{?(.*?);", text, re.S | re.M):
        found |= {name: float(value) for name, value in re.findall(r"\b([A-Z_]{3,})\s*=\s*([-\d.e]+)", line)}
        found |= {name: tuple(map(float, row.split(","))) for name, row in re.findall(r"\b([A-Z_]{3,})\[\] = \{(.*?)\}", line)}
    return found


@pytest.mark.parametrize(("file", "module", "names", "count"), [
    ("start/newton.c", newton, {"FULL": None}, 12), ("start/metric.c", metric, {"FREE": "_EASE"}, 3),
    ("start/assemble.c", assembly, {}, 22), ("run/batch.c", simulate, {}, 5),
])
def test_the_same_constants(file: str, module: Any, names: Mapping[str, str | None], count: int) -> None:
    """newton, metric and assembly run without a C compiler what runtime/ does with one; CasADi's integrators have their accounts
    judged in Python, as single runs have, and sweeps theirs in C."""
    there = constants_of(file)
    assert len(there) == count
    for name in there.keys() - {name for name, own in names.items() if own is None}:
        own = names.get(name) or (f"_{name}" if hasattr(module, f"_{name}") else name)
        assert getattr(module, own) == there[name], name


def test_how_large_a_scene_may_be_whose_unsure_forces_are_told() -> None:
    text = (FOLDER / "run" / "unsure.c").read_text(encoding="utf-8")
    assert re.findall(r"MOST_ROWS = (\d+)", text) == [str(summary._MOST_ROWS)]
