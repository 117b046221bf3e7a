"""The C run time that comes with the package: built once, when the package is, for its platform.

The build hook (compiler/build_package.py) loads this file by itself, before the package is there: it imports the standard library
alone. A library goes with the digest of its sources and flags; one that was built from others is not found.

It is compiled for this machine's processor and, with less care, for any of the platform: which is taken is decided where it is
loaded. LAGRANGIA_KINDS=all compiles for all kinds with the same care, as a wheel for others should be. Widths of registers change
no digit (no contraction, sums in a fixed order). Fused multiply-adds do: products that say that they are rounded with their sums
are, wherever the processor can (avx2 and avx512 have the same digits), and "any" rounds them twice; its rows differ in their last
digits, within their errors. What hardly counts in any run is compiled once and goes into all of them (_SHARED). All else of a
library is of one kind: where loops with and without wide registers take turns, implicit steps take twice as long.

Two libraries more, one a version of the standard, are binaries of FMUs: for any processor, and any scene (runtime/fmi/stored.c).
"""

import hashlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from concurrent.futures import Future

SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# No contraction and no -ffast-math: the same digits on every machine that fuses, and the compensated sums of the run time stay
# intact. A product that is rounded with its sum says so, and is rounded by itself where the processor cannot (numbers/wide.h).
FLAGS = ("-std=c99", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden",
         *(() if sys.platform == "win32" else ("-fPIC",)))
LIBRARIES = () if sys.platform == "win32" else ("-lm",)
LEVEL = "-O2"
# The loop that runs tapes takes up to a sixth longer where its function begins inside a line of the cache, which any change of
# another file decides; others 2 to 5 % where they do.
_ALIGNED = ("-falign-functions=64", "-falign-loops=32")
PROBE = "int lag_probe(void);\nint lag_probe(void) { return 0; }\n"  # what a compiler that works can build
_FOLDER = Path(__file__).with_name("prebuilt")
_PROCESSOR = Path("/proc/cpuinfo")
FMI_VERSIONS = ("2", "3") if sys.platform != "win32" else ()  # of FMUs for which a library comes with the package
_FMI = ("cosimulation", "evaluations", "exchange", "exchange_steps", "image", "life", "log", "partial", "saved", "settle",
        "states", "stored", "values")
_OF_VERSION = ("-fvisibility=default",)  # the files of a version define the functions of the standard, and no others
_TOGETHER = 8  # files compiled as one
_WIDEST = ("avx512f", "avx512dq", "avx512vl")
# gcc clears the upper halves of registers at -O1, too: where they are in use, going over to instructions of older kinds (libm's,
# ours for any processor) and back takes tens of cycles each time.
_CLEARED = "-fexpensive-optimizations"
# What is compiled for, by name, the best first: the flags, and what a processor has to tell of itself. Instructions of three
# operands and wide registers take a tenth off the time of series, half or more off that of states evaluated abreast.
_KINDS: Mapping[str, tuple[tuple[str, ...], frozenset[str]]] = {
    "avx512": (("-mavx2", "-mfma", _CLEARED, *(f"-m{name}" for name in _WIDEST)), frozenset(("avx2", "fma", *_WIDEST))),
    "avx2": (("-mavx2", "-mfma", _CLEARED), frozenset({"avx2", "fma"})),
    "any": ((), frozenset()),
}

# The kind of processors for which these are compiled, and with how much care: they go into the library of this machine, too.
_ONCE = ("any", LEVEL)
# By rooms, the files in which no example spends a fiftieth of its run, whatever the solver, and that compute nothing abreast.
_SHARED: Mapping[str, frozenset[str]] = {room: frozenset(names.split()) for room, names in {
    "base": "clock",
    "model": "arrange hoist history inputs read_numbers schedule",
    "numbers": "complementarity",
    "start": "assemble blocks known_start metric newton",
    "state": "first_step inside onset",
    "events": "candidates cones contact_friction impacts impulses jams jumps rest sampling slide_settle slide_states switches",
    "steps": "branch delays rounding singular turns",
    "methods": "equal_steps linear_pace linear_series linear_system pirk_edges transition_system",
    "choice": "choice methods stiffness",
    "run": "begin course islands layout parts run snapshot stepping window",
}.items()}


def kinds() -> tuple[str, ...]:
    """Of processors on this platform, the best first."""
    return tuple(_KINDS) if _machine() in ("x86_64", "AMD64") else ("any",)


def _machine() -> str:
    if hasattr(os, "uname"):
        return os.uname().machine
    import platform

    return platform.machine()


def flags_of(kind: str) -> tuple[str, ...]:
    """What the compiler is told for a kind of processor."""
    return _KINDS[kind][0]


