"""The run time for other registers than the widest of this machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from helpers.one_process import one_process_at_a_time
from lagrangia.base.folders import data_folder
from lagrangia.native import prebuilt
from lagrangia.native.build import build


@contextmanager
def in_registers(kind: str, built: Path) -> Iterator[None]:
    """As on a processor of this kind. Where its library does not come with the package it is compiled into a folder of `built`,
    at -O0, which changes no digit and takes less time."""
    found = prebuilt.find(data_folder("runtime"))
    own = found.with_stem(kind) if found and found.with_stem(kind).exists() else None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prebuilt, "kind_here", lambda: kind)
        patch.setenv("LAGRANGIA_CACHE", str(built / kind))
        if own is None:
            with one_process_at_a_time(built / f"{kind}.lock"):
                own = built_quickly()
        patch.setattr(prebuilt, "find", lambda *_, **__: own)
        yield


def built_quickly() -> Path:
    """The run time by the compiler that is named, or found, kept in the cache that is named."""
    folder = data_folder("runtime")
    return build("runtime", prebuilt.sources(folder), include=[folder], level="-O0")
