"""The run time that comes with the package: which library is taken, and what runs without a C compiler."""

import ctypes
import os
import re
import subprocess
import sys
import time
from importlib.util import cache_from_source, module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import main
from lagrangia.native import prebuilt
from lagrangia.native.build import find_compiler

RUNTIME = data_folder("runtime")
EXAMPLES = data_folder("models") / "examples"
needs_prebuilt = pytest.mark.skipif(prebuilt.find(RUNTIME) is None, reason="installed without a run time, or changed since")


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A machine without a compiler, on which nothing was built before."""
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "empty"))


def library(folder: Path, *kinds: str) -> Path:
    """A folder as the build leaves it, but for what is in the libraries."""
    folder.mkdir()
    for kind in kinds:
        (folder / f"{kind}{prebuilt.SUFFIX}").write_bytes(b"")
    (folder / "digest").write_text(prebuilt.digest(RUNTIME) + "\n")
    return folder


def test_a_library_of_other_sources_is_not_taken(tmp_path: Path) -> None:
    folder = library(tmp_path / "built", "any")
    assert prebuilt.find(RUNTIME, folder) == folder / f"any{prebuilt.SUFFIX}"
    (folder / "digest").write_text("0" * 64)
    assert prebuilt.find(RUNTIME, folder) is None
    assert prebuilt.find(RUNTIME, tmp_path / "nowhere") is None


def test_a_processor_gets_what_it_can_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = library(tmp_path / "built", *prebuilt.kinds())
    for kind in prebuilt.kinds():
        monkeypatch.setattr(prebuilt, "kind_here", lambda kind=kind: kind)
        assert prebuilt.find(RUNTIME, folder) == folder / f"{kind}{prebuilt.SUFFIX}"
    (folder / f"{prebuilt.kinds()[-1]}{prebuilt.SUFFIX}").unlink()
    assert prebuilt.find(RUNTIME, folder) is None  # wider registers than it has


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_files_are_compiled_together_where_no_name_is_that_of_another(tmp_path: Path) -> None:
    texts = {
        "a": "#define WIDE(x) (x)\nstatic const double NEAR = 1, FAR = 2 * NEAR;\nstatic int step(int n) { return n; }",
        "b": "enum { FAR = 3 };",  # FAR of a
        "c": "static double place[2];\nstatic int walk(int step) { int FAR = step; return FAR; }",  # names inside are its own
        "d": "typedef struct { int place; } Place;\nstatic int WIDE(int n);",  # a macro of a
        "e": "/* static int step; */ static double place[2];",  # C takes two for one where nothing is given
        "f": "#include <windows.h>\nstatic int alone;",  # which has macros of its own
    }
    files = [tmp_path / f"{name}.c" for name in texts]
    for file, text in zip(files, texts.values(), strict=True):
        file.write_text(text)
    assert {"".join(file.stem for file in unit) for unit in prebuilt.units(files)} == {"ac", "bde", "f"}
    runtime = data_folder("runtime")
    made = prebuilt.units(prebuilt.sources(runtime))
    assert sorted(file for unit in made for file in unit) == prebuilt.sources(runtime)
    assert len(made) <= 30


@needs_prebuilt
@pytest.mark.skipif(sys.platform != "linux", reason="addresses are read from an ELF file")
def test_the_loop_of_tapes_begins_a_line_of_the_cache() -> None:
    library = prebuilt.find(RUNTIME)
    assert library is not None
    address = ctypes.cast(ctypes.CDLL(str(library)).lag_tape_run, ctypes.c_void_p).value
    assert address is not None and address % 64 == 0


@pytest.mark.skipif(find_compiler() is None or prebuilt.kinds() == ("any",), reason="no C compiler, or no registers of 256 bits")
def test_wide_registers_are_cleared_before_calls() -> None:
    """GCC 12 by itself leaves them to a function of the same file, and holds them for clean behind it (base/registers.h)."""
    compiler = find_compiler()
    assert compiler is not None
    command = [*compiler.command, *prebuilt.FLAGS, *prebuilt.flags_of("avx2"), prebuilt.LEVEL, f"-I{RUNTIME}", "-S", "-o", "-"]
    code = subprocess.run([*command, str(RUNTIME / "state" / "attitudes.c")], capture_output=True, text=True, check=True).stdout
    is_wide, calls = False, 0
    for line in code.splitlines():
        is_wide = is_wide or re.search(r"%ymm\d\b|%ymm1[0-5]", line) is not None
        if re.match(r"\S+:|\s*(jmp|ret|vzeroupper)\b", line):
            is_wide = False
        elif re.match(r"\s*call", line):
            assert not is_wide, line
            calls += 1
    assert calls > 0


def test_what_is_compiled_once_computes_nothing_by_registers() -> None:
    """Its digits would be those of any processor, in libraries that round products with their sums."""
    runtime = data_folder("runtime")
    shared = [file for file in prebuilt.sources(runtime) if prebuilt.is_shared(file)]
    assert len(shared) == sum(map(len, prebuilt._SHARED.values()))
    for file in shared:
        text = file.read_text(encoding="utf-8")
        assert not [word for word in ("LagLanes", "LagWide", "LAG_LANES", "LAG_WIDE", "FUSED", "fma(") if word in text], file


def test_what_is_built_is_found_and_only_then(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With sources of one function: all of them take a quarter of a minute."""
    sources = tmp_path / "runtime"
    sources.mkdir()
    (sources / "answer.h").write_text("int lag_answer(void);\n")
    (sources / "answer.c").write_text('#include "answer.h"\nint lag_answer(void) { return 42; }\n')
    command = prebuilt.find_command()
    assert command is not None
    prebuilt.build(sources, tmp_path / "built", command)
    assert prebuilt.find(sources, tmp_path / "built") is not None
    (sources / "answer.h").write_text("int lag_answer(void); /* changed */\n")
    prebuilt.digest.cache_clear()
    assert prebuilt.find(sources, tmp_path / "built") is None


