"""What is made of the grammar and of the component library once, when the package is built: tables of the parser, syntax trees.

They are found by the content that they were made from. Where that is another (a changed library, another Python) they are made
when they are first needed, and kept in the cache.
"""

import hashlib
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from lagrangia.base.store import find_kept, keep

_FOLDER = Path(__file__).with_name("shipped")
_MAKERS = ("syntax.py", "expression_nodes.py", "reader.py", "grammar_tables.py", "tree.py", "plain_tree.py")


def made_of(name: str, files: Sequence[Path], make: Callable[[], bytes]) -> bytes:
    """What `make` makes of these files: as it was shipped, as it was kept, or now."""
    key = _key(name, files)
    try:
        return (_FOLDER / key).read_bytes()  # beside the modules, and as trusted as they are
    except OSError:
        pass
    if (kept := find_kept("syntax", key)) is not None:
        return kept
    content = make()
    keep("syntax", key, content)
    return content


def ship(name: str, files: Sequence[Path], content: bytes) -> Path:
    """Puts what was made of these files beside the modules, where it is found whole. Raises OSError."""
    _FOLDER.mkdir(exist_ok=True)
    place = _FOLDER / _key(name, files)
    fresh = place.with_name(f"{place.name}.{os.urandom(4).hex()}")  # by itself: several may be built at once
    fresh.write_bytes(content)
    fresh.replace(place)
    return place


def _key(name: str, files: Sequence[Path]) -> str:
    makers = [Path(__file__).with_name(maker) for maker in _MAKERS]
    hashed = hashlib.sha256(sys.implementation.cache_tag.encode())
    for file in (*makers, *files):
        hashed.update(file.name.encode() + hashlib.sha256(file.read_bytes()).digest())
    return f"{name}-{hashed.hexdigest()[:32]}"
