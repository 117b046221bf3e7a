"""What cost time to make, kept in files: `<kind>/<key>` under the cache folder, the SHA-256 of the content in the first line.

A file is written beside its place and renamed, so that whoever finds it finds it whole; one that was damaged since is not found.
"""

import contextlib
import hashlib
import os
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from lagrangia.base.folders import cache_folder, data_folder, is_trusted, make_private, note_use, put, remove, stamps
from lagrangia.base.records import dataclass

_KINDS = ("scenes", "syntax", "objects", "texts")  # folders of files
_DAY = 86_400.0  # seconds


def find_kept(kind: str, key: str) -> bytes | None:
    """What was kept, or None."""
    place = cache_folder() / kind / key
    try:
        if not is_trusted(place) or not is_trusted(place.parent):
            return None
        digest, _, content = place.read_bytes().partition(b"\n")
    except OSError:
        return None
    with contextlib.suppress(OSError):
        note_use(place)
    return content if digest == _digest(content) else None


def keep(kind: str, key: str, content: bytes) -> None:
    """A full or unwritable disk is no error: the next who asks makes it again."""
    import tempfile

    with contextlib.suppress(OSError):
        folder = cache_folder() / kind
        make_private(folder)
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(_digest(content) + b"\n" + content)
            put(Path(temporary), folder / key)
        except OSError:
            os.unlink(temporary)


def prune(most: int = 1 << 30) -> None:
    """Once a day: what has not been used for longest is removed until at most so many bytes are left, and what killed
    compilations left behind. What cannot be removed stays."""
    folder = cache_folder()
    stamp, now = folder / ".pruned", time.time()
    with contextlib.suppress(OSError):
        if stamp.exists() and now - stamp.stat().st_mtime < _DAY:
            return
        if stamp.is_symlink():
            remove(stamp)
        stamp.touch(mode=0o600)
        found = [entry for path in _entries(folder) if (entry := _Entry.of(path))]
        left = sum(entry.size for entry in found)
        for entry in sorted(found, key=lambda entry: entry.used):
            is_stray = entry.path.name.startswith(".") or entry.path.suffix == ".part"
            if left > most or (is_stray and now - entry.used > _DAY):
                remove(entry.path)
                left -= entry.size


@dataclass(frozen=True)
class _Entry:
    path: Path
    size: int  # bytes
    used: float  # seconds since the epoch

    @classmethod
    def of(cls, path: Path) -> "_Entry | None":
        """None for what another process has removed meanwhile. Links are not followed."""
        try:
            is_folder = path.is_dir() and not path.is_symlink()
            stats = [file.lstat() for file in (path.rglob("*") if is_folder else [path])]
            used = max((max(stat.st_mtime, stat.st_atime) for stat in stats), default=path.lstat().st_mtime)
        except OSError:
            return None
        return cls(path, sum(stat.st_size for stat in stats), used)


def _entries(folder: Path) -> Iterator[Path]:
    """Libraries with their folders, and kept files; nothing that a link leads to."""
    for path in folder.iterdir():
        if path.name in _KINDS and path.is_dir() and not path.is_symlink():
            yield from path.iterdir()
        elif path.name != ".pruned":
            yield path


def key_of(*what: object) -> str:
    """A name for the file of what follows from `what` and from this installation of the compiler."""
    return hashlib.sha256(repr((what, _installation())).encode()).hexdigest()[:32]


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


@cache
def _installation() -> str:
    """Changes with every file of the compiler, its grammar and its library."""
    found = (stamps(Path(__file__).parents[1], ".py"), stamps(data_folder("grammar"), ".lark"),
             stamps(data_folder("models") / "library", ".lag"))
    return hashlib.sha256(repr(found).encode()).hexdigest()
