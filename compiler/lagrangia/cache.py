"""Compiled scenes on disk, found again by the text they were compiled from.

`scenes/<key>.json` under the cache folder; the key is the hash of the file's text and name, the model, the structural values, the
outputs and this installation of the compiler. The texts of imported files are checked when the scene is read.
"""

import contextlib
import hashlib
import json
import os
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from lagrangia.folders import data_folder
from lagrangia.native import cache_folder
from lagrangia.scene import Scene, from_json, to_json


def find_scene(path: Path, model: str | None, structural: Mapping[str, Any], outputs: tuple[str, ...],
               for_any_mass: bool = False, is_general: bool = False) -> Scene | None:
    """The scene compiled earlier from the same text, or None."""
    try:
        file = _file(path, model, structural, outputs, for_any_mass, is_general)
        stored = json.loads(file.read_text(encoding="utf-8"))
        if all(_digest(Path(name)) == digest for name, digest in stored["imports"].items()):
            return from_json(stored["scene"]) if _digest_text(stored["scene"]) == stored["digest"] else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    return None


def keep_scene(scene: Scene, path: Path, model: str | None, structural: Mapping[str, Any], outputs: tuple[str, ...],
               imports: list[Path], for_any_mass: bool = False, is_general: bool = False) -> None:
    """Store a scene; a full or unwritable disk is no error, the next run compiles again."""
    whole = to_json(scene)
    text = json.dumps({"imports": {str(p.resolve()): _digest(p) for p in imports}, "scene": whole, "digest": _digest_text(whole)})
    with contextlib.suppress(OSError):
        file = _file(path, model, structural, outputs, for_any_mass, is_general)
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=file.parent, suffix=".part")
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
        os.replace(temporary, file)


def _file(path: Path, model: str | None, structural: Mapping[str, Any], outputs: tuple[str, ...], *formulas: bool) -> Path:
    what = [str(path.resolve()), _digest(path), model, sorted(structural.items()), outputs, formulas, _installation()]
    return cache_folder() / "scenes" / f"{hashlib.sha256(repr(what).encode()).hexdigest()[:32]}.json"


def _digest_text(text: str) -> str:
    """Of the stored scene: damaged instructions could crash the run."""
    return hashlib.sha256(text.encode()).hexdigest()


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def _installation() -> str:
    """Changes with every file of the compiler, its grammar and its library."""
    files = [*Path(__file__).parent.glob("*.py"), *data_folder("grammar").glob("*.lark"),
             *(data_folder("models") / "library").glob("*.lag")]
    stats = [(file.name, (stat := file.stat()).st_size, stat.st_mtime_ns) for file in sorted(files)]
    return hashlib.sha256(repr(stats).encode()).hexdigest()
