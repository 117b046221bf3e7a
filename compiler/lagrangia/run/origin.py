"""The file that something was read from: it is found from other working folders, too, and told where its text is another one by
now, for what is made of it later would go with another model than what was made before."""

import hashlib
import os
from pathlib import Path
from typing import Any

from lagrangia.base.checked_values import a_path
from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import require_file


class Origin:
    """A file as it is now, or, of what was pickled, as it was then: `digest` is the SHA-256 of its text, None where it could not
    be read, which who compiles it tells."""

    def __init__(self, path: Path, digest: str | None = None) -> None:
        self._given, self._folder = path, None if path.is_absolute() else os.getcwd()
        self._digest = digest if digest is not None else _digest_if_any(path)

    @property
    def path(self) -> Path:
        """As it was given, where that leads there still, else in full."""
        return self._given if self._folder in (None, _working_folder()) else Path(str(self._folder), self._given)

    def unchanged(self) -> Path:
        """The path. Raises LagError L0001 where the text is another one by now."""
        path = self.path
        if self._digest is not None and _digest_if_any(path) not in (None, self._digest):
            fail("L0001", f"'{path}' has changed since it was loaded", None,
                 "load it again: what was made of it before goes with the text as it was")
        return path

    def __reduce__(self) -> tuple[Any, ...]:
        """In full: it may be unpickled in another folder."""
        return Origin, (self.path.absolute(), self._digest)


def origin_of(place: str | os.PathLike[str] | Origin) -> Origin:
    """Of a path, or what is one already."""
    return place if isinstance(place, Origin) else Origin(a_path(place))


def digest_of(path: Path) -> str:
    """Raises OSError, also for what is no file."""
    require_file(path)
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _digest_if_any(path: Path) -> str | None:
    try:
        return digest_of(path)
    except (OSError, ValueError):  # a zero in a name
        return None


def _working_folder() -> str | None:
    try:
        return os.getcwd()
    except FileNotFoundError:  # removed
        return None
