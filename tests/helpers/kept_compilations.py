"""Scenes that many tests compile as they are, examples, cases and those of the `scene` fixture: once in a process."""

import os
from collections import OrderedDict
from collections.abc import Callable
from inspect import signature
from pathlib import Path
from typing import Any

import pytest

from lagrangia.compile import pipeline

_TESTS = Path(__file__).parents[1]
_SCENES = _TESTS.parent / "models" / "examples", _TESTS / "cases"
_MOST = 64


class KeptCompilations:
    """A plug-in of pytest. What a test may have patched is compiled anew, and so is what lies beside files of a test."""

    def __init__(self) -> None:
        self.is_shared = False
        self.texts: Path | None = None  # those of the fixture: conftest.shared_texts
        self.found: OrderedDict[object, object] = OrderedDict()
        for name in ("compile_file", "compile_energies"):
            setattr(pipeline, name, self._kept(getattr(pipeline, name)))

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        self.is_shared = "monkeypatch" not in getattr(item, "fixturenames", ())

    def _kept(self, make: Callable[..., object]) -> Callable[..., object]:
        parameters = signature(make)

        def made(path: Path, *given: Any, **named: Any) -> object:
            folder = Path(os.path.abspath(path)).parent
            if not self.is_shared or (folder not in _SCENES and folder.parent != self.texts):
                return make(path, *given, **named)
            bound = parameters.bind(path, *given, **named)
            bound.apply_defaults()
            asked = {name: x for name, x in bound.arguments.items() if x}  # no structural parameters are None or {}
            key = make.__name__, path.stat().st_mtime_ns, repr(asked)
            if key not in self.found:
                self.found[key] = make(path, *given, **named)
                if len(self.found) > _MOST:
                    self.found.popitem(last=False)
            self.found.move_to_end(key)
            return self.found[key]

        return made
