"""C -> shared library: finding a compiler, building once, keeping the result.

The cache is a folder of folders, one for each library ever built: `<name>-<key>/` holds the library and the SHA-256 of its
bytes; `objects/` holds objects to be linked. The key is the hash of everything the result depends on: sources, headers, flags
and compiler. A library is built in a folder of another name and renamed, so that whoever sees the folder sees it whole, and two
processes may build the same library at the same time: the second one keeps the first one's.
"""

import contextlib
import errno
import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
import weakref
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from sysconfig import get_platform

from lagrangia.base.diagnostics import fail
from lagrangia.base.folders import cache_folder, has_room, is_trusted, make_private, note_use, put, remove
from lagrangia.base.records import dataclass
from lagrangia.native import prebuilt

_MOST_LINES = 20
_NO_COMPILER = ((), ("none",))  # what LAGRANGIA_CC says then
_ATTEMPTS = 10  # to put a library in its place, where others put it or damage it at the same time


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

    @property
    def is_zig(self) -> bool:
        """Whether it is zig, which compiles for other platforms too."""
        return any("zig" in word for word in self.command)

    def works(self) -> bool:
        """Whether it builds an empty library. A success is remembered in the cache."""
        try:
            build("probe", prebuilt.PROBE, compiler=self)
        except CompilerError:
            return False
        except OSError as error:
            if error.errno == errno.ENOSPC:
                raise  # with room, it may well work
            return False
        return True


def _ziglang() -> str | None:
    spec = find_spec("ziglang")
    return spec.origin if spec else None


def is_compiler_named() -> bool:
    """Whether LAGRANGIA_CC asks for a compiler. Raises LagError L0706 where it, or CC, holds no command."""
    _words("CC", os.environ.get("CC", ""))
    return _words("LAGRANGIA_CC", os.environ.get("LAGRANGIA_CC", "")) not in _NO_COMPILER


def _candidates() -> Iterator[Compiler]:
    chosen = os.environ.get("LAGRANGIA_CC")
    if chosen is not None:
        if (words := _words("LAGRANGIA_CC", chosen)) not in _NO_COMPILER:
            yield Compiler(words)
        return
    yield from map(Compiler, prebuilt.candidates(_words("CC", os.environ.get("CC", ""))))


def _words(variable: str, command: str) -> tuple[str, ...]:
    """Raises LagError L0706 for what no shell would take."""
    try:
        return tuple(shlex.split(command))
    except ValueError as error:
        fail("L0706", f"the environment variable {variable} holds no command: {command} ({str(error).lower()})", None,
             "it names a C compiler, with options if need be: gcc, or '/opt/my tools/cc' -m64")


def find_compiler() -> Compiler | None:
    """The first of $LAGRANGIA_CC ("none": pretend there is none), $CC, cc, gcc, clang and PyPI's ziglang that works."""
    return next((compiler for compiler in _candidates() if compiler.works()), None)


def _require_success(command: Sequence[str], process: "subprocess.Popen[str]") -> None:
    output, _ = process.communicate()
    if process.returncode != 0:
        raise CompilerError(command, output)


class _Work:
    """Commands running side by side in a folder of their own. `close` ends and removes them; so does the end of Python."""

    def __init__(self, name: str, cache: Path) -> None:
        with _told_where(cache):
            self.folder = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=cache))
        self._cache = cache
        self._running: list[tuple[Sequence[str], subprocess.Popen[str]]] = []
        self.close = weakref.finalize(self, _abandon, self.folder, self._running)

    def start(self, command: Sequence[str]) -> None:
        """Raises CompilerError."""
        try:
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self.folder)
        except OSError as error:
            self.close()
            raise CompilerError(command, str(error)) from error
        self._running.append((command, process))

    def wait(self) -> None:
        """Raises CompilerError; OSError where the disk is full."""
        try:
            for command, process in self._running:
                _require_success(command, process)
        except CompilerError as error:
            if os.strerror(errno.ENOSPC) in error.output or not has_room(self._cache):
                raise _no_room(self._cache) from error
            raise


