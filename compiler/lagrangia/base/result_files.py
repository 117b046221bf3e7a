"""Files that are read, opened with care, and files of results: written beside the target, and given its name when all is well;
never in the place of what is read."""

import contextlib
import errno
import os
import re
import stat
import sys
from array import array
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import IO, Any, Self

from lagrangia.base.diagnostics import fail


def open_with_care(path: str, flags: int) -> int:
    """As `opener` of open(): a device is refused (it may never end), and a pipe into which nobody writes is empty, and not waited
    for. Raises OSError.
    """
    handle = os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    kind = os.fstat(handle).st_mode
    if stat.S_ISREG(kind) or stat.S_ISFIFO(kind):
        if hasattr(os, "O_NONBLOCK"):
            os.set_blocking(handle, True)
        return handle
    os.close(handle)
    if stat.S_ISDIR(kind):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), path)
    raise OSError(errno.ENODEV, "it is a device, not a file", path)


def require_file(path: Path) -> None:
    """For what is read more than once, or not from its beginning: a link is followed, a pipe refused. Raises OSError."""
    kind = path.stat().st_mode
    if stat.S_ISDIR(kind):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(kind):
        what = "a pipe" if stat.S_ISFIFO(kind) else "a socket" if stat.S_ISSOCK(kind) else "a device"
        raise OSError(errno.ENODEV, f"it is {what}, not a file", str(path))


_OPEN_FILES = "/proc/self/fd"
_MOST_LINKS = 40


def _opened(path: Path) -> Path | None:
    """The name among those of open files (/proc/1/fd/3, on macOS /dev/fd/3) that a path leads to, as /dev/stdout does; None where
    it leads elsewhere."""
    for _ in range(_MOST_LINKS):
        folder = os.path.realpath(path.parent)
        if re.fullmatch(r"/proc/\d+/(task/\d+/)?fd|/dev/fd", folder):
            return Path(folder, path.name)
        if not os.path.islink(path):
            return None
        path = path.parent / os.readlink(path)
    return None


def _open_again(opened: Path) -> int:
    """Goes on with an open file where it is, and cuts nothing short. Raises OSError."""
    if opened.parent in (Path("/dev/fd"), Path(os.path.realpath(_OPEN_FILES))) and opened.name.isdecimal():
        handle = os.dup(int(opened.name))
    else:
        handle = os.open(opened, os.O_WRONLY | os.O_APPEND)
    try:
        os.write(handle, b"")  # refused where it is open for reading alone
    except OSError:
        os.close(handle)
        raise
    return handle


def _nameless(folder: Path) -> int | None:
    """A new file in a folder, which is gone with the process unless it is linked to a name; None where there are none such."""
    if not hasattr(os, "O_TMPFILE") or not os.path.isdir(_OPEN_FILES):
        return None
    try:
        return os.open(folder, os.O_TMPFILE | os.O_RDWR, 0o600)
    except OSError:  # not of this file system
        return None


class Target:
    """A file that takes its name when all is well, so that a run that is killed leaves an older result as it was.

    A link is followed; what is no file (a device, a named pipe), or is open already (/dev/stdout), is written to directly, for a
    file must not take its place.
    Use it in a `with` statement. Raises LagError L0004 when the place cannot be written.
    """

    def __init__(self, path: Path, binary: bool = False, direct: bool = False) -> None:
        """`direct`: what is written is in its place at once."""
        self.path, self.direct = path, direct
        self.temporary: Path | None = None
        self.is_nameless = False
        try:
            self.target = path.resolve()
            self.stream = self._open(binary)
        except OSError as error:
            fail("L0004", f"'{path}' cannot be written: {error.strerror}")
        except RuntimeError:  # links that lead to each other
            fail("L0004", f"'{path}' cannot be written: {os.strerror(errno.ELOOP)}")

    def _open(self, binary: bool) -> IO[Any]:
        encoding, newline, mode = (None, None, "wb") if binary else ("utf-8", "", "w")
        if self.target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if (opened := _opened(self.path)) is not None:
            return os.fdopen(_open_again(opened), mode, encoding=encoding, newline=newline)
        with contextlib.suppress(FileNotFoundError):
            self.target.lstat()  # a name that is too long is told now
        if self.direct or (self.target.exists() and not self.target.is_file()):
            return self.target.open(mode, encoding=encoding, newline=newline)
        handle = _nameless(self.target.parent)
        if handle is None:
            handle = self._begin_beside()
        self.is_nameless = self.temporary is None
        return os.fdopen(handle, mode, encoding=encoding, newline=newline)

    def _begin_beside(self) -> int:
        """A new file beside the target, where no link is followed."""
        import tempfile

        handle, name = tempfile.mkstemp(prefix=self._prefix(), suffix=".part", dir=self.target.parent)
        self.temporary = Path(name)
        return handle

    def _prefix(self) -> str:
        """Of names beside the target, so short that they are no longer than a file system takes: 255 bytes, as a rule."""
        return f".{os.fsencode(self.target.name)[:100].decode(errors='ignore')}."

    def put(self, *parts: str | bytes) -> None:
        """Text, or bytes where it is binary. Raises OSError with the name people know: a full disk is no fault of the input."""
        self.put_all(parts)

    def put_all(self, parts: Iterable[str | bytes]) -> None:
        """One after the other, without putting them together before. Raises OSError likewise."""
        try:
            self.stream.writelines(parts)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.path)) from None

    def abandon(self) -> None:
        """Leaves everything as it was."""
        self.stream.close()
        if self.temporary is not None:
            self.temporary.unlink(missing_ok=True)

    def _name(self) -> None:
        """Gives what has none a name beside the target."""
        import shutil

        self.stream.flush()
        handle = self.stream.fileno()
        temporary = self.target.with_name(f"{self._prefix()}{os.getpid()}.{handle}.part")
        temporary.unlink(missing_ok=True)
        try:
            os.link(f"{_OPEN_FILES}/{handle}", temporary, src_dir_fd=handle)  # without a folder it would link the link
        except OSError:  # links may be forbidden where nameless files are not
            with open(self._begin_beside(), "wb") as copy, open(f"{_OPEN_FILES}/{handle}", "rb") as whole:
                shutil.copyfileobj(whole, copy)
        else:
            self.temporary = temporary

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        try:
            if kind is None and self.is_nameless:
                self._name()
            self.stream.close()
            if kind is None and self.temporary is not None:
                _keep_mode(self.target, self.temporary)
                os.replace(self.temporary, self.target)
        except OSError as error:
            if kind is None:
                raise OSError(error.errno, error.strerror, str(self.path)) from None
        finally:
            if self.temporary is not None:
                self.temporary.unlink(missing_ok=True)


