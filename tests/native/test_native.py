"""Compilers, the cache, and what happens when either is missing or broken."""

import ctypes
import errno
import os
import shlex
import shutil
import stat
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import lagrangia as lag
from helpers.register_widths import built_quickly, in_registers
from lagrangia.base import folders
from lagrangia.base.folders import cache_folder, data_folder
from lagrangia.native import build as native
from lagrangia.native import prebuilt
from lagrangia.native.build import Compiler, CompilerError, build, find_compiler, start_build
from lagrangia.run.library import start_runtime

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
ROW = Path(__file__).parents[1] / "benchmarks" / "scenes" / "row.lag"
FORTY_TWO = "int answer(void);\n__attribute__((visibility(\"default\"))) int answer(void) { return 42; }\n"
# Whether upper halves of registers are in use after work() has filled some: component 2 of what an XSAVE would keep.
WIDE = """
typedef double Four __attribute__((vector_size(32)));
static __attribute__((noinline)) void work(double *x) { *(Four *)x = *(Four *)x * 3 + 1; }
int in_use(void);
__attribute__((visibility("default"))) int in_use(void)
{
    double x[4] __attribute__((aligned(32))) = {1, 2, 3, 4};
    unsigned low, high;
    work(x);
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(1));
    return x[3] == 13 ? (int)(low & 4) : -1;
}
"""
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def has_flag(name: str) -> bool:
    told = Path("/proc/cpuinfo")
    return told.exists() and f" {name} " in told.read_text()


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("LAGRANGIA_CACHE", str(folder))
    monkeypatch.delenv("LAGRANGIA_CC", raising=False)
    return folder


def answer(library: Path) -> int:
    return int(ctypes.CDLL(str(library)).answer())


def counting_compiler(folder: Path) -> tuple[Compiler, Path]:
    """A compiler that leaves a line in a log each time it is called."""
    real = find_compiler()
    assert real is not None
    log, script = folder / "log", folder / "counting-cc"
    script.write_text(f'#!/bin/sh\necho called >> "{log}"\nexec {" ".join(real.command)} "$@"\n')
    script.chmod(0o755)
    return Compiler((str(script),)), log


@needs_compiler
def test_builds_once(tmp_path: Path) -> None:
    compiler, log = counting_compiler(tmp_path)
    first = build("answer", FORTY_TWO, compiler=compiler)
    assert answer(first) == 42
    assert build("answer", FORTY_TWO, compiler=compiler) == first
    assert log.read_text().count("called") == 1


@needs_compiler
def test_source_header_level_and_compiler_are_part_of_the_key(tmp_path: Path) -> None:
    source, header = tmp_path / "answer.c", tmp_path / "answer.h"
    source.write_text('#include "answer.h"\n' + FORTY_TWO.replace("42", "ANSWER"))
    header.write_text("#define ANSWER 42\n")

    def built(level: str = "-O1", compiler: Compiler | None = None) -> Path:
        return build("answer", [source], include=[tmp_path], level=level, compiler=compiler)

    libraries = [built(), built("-O0"), built(compiler=counting_compiler(tmp_path)[0])]
    header.write_text("#define ANSWER 43\n")
    libraries.append(built())
    assert answer(libraries[-1]) == 43
    source.write_text(source.read_text() + "\n")
    libraries.append(built())
    assert len(set(libraries)) == 5


@needs_compiler
@pytest.mark.parametrize("damage", [lambda file: file.write_bytes(file.read_bytes()[:1000]), lambda file: file.unlink()])
def test_a_damaged_library_is_built_again(damage: "object") -> None:
    library = build("answer", FORTY_TWO)
    assert callable(damage)
    damage(library)
    assert build("answer", FORTY_TWO) == library
    assert answer(library) == 42


@needs_compiler
def test_a_damaged_digest_is_no_text() -> None:
    library = build("answer", FORTY_TWO)
    library.with_suffix(".sha256").write_bytes(b"\xff" * 64)
    assert build("answer", FORTY_TWO) == library
    assert library.with_suffix(".sha256").read_bytes() != b"\xff" * 64