def _no_room(cache: Path) -> OSError:
    return OSError(errno.ENOSPC, "no room for compiled code, or for temporary files (LAGRANGIA_CACHE names another folder)",
                   str(cache))


@contextlib.contextmanager
def _told_where(cache: Path) -> Iterator[None]:
    """A full disk, or a quota, by the name of the folder."""
    try:
        yield
    except OSError as error:
        raise _no_room(cache) if error.errno in (errno.ENOSPC, errno.EDQUOT) else error from None


def _abandon(folder: Path, running: Sequence[tuple[Sequence[str], "subprocess.Popen[str]"]]) -> None:
    for _, process in running:
        if process.poll() is None:
            process.kill()
            process.wait()
    shutil.rmtree(folder, ignore_errors=True)


class Objects:
    """Objects of sources, each kept by what it depends on. `start` makes those that are missing, on all cores, `finish` waits."""

    def __init__(self, sources: Sequence[Path], include: Sequence[Path], level: str, compiler: Compiler) -> None:
        self._folder = cache_folder() / "objects"
        self._command = [*compiler.command, *_options(level), *(f"-I{folder}" for folder in include), "-c"]
        self._cores = os.cpu_count() or 1
        base = _base(include, _options(level), compiler)
        self._places = {file: self._folder / f"{file.stem}-{_hashed([base, file.read_bytes()])}.o" for file in sources}
        self._work: _Work | None = None

    @property
    def paths(self) -> list[Path]:
        """In the order of the sources; they are there after `finish`."""
        return list(self._places.values())

    def start(self) -> None:
        """Raises CompilerError."""
        missing = [file for file, place in self._places.items() if not _is_whole(place)]
        if self._work is None and missing:
            self._work = _Work("objects", self._folder.parent)
            for k in range(min(self._cores, len(missing))):
                self._work.start([*self._command, *map(str, missing[k :: self._cores])])

    def finish(self) -> None:
        """Raises CompilerError."""
        self.start()
        if self._work is None:
            return
        try:
            self._work.wait()
            with _told_where(self._folder.parent):
                self._keep(self._work.folder)
        finally:
            self._work.close()
            self._work = None

    def _keep(self, made: Path) -> None:
        """Renamed into their places, never written there: a link in one would lead to what is not the cache's."""
        make_private(self._folder)
        for file, place in self._places.items():
            if (built := made / f"{file.stem}.o").exists():
                _digest_file(built).write_text(_digest(built))
                put(built, place)
                put(_digest_file(built), _digest_file(place))


class Build:
    """A library in the making. `finish` waits for it; builds that were started together run at the same time."""

    def __init__(self, name: str, sources: str | Sequence[Path], include: Sequence[Path], level: str, compiler: Compiler,
                 objects: Sequence[Objects] = ()) -> None:
        options = _options(level)
        linked = [path for made in objects for path in made.paths]
        self._library = _place(name, sources, linked, include, options, compiler)
        self._work: _Work | None = None
        if _is_whole(self._library):
            return
        for made in objects:
            made.finish()
        self._cache = self._library.parent.parent
        self._work = _Work(name, self._cache)
        with _told_where(self._cache):
            files = [*self._written(self._work, name, sources), *linked]
        self._work.start([*compiler.command, *options, *(f"-I{folder}" for folder in include),
                          "-o", str(self._work.folder / self._library.name), *map(str, files), *prebuilt.LIBRARIES])

    @staticmethod
    def _written(work: _Work, name: str, sources: str | Sequence[Path]) -> Sequence[Path]:
        if not isinstance(sources, str):
            return prebuilt.joined(sources, work.folder)
        file = work.folder / f"{name}.c"
        file.write_text(sources, encoding="utf-8")
        return [file]

    def finish(self) -> Path:
        """The library's path. Raises CompilerError."""
        if self._work is not None:
            try:
                self._work.wait()
                made = self._work.folder / self._library.name
                with _told_where(self._cache):
                    _digest_file(made).write_text(_digest(made))
                    self._install(self._work.folder)
            finally:
                self._work.close()
                self._work = None
        return self._library

    def cancel(self) -> None:
        """Ends the compiler, if it is still at work."""
        if self._work is not None:
            self._work.close()

    def _install(self, made: Path) -> None:
        folder = self._library.parent
        for attempt in range(_ATTEMPTS):
            if _is_whole(self._library):
                return
            try:
                os.rename(made, folder)
            except OSError:
                if not os.path.lexists(folder) or attempt == _ATTEMPTS - 1:
                    raise
                if not _is_whole(self._library):
                    remove(folder)


