"""Where the data folders are (in a wheel beside the rooms, in a checkout two levels above them), and where results are kept."""

import contextlib
import os
import stat
import sys
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
_ROOM = 4 << 20  # bytes: the run time and a scene, twice over
_REMARKS: dict[str, bool] = {}  # warnings of folders and environment, and whether they are told
_KEEPERS: list[bool] = []  # while there are any, they wait


def data_folder(name: str) -> Path:
    """The folder `name` ("grammar", "runtime" or "models").

    `importlib.resources` is not used: with an editable install it would find a stale copy.
    Raises FileNotFoundError when the installation is broken.
    """
    for base in (_PACKAGE, _PACKAGE.parents[1]):
        folder = base / name
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the installation of lagrangia lacks its folder {name!r}")


def stamps(folder: str | Path, *endings: str) -> list[tuple[str, int, int]]:
    """Of the files with these endings in a folder and all those in it, in order: names, sizes and times of their last change,
    which tell sooner than contents whether something is another. Raises OSError."""
    found: list[tuple[str, int, int]] = []
    pending = [str(folder)]
    while pending:
        with os.scandir(pending.pop()) as entries:
            for entry in entries:
                if entry.name.endswith(endings):
                    now = entry.stat()
                    found.append((entry.path, now.st_size, now.st_mtime_ns))
                elif entry.name != "__pycache__" and entry.is_dir():
                    pending.append(entry.path)
    return sorted(found)


def cache_folder() -> Path:
    """Where libraries and other results are kept: $LAGRANGIA_CACHE, the system's place for caches, a private temporary one.

    The first that can be written to by its owner alone and has room; where none has, the first: what is there can still be used.
    """
    full: list[Path] = []
    for folder in _cache_candidates():
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            folder.mkdir(mode=0o700, exist_ok=True)
        except OSError:
            continue
        if not is_trusted(folder):
            _tell_untrusted(folder)
            continue
        if os.access(folder, os.W_OK | os.X_OK):
            if has_room(folder):
                return folder
            full.append(folder)
    temporary = _private_temporary_folder()
    return full[0] if full and not has_room(temporary) else temporary


def is_trusted(path: Path) -> bool:
    """Whether it is a file or a folder, and nobody else may have put there what is read: what is kept is loaded as machine code.
    Raises OSError."""
    found = path.stat()
    if not (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode)):
        return False  # nothing ever comes out of a pipe
    if not hasattr(os, "getuid"):
        return True
    is_shared = found.st_mode & 0o002 or (found.st_mode & 0o020 and found.st_gid != os.getgid())
    return found.st_uid in (os.getuid(), 0) and not is_shared


def remove(path: Path) -> None:
    """A file, a folder with all in it, or a link, which is not followed; what cannot be removed stays."""
    import shutil

    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with contextlib.suppress(OSError):
            path.unlink()


def make_private(folder: Path) -> None:
    """A folder of the cache; a file there, or a link to nowhere, gives way. Raises OSError."""
    if not folder.is_dir():
        remove(folder)
    folder.mkdir(mode=0o700, exist_ok=True)


def put(made: Path, place: Path) -> None:
    """A file in its place in the cache; a folder there gives way, a link is not followed. Raises OSError."""
    if place.is_dir() and not place.is_symlink():
        remove(place)
    os.replace(made, place)


def note_use(path: Path) -> None:
    """What is used stays in the cache, by its time of access: see store.prune. Raises OSError."""
    os.utime(path, ns=(time.time_ns(), path.stat().st_mtime_ns))


def _tell_untrusted(folder: Path) -> None:
    remark(f"warning[L0742]: the cache folder '{folder}' is not used: others own it or may write to it, and what it holds is "
           "run\n   = chmod go-w makes a folder of your own safe; LAGRANGIA_CACHE names another one")


def remark(text: str) -> None:
    """A warning of where all is done, told once."""
    if text not in _REMARKS:
        _REMARKS[text] = not _KEEPERS
        if not _KEEPERS:
            print(text, file=sys.stderr)


@contextlib.contextmanager
def remarks_kept() -> Iterator[None]:
    """Such warnings wait until it is known which are allowed, see `kept_remarks`; what nobody asks for is told at last."""
    _REMARKS.clear()
    _KEEPERS.append(True)
    try:
        yield
    finally:
        _KEEPERS.pop()
        for text in kept_remarks():
            print(text, file=sys.stderr)


def kept_remarks() -> list[str]:
    """Those not told yet, which count as told then."""
    found = [text for text, is_told in _REMARKS.items() if not is_told]
    _REMARKS.update(dict.fromkeys(found, True))
    return found


def has_room(folder: Path) -> bool:
    """Whether a library can be built there."""
    import shutil

    try:
        usage = shutil.disk_usage(folder)
    except OSError:
        return True
    return usage.free >= _ROOM or usage.total == 0  # some systems of files do not tell


def _cache_candidates() -> Iterator[Path]:
    environment = os.environ.get
    if chosen := environment("LAGRANGIA_CACHE"):
        yield Path(chosen).expanduser().absolute()
    if xdg := environment("XDG_CACHE_HOME"):
        yield Path(xdg) / "lagrangia"
    if sys.platform == "win32" and (local := environment("LOCALAPPDATA")):
        yield Path(local) / "lagrangia" / "cache"
    try:
        home = Path.home()
    except RuntimeError:
        return
    yield home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "lagrangia"


@cache
def _private_temporary_folder() -> Path:
    """Libraries get loaded, so nobody else may be able to put one there."""
    import tempfile

    user = os.getuid() if hasattr(os, "getuid") else None
    folder = Path(tempfile.gettempdir()) / f"lagrangia-{'cache' if user is None else user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        mode = folder.lstat()
        if user is None or (mode.st_uid == user and mode.st_mode & 0o077 == 0 and not folder.is_symlink()):
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="lagrangia-"))
