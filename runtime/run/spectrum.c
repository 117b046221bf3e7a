#include "run/spectrum.h"

#include <math.h>
#include <stdlib.h>

enum { FIRST_ROOM = 64, LINES = 4, FEWEST = 8, CANDIDATES = 4, ROUNDS = 12 };

static const double PI = 3.14159265358979323846;
static const double LIKE = 0.7;      /* a line so near the greatest may be the greatest between lines (Hann's scallops: 0.85) */
static const double NOTHING = 1e-13; /* of the quantity: rounding, no vibration */
static const double FINE = 1e-12;    /* of a line */

void lag_spectrum_start(LagSpectrum *spectrum)
{
    spectrum->n = 0;
    spectrum->has_failed = 0;
}

void lag_spectrum_free(LagSpectrum *spectrum)
{
    free(spectrum->pieces);
    free(spectrum->work);
}

/* Twice the room, for the transform at the end, too. */
static int grow(LagSpectrum *spectrum)
{
    const size_t wanted = spectrum->room ? 2 * spectrum->room : FIRST_ROOM;
    LagPiece *pieces = realloc(spectrum->pieces, wanted * sizeof *pieces);
    if (pieces)
        spectrum->pieces = pieces;
    double *work = realloc(spectrum->work, 2 * LINES * wanted * sizeof *work);
    if (work)
        spectrum->work = work;
    spectrum->has_failed = !pieces || !work;
    if (!spectrum->has_failed)
        spectrum->room = wanted;
    return !spectrum->has_failed;
}

void lag_spectrum_add(LagSpectrum *spectrum, const LagPiece *piece)
{
    if (!spectrum->has_failed && (spectrum->n < spectrum->room || grow(spectrum)))
        spectrum->pieces[spectrum->n++] = *piece;
}

static double value(const LagPiece *piece, double s)
{
    double y = piece->k[LAG_NODES - 1];
    for (int i = LAG_NODES - 2; i >= 0; --i)
        y = y * s + piece->k[i];
    return y;
}

typedef struct {
    const LagSpectrum *spectrum;
    double start, length; /* s */
    double mean, weight;  /* of the quantity by the window, and the integral of that */
    double size;          /* the greatest value */
} Span;

static double hann(const Span *span, double t)
{
    const double s = sin(PI * (t - span->start) / span->length);
    return s * s;
}

static Span span_of(const LagSpectrum *spectrum)
{
    const LagPiece *last = &spectrum->pieces[spectrum->n - 1];
    Span span = {spectrum, spectrum->pieces[0].start, 0, 0, 0, 0};
    span.length = last->start + 2 * last->half - span.start;
    for (size_t i = 0; i < spectrum->n; ++i) {
        const LagPiece *piece = &spectrum->pieces[i];
        for (int j = 0; j < LAG_NODES; ++j) {
            const double y = value(piece, lag_window_node[j]);
            const double w = piece->half * lag_window_weight[j] * hann(&span, piece->start + piece->half * (1 + lag_window_node[j]));
            span.weight += w;
            span.mean += w * y;
            span.size = fmax(span.size, fabs(y));
        }
    }
    span.mean /= span.weight;
    return span;
}

/* In place, of n complex numbers, n a power of two. */
static void transform(double *z, size_t n)
{
    for (size_t i = 1, j = 0; i < n; ++i) {
        size_t bit = n >> 1;
        for (; j & bit; bit >>= 1)
            j ^= bit;
        j ^= bit;
        for (size_t part = 0; i < j && part < 2; ++part) {
            const double kept = z[2 * i + part];
            z[2 * i + part] = z[2 * j + part];
            z[2 * j + part] = kept;
        }
    }
    for (size_t half = 1; half < n; half *= 2)
        for (size_t k = 0; k < half; ++k) {
            const double angle = -PI * (double)k / (double)half, c = cos(angle), s = sin(angle);
            for (size_t i = k; i < n; i += 2 * half) {
                double *a = z + 2 * i, *b = a + 2 * half;
                const double x = c * b[0] - s * b[1], y = c * b[1] + s * b[0];
                b[0] = a[0] - x, b[1] = a[1] - y;
                a[0] += x, a[1] += y;
            }
        }
}

