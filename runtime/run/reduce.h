/* What is kept of a motion: a few numbers of quantities in its rows, taken while the run goes on.
 *
 * The motion is looked at in windows, each within one step of the solver. A window has rows at the Gauss-Lobatto nodes; the
 * polynomial through them tells where a quantity turns or crosses a level, and the run's dense output then gives the value
 * there. So extremes and crossings are those of the motion, not of rows on a grid, and integrals are exact for polynomials of
 * degree 11. What a window is too long to show (an output that oscillates several times within it) is not seen: its length
 * is the caller's choice.
 *
 * Some ask for the end, or the mean, before they can be taken: the run is made a second time for them, and is the same.
 */
#ifndef LAG_REDUCE_H
#define LAG_REDUCE_H

#include "run/course.h"
#include "run/rainflow.h"
#include "run/spectrum.h"

enum {
    LAG_REDUCE_AT, /* at the time `value` */
    LAG_REDUCE_MIN,
    LAG_REDUCE_MAX,
    LAG_REDUCE_TIME_OF_MIN,
    LAG_REDUCE_TIME_OF_MAX,
    LAG_REDUCE_RANGE, /* maximum - minimum */
    LAG_REDUCE_OVERSHOOT, /* how far it goes beyond its end, of the way from its start to its end */
    LAG_REDUCE_MEAN,
    LAG_REDUCE_RMS,
    LAG_REDUCE_INTEGRAL,
    LAG_REDUCE_FIRST_ABOVE, /* the first time that it is above `value` (or at it, see or_equal); NaN: never */
    LAG_REDUCE_FIRST_BELOW,
    LAG_REDUCE_LAST_ABOVE, /* the last time */
    LAG_REDUCE_LAST_BELOW,
    LAG_REDUCE_COUNT_ABOVE, /* how often it is above the level: stretches of time */
    LAG_REDUCE_COUNT_BELOW,
    LAG_REDUCE_DURATION_ABOVE, /* for how long */
    LAG_REDUCE_DURATION_BELOW,
    LAG_REDUCE_PERIOD_ABOVE, /* the mean time from one crossing into the level to the next */
    LAG_REDUCE_PERIOD_BELOW,
    LAG_REDUCE_PERIOD,   /* the same, of its mean; takes two runs */
    LAG_REDUCE_SETTLING, /* the time after which it stays within `value` x |end - start| of its end; takes two runs */
    LAG_REDUCE_DAMAGE,   /* the sum of (range / size)^value over its rainflow cycles */
    LAG_REDUCE_PEAK_FREQUENCY, /* of its strongest vibration, Hz */
    LAG_REDUCE_PEAK_AMPLITUDE
};

typedef struct {
    int32_t kind;     /* LAG_REDUCE_... */
    int32_t column;   /* of a row of results */
    int32_t rate;     /* the column of its rate, or -1 */
    int32_t absolute; /* of the absolute value */
    double value;
    double size;
    double centre;    /* taken off the quantity */
    double from, to;  /* the times it is taken over, from < to */
    int32_t or_equal; /* the condition holds at the level, too; of LAG_REDUCE_AT: at the end of a run that ends before */
    int32_t keeps_cycles; /* of rainflow: range, mean and count of each */
} LagReduction;

typedef struct {
    double low, high;           /* extremes so far */
    double time_low, time_high; /* and where they are */
    double integral, found;     /* of the quantity or its square; the result of at, first, last and duration */
    double before, latest;      /* the quantity at the ends of the last two steps, NaN when unknown */
    double rate;                /* and its rate at the latest */
    double first, last;         /* the quantity at the ends of the times it is taken over */
    double stretches;                   /* of time in which the condition holds */
    double entered, entered_first, entered_last; /* how many of them were seen to begin, and when */
    int holds;    /* whether the condition did at the latest; -1: unknown */
    int is_known; /* nothing that comes can change it */
    LagRainflow flow;
    LagSpectrum spectrum;
} LagReduced;

/* What is looked at in the first run, and what in the second, for those that take one. */
LagReduction lag_reduce_first(const LagReduction *what);
int lag_reduce_takes_two(const LagReduction *what);
LagReduction lag_reduce_second(const LagReduction *what, const LagReduced *reduced, double duration);

void lag_reduce_start(const LagReduction *what, LagReduced *reduced);
void lag_reduce_row(const LagReduction *what, LagReduced *reduced, const double *row);

/* The quantity starts anew at the window's start. */
void lag_reduce_open(const LagReduction *what, LagReduced *reduced, const LagWindow *window);

/* Looks at the ends of a step alone, unless it is long. Answers whether that was not enough: its windows are to be looked at. */
int lag_reduce_glance(const LagReduction *what, LagReduced *reduced, const LagWindow *window, int is_long);
LagStatus lag_reduce_window(const LagReduction *what, LagReduced *reduced, LagWindow *window);

/* The result of what was asked for, taken as `taken` over so long; NaN where there is none. */
double lag_reduce_result(const LagReduction *what, const LagReduction *taken, LagReduced *reduced, double start, double duration);

#endif
