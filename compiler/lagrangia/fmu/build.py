"""C sources -> binaries of the platforms, by the C compiler of this machine or by ziglang for all of them.

Each binary is kept in the cache by the content of what it is made from. zig's own cache is keyed by its options: they stay the
same, so that only the first binary of a platform is slow.
"""

import contextlib
import hashlib
import os
import platform
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

from lagrangia.base.diagnostics import fail
from lagrangia.base.folders import cache_folder
from lagrangia.base.records import dataclass
from lagrangia.base.store import find_kept, keep
from lagrangia.native.build import CompilerError, find_compiler
from lagrangia.native.prebuilt import joined

# Reproducible on every processor: no contraction to fused multiply-add, no folder names inside.
_FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden", "-DLAG_STATIC=1",
          "-DFMI3_OVERRIDE_FUNCTION_PREFIX=1")
_GENERATED = ("scene.c", "scene_fmu.c")
# For Windows zig would compile mingw's whole C library (a minute and more), of which a library without constructors and variables
# of threads needs these few functions; the others are Windows' own, and zig's mathematics.
_FOR_WINDOWS = ("-nostdlib", "-lcompiler_rt", "-lkernel32",
                *(f"-lapi-ms-win-crt-{part}-l1-1-0" for part in ("heap", "math", "stdio", "string", "utility")))
_START = """#define __CRT__NO_INLINE 1
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

int __stdcall DllMainCRTStartup(void *instance, unsigned long why, void *reserved)
{
    (void)instance, (void)why, (void)reserved;
    return 1;
}

int vsnprintf(char *text, size_t room, const char *format, va_list values)
{
    return __stdio_common_vsprintf(_CRT_INTERNAL_PRINTF_STANDARD_SNPRINTF_BEHAVIOR, text, room, format, NULL, values);
}

int __fpclassify(double x) { return __builtin_fpclassify(FP_NAN, FP_INFINITE, FP_NORMAL, FP_SUBNORMAL, FP_ZERO, x); }
int __isnan(double x) { return __builtin_isnan(x); }
int __signbit(double x) { return __builtin_signbit(x); }
"""
_OF_ONE_VERSION = ("fmi2", "fmi3")  # begin the names of files that only FMUs of this version have


@dataclass(frozen=True)
class Platform:
    """Folders of the binary in FMI 2 and 3, its suffix and zig's name of the target."""

    fmi2: str
    fmi3: str
    suffix: str
    target: str
    flags: tuple[str, ...] = ()


PLATFORMS: Mapping[str, Platform] = {
    "x86_64-linux": Platform("linux64", "x86_64-linux", ".so", "x86_64-linux-gnu.2.17", ("-fPIC", "-Wl,-s,-z,defs")),
    "aarch64-linux": Platform("aarch64-linux", "aarch64-linux", ".so", "aarch64-linux-gnu.2.17", ("-fPIC", "-Wl,-s,-z,defs")),
    "x86_64-windows": Platform("win64", "x86_64-windows", ".dll", "x86_64-windows-gnu", ("-U__CRT__NO_INLINE",)),
    "x86_64-darwin": Platform("darwin64", "x86_64-darwin", ".dylib", "x86_64-macos", ("-fPIC",)),
    "aarch64-darwin": Platform("aarch64-darwin", "aarch64-darwin", ".dylib", "aarch64-macos.11.0", ("-fPIC",)),
}


DARWIN = ("x86_64-darwin", "aarch64-darwin")  # in the order of their slices in a universal binary
_SLICES = ((0x01000007, 3), (0x0100000C, 0))  # CPU type and subtype of each


def universal(libraries: Sequence[bytes]) -> bytes:
    """One Mach-O file of the libraries for DARWIN: a header in big endian, the slices at multiples of 16 kB."""
    align = 14
    header, content = struct.pack(">II", 0xCAFEBABE, len(libraries)), b""
    offset = 1 << align
    for (kind, subtype), library in zip(_SLICES, libraries, strict=True):
        header += struct.pack(">IIIII", kind, subtype, offset, len(library), align)
        padded = library + bytes(-len(library) % (1 << align))
        content += padded
        offset += len(padded)
    return header.ljust(1 << align, b"\0") + content


def host_platform() -> str | None:
    """The name of this machine's platform; None where it is no platform of ours."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    name = f"{machine}-{system}"
    return name if name in PLATFORMS else None


def read_platforms(given: object) -> tuple[str, ...]:
    """ "all", "host", or names between commas. Raises LagError L0706."""
    text = str(given)
    if text == "all":
        return tuple(PLATFORMS)
    host = host_platform()
    names = [name.strip() for name in text.split(",") if name.strip()]
    chosen = [host or name if name == "host" else name for name in names]
    for name in chosen:
        if name not in PLATFORMS:
            fail("L0706", f"there is no platform '{name}'", None, f"there are {', '.join(PLATFORMS)}, host, all")
    return tuple(dict.fromkeys(chosen))


def standard_headers() -> Path:
    """The folder of fmi2Functions.h and fmi3Functions.h. Raises LagError L0720 when FMPy is not installed."""
    spec = find_spec("fmpy")
    if spec is None or not spec.submodule_search_locations:
        fail("L0720", "FMPy, which brings the headers of the FMI standard, is not installed", None,
             'pip install "lagrangia[fmu]"')
    return Path(spec.submodule_search_locations[0]) / "c-code"


def build_binaries(identifier: str, sources: Mapping[str, str], platforms: Sequence[str],
                   tell: Callable[[str], None] | None = None) -> dict[str, bytes]:
    """The library of each platform. `sources` are all files of the FMU's folder of that name. Raises LagError, CompilerError."""
    headers = standard_headers()
    with ThreadPoolExecutor(max(1, os.cpu_count() or 1)) as pool:
        started = [pool.submit(_build, identifier, sources, name, headers, tell) for name in platforms]
        return {name: future.result() for name, future in zip(platforms, started, strict=True)}


