"""Compiled scenes on disk, found again by the text they were compiled from.

The key is the file's text and name, the model, the structural values, the outputs and this installation of the compiler. The
texts of imported files are checked when the scene is read.
"""

import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from lagrangia.base.search_path import search_path
from lagrangia.base.store import find_kept, keep, key_of, prune
from lagrangia.run.formulas import AS_DECLARED, Formulas
from lagrangia.run.origin import digest_of
from lagrangia.run.scene import Scene, from_json, to_json

_MOST, _LARGE = 16, 1 << 18  # scenes that a process remembers; bytes of one that is read anew each time


def find_scene(path: Path, model: str | None, structural: Mapping[str, Any], outputs: tuple[str, ...],
               formulas: Formulas = AS_DECLARED) -> Scene | None:
    """The scene compiled earlier from the same text, or None."""
    try:
        imports, _, scene = (find_kept("scenes", _key(path, model, structural, outputs, formulas)) or b"").partition(b"\n")
        if all(digest_of(Path(name)) == digest for name, digest in json.loads(imports).items()):
            return _remembered(scene) if len(scene) < _LARGE else from_json(scene)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    return None


@lru_cache(maxsize=_MOST)
def _remembered(text: bytes) -> Scene:
    """The same scene for the same text: nobody changes one, and reading it takes longer than finding it. Raises ValueError,
    KeyError, TypeError."""
    return from_json(text)


def keep_scene(scene: Scene, path: Path, model: str | None, structural: Mapping[str, Any], outputs: tuple[str, ...],
               imports: list[Path], formulas: Formulas = AS_DECLARED) -> None:
    """Store a scene."""
    text = f"{json.dumps({str(p.resolve()): digest_of(p) for p in imports})}\n{to_json(scene)}"
    keep("scenes", _key(path, model, structural, outputs, formulas), text.encode())
    prune()


def _key(path: Path, model: str | None, structural: Mapping[str, Any], outputs: tuple[str, ...],
         formulas: Formulas) -> str:
    digest = digest_of(path)  # first: of links that lead to each other no path can be told
    folders = [str(folder) for folder in search_path()]
    return key_of(str(path.resolve()), digest, model, sorted(structural.items()), outputs, formulas, *folders)