def build(
    name: str,
    sources: str | Sequence[Path],
    *,
    include: Sequence[Path] = (),
    level: str = "-O2",
    compiler: Compiler | None = None,
    objects: Sequence[Objects] = (),
) -> Path:
    """Build a shared library, or find it in the cache.

    `sources` is the text of one C file, or paths; `include` are the folders of headers, `level` is -O0 … -O3, `objects` are
    finished and linked too, when the library is not there. Raises CompilerError; also when there is no compiler at all.
    """
    return start_build(name, sources, include=include, level=level, compiler=compiler, objects=objects).finish()


def start_build(
    name: str,
    sources: str | Sequence[Path],
    *,
    include: Sequence[Path] = (),
    level: str = "-O2",
    compiler: Compiler | None = None,
    objects: Sequence[Objects] = (),
) -> Build:
    """Like `build`, but does not wait for the compiler."""
    return Build(name, sources, include, level, compiler or require_compiler(), objects)


def require_compiler() -> Compiler:
    """Raises CompilerError when there is none."""
    compiler = find_compiler()
    if compiler is None:
        raise CompilerError(["cc"], "no C compiler was found; `pip install ziglang` brings one")
    return compiler


def has_builds(name: str) -> bool:
    """Whether any library of this name was ever built."""
    return next(cache_folder().glob(f"{name}-*"), None) is not None


def find_build(
    name: str, sources: str | Sequence[Path], *, include: Sequence[Path], level: str, compiler: Compiler
) -> Path | None:
    """The library, if it was built before."""
    library = _place(name, sources, (), include, _options(level), compiler)
    return library if _is_whole(library) else None


def _place(name: str, sources: str | Sequence[Path], objects: Sequence[Path], include: Sequence[Path], options: Sequence[str],
           compiler: Compiler) -> Path:
    texts = [sources.encode()] if isinstance(sources, str) else [file.read_bytes() for file in sources]
    names = [file.name.encode() for file in objects]  # they tell the content
    return cache_folder() / f"{name}-{_hashed([_base(include, options, compiler), *texts, *names])}" / f"{name}{prebuilt.SUFFIX}"


def _base(include: Sequence[Path], options: Sequence[str], compiler: Compiler) -> bytes:
    """What a result depends on beside its sources."""
    headers = [header.read_bytes() for folder in include for header in sorted(folder.rglob("*.h"))]
    return _hashed([repr((tuple(options), compiler.identity, get_platform())).encode(), *headers]).encode()


def _hashed(texts: Sequence[bytes]) -> str:
    hashed = hashlib.sha256()
    for text in texts:
        hashed.update(hashlib.sha256(text).digest())
    return hashed.hexdigest()[:32]


def _options(level: str) -> tuple[str, ...]:
    return (*prebuilt.FLAGS, "-shared", *prebuilt.flags_of(prebuilt.kind_here()), level)


def _digest(library: Path) -> str:
    return hashlib.sha256(library.read_bytes()).hexdigest()


def _digest_file(library: Path) -> Path:
    return library.with_suffix(".sha256")


def _is_whole(library: Path) -> bool:
    """Whether the library is there with the bytes it was built with. A truncated one would crash whoever loads it."""
    try:
        if not all(map(is_trusted, (library.parent, library, _digest_file(library)))):
            return False
        note_use(library)
        return _digest_file(library).read_bytes() == _digest(library).encode()
    except OSError:
        return False
