"""What an FMU may write: files in the folders of its run alone, where the system can see to that without rights of its own.

Linux has it from 5.13 on (Landlock, M. Salaün; https://docs.kernel.org/userspace-api/landlock.html): what is opened for writing,
made, removed or moved outside is refused to this process and all that it starts, for good; from 6.2 on (version 3 of the
interface) what is cut short by its name as well, from 6.12 on (version 6) signals to others. It does not look at modes and times
of files. Memory that processes share, and semaphores (/dev/shm), are allowed. What is read, home and networks stay as they are,
as licences may need them. Elsewhere only the place for what is temporary is another.
"""

import contextlib
import ctypes as c
import os
import sys
from collections.abc import Sequence
from pathlib import Path

_CREATE, _ADD, _RESTRICT = 444, 445, 446  # system calls, of the same numbers on x86, ARM and RISC-V
_ASK_VERSION = 1
_PATH_BENEATH = 1
_NO_NEW_PRIVILEGES = 38  # of prctl
_WRITE_FILE, _REFER, _TRUNCATE = 1 << 1, 1 << 13, 1 << 14
_MAKE_OR_REMOVE = sum(1 << bit for bit in range(4, 13))
_NO_SIGNALS = 1 << 1  # to processes outside
_SINCE = {_REFER: 2, _TRUNCATE: 3}  # versions of the interface
_DEVICES = ("/dev/null", "/dev/zero", "/dev/full")
_SHARED_MEMORY = Path("/dev/shm")


class _Rules(c.Structure):
    _fields_ = [("files", c.c_uint64), ("network", c.c_uint64), ("scope", c.c_uint64)]


class _Beneath(c.Structure):
    _pack_ = 1
    _fields_ = [("allowed", c.c_uint64), ("folder", c.c_int32)]


def confine(folders: Sequence[Path]) -> int:
    """This process writes in the folders alone from now on: the first one is its place for what is temporary. The version of the
    interface that sees to it, 0 where there is none."""
    os.environ |= dict.fromkeys(("TMPDIR", "TMP", "TEMP"), str(folders[0]))
    if not sys.platform.startswith("linux") or os.uname().machine not in ("x86_64", "aarch64", "riscv64"):
        return 0
    call = c.CDLL(None, use_errno=True).syscall
    version = call(_CREATE, None, c.c_size_t(0), c.c_uint32(_ASK_VERSION))
    if version < 1:
        return 0
    writing = _WRITE_FILE | _MAKE_OR_REMOVE | sum(right for right, since in _SINCE.items() if version >= since)
    rules = _Rules(writing, 0, _NO_SIGNALS if version >= 6 else 0)
    size = c.sizeof(_Rules) if version >= 6 else 8
    made = call(_CREATE, c.byref(rules), c.c_size_t(size), c.c_uint32(0))
    if made < 0:
        return 0
    try:
        for folder in (*folders, _SHARED_MEMORY):
            _allow(call, made, str(folder), writing)
        for device in _DEVICES:
            _allow(call, made, device, writing & (_WRITE_FILE | _TRUNCATE))
        is_bound = c.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) == 0
        return int(version) if is_bound and call(_RESTRICT, made, c.c_uint32(0)) == 0 else 0
    finally:
        os.close(made)


def _allow(call: "c._FuncPointer", rules: int, path: str, rights: int) -> None:
    with contextlib.suppress(FileNotFoundError):
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        try:
            call(_ADD, rules, _PATH_BENEATH, c.byref(_Beneath(rights, place)), c.c_uint32(0))
        finally:
            os.close(place)