@cache
def kind_here() -> str:
    """The best that this machine can run."""
    if kinds() == ("any",):
        return "any"
    try:
        told = next((line.split() for line in _PROCESSOR.read_text().splitlines() if line.startswith("flags")), [])
    except OSError:
        return "any"
    return next(kind for kind in kinds() if _KINDS[kind][1] <= {*told})


def find(runtime: Path, folder: Path = _FOLDER, digest_of: "Callable[[Path], str] | None" = None) -> Path | None:
    """The library for this machine, built from these sources; None where it is not there, or was built from others.

    `runtime` is the folder of the sources. What is loaded lies beside the modules, and is as trusted as they are.
    `digest_of`: what knows the digest of sources sooner than by reading them.
    """
    try:
        known = (folder / "digest").read_text().strip()
    except OSError:
        return None
    able = kinds()[kinds().index(kind_here()) :]
    there = next((library for kind in able if (library := folder / f"{kind}{SUFFIX}").exists()), None)
    return there if there is not None and known == (digest_of or digest)(runtime) else None


def find_fmu(runtime: Path, version: str, folder: Path = _FOLDER) -> Path | None:
    """The binary of FMUs of a version of the standard, likewise."""
    try:
        known = (folder / "digest").read_text().strip()
    except OSError:
        return None
    library = folder / f"fmu{version}{SUFFIX}"
    return library if library.exists() and known == digest(runtime) else None


def sources(runtime: Path) -> list[Path]:
    """All C files of the run time but those of FMUs."""
    return sorted(file for file in runtime.rglob("*.c") if "fmi" not in file.relative_to(runtime).parts)


@cache
def digest(runtime: Path) -> str:
    """Changes with every source, every header and the flags."""
    shared = [(room, sorted(names)) for room, names in _SHARED.items()]
    hashed = hashlib.sha256(repr((FLAGS, LEVEL, _ALIGNED, sorted(flags for flags, _ in _KINDS.values()), shared, _ONCE)).encode())
    for file in sorted(runtime.rglob("*.[ch]")):
        hashed.update(file.name.encode() + hashlib.sha256(file.read_bytes()).digest())
    return hashed.hexdigest()


# -------------------------------------------------------------------- building


def find_command() -> list[str] | None:
    """The first of $CC, cc, gcc, clang and PyPI's ziglang that builds an empty library."""
    import shlex
    import tempfile

    for found in candidates(shlex.split(os.environ.get("CC", ""))):
        words = [*found, *(("-mcpu=baseline",) if "ziglang" in found and sys.platform != "darwin" else ())]
        with tempfile.TemporaryDirectory() as folder:
            source = Path(folder) / "probe.c"
            source.write_text(PROBE)
            try:
                _run([*words, *FLAGS, "-shared", str(source), "-o", str(Path(folder) / "probe")], Path(folder))
            except (OSError, RuntimeError):
                continue
        return words
    return None


