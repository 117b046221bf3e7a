"""Modules of this package run in processes of their own: none of a folder that somebody else filled stands in their place."""

import os
import sys
from pathlib import Path


def own_command(module: str) -> list[str]:
    """Of Python, without the working folder in its path: a file json.py there would be run."""
    return [sys.executable, "-P", "-m", module]


def own_environment() -> dict[str, str]:
    """In which it finds this package, wherever this process has it from."""
    home = str(Path(__file__).resolve().parents[2])
    return {**os.environ, "PYTHONPATH": os.pathsep.join([home, *filter(None, [os.environ.get("PYTHONPATH")])])}
