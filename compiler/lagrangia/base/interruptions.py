"""Signals that end the command: what was computed is kept."""

import contextlib
import signal
from collections.abc import Callable, Iterator
from typing import Any, NoReturn

INTERRUPTED = 130  # exit code, as shells have it for SIGINT
_ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGINT") if hasattr(signal, name))
_came: list[int] = []


@contextlib.contextmanager
def ended_as_by_control_c() -> Iterator[None]:
    """SIGTERM, by which schedulers and `timeout` end a process, and SIGHUP, by which a closed terminal does, act as Ctrl-C;
    what is ignored (`nohup`, shells that start something in the background) stays so."""
    _came.clear()
    with _handled(_end, lambda earlier: earlier != signal.SIG_IGN):
        yield


def _end(number: int, frame: Any) -> NoReturn:
    _came.append(number)
    raise KeyboardInterrupt


def is_ended() -> bool:
    """Whether a signal has come that ends the command: imports of modules in C turn its KeyboardInterrupt into an ImportError."""
    return bool(_came)


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """What is written here is written as a whole: signals wait, then raise KeyboardInterrupt."""
    came: list[int] = []
    with _handled(lambda number, frame: came.append(number), lambda earlier: earlier != signal.SIG_IGN):
        yield
    if came:
        raise KeyboardInterrupt


@contextlib.contextmanager
def held_back() -> Iterator[list[int]]:
    """What would raise KeyboardInterrupt is only noted: who looks at the list ends where nothing is half done."""
    came: list[int] = []
    with _handled(lambda number, frame: came.append(number), lambda earlier: earlier in (signal.default_int_handler, _end)):
        yield came


@contextlib.contextmanager
def noticed() -> Iterator[list[int]]:
    """Whether Ctrl-C came meanwhile: a library that calls back may turn its KeyboardInterrupt into an error of its own."""
    came: list[int] = []
    earlier = signal.getsignal(signal.SIGINT)

    def notice(number: int, frame: Any) -> Any:
        came.append(number)
        return earlier(number, frame) if callable(earlier) else None

    is_handled = False
    if callable(earlier):
        with contextlib.suppress(ValueError):  # in a thread of its own nobody ends it
            signal.signal(signal.SIGINT, notice)
            is_handled = True
    try:
        yield came
    finally:
        if is_handled:
            signal.signal(signal.SIGINT, earlier)


@contextlib.contextmanager
def _handled(handler: Callable[[int, Any], Any], which: Callable[[Any], bool]) -> Iterator[None]:
    before: dict[int, Any] = {}
    try:
        for number in _ENDING:
            if which(signal.getsignal(number)):
                with contextlib.suppress(ValueError):  # in a thread of its own nobody ends it
                    before[number] = signal.signal(number, handler)
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)
