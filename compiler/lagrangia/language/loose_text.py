"""A scene's text that stands in no file of its own: it gets one, under the cache folder."""

import hashlib
import os
import re
import tempfile
from pathlib import Path

from lagrangia.base.diagnostics import fail
from lagrangia.base.folders import cache_folder

_IMPORT = re.compile(r'^\s*import\s*"', re.MULTILINE)


def place_of(text: str) -> Path:
    """A file with this text, the same for the same text, so that what was compiled from it is found again. Raises LagError L0901
    for one that imports others: where they would be looked for, nobody could say."""
    if not isinstance(text, str):
        fail("L0703", f"a scene is a text, not {text!r}"[:200], None, "lagrangia.load takes the name of a file")
    if _IMPORT.search(text):
        fail("L0901", "not supported yet: imports in a text that stands in no file", None, "write it into a file and load that")
    folder = cache_folder() / "texts" / hashlib.sha256(text.encode()).hexdigest()[:32]
    place = folder / "text.lag"
    if not place.exists() or place.read_text(encoding="utf-8") != text:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".part")
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as stream:
            stream.write(text)
        os.replace(temporary, place)
    return place
