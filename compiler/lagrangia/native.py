"""C -> shared library: finding a compiler, building once, keeping the result.

The cache is a folder of folders, one for each library ever built: `<name>-<key>/` holds the library and the SHA-256 of its
bytes. The key is the hash of everything the result depends on: sources, headers, flags and compiler. A library is built in
a folder of another name and renamed, so that whoever sees the folder sees it whole, and two processes may build the same
library at the same time: the second one keeps the first one's.
"""

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from sysconfig import get_platform

from lagrangia.folders import cache_folder, data_folder

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# No contraction and no -ffast-math: the same digits on every machine, and the compensated sums of the run time stay intact.
_FLAGS = ("-std=c99", "-shared", "-ffp-contract=off", "-fno-math-errno", "-fvisibility=hidden")
_PLATFORM_FLAGS = () if sys.platform == "win32" else ("-fPIC",)
_LIBRARIES = () if sys.platform == "win32" else ("-lm",)
_MOST_LINES = 20


class CompilerError(Exception):
    """The C compiler refused: `command`, and the first lines of its `output`."""

    def __init__(self, command: Sequence[str], output: str) -> None:
        self.command = tuple(command)
        self.output = "\n".join(output.splitlines()[:_MOST_LINES])
        super().__init__(f"{shlex.join(self.command)}\n{self.output}")


@dataclass(frozen=True)
class Compiler:
    """A command that understands the options of cc."""

    command: tuple[str, ...]

    @property
    def identity(self) -> str:
        """Changes when the compiler does. Looks at its file only: running it would cost more than loading a library."""
        file = _ziglang() if "ziglang" in self.command else shutil.which(self.command[0])
        stat = os.stat(os.path.realpath(file)) if file else None
        return repr((self.command, file, stat and (stat.st_size, stat.st_mtime_ns)))

    def works(self) -> bool:
        """Whether it builds an empty library. A success is remembered in the cache."""
        try:
            build("probe", "int lag_probe(void);\nint lag_probe(void) { return 0; }\n", compiler=self)
        except (CompilerError, OSError):
            return False
        return True


def _ziglang() -> str | None:
    spec = find_spec("ziglang")
    return spec.origin if spec else None


def _candidates() -> Iterator[Compiler]:
    chosen = os.environ.get("LAGRANGIA_CC")
    if chosen is not None:
        if chosen not in ("", "none"):
            yield Compiler(tuple(shlex.split(chosen)))
        return
    for command in (os.environ.get("CC"), "cc", "gcc", "clang"):
        if command and shutil.which(shlex.split(command)[0]):
            yield Compiler(tuple(shlex.split(command)))
    if _ziglang():
        yield Compiler((sys.executable, "-m", "ziglang", "cc"))


def find_compiler() -> Compiler | None:
    """The first of $LAGRANGIA_CC ("none": pretend there is none), $CC, cc, gcc, clang and PyPI's ziglang that works."""
    return next((compiler for compiler in _candidates() if compiler.works()), None)


def _require_success(command: Sequence[str], process: "subprocess.Popen[str]") -> None:
    output, _ = process.communicate()
    if process.returncode != 0:
        raise CompilerError(command, output)


def _parts(files: Sequence[str], compiler: Compiler) -> list[Sequence[str]]:
    """Sources by the core that compiles them; none where one command does it all: zig is parallel by itself."""
    cores = 1 if any("zig" in word for word in compiler.command) else os.cpu_count() or 1
    return [files[k::cores] for k in range(min(cores, len(files)))] if cores > 1 and len(files) > 1 else []


