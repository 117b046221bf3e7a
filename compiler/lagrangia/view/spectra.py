"""Amplitudes over frequency, of rows at equal distances in time.

With Hann's window w, X_k = sum_j w_j (x_j - mean) exp(-2 pi i jk/n), the amplitude is 2 |X_k| / sum w (half of that at the ends
of the frequency axis): a vibration A cos(2 pi f t) gives a peak of A where f is a multiple of 1/(n dt), and no less than 0.85 A
elsewhere (Harris, On the use of windows for harmonic analysis with the discrete Fourier transform, Proc. IEEE 66, 1978).
"""

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass

_EVEN = 1e-6  # of an interval
_LEAST_ROWS = 8


@dataclass(frozen=True)
class Spectrum:
    """`frequencies` in Hz and `amplitude` in the unit of the quantity, (rows // 2 + 1,); resolved from `resolution` Hz on."""

    frequencies: np.ndarray
    amplitude: np.ndarray
    resolution: float


def find_spectrum(name: str, time: np.ndarray, values: np.ndarray) -> Spectrum:
    """Of one quantity, (rows,). A last row that comes early, at the end of a run, is left out.

    Raises LagError L0706 for rows that are uneven or few, or values that are not finite.
    """
    steps = np.diff(time)
    if len(steps) > 1 and steps[-1] < steps[0] * (1 - _EVEN):
        time, values, steps = time[:-1], values[:-1], steps[:-1]
    if len(time) < _LEAST_ROWS:
        fail("L0706", f"a spectrum of '{name}' needs {_LEAST_ROWS} rows at least, here are {len(time)}", None,
             "a smaller --interval or a later --stop gives more")
    uneven = np.flatnonzero(np.abs(steps - steps[0]) > _EVEN * steps[0])
    if steps[0] <= 0 or uneven.size:
        k = int(uneven[0]) if uneven.size else 0
        fail("L0706", f"a spectrum of '{name}' needs rows at equal distances in time", None,
             f"the first two are {steps[0]:g} s apart, those at t = {time[k]:g} s {steps[k]:g} s: --interval makes them even")
    if not np.isfinite(values).all():
        fail("L0706", f"'{name}' has rows without a finite value, so that it has no spectrum", None, "end the run before them")
    count = len(time)
    interval = float(time[-1] - time[0]) / (count - 1)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    mean = float(window @ values / window.sum())
    amplitude = 2 * np.abs(np.fft.rfft(window * (values - mean))) / window.sum()
    amplitude[0] /= 2
    if count % 2 == 0:
        amplitude[-1] /= 2
    return Spectrum(np.fft.rfftfreq(count, interval), amplitude, 1 / (count * interval))
