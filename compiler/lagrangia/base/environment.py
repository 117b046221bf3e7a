"""Environment variables of Lagrangia: what nothing reads, and what names nothing there is."""

import os
from collections.abc import Iterator
from pathlib import Path

from lagrangia.base.diagnostics import suggest

_PREFIX = "LAGRANGIA_"
_KNOWN = ("LAGRANGIA_CACHE", "LAGRANGIA_CC", "LAGRANGIA_PATH", "LAGRANGIA_TRACEBACK", "LAGRANGIA_KINDS", "LAGRANGIA_FMU_RUN")
_OF_TESTS = ("LAGRANGIA_TEST_CACHE", "LAGRANGIA_FUZZ", "LAGRANGIA_TREES")


def environment_remarks() -> Iterator[str]:
    """Warnings L0749, as `lag` prints them."""
    for name in sorted(name for name in os.environ if name.startswith(_PREFIX)):
        if name not in _KNOWN and name not in _OF_TESTS:
            yield f"warning[L0749]: nothing reads the environment variable '{name}'\n   = {suggest(name, _KNOWN)}"
    for folder in filter(None, os.environ.get("LAGRANGIA_PATH", "").split(os.pathsep)):
        if not Path(folder).is_dir():
            yield f"warning[L0749]: LAGRANGIA_PATH names '{folder}', which is no folder\n   = no package is looked for there"
    words = os.environ.get("LAGRANGIA_CC", "").split()
    if words and words != ["none"] and "'" not in words[0] and '"' not in words[0]:
        from shutil import which

        if which(words[0]) is None:
            yield (f"warning[L0749]: LAGRANGIA_CC names the C compiler '{words[0]}', which is not there: runs go without one\n"
                   "   = LAGRANGIA_CC=none says so without this warning")
