"""The binary of a foreign FMU runs within limits of time, memory and output, and writes in the folders of its run alone."""

import os
import shutil
import socket
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

from helpers.broken_fmus import broken
from helpers.fmus import EXAMPLES, fmu_of
from lagrangia.command.cli import WRONG, main
from lagrangia.fmu.process import Job, Outcome, run_job
from lagrangia.fmu.run import open_fmu, unpacked

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")

EVIL = """#include <arpa/inet.h>
#include <fcntl.h>
#include <semaphore.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
extern char **environ;
__attribute__((constructor)) static void act(void) { %s }
"""
ACTS = {
    "child": ("for (int i = 0; i < 2; ++i) if (fork() == 0) { "
              "if (i) { setsid(); for (char **e = environ; *e; ++e) memset(*e, 0, strlen(*e)); } sleep(3); "
              "struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(PORT), .sin_addr = {htonl(INADDR_LOOPBACK)}}; "
              'sendto(socket(AF_INET, SOCK_DGRAM, 0), "x", 1, 0, (void *)&to, sizeof to); _exit(0); } abort();', "SIGABRT"),
    "children": ("for (int i = 0; i < 400; ++i) if (fork() == 0) { sleep(60); _exit(0); } sleep(60);",
                 "more than 256 processes"),
    "log": ('for (int i = 0; i < 400000; ++i) printf("noise, \\033[31m, noise, noise, noise\\n"); fflush(stdout); abort();',
            "SIGABRT"),
    "end": ("_exit(0);", "the FMU ended the process that ran it"),
    "memory": ('char *x = malloc((size_t)9 << 30); if (!x) { puts("no memory"); fflush(stdout); } else memset(x, 1, 1); abort();',
               "no memory"),
    "endless": ("for (;;) sleep(1);", "given up after 2 s"),
    "endless noise": ('for (;;) puts("noise, noise, noise, noise, noise, noise, noise");', "given up after 2 s"),
}
OUTSIDE = """const char *kept = "KEPT", *other = "KEPT2"; char name[4096];
    int out = fopen(kept, "a") || fopen(other, "w") || !unlink(kept) || !rename(kept, other) || !symlink("/etc", other)
              || VERSION >= 3 && !truncate(kept, 0) || VERSION >= 6 && !kill(getppid(), 0) || !system("echo x > KEPT");
    int in = fopen("b", "w") && !strcmp(getenv("HOME"), "OWN") && sem_open("/SHARED", O_CREAT, 0600, 1)
             && shm_open("/SHARED", O_CREAT | O_RDWR, 0600) >= 0 && !sem_unlink("/SHARED") && !shm_unlink("/SHARED");
    sprintf(name, "%s/c", getenv("TMPDIR"));
    puts(out ? "was outside" : in && fopen(name, "w") ? "was inside alone" : "was nowhere"); fflush(stdout); abort();"""


def fmu_that(code: str, folder: Path) -> Path:
    """One whose library does this when it is loaded."""
    (folder / "a.c").write_text(EVIL % code)
    subprocess.run(["gcc", "-shared", "-fPIC", "-w", "-o", "a.so", "a.c"], check=True, cwd=folder)
    good = fmu_of(EXAMPLES / "double_pendulum.lag", "2")
    (name,) = (name for name in zipfile.ZipFile(good).namelist() if name.startswith("binaries/"))
    return broken(good, folder / "x.fmu", {name: (folder / "a.so").read_bytes()})


def outcome_of(code: str, folder: Path, seconds: float | None = 20) -> Outcome:
    with unpacked(open_fmu(fmu_that(code, folder))) as place:
        return run_job(Job(place, "me", [0.0], 1.0, 1e-6, probe=True), seconds)


@pytest.mark.parametrize("act", ACTS)
def test_foreign_code_has_limits(act: str, tmp_path: Path) -> None:
    """Processes that it starts end with it, its log is bounded, so is its memory."""
    code, said = ACTS[act]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.bind(("127.0.0.1", 0))
        outcome = outcome_of(code.replace("PORT", str(heard.getsockname()[1])), tmp_path, 2 if "endless" in act else 20)
        assert said in outcome.explanation and len(outcome.log) <= 20_000 and "\x1b" not in outcome.explanation
        heard.settimeout(3.5 if act == "child" else 0.01)
        with pytest.raises(TimeoutError):
            heard.recv(1)


def test_what_does_not_begin_is_given_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = fmu_that("for (;;) sleep(1);", tmp_path)
    assert main(["fmu", "check", str(target), "--seconds", "0.5"]) == WRONG  # it has no functions, either
    assert capsys.readouterr().err.count("it was given up after 0.5 s") == len(open_fmu(target).offers)
    assert main(["fmu", "check", str(target), "--seconds", "-1"]) == WRONG


@pytest.mark.parametrize("seconds", [None, 20])
def test_foreign_code_writes_in_its_folders_alone(seconds: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing outside is made, changed, moved or removed, nor cut short where the system sees to that; the place for what is
    temporary is inside, home is where it was, shared memory and semaphores are there."""
    ask = "from pathlib import Path; from lagrangia.fmu.confined import confine; print(confine([Path.cwd()]))"
    version = subprocess.run([sys.executable, "-c", ask], check=True, capture_output=True, text=True).stdout.strip()
    if version == "0":
        pytest.skip("the system has no Landlock")
    (tmp_path / "kept").write_text("mine")
    monkeypatch.setenv("HOME", str(Path.home()))
    code = OUTSIDE.replace("KEPT", str(tmp_path / "kept")).replace("VERSION", version)
    code = code.replace("OWN", str(Path.home())).replace("SHARED", f"lagrangia-{os.getpid()}")
    outcome = outcome_of(code, tmp_path, seconds)
    assert "was inside alone" in outcome.log and "refused here, by Landlock" in outcome.explanation
    assert (tmp_path / "kept").read_text() == "mine" and not (tmp_path / "kept2").exists()


@pytest.mark.parametrize("text", ["[1]", '{"foo": 1, "steps": "x", "faults": 3}', "[" * 5000, ""])
def test_what_an_fmu_forges_of_its_run_is_no_result(text: str, tmp_path: Path) -> None:
    """Files of a run that it writes itself are not believed, nor are links to devices followed."""
    quoted = text.replace('"', '\\"')
    made = "".join(f'fputs("{quoted}", fopen("{name}", "w")); ' for name in ("result.json", "columns.json"))
    outcome = outcome_of(f'{made} symlink("/dev/zero", "rows"); fflush(NULL); abort();', tmp_path)
    assert "SIGABRT" in outcome.explanation and not outcome.rows and outcome.steps == 0
