"""What cost time to make, kept in files: `<kind>/<key>` under the cache folder, the SHA-256 of the content in the first line.

A file is written beside its place and renamed, so that whoever finds it finds it whole; one that was damaged since is not found.
"""

import contextlib
import hashlib
import os
import tempfile
from functools import cache
from pathlib import Path

from lagrangia.folders import cache_folder, data_folder


def find_kept(kind: str, key: str) -> bytes | None:
    """What was kept, or None."""
    try:
        digest, _, content = (cache_folder() / kind / key).read_bytes().partition(b"\n")
    except OSError:
        return None
    return content if digest == _digest(content) else None


def keep(kind: str, key: str, content: bytes) -> None:
    """A full or unwritable disk is no error: the next who asks makes it again."""
    with contextlib.suppress(OSError):
        folder = cache_folder() / kind
        folder.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(_digest(content) + b"\n" + content)
            os.replace(temporary, folder / key)
        except OSError:
            os.unlink(temporary)


def key_of(*what: object) -> str:
    """A name for the file of what follows from `what` and from this installation of the compiler."""
    return hashlib.sha256(repr((what, _installation())).encode()).hexdigest()[:32]


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


@cache
def _installation() -> str:
    """Changes with every file of the compiler, its grammar and its library."""
    files = [*Path(__file__).parent.glob("*.py"), *data_folder("grammar").glob("*.lark"),
             *(data_folder("models") / "library").glob("*.lag")]
    stats = [(file.name, (stat := file.stat()).st_size, stat.st_mtime_ns) for file in sorted(files)]
    return hashlib.sha256(repr(stats).encode()).hexdigest()
