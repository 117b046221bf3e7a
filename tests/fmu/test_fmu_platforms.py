"""Binaries for all platforms: each is of its own kind; those of Windows and of aarch64 run where wine and qemu are installed."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import zipfile
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

pytest.importorskip("fmpy")

from fmpy import read_model_description
from fmpy.validation import validate_fmu

from helpers.fmus import EXAMPLES, Instance, model_of
from lagrangia.fmu import build
from lagrangia.fmu.build import PLATFORMS, read_platforms, standard_headers

pytestmark = [pytest.mark.slow, pytest.mark.skipif(importlib.util.find_spec("ziglang") is None,
                                                   reason="needs ziglang, which compiles for all platforms")]
PATH = EXAMPLES / "double_pendulum.lag"
FOR = {"2": "all", "3": "aarch64-linux"}  # whose sources differ in little, and whose folders are named otherwise
_FOLDER = TemporaryDirectory(prefix="lagrangia-platforms-")
# Loads the library as an importer does, makes 100 steps of Co-Simulation and prints where the arms are. For Windows without
# mingw's C library, which zig would compile for it alone.
DRIVER = """
#define __CRT__NO_INLINE 1
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include "fmi2Functions.h"
#ifdef _WIN32
#include <windows.h>
#define LOAD(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)GetProcAddress((HMODULE)library, name))
static int told(const char *format, ...)
{
    char text[1000];
    va_list values;
    DWORD written;
    va_start(values, format);
    const int length = __stdio_common_vsprintf(_CRT_INTERNAL_PRINTF_STANDARD_SNPRINTF_BEHAVIOR, text, sizeof text, format, NULL,
                                               values);
    va_end(values);
    return WriteFile(GetStdHandle(STD_OUTPUT_HANDLE), text, (DWORD)length, &written, NULL);
}
#define printf told
#else
#include <dlfcn.h>
#define LOAD(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

