"""What all processes of a run need, and one of them makes."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def one_process_at_a_time(lock: Path) -> Iterator[None]:
    """The others wait, rather than compile the same beside it; where files cannot be locked they do not."""
    try:
        from fcntl import LOCK_EX, flock
    except ImportError:
        yield
        return
    with lock.open("w") as held:
        flock(held, LOCK_EX)
        yield
