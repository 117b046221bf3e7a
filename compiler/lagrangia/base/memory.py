"""How a command keeps its memory: a scene of 10 000 links takes a gigabyte, and the command ends soon after."""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

# Numbers of glibc's <malloc.h>, and what the C library then does.
_SETTINGS = {
    -1: 1 << 30,  # M_TRIM_THRESHOLD: what is freed at the top is kept
    -2: 64 << 20,  # M_TOP_PAD: and asked for in large pieces, of which untouched pages take nothing
    -3: 32 << 20,  # M_MMAP_THRESHOLD: large blocks come from there too, instead of new pages each time
}


def keep_freed_memory() -> None:
    """What is freed is used again instead of being given back: else a large scene's pages come twice, each at 2 us.

    Only where the C library is glibc; others do as they do.
    """
    if sys.platform != "linux":
        return
    import ctypes

    with suppress(OSError, AttributeError):
        set_option = ctypes.CDLL(None).mallopt
        for option, value in _SETTINGS.items():
            set_option(option, value)


@contextmanager
def without_collections() -> Iterator[None]:
    """What is made here is kept or freed at once: looking for cycles, over and over, takes a tenth of compiling a large scene,
    and once at the end as much again, were it not among the old objects then, where freeze and unfreeze leave it."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            if gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()
            gc.enable()
