"""Saved states of runs that go on in others."""

import ctypes
import mmap
import sys
from array import array

import pytest

from helpers.native_models import OSCILLATOR, compiled, started
from lagrangia.native.build import find_compiler
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Model, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def moved_to(address: int, model: Model) -> Model:
    """The same where a process at a fixed address has its memory; skips where that is not to be had."""
    ask = ctypes.CDLL(None).mmap
    ask.restype, ask.argtypes = ctypes.c_void_p, [ctypes.c_void_p, ctypes.c_size_t, *3 * [ctypes.c_int], ctypes.c_long]
    size = ctypes.sizeof(model.struct)
    got = ask(address, size, mmap.PROT_READ | mmap.PROT_WRITE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, 0)
    if got != address:
        pytest.skip("there is something else")
    ctypes.memmove(address, ctypes.addressof(model.struct), size)
    return Model(type(model.struct).from_address(address), model)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for memory at an address")
@pytest.mark.parametrize("address", [0, 0x1A000000], ids=["anywhere", "low"])
def test_counts_are_no_pointers(runtime: Runtime, address: int) -> None:
    """Of a saved struct, pointers into the model are those of the run that goes on, and only they."""
    model = compiled(1, rhs=OSCILLATOR)
    if address:
        model = moved_to(address, model)
    with started(runtime, model, [1], [0], t_stop=9, tolerance=1e-8) as one, started(runtime, model, [1], [0], t_stop=9) as other:
        one.advance([3])
        taken = array("b", bytes(runtime.library.lag_snapshot_size(one.handle)))
        runtime.library.lag_snapshot_take(one.handle, taken.buffer_info()[0])
        assert runtime.library.lag_snapshot_restore(other.handle, taken.tobytes(), len(taken)) == Status.OK
        assert [*one.advance([9])[0]] == [*other.advance([9])[0]]
        assert one.statistics.steps == other.statistics.steps