def candidates(own: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Commands of C compilers that are there, in the order in which they are tried; `own` is what $CC says."""
    import shutil
    from importlib.util import find_spec

    for words in (tuple(own), ("cc",), ("gcc",), ("clang",)):
        if words and shutil.which(words[0]):
            yield words
    if find_spec("ziglang"):
        yield sys.executable, "-m", "ziglang", "cc"


def build(runtime: Path, folder: Path, command: Sequence[str]) -> None:
    """The libraries, and the digest of what they were built from. Raises RuntimeError, OSError."""
    import shutil
    import tempfile
    from concurrent.futures import ThreadPoolExecutor

    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="lagrangia-") as temporary, ThreadPoolExecutor(os.cpu_count()) as pool:
        work = Path(temporary)

        def compiled(kind: str, unit: Sequence[Path], *flags: str) -> str:
            source = _written(unit, work / f"{kind}-{unit[0].stem}.c")
            made = str(source.with_suffix(".o"))
            _run([*command, *FLAGS, *flags_of(kind), _level(kind), *_ALIGNED, *_portable(command, runtime), *flags,
                  f"-I{runtime}", "-c", str(source), "-o", made], work)
            return made

        def linked(name: str, objects: "Sequence[Future[str]]", *flags: str) -> None:
            fresh = work / f"{name}{SUFFIX}"
            _run([*command, *FLAGS, "-shared", *flags, *(item.result() for item in objects), "-o", str(fresh), *LIBRARIES], work)
            shutil.move(fresh, folder / fresh.name)

        own = units([file for file in sources(runtime) if not is_shared(file)])
        objects = {kind: [pool.submit(compiled, kind, unit) for unit in own] for kind in _wanted()}
        shared = units([file for file in sources(runtime) if is_shared(file)])
        once = [pool.submit(compiled, _ONCE[0], unit, *_ONCE[1:]) for unit in shared]
        told = (f"-I{runtime / 'standard'}", f'-DLAG_BUILD="{digest(runtime)}"')
        glue = {version: [pool.submit(compiled, "any", unit, *told, *_OF_VERSION)
                          for unit in units(sorted((runtime / "fmi").glob(f"fmi{version}*.c")))] for version in FMI_VERSIONS}
        around = [pool.submit(compiled, "any", unit, *told)
                  for unit in units([file for file in sorted((runtime / "fmi").glob("*.c")) if file.stem in _FMI])]
        for kind, made in objects.items():
            linked(kind, [*made, *once])
        for version, made in glue.items() if around else ():
            linked(f"fmu{version}", [*objects["any"], *once, *around, *made], *_exported(work))
    (folder / "digest").write_text(digest(runtime) + "\n")


def joined(files: Sequence[Path], folder: Path) -> list[Path]:
    """Files written to a folder that are compiled in the place of others: each includes those of one of their `units`."""
    return [_written(unit, folder / f"unit-{unit[0].stem}.c") for unit in units(files)]


def _written(unit: Sequence[Path], source: Path) -> Path:
    names = [file.name if file.parent == source.parent else file.as_posix() for file in unit]
    source.write_text("".join(f'#include "{name}"\n' for name in names), encoding="utf-8")
    return source


def is_shared(file: Path) -> bool:
    """Whether a source of the run time is compiled once, for all kinds of processors."""
    return file.stem in _SHARED.get(file.parent.name, ())


def units(files: Sequence[Path]) -> list[list[Path]]:
    """Files that may be compiled as one, the largest units first: no name of one, outside its functions, is that of another.

    Compilers start once and read headers once for each unit; what a file defines for itself is still its own. A unit has no more
    files than _TOGETHER, so that all processors have work. One that includes Windows' own header, whose macros have usual names
    (near), is a unit by itself.
    """
    made: list[tuple[list[Path], set[str], set[str]]] = []
    alone: list[list[Path]] = []
    for file in files:
        text = file.read_text(encoding="utf-8")
        if "<windows.h>" in text:
            alone.append([file])
            continue
        words, own, macros = _names(text)
        for unit, others, theirs in made:
            if len(unit) < _TOGETHER and not own & others and not macros & words and not theirs & words:
                break
        else:
            made.append(([], set(), set()))
            unit, others, theirs = made[-1]
        unit.append(file)
        others |= own
        theirs |= macros
    return sorted([*alone, *(unit for unit, _, _ in made)], key=lambda unit: -sum(file.stat().st_size for file in unit))


def _names(text: str) -> tuple[set[str], set[str], set[str]]:
    """Of a C file: all its words, what it defines outside of functions, and its macros."""
    import re

    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    words, macros = set(re.findall(r"\w+", text)), set(re.findall(r"^\s*#\s*define\s+(\w+)", text, re.M))
    text = re.sub(r"^\s*#(?:.*\\\n)*.*", "", text, flags=re.M)
    inside = " ".join(re.findall(r"\benum\b[^{;]*({[^}]*})", text))
    for ends in (r"{[^{}]*}", r"\([^()]*\)"):
        while (shorter := re.sub(ends, lambda found: "[" if found[0][0] == "(" else "]", text)) != text:
            text = shorter
    defined = re.findall(r"([A-Za-z_]\w*)\s*(?=[]\[=;,])", re.sub(r"=[^,;]*", "=", text))
    return words, {*defined, *re.findall(r"([A-Za-z_]\w*)\s*(?=[=,}])", inside)} - {"enum", "struct", "union"}, macros


def _portable(command: Sequence[str], runtime: Path) -> tuple[str, ...]:
    """Of the mathematical library only what every glibc has. Zig sees to that itself."""
    from platform import libc_ver

    header = runtime / "standard" / "old_glibc.h"
    return ("-include", str(header)) if libc_ver()[0] == "glibc" and "ziglang" not in command and header.exists() else ()


def _exported(work: Path) -> tuple[str, ...]:
    """Only the functions of the standard are seen from outside: several FMUs may be loaded into one process."""
    if sys.platform == "darwin":
        return ("-Wl,-exported_symbol,_fmi*", "-Wl,-x")
    script = work / "exported"
    script.write_text("{ global: fmi2*; fmi3*; local: *; };\n")
    return (f"-Wl,--version-script={script}", "-Wl,-s")


def _wanted() -> tuple[str, ...]:
    return kinds() if os.environ.get("LAGRANGIA_KINDS") == "all" else tuple(dict.fromkeys((kind_here(), "any")))


def _level(kind: str) -> str:
    return "-O1" if kind == "any" and len(_wanted()) == 2 else LEVEL


def _run(command: Sequence[str], folder: Path) -> None:
    import shlex
    import subprocess

    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{shlex.join(command)}\n{done.stdout}{done.stderr}"[:4000])