def _keep_mode(path: Path, temporary: Path) -> None:
    """The permissions a newly made file would have, or those of the file that is replaced."""
    mask = os.umask(0)
    os.umask(mask)
    temporary.chmod(path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~mask)


def is_device(path: str | os.PathLike[str]) -> bool:
    """A terminal, a named pipe, what is open already (/dev/stdout): what is written to as it is. A folder is none, and told of
    where it is to be written."""
    if _opened(Path(path)) is not None:
        return True
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def write_text(path: Path, text: str) -> None:
    """As a whole or not at all. Raises LagError L0004 where it cannot be written."""
    with Target(path) as target:
        target.put(text)


def keep_sources(written: str | os.PathLike[str], read: Iterable[str | os.PathLike[str]]) -> None:
    """Raises LagError L0004 where a result would take the place of what is read for it."""
    if os.path.isfile(written) and any(os.path.exists(source) and os.path.samefile(written, source) for source in read):
        fail("L0004", f"'{os.fspath(written)}' is read: a result does not take its place", None, "choose another name")


def keep_apart(written: Iterable[str | os.PathLike[str] | None], read: Iterable[str | os.PathLike[str]]) -> None:
    """Raises LagError L0004 where a result would take the place of what is read for it, or of any scene."""
    sources = list(read)
    for place in (path for path in written if path is not None and os.path.isfile(path)):
        keep_sources(place, sources)
        if Path(place).suffix.lower() == ".lag":
            fail("L0004", f"'{os.fspath(place)}' is a scene: a result does not take its place", None, "choose another name")


def require_kind(path: str | os.PathLike[str], *endings: str) -> None:
    """What the name ends in says what is in the file; a name that says nothing, or a device, takes what comes.

    Raises LagError L0004 for another kind.
    """
    ending = Path(path).suffix
    if re.match(r"\.[^\W\d]", ending) and ending.lower() not in endings and not is_device(path):
        fail("L0004", f"'{os.fspath(path)}' is no table that can be written", None,
             f"its name should end in {', '.join(endings)}")


def cells(values: Sequence[float | None]) -> str:
    """Numbers of a line of a CSV file: the fewest digits that tell each double from all others, nothing where there is no finite
    one. A library writes them: sixteen times as fast as Python, whose digits took three quarters of a large scene's run."""
    return written(values).replace(b"null", b"").decode()


def written(values: Sequence[float | None]) -> bytes:
    """Numbers with commas between them; null where there is no finite one."""
    import orjson  # which loads a dozen modules: for rows alone

    np = sys.modules.get("numpy")  # by which it takes half as long, and which is not loaded for that
    if np is not None and isinstance(values, array):
        return orjson.dumps(np.frombuffer(values), option=orjson.OPT_SERIALIZE_NUMPY)[1:-1]
    return orjson.dumps(list(values))[1:-1]


def quoted(name: str) -> str:
    """A cell of a CSV file."""
    return '"' + name.replace('"', '""') + '"' if any(c in name for c in ',"\n') else name


def require_parquet() -> tuple[Any, Any]:
    """pyarrow and its Parquet module. Raises LagError L0715."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        fail("L0715", "Parquet files need pyarrow, which is not installed", None, "pip install pyarrow, or write a .csv file")
    return pyarrow, parquet
