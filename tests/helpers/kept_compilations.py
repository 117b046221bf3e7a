"""Scenes that many tests compile as they are, the examples and those of the `scene` fixture, are compiled once in a process."""

import os
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from lagrangia.compile import pipeline

_EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
_MOST = 64


class KeptCompilations:
    """A plug-in of pytest. What a test may have patched is compiled anew, and so is what lies beside files of a test."""

    def __init__(self) -> None:
        self.is_shared = False
        self.texts = _EXAMPLES
        self.found: OrderedDict[object, object] = OrderedDict()
        for name in ("compile_file", "compile_energies"):
            setattr(pipeline, name, self._kept(getattr(pipeline, name)))

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self.is_shared = "monkeypatch" not in getattr(item, "fixturenames", ())

    def _kept(self, make: Callable[..., object]) -> Callable[..., object]:
        def made(path: Path, *given: Any, **named: Any) -> object:
            folder = Path(os.path.abspath(path)).parent
            if not self.is_shared or (folder != _EXAMPLES and folder.parent != self.texts):
                return make(path, *given, **named)
            key = make.__name__, str(path), path.stat().st_mtime_ns, repr((given, named))
            if key not in self.found:
                self.found[key] = make(path, *given, **named)
                if len(self.found) > _MOST:
                    self.found.popitem(last=False)
            self.found.move_to_end(key)
            return self.found[key]

        return made
