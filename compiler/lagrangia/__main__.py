"""The command `lag`, also as `python -m lagrangia`: Ctrl-C ends it without a word of Python's from its first import on."""

import os
import signal
import sys
from types import FrameType


def _leave(_number: int, _frame: FrameType | None) -> None:
    os.write(2, b"interrupted\n")
    os._exit(130)  # INTERRUPTED, which is not imported yet


if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # what is ignored (`nohup`) stays so
    signal.signal(signal.SIGINT, _leave)

from lagrangia.command.cli import main  # noqa: E402 # which takes time

if __name__ == "__main__":
    sys.exit(main())