def test_a_library_is_stale_when_shared_files_are_compiled_in_another_way(monkeypatch: pytest.MonkeyPatch) -> None:
    before = prebuilt.digest.__wrapped__(RUNTIME)
    monkeypatch.setattr(prebuilt, "_ONCE", ("any", "-O1"))
    assert prebuilt.digest.__wrapped__(RUNTIME) != before


@needs_prebuilt
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("scene", "solver"), [
    ("bouncing_ball", "auto"), ("stick_slip", "auto"), ("four_bar", "auto"), ("four_bar", "implicit"), ("chain", "pirk"),
    ("vibration_absorber", "linear"), ("pendulum", "conservative"), ("suspended_bar", "adams"), ("suspended_bar", "taylor"),
])
def test_every_solver_runs_without_a_compiler_with_the_digits_of_native_code(scene: str, solver: str, alone: None,
                                                                        monkeypatch: pytest.MonkeyPatch) -> None:
    found = lag.load(EXAMPLES / f"{scene}.lag").simulate(stop=0.5, solver=solver)
    monkeypatch.delenv("LAGRANGIA_CC")
    model = lag.load(EXAMPLES / f"{scene}.lag")
    model.native = True
    assert found.rows.tolist() == model.simulate(stop=0.5, solver=solver).rows.tolist()


@needs_prebuilt
def test_sweeps_run_without_a_compiler_and_what_cannot_says_so(alone: None, tmp_path: Path,
                                                              capsys: pytest.CaptureFixture[str]) -> None:
    pendulum = str(EXAMPLES / "pendulum.lag")
    assert main(["sweep", pendulum, "-p", "L=1,2", "-o", str(tmp_path / "runs.csv"), "--outputs", "max(hinge.phi)"]) == 0
    assert len((tmp_path / "runs.csv").read_text().splitlines()) == 3
    capsys.readouterr()
    assert main(["simulate", pendulum, "-o", str(tmp_path / "x.csv"), "--engine", "native"]) == 2
    assert "error[L0704]" in capsys.readouterr().err
    assert main(["bench", pendulum]) == 2
    assert "error[L0901]" in capsys.readouterr().err