@needs_compiler
def test_a_library_that_cannot_take_its_place_is_told(own_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And not tried for ever."""
    monkeypatch.setattr(native.shutil, "rmtree", lambda *_, **__: None)
    begun = start_build("answer", FORTY_TWO)
    begun._library.parent.mkdir(parents=True)
    (begun._library.parent / "in the way").touch()
    with pytest.raises(OSError):
        begun.finish()


@needs_compiler
def test_builds_at_the_same_time_agree(own_cache: Path) -> None:
    def one(_: int) -> Path:
        return build("answer", FORTY_TWO)

    with ThreadPoolExecutor(8) as pool:
        libraries = set(pool.map(one, range(8)))
    assert len(libraries) == 1
    assert answer(libraries.pop()) == 42
    assert not [entry for entry in own_cache.iterdir() if entry.name.startswith(".")]


@needs_compiler
def test_builds_started_together_finish_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some sources stand in for all of the run time."""
    few = [file for file in prebuilt.sources(data_folder("runtime")) if file.parent.name == "numbers"]
    assert len(few) > 1
    monkeypatch.setattr(prebuilt, "sources", lambda _: few)
    runtime, scene = start_runtime(level="-O0"), start_build("answer", FORTY_TWO)
    assert answer(scene.finish()) == 42
    assert runtime.path().exists()


@needs_compiler
@pytest.mark.slow
@pytest.mark.skipif(prebuilt.kind_here() == "any", reason="the processor has no registers beyond the usual ones")
@pytest.mark.parametrize(("file", "solver", "structural"), [
    (EXAMPLES / "double_pendulum.lag", "taylor", {}), (EXAMPLES / "andrews_squeezer.lag", "erk", {}),
    (EXAMPLES / "chain.lag", "erk5", {"n": 19}), (EXAMPLES / "chain.lag", "erk", {"n": 19}), (ROW, "taylor", {"n": 19}),
    (EXAMPLES / "chain.lag", "adams", {"n": 19}), (EXAMPLES / "four_bar.lag", "adams", {}),
    (EXAMPLES / "chain.lag", "pirk", {"n": 6}), (EXAMPLES / "andrews_squeezer.lag", "pirk", {}),
], ids=lambda given: given.stem if isinstance(given, Path) else str(given))
def test_wide_registers_and_vectors_change_no_digit(file: Path, solver: str, structural: dict[str, int], built: Path,
                                                    monkeypatch: pytest.MonkeyPatch) -> None:
    def rows() -> "object":
        model = lag.load(file, **structural)
        model.native = True
        return model.simulate(solver=solver, interval=0.001, stop=0.03).rows.tolist()

    monkeypatch.setenv("LAGRANGIA_CACHE", str(built / "wide"))
    wide, here = rows(), prebuilt.kind_here()
    for kind in prebuilt.kinds()[prebuilt.kinds().index(here) + 1 :]:  # four numbers to a register, and two
        with in_registers(kind, built):
            assert rows() == wide
    compiler = find_compiler()
    assert compiler is not None
    if not compiler.is_zig:  # headers of clang ask which one it is
        monkeypatch.setenv("LAGRANGIA_CC", f"{shlex.join(compiler.command)} -U__GNUC__ -D__GNUC__=11")
        monkeypatch.setenv("LAGRANGIA_CACHE", str(built / "without"))
        own = built_quickly()
        monkeypatch.setattr("lagrangia.run.library._ready", lambda: own)
        assert rows() == wide


@needs_compiler
def test_a_refusal_shows_command_and_message(own_cache: Path) -> None:
    with pytest.raises(CompilerError, match="nonsense") as caught:
        build("answer", "int nonsense = ;\n" * 100)
    assert "-std=c99" in caught.value.command
    assert len(caught.value.output.splitlines()) <= 20
    assert not list(own_cache.glob("*answer*"))


def test_none_pretends_that_there_is_no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    assert find_compiler() is None
    with pytest.raises(CompilerError, match="ziglang"):
        build("answer", FORTY_TWO)


def test_a_compiler_that_does_not_work_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = f"{sys.executable} -c 'raise SystemExit(1)'"
    monkeypatch.setenv("CC", broken)
    assert find_compiler() not in (Compiler((sys.executable, "-c", "raise SystemExit(1)")),)
    monkeypatch.setenv("LAGRANGIA_CC", broken)
    assert find_compiler() is None
    monkeypatch.setenv("LAGRANGIA_CC", "no-such-compiler-anywhere")
    assert find_compiler() is None


@needs_compiler
def test_a_chosen_compiler_is_taken(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    compiler, log = counting_compiler(tmp_path)
    monkeypatch.setenv("LAGRANGIA_CC", compiler.command[0])
    assert find_compiler() == compiler
    assert find_compiler() == compiler
    assert log.read_text().count("called") == 1


@pytest.mark.slow
def test_ziglang_builds_the_run_time_without_a_warning() -> None:
    """Without optimisation, which takes most of the time, and which binaries of FMUs for other platforms have."""
    pytest.importorskip("ziglang")
    zig = Compiler((sys.executable, "-m", "ziglang", "cc"))
    assert answer(build("answer", FORTY_TWO, compiler=zig)) == 42
    assert start_runtime(zig, level="-O0").path().exists()


@needs_compiler
@pytest.mark.skipif(prebuilt.kind_here() == "any", reason="has no such registers")
@pytest.mark.skipif(not has_flag("xgetbv1"), reason="does not tell what is in use")
@pytest.mark.parametrize("level", ["-O1", "-O2"])
def test_wide_registers_are_cleared_behind_compiled_code(level: str) -> None:
    """Else each instruction of an older kind that follows takes tens of cycles."""
    assert ctypes.CDLL(str(build("wide", WIDE, level=level))).in_use() == 0


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX folders")
def test_cache_folders(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert cache_folder() == tmp_path / "cache"
    monkeypatch.delenv("LAGRANGIA_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "lagrangia"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert tmp_path in cache_folder().parents


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX folders")
def test_a_cache_without_room_is_passed_over(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where none has room the first serves: what is there already can be used."""
    full = {tmp_path / "cache"}
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda place: usage._replace(free=0) if place in full else usage)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "lagrangia"
    monkeypatch.setattr(shutil, "disk_usage", lambda place: usage._replace(free=0))
    assert cache_folder() == tmp_path / "cache"
    monkeypatch.setattr(shutil, "disk_usage", lambda place: usage._replace(total=0, free=0))  # it does not tell
    assert cache_folder() == tmp_path / "cache"


@needs_compiler
def test_a_disk_that_fills_up_is_told_by_the_cache(monkeypatch: pytest.MonkeyPatch, own_cache: Path) -> None:
    def no_room(*_: object, **__: object) -> str:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    compiler = find_compiler()
    monkeypatch.setattr(native.tempfile, "mkdtemp", no_room)
    with pytest.raises(OSError, match="no room for compiled code") as caught:
        build("answer", FORTY_TWO, compiler=compiler)
    assert caught.value.filename == str(own_cache)


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX permissions")
def test_without_a_home_the_cache_is_a_private_temporary_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for name in ("LAGRANGIA_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.setenv(name, str(tmp_path / "file"))  # no folder can be made below a file
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    folders._private_temporary_folder.cache_clear()
    folder = cache_folder()
    assert folder.parent == tmp_path
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert os.access(folder, os.W_OK)


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX permissions")
def test_a_temporary_folder_that_others_can_write_to_is_not_used(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    trap = tmp_path / f"lagrangia-{os.getuid()}"
    trap.mkdir()
    trap.chmod(0o777)
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    folders._private_temporary_folder.cache_clear()
    assert folders._private_temporary_folder() != trap
    folders._private_temporary_folder.cache_clear()