class Build:
    """A library in the making, on all cores when it has several sources. `finish` waits for it; builds that were started
    together run at the same time."""

    def __init__(self, name: str, sources: str | Sequence[Path], include: Sequence[Path], level: str, compiler: Compiler) -> None:
        self.compiler = compiler
        options = _options(level)
        self._library = _place(name, sources, include, level, compiler)
        self._folder = self._library.parent
        self._processes: list[subprocess.Popen[str]] = []
        if _is_whole(self._library):
            return
        self._workplace = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=self._folder.parent))
        begin = [*compiler.command, *options, *(f"-I{folder}" for folder in include)]
        end = ["-o", str(self._workplace / self._library.name)]
        files = [str(file) for file in self._written(name, sources)]
        parts = _parts(files, compiler)
        self._commands = [[*begin, "-c", *part] for part in parts] or [[*begin, *end, *files, *_LIBRARIES]]
        self._link = [*begin, *end, *(f"{Path(file).stem}.o" for file in files), *_LIBRARIES] if parts else []
        try:
            self._processes = [self._started(command) for command in self._commands]
        except OSError as error:
            shutil.rmtree(self._workplace)
            raise CompilerError(self._commands[0], str(error)) from error

    def _started(self, command: Sequence[str]) -> "subprocess.Popen[str]":
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self._workplace)

    def _written(self, name: str, sources: str | Sequence[Path]) -> Sequence[Path]:
        if not isinstance(sources, str):
            return sources
        file = self._workplace / f"{name}.c"
        file.write_text(sources, encoding="utf-8")
        return [file]

    def finish(self) -> Path:
        """The library's path. Raises CompilerError."""
        if not self._processes:
            return self._library
        try:
            for command, process in zip(self._commands, self._processes, strict=True):
                _require_success(command, process)
            if self._link:
                _require_success(self._link, self._started(self._link))
            _digest_file(self._workplace / self._library.name).write_text(_digest(self._workplace / self._library.name))
            for file in self._workplace.glob("*.o"):
                file.unlink()
            self._install()
        finally:
            shutil.rmtree(self._workplace, ignore_errors=True)
            self._processes = []
        return self._library

    @property
    def is_gone(self) -> bool:
        """Whether nothing is being built any more and the library is not there: it failed, or somebody deleted it."""
        return not self._processes and not _is_whole(self._library)

    def cancel(self) -> None:
        """Ends the compiler, if it is still at work."""
        running = [process for process in self._processes if process.poll() is None]
        for process in running:
            process.kill()
        if running:
            shutil.rmtree(self._workplace, ignore_errors=True)

    def _install(self) -> None:
        while not _is_whole(self._library):
            try:
                os.rename(self._workplace, self._folder)
            except OSError:
                if not self._folder.exists():
                    raise
                if not _is_whole(self._library):
                    shutil.rmtree(self._folder, ignore_errors=True)


def build(
    name: str,
    sources: str | Sequence[Path],
    *,
    include: Sequence[Path] = (),
    level: str = "-O2",
    compiler: Compiler | None = None,
) -> Path:
    """Build a shared library, or find it in the cache.

    `sources` is the text of one C file, or paths; `include` are the folders of headers, `level` is -O0 … -O3.
    Raises CompilerError; also when there is no compiler at all.
    """
    return start_build(name, sources, include=include, level=level, compiler=compiler).finish()


def start_build(
    name: str,
    sources: str | Sequence[Path],
    *,
    include: Sequence[Path] = (),
    level: str = "-O2",
    compiler: Compiler | None = None,
) -> Build:
    """Like `build`, but does not wait for the compiler."""
    compiler = compiler or find_compiler()
    if compiler is None:
        raise CompilerError(["cc"], "no C compiler was found; `pip install ziglang` brings one")
    return Build(name, sources, include, level, compiler)


def start_runtime_build(compiler: Compiler | None = None, level: str = "-O2") -> Build:
    """The run time, as one library for all scenes: a process builds it once, however many scenes ask for it meanwhile."""
    build = _runtime_build(cache_folder(), compiler, level)
    if build.is_gone:
        _runtime_build.cache_clear()
        build = _runtime_build(cache_folder(), compiler, level)
    return build


@cache
def _runtime_build(_cache: Path, compiler: Compiler | None, level: str) -> Build:
    folder = data_folder("runtime")
    return start_build("runtime", sorted(folder.glob("*.c")), include=[folder], level=level, compiler=compiler)


def find_build(
    name: str, sources: str | Sequence[Path], *, include: Sequence[Path], level: str, compiler: Compiler
) -> Path | None:
    """The library, if it was built before."""
    library = _place(name, sources, include, level, compiler)
    return library if _is_whole(library) else None


def _place(name: str, sources: str | Sequence[Path], include: Sequence[Path], level: str, compiler: Compiler) -> Path:
    return cache_folder() / f"{name}-{_key(sources, include, _options(level), compiler)}" / f"{name}{_SUFFIX}"


def _options(level: str) -> tuple[str, ...]:
    return (*_FLAGS, *_PLATFORM_FLAGS, level)


def _key(sources: str | Sequence[Path], include: Sequence[Path], options: Sequence[str], compiler: Compiler) -> str:
    hashed = hashlib.sha256(repr((options, compiler.identity, get_platform())).encode())
    texts = [sources.encode()] if isinstance(sources, str) else [file.read_bytes() for file in sources]
    headers = [header.read_bytes() for folder in include for header in sorted(folder.glob("*.h"))]
    for text in (*texts, *headers):
        hashed.update(hashlib.sha256(text).digest())
    return hashed.hexdigest()[:32]


def _digest(library: Path) -> str:
    return hashlib.sha256(library.read_bytes()).hexdigest()


def _digest_file(library: Path) -> Path:
    return library.with_suffix(".sha256")


def _is_whole(library: Path) -> bool:
    """Whether the library is there with the bytes it was built with. A truncated one would crash whoever loads it."""
    try:
        return _digest_file(library).read_text() == _digest(library)
    except OSError:
        return False