/* |X| at the multiples of 1/T below n / 2, in the first places of the work. */
static size_t lines(const Span *span)
{
    const LagSpectrum *spectrum = span->spectrum;
    size_t n = LINES;
    while (n < LINES * spectrum->n)
        n *= 2;
    double *z = spectrum->work;
    const LagPiece *piece = spectrum->pieces, *last = piece + spectrum->n - 1;
    for (size_t i = 0; i < n; ++i) {
        const double t = span->start + span->length * (double)i / (double)n;
        while (piece < last && t > piece->start + 2 * piece->half)
            ++piece;
        z[2 * i] = hann(span, t) * (value(piece, (t - piece->start) / piece->half - 1) - span->mean);
        z[2 * i + 1] = 0;
    }
    transform(z, n);
    for (size_t i = 0; i < n / 2; ++i)
        z[i] = hypot(z[2 * i], z[2 * i + 1]);
    return n / 2;
}

/* |X|^2 at a frequency, and its derivatives by it. */
static void strength(const Span *span, double frequency, double of[3])
{
    const double omega = 2 * PI * frequency, middle = span->start + span->length / 2;
    double x[3][2] = {{0, 0}, {0, 0}, {0, 0}};
    for (size_t i = 0; i < span->spectrum->n; ++i) {
        const LagPiece *piece = &span->spectrum->pieces[i];
        for (int j = 0; j < LAG_NODES; ++j) {
            const double t = piece->start + piece->half * (1 + lag_window_node[j]), tau = t - middle, turned = 2 * PI * tau;
            const double y = piece->half * lag_window_weight[j] * hann(span, t) * (value(piece, lag_window_node[j]) - span->mean);
            const double re = y * cos(omega * tau), im = -y * sin(omega * tau);
            x[0][0] += re, x[0][1] += im;
            x[1][0] += turned * im, x[1][1] -= turned * re;
            x[2][0] -= turned * turned * re, x[2][1] -= turned * turned * im;
        }
    }
    of[0] = x[0][0] * x[0][0] + x[0][1] * x[0][1];
    of[1] = 2 * (x[0][0] * x[1][0] + x[0][1] * x[1][1]);
    of[2] = 2 * (x[1][0] * x[1][0] + x[1][1] * x[1][1] + x[0][0] * x[2][0] + x[0][1] * x[2][1]);
}

/* The top beside a line: Newton on the logarithm, which is concave over the whole of a top. */
static double climb(const Span *span, double line, double *frequency)
{
    const double low = fmax(1, line - 1), high = line + 1;
    double k = line, of[3];
    for (int round = 0; round < ROUNDS; ++round) {
        strength(span, k / span->length, of);
        const double slope = of[1] / of[0] / span->length, bend = of[2] / of[0] / (span->length * span->length) - slope * slope;
        const double next = fmin(high, fmax(low, bend < 0 ? k - slope / bend : slope > 0 ? high : low));
        const double moved = fabs(next - k);
        k = next;
        if (!(moved > FINE))
            break;
    }
    strength(span, k / span->length, of);
    *frequency = k / span->length;
    return 2 * sqrt(of[0]) / span->weight;
}

void lag_spectrum_peak(const LagSpectrum *spectrum, double *frequency, double *amplitude)
{
    *frequency = *amplitude = NAN;
    if (spectrum->n < FEWEST)
        return;
    const Span span = span_of(spectrum);
    const double *x = spectrum->work;
    const size_t n = lines(&span);
    double greatest = 0;
    for (size_t k = 1; k < n; ++k)
        greatest = fmax(greatest, x[k]);
    size_t best[CANDIDATES] = {0};
    for (size_t k = 1; k + 1 < n; ++k) {
        if (!(x[k] >= LIKE * greatest) || x[k] < x[k + 1] || (k > 1 && x[k] < x[k - 1]))
            continue;
        size_t place = CANDIDATES;
        while (place > 0 && (!best[place - 1] || x[k] > x[best[place - 1]]))
            --place;
        for (size_t i = CANDIDATES - 1; i > place; --i)
            best[i] = best[i - 1];
        if (place < CANDIDATES)
            best[place] = k;
    }
    for (int i = 0; i < CANDIDATES && best[i]; ++i) {
        double f = NAN;
        const double a = climb(&span, (double)best[i], &f);
        if (!(a <= *amplitude)) {
            *amplitude = a;
            *frequency = f;
        }
    }
    if (*amplitude <= NOTHING * span.size || span.size == 0) {
        *amplitude = 0;
        *frequency = NAN;
    }
}
