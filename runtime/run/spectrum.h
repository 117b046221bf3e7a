/* The strongest vibration in a quantity: the greatest amplitude over all frequencies, between the lines of a transform, too.
 *
 * X(f) is the integral of w (y - mean) exp(-2 pi i f t) over the time T that was looked at, with Hann's window w, by the
 * quadrature of its windows; 2 |X| / (the integral of w) is A for A cos(2 pi f t) of many periods (Harris, On the use of windows
 * for harmonic analysis with the discrete Fourier transform, Proc. IEEE 66, 1978). Frequencies from 1/T on are looked at.
 */
#ifndef LAG_SPECTRUM_H
#define LAG_SPECTRUM_H

#include <stddef.h>

#include "run/window.h"

typedef struct {
    double start, half;   /* its first time, and half of how long it is */
    double k[LAG_NODES];  /* the quantity as a polynomial over -1 <= s <= 1, ascending */
} LagPiece;

typedef struct {
    LagPiece *pieces;
    double *work; /* of the transform */
    size_t n, room;
    int has_failed; /* out of memory */
} LagSpectrum;

void lag_spectrum_start(LagSpectrum *spectrum);
void lag_spectrum_free(LagSpectrum *spectrum);

/* The quantity in the next window. */
void lag_spectrum_add(LagSpectrum *spectrum, const LagPiece *piece);

/* NaN: too short to be told, or no vibration; a quantity at rest has the amplitude 0. */
void lag_spectrum_peak(const LagSpectrum *spectrum, double *frequency, double *amplitude);

#endif
