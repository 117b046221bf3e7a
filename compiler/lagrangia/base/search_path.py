"""Folders in which packages are looked for: $LAGRANGIA_PATH, before it those of the option --path."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from lagrangia.base.diagnostics import fail

_PATH = "LAGRANGIA_PATH"  # separated as in PATH


def search_path() -> list[Path]:
    """The folders, the first to be looked in first."""
    return [Path(folder) for folder in os.environ.get(_PATH, "").split(os.pathsep) if folder]


@contextmanager
def searching_in(folders: Sequence[str]) -> Iterator[None]:
    """With these before the others, in processes that are started, too. Raises LagError L0706 for what is no folder."""
    for folder in folders:
        if not Path(folder).is_dir():
            fail("L0706", f"--path: there is no folder '{folder}'")
    before = os.environ.get(_PATH)
    if folders:
        os.environ[_PATH] = os.pathsep.join([*(str(Path(folder).absolute()) for folder in folders), *filter(None, [before])])
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(_PATH, None)
        else:
            os.environ[_PATH] = before
