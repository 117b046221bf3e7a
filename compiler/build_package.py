"""Builds what the package ships beside its sources: the C run time, the parser's tables, the parsed component library.

The hook of hatchling that pyproject.toml names.

    python compiler/build_package.py    does so in a source tree, as an editable install does

Where the sources are run from their place, their modules are compiled there, as pip does for what it installs: compiling those
that a scene needs takes twice as long as the scene, each time where PYTHONDONTWRITEBYTECODE is set.

Where no C compiler is found pip brings zig. Where it cannot, it says so, and LAGRANGIA_CC=none asks for neither: the wheel has no
run time then, and what is installed looks for a compiler when a scene is run, and says so.
"""

import compileall
import os
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from sysconfig import get_platform
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "compiler" / "lagrangia"
STRAY = 3600.0  # seconds: no build takes so long

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # called as a script
    BuildHookInterface = object


def prebuilt() -> ModuleType:
    """The module of the package, by itself: what it imports is not installed yet."""
    (file,) = PACKAGE.rglob("prebuilt.py")
    spec = spec_from_file_location("prebuilt", file)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["prebuilt"] = module
    spec.loader.exec_module(module)
    return module


class RuntimeHook(BuildHookInterface):
    """`initialize` builds; wheels take what lies beside the module, with a tag of the platform."""

    def dependencies(self) -> list[str]:
        """Zig, where this machine has no C compiler. What the parser needs, pyproject.toml requires: pip installs once then."""
        is_asked = self.target_name == "wheel" and not has_renounced()
        return ["ziglang>=0.13"] if is_asked and not prebuilt().find_command() else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if self.target_name != "wheel":
            return
        is_built = ship_and_build(in_place=version == "editable")
        build_data["artifacts"].append("compiler/lagrangia/**/shipped/*")
        if is_built:
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{get_platform().replace('-', '_').replace('.', '_')}"
            build_data["artifacts"].append("compiler/lagrangia/**/prebuilt/*")

    def clean(self, versions: list[str]) -> None:
        shutil.rmtree(place(), ignore_errors=True)


def has_renounced() -> bool:
    """Whether nothing is to be compiled."""
    return os.environ.get("LAGRANGIA_CC", "").strip() == "none"


def place() -> Path:
    (file,) = PACKAGE.rglob("prebuilt.py")
    return file.with_name("prebuilt")


def ship_and_build(in_place: bool) -> bool:
    """All at once: some is Python's work, the rest that of compilers. `in_place`: the sources are run from where they are."""
    with ThreadPoolExecutor(1) as other:
        built = other.submit(build, prebuilt(), place())  # found before folders come and go
        ship_syntax()
        if in_place:
            compileall.compile_dir(PACKAGE, quiet=2)
        return built.result()


def ship_syntax() -> None:
    """By the package itself. Where that cannot be, it is done when it is first needed."""
    sys.path.insert(0, str(PACKAGE.parent))
    try:
        from lagrangia.language.component_library import ship_all

        fresh = {*ship_all()}
        for file in PACKAGE.rglob("shipped/*"):
            if file not in fresh:
                file.unlink(missing_ok=True)
    except (ImportError, OSError) as error:
        print(f"lagrangia: the parsed library is made at first use: {error}", file=sys.stderr)


def build(module: ModuleType, folder: Path) -> bool:
    """Whether there is a run time in `folder` now; one that is there for these sources is kept. `module`: `prebuilt`.

    What is there is found until another has been built, beside it."""
    runtime = ROOT / "runtime"
    if module.find(runtime, folder):
        return True
    if has_renounced() or (command := module.find_command()) is None:
        print("lagrangia: no C compiler was found, so that the run time is not built: scenes without contacts and loops run by "
              "CasADi, all others need one; pip install ziglang brings it", file=sys.stderr)
        return False
    try:
        remove_strays(folder)
        with TemporaryDirectory(dir=folder.parent, prefix=f"{folder.name}-") as beside:
            fresh, old = Path(beside, "fresh"), Path(beside, "old")
            module.build(runtime, fresh, command)
            if folder.exists():
                folder.rename(old)
            fresh.rename(folder)
    except (OSError, RuntimeError) as error:
        if module.find(runtime, folder):  # another process was faster
            return True
        print(f"lagrangia: the run time could not be built, and is when it is needed: {error}", file=sys.stderr)
        return False
    return True


def remove_strays(folder: Path) -> None:
    """What builds that were killed have left beside `folder`: what is younger may be at work."""
    for stray in folder.parent.glob(f"{folder.name}-*"):
        with suppress(OSError):  # gone meanwhile
            if time.time() - stray.stat().st_mtime > STRAY:
                shutil.rmtree(stray)


if __name__ == "__main__":
    sys.exit(not ship_and_build(in_place=True))
