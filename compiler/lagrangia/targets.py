"""Files of results: written beside the target, and given its name when all is well."""

import errno
import os
import tempfile
from pathlib import Path
from typing import IO, Any, Self

from lagrangia.diagnostics import fail


class Target:
    """A file that takes its name when all is well, so that a run that is killed leaves an older result as it was.

    A link is followed; what is no file (a device, a named pipe) is written to directly, for a file must not take its place.
    Use it in a `with` statement. Raises LagError L0004 when the place cannot be written.
    """

    def __init__(self, path: Path, binary: bool = False) -> None:
        self.path, self.target = path, path.resolve()
        self.temporary: Path | None = None
        try:
            self.stream = self._open(binary)
        except OSError as error:
            fail("L0004", f"'{path}' cannot be written: {error.strerror}")

    def _open(self, binary: bool) -> IO[Any]:
        encoding, newline, mode = (None, None, "wb") if binary else ("utf-8", "", "w")
        if self.target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if self.target.exists() and not self.target.is_file():
            return self.target.open(mode, encoding=encoding, newline=newline)
        handle, name = tempfile.mkstemp(prefix=f".{self.target.name[:100]}.", suffix=".part", dir=self.target.parent)
        self.temporary = Path(name)
        return os.fdopen(handle, mode, encoding=encoding, newline=newline)

    def put(self, text: str) -> None:
        """Raises OSError with the name people know: a full disk is no fault of the input."""
        try:
            self.stream.write(text)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.path)) from None

    def abandon(self) -> None:
        """Leaves everything as it was."""
        self.stream.close()
        if self.temporary is not None:
            self.temporary.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        try:
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


def quoted(name: str) -> str:
    """A cell of a CSV file."""
    return '"' + name.replace('"', '""') + '"' if any(c in name for c in ',"\n') else name