@pytest.fixture
def hook() -> ModuleType:
    """What pip calls."""
    spec = spec_from_file_location("build_package", Path(__file__).parents[2] / "compiler" / "build_package.py")
    assert spec is not None and spec.loader is not None
    made = module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_sources_that_run_in_their_place_are_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hook: ModuleType) -> None:
    """As pip compiles what it installs: it takes a scene three times as long to start by sources."""
    (tmp_path / "module.py").write_text("answer = 42\n")
    for name, there in {"PACKAGE": tmp_path, "prebuilt": lambda: None, "place": lambda: tmp_path, "build": lambda *_: True,
                        "ship_syntax": lambda: None}.items():
        monkeypatch.setattr(hook, name, there)
    compiled = Path(cache_from_source(str(tmp_path / "module.py")))
    assert hook.ship_and_build(in_place=False) and not compiled.exists()
    assert hook.ship_and_build(in_place=True) and compiled.exists()


def test_a_machine_may_be_without_a_compiler_and_without_zig(monkeypatch: pytest.MonkeyPatch, hook: ModuleType,
                                                            capsys: pytest.CaptureFixture[str]) -> None:
    """Where pip finds no ziglang, an installation that asks for it is none."""
    monkeypatch.setattr(hook, "prebuilt", lambda: SimpleNamespace(find=lambda *_: None, find_command=lambda: None))
    wheel = SimpleNamespace(target_name="wheel")
    monkeypatch.delenv("LAGRANGIA_CC", raising=False)
    assert hook.RuntimeHook.dependencies(wheel) == ["ziglang>=0.13"]
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    assert hook.RuntimeHook.dependencies(wheel) == [] and not hook.build(hook.prebuilt(), hook.place())
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1 and "no C compiler" in said[0] and "ziglang" in said[0]


@pytest.mark.parametrize("fails", [False, True])
def test_a_library_is_found_until_another_has_been_built(fails: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                         hook: ModuleType) -> None:
    """It was away while compilers ran: FMUs that were made in that time had no binary."""
    folder = library(tmp_path / "prebuilt", "any")
    seen = []

    def build(runtime: Path, fresh: Path, command: object) -> None:
        seen.append((folder / "digest").exists())
        if fails:
            raise RuntimeError("no space left")
        library(fresh, "any", "other")

    monkeypatch.delenv("LAGRANGIA_CC", raising=False)
    made = SimpleNamespace(find=lambda *_: None, find_command=lambda: ["cc"], build=build)
    assert hook.build(made, folder) is not fails
    assert seen == [True] and (folder / f"other{prebuilt.SUFFIX}").exists() is not fails
    assert [item.name for item in tmp_path.iterdir()] == ["prebuilt"] and (folder / "digest").exists()


def test_of_two_that_build_at_once_one_is_faster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hook: ModuleType,
                                                 capsys: pytest.CaptureFixture[str]) -> None:
    """The other one could not put its own in place, and said that none was built."""
    folder = tmp_path / "prebuilt"
    rename = Path.rename

    def later(self: Path, target: Path) -> Path:
        library(folder, "any")
        return rename(self, target)

    monkeypatch.delenv("LAGRANGIA_CC", raising=False)
    monkeypatch.setattr(Path, "rename", later)
    made = SimpleNamespace(find=lambda _, place: prebuilt.find(RUNTIME, place), find_command=lambda: ["cc"],
                           build=lambda _, fresh, __: library(fresh, "any"))
    assert hook.build(made, folder) and capsys.readouterr().err == ""
    assert [item.name for item in tmp_path.iterdir()] == ["prebuilt"]


def test_what_a_build_has_left_that_was_killed_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                          hook: ModuleType) -> None:
    """But not what another one may be at: its time tells."""
    for name, age in (("prebuilt-old", 2 * hook.STRAY), ("prebuilt-young", 0.0)):
        library(tmp_path / name, "any")
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    monkeypatch.delenv("LAGRANGIA_CC", raising=False)
    made = SimpleNamespace(find=lambda *_: None, find_command=lambda: ["cc"], build=lambda _, fresh, __: library(fresh, "any"))
    assert hook.build(made, tmp_path / "prebuilt")
    assert sorted(item.name for item in tmp_path.iterdir()) == ["prebuilt", "prebuilt-young"]
