"""A process whose children end with it, also those that left its session and forgot its environment.

On Linux what a process leaves behind is handed to the nearest one above it that adopts (PR_SET_CHILD_SUBREAPER, prctl(2)): work
goes on in a process below this one, which waits for it and ends what is left. Elsewhere the work is done here.
"""

import contextlib
import ctypes as c
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import NoReturn

_ADOPT, _END_WITH_PARENT = 36, 1  # of prctl
_MOST_CHILDREN = 256  # at one time: more are processes without end
_PAUSE, _LOOK = 0.005, 0.1  # s: for processes to end, and between looks at how many there are
_MOST_LOOKS = 400


def run_watched(work: Callable[[], int]) -> int:
    """The exit code of the work; a signal that ends it ends this process as well, and so do very many children. SIGTERM, and
    the end of the process above, end all."""
    if not sys.platform.startswith("linux") or c.CDLL(None).prctl(_ADOPT, 1, 0, 0, 0) != 0:
        return work()
    c.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGTERM, 0, 0, 0)
    child = os.fork()
    if child == 0:
        os.setsid()
        c.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL, 0, 0, 0)
        return work()

    def leave(number: int, _: FrameType | None) -> NoReturn:
        _end_all(child)
        os._exit(128 + number)

    signal.signal(signal.SIGTERM, leave)
    threading.Thread(target=_look_after, args=(child,), daemon=True).start()
    _, status = os.waitpid(child, 0)
    _end_all(child)
    code = os.waitstatus_to_exitcode(status)
    if code < 0:
        _end_by(-code)
    return code


def _end_by(number: int) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError, ValueError):  # of SIGKILL
        signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


def _end_all(group: int) -> None:
    """First those that still are in the group, at once: each of them may be starting more."""
    for _ in range(_MOST_LOOKS):
        with contextlib.suppress(OSError):
            os.killpg(group, signal.SIGKILL)
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        if not (below := _below(os.getpid())):
            break
        for process in below:
            with contextlib.suppress(OSError):
                os.kill(process, signal.SIGKILL)
        time.sleep(_PAUSE)


def _look_after(group: int) -> None:
    before = len(os.listdir("/proc"))
    while True:
        time.sleep(_LOOK)
        if len(os.listdir("/proc")) - before > _MOST_CHILDREN and len(_below(os.getpid())) > _MOST_CHILDREN:
            print(f"ended here: more than {_MOST_CHILDREN} processes at one time", flush=True)
            with contextlib.suppress(OSError):
                os.killpg(group, signal.SIGKILL)
            return


def _below(process: int) -> list[int]:
    """The processes that it started, or that were handed to it, with those that they have started."""
    started: dict[int, list[int]] = {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError, ValueError, IndexError):  # gone meanwhile
            above = int(file.read_text(errors="replace").rpartition(")")[2].split()[1])
            started.setdefault(above, []).append(int(file.parent.name))
    found, ahead = [], [process]
    while ahead:
        more = started.get(ahead.pop(), [])
        found += more
        ahead += more
    return found