def _command(target: str) -> tuple[list[str], str]:
    """The compiler, and what changes when it does."""
    if find_spec("ziglang") is not None:
        from importlib.metadata import version

        # Nothing of zig's own library is called but on Windows: it would be compiled, for 3 to 5 s of the first binary.
        own = [] if PLATFORMS[target].suffix == ".dll" else ["-rtlib=none"]
        return [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[target].target, *own], f"zig {version('ziglang')}"
    compiler = find_compiler() if target == host_platform() else None
    if compiler is None:
        fail("L0721", f"there is no compiler for {target}", None, 'pip install "lagrangia[fmu]" brings one for all platforms')
    return list(compiler.command), compiler.identity


def _build(identifier: str, sources: Mapping[str, str], target: str, headers: Path,
           tell: Callable[[str], None] | None) -> bytes:
    compiler = _Compiler(target, headers)
    own = {name: text for name, text in sources.items() if name in _GENERATED}
    kind = PLATFORMS[target]
    flags = [f"-Wl,-install_name,@rpath/{identifier}.dylib"] if kind.suffix == ".dylib" else []
    key = f"{target}-{compiler.key(sources, [identifier, *flags])}"
    if (kept := find_kept("fmu", key)) is not None:
        return kept
    objects = _objects(compiler, {name: text for name, text in sources.items() if name not in _GENERATED}, tell)
    with tempfile.TemporaryDirectory(prefix="lagrangia-fmu-") as folder:
        for name, text in sources.items():
            if name in own or name.endswith(".h"):
                (Path(folder) / name).write_text(text, encoding="utf-8")
        library = f"{identifier}{kind.suffix}"
        linked = sorted((str(file) for folder in objects for file in folder.glob("*.o")), key=os.path.basename)
        compiler.link(library, [name for name in own if name.endswith(".c")], [*flags, *linked], folder)
        built = (Path(folder) / library).read_bytes()
    keep("fmu", key, built)
    return built


def _objects(compiler: "_Compiler", shared: Mapping[str, str], tell: Callable[[str], None] | None) -> list[Path]:
    """Folders with the run time and the glue of one version, which are compiled once for all scenes.

    zig makes one object of all files for Darwin, out of which hidden functions cannot be called: there they stay together.
    """
    common = {name: text for name, text in shared.items() if not name.startswith(_OF_ONE_VERSION)}
    headers = {name: text for name, text in common.items() if name.endswith(".h")}
    parts = [common, headers | {name: text for name, text in shared.items() if name not in common}]
    if PLATFORMS[compiler.platform].suffix == ".dylib":
        parts = [dict(shared)]
    folders = [cache_folder() / f"fmu-{compiler.platform}-{compiler.key(part)}" for part in parts]
    if tell is not None and not folders[0].is_dir():
        tell(f"compiling the run time for {compiler.platform}, the first time")
    for part, folder in zip(parts, folders, strict=True):
        if not folder.is_dir():
            _compile_objects(compiler, part, folder)
    return folders


def _compile_objects(compiler: "_Compiler", sources: Mapping[str, str], objects: Path) -> None:
    """All of the run time in one go; the folder appears when it is whole."""
    folder = Path(tempfile.mkdtemp(prefix=f".{objects.name}-", dir=objects.parent))
    try:
        for name, text in sources.items():
            (folder / name).write_text(text, encoding="utf-8")
        files = [file.name for file in joined([folder / name for name in sorted(sources) if name.endswith(".c")], folder)]
        compiler.compile(files, str(folder))
        with contextlib.suppress(OSError):  # another process was quicker
            os.rename(folder, objects)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class _Compiler:
    """The compiler for a platform: zig where it is installed, for the same bytes on every machine."""

    def __init__(self, target: str, headers: Path) -> None:
        self.platform = target
        command, self.identity = _command(target)
        self.command = [*command, *_FLAGS, *PLATFORMS[target].flags, f"-I{headers}"]

    def key(self, sources: Mapping[str, str], options: Sequence[str] = ()) -> str:
        what = (sorted(sources.items()), _FLAGS, PLATFORMS[self.platform], _FOR_WINDOWS, _START, self.identity, options)
        return hashlib.sha256(repr(what).encode()).hexdigest()[:32]

    def compile(self, files: Sequence[str], folder: str) -> None:
        """Objects beside the files."""
        if PLATFORMS[self.platform].suffix == ".dll":  # zig would make one object of them, which it cannot
            for name in files:
                self._run(["-c", name, "-o", f"{name}.o"], folder)
        else:
            self._run(["-c", *files], folder)

    def link(self, library: str, files: Sequence[str], others: Sequence[str], folder: str) -> None:
        """A library of C files, objects and what flags name."""
        libraries: tuple[str, ...] = ("-lm",)
        if self.identity.startswith("zig") and PLATFORMS[self.platform].suffix == ".dll":
            (Path(folder) / "start.c").write_text(_START, encoding="utf-8")
            self.compile([*files, "start.c"], folder)  # without a library there are no headers either
            files, libraries = [f"{name}.o" for name in (*files, "start.c")], _FOR_WINDOWS
        self._run(["-shared", "-o", library, *files, *others, *libraries], folder)

    def _run(self, arguments: Sequence[str], folder: str) -> None:
        full = [*self.command, *arguments]
        done = subprocess.run(full, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise CompilerError(full, done.stderr or done.stdout)