static void logger(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{ (void)e, (void)n, (void)c; printf("%d %s\\n", (int)s, m); }

#define GET(name) name##TYPE *name##_ = (name##TYPE *)FIND(library, #name); if (!name##_) return 2;

static int driven(void)
{
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    const fmi2ValueReference references[] = {1, 2};
    double x[2] = {0, 0};
    void *library = LOAD(LIBRARY);
    if (!library)
        return 1;
    GET(fmi2Instantiate) GET(fmi2SetupExperiment) GET(fmi2EnterInitializationMode) GET(fmi2ExitInitializationMode) GET(fmi2DoStep)
    GET(fmi2GetReal) GET(fmi2Terminate) GET(fmi2FreeInstance)
    fmi2Component c = fmi2Instantiate_("one", fmi2CoSimulation, TOKEN, NULL, &callbacks, 0, 0);
    if (!c || fmi2SetupExperiment_(c, 1, 1e-8, 0, 0, 0) || fmi2EnterInitializationMode_(c) || fmi2ExitInitializationMode_(c))
        return 3;
    for (int k = 0; k < 100; ++k)
        if (fmi2DoStep_(c, 0.01 * k, 0.01, 1))
            return 4;
    if (fmi2GetReal_(c, references, 2, x))
        return 5;
    printf("%.17g %.17g\\n", x[0], x[1]);
    fmi2Terminate_(c);
    fmi2FreeInstance_(c);
    return 0;
}

#ifdef _WIN32
void mainCRTStartup(void) { ExitProcess((UINT)driven()); }
#else
int main(void) { return driven(); }
#endif
"""


@cache
def archives() -> dict[str, Path]:
    """By version, with binaries of several platforms; without optimisation, which triples the time of compilation."""
    plain = (*("-O0" if flag == "-O2" else flag for flag in build._FLAGS), "-fno-sanitize=all")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "_FLAGS", plain)
        made = {version: model_of(PATH).export_fmu(Path(_FOLDER.name) / f"x{version}.fmu", fmi=version, platforms=platforms)
                for version, platforms in FOR.items()}
    return {version: path for version, (path,) in made.items()}


def test_binaries_of_all_platforms() -> None:
    """Each is of its own kind (in FMI 2 the one of Darwin is of both processors), of its own processor, with libraries of the
    system alone, for an old glibc. One test, so that one process builds them."""
    from lagrangia.fmu.check import read_faults
    from lagrangia.fmu.run import open_fmu

    for version, path in archives().items():
        assert validate_fmu(str(path)) == []
        archive = zipfile.ZipFile(path)
        kinds = {name.split("/")[1]: archive.read(name)[:20] for name in archive.namelist() if name.startswith("binaries/")}
        assert len(kinds) == len(read_platforms(FOR[version]))
        for folder, head in kinds.items():
            assert _is_of(folder, head), folder
        assert list(read_faults(open_fmu(path))) == []
    with zipfile.ZipFile(archives()["2"]) as archive:
        named = set(re.findall(rb"[\w-]+\.dll", archive.read("binaries/win64/DoublePendulum.dll")))
    of_the_system = {f"api-ms-win-crt-{part}-l1-1-0.dll".encode() for part in ("heap", "math", "stdio", "string", "utility")}
    assert named - {b"DoublePendulum.dll", b"KERNEL32.dll"} <= of_the_system, "nothing that is to be installed"


def _is_of(folder: str, head: bytes) -> bool:
    if folder == "darwin64":
        return head[:8] == bytes.fromhex("cafebabe00000002")
    if "darwin" in folder:
        return head[:4] == bytes.fromhex("cffaedfe")
    if "win" in folder:
        return head[:2] == b"MZ"
    return head[:4] == b"\x7fELF" and head[18] == (0xB7 if "aarch64" in folder else 0x3E)


def expected() -> list[float]:
    instance = Instance(PATH, "2", "CoSimulation").start()
    for k in range(100):
        instance.step(0.01 * k, 0.01)
    return instance.get("shoulder.phi", "elbow.phi")


def driven(platform: str, runner: list[str], folder: Path, environment: dict[str, str]) -> list[float]:
    """What the driver, compiled for the platform too, prints there."""
    kind = PLATFORMS[platform]
    with zipfile.ZipFile(archives()["2"]) as archive:
        archive.extractall(folder)
    (folder / "driver.c").write_text(DRIVER)
    named = {"LIBRARY": f"binaries/{kind.fmi2}/DoublePendulum{kind.suffix}",
             "TOKEN": read_model_description(str(archives()["2"])).guid}
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", kind.target]
    flags = ["-O1", f"-I{standard_headers()}", *(f'-D{name}="{value}"' for name, value in named.items())]
    libraries = ("-Wl,-e,mainCRTStartup", *build._FOR_WINDOWS) if kind.suffix == ".dll" else ("-ldl",)
    for arguments in ([*flags, "-c", "driver.c", "-o", "driver.o"], ["-o", "driver.exe", "driver.o", *libraries]):
        subprocess.run([*compiler, *arguments], cwd=folder, check=True, capture_output=True)
    done = subprocess.run([*runner, "./driver.exe"], cwd=folder, env=os.environ | environment, capture_output=True,
                          text=True, check=False, timeout=300)
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    return [float(x) for x in done.stdout.split()]


def test_the_windows_binary_runs_under_wine(tmp_path: Path) -> None:
    wine = next((found for name in ("wine64", "wine", "/usr/lib/wine/wine64") if (found := shutil.which(name))), None)
    if wine is None:
        pytest.skip("wine is not installed: apt-get install wine64")
    environment = {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all"}
    assert driven("x86_64-windows", [wine], tmp_path, environment) == pytest.approx(expected(), abs=1e-7)


def test_the_aarch64_binary_runs_under_qemu(tmp_path: Path) -> None:
    qemu = next((found for name in ("qemu-aarch64-static", "qemu-aarch64") if (found := shutil.which(name))), None)
    system = Path("/usr/aarch64-linux-gnu")
    if qemu is None or not (system / "lib" / "ld-linux-aarch64.so.1").exists():
        pytest.skip("qemu, or a glibc for it, is not installed: apt-get install qemu-user-static libc6-arm64-cross")
    assert driven("aarch64-linux", [qemu, "-L", str(system)], tmp_path, {}) == pytest.approx(expected(), abs=1e-7)
