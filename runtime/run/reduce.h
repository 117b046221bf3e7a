/* What is kept of a motion: a few numbers of quantities in its rows, taken while the run goes on.
 *
 * The motion is looked at in windows, each within one step of the solver. A window has rows at the Gauss-Lobatto nodes; the
 * polynomial through them tells where a quantity turns or crosses a level, and the run's dense output then gives the value
 * there. So extremes and crossings are those of the motion, not of rows on a grid, and integrals are exact for polynomials of
 * degree 11. What a window is too long to show (an output that oscillates several times within it) is not seen: its length
 * is the caller's choice.
 */
#ifndef LAG_REDUCE_H
#define LAG_REDUCE_H

#include "base/arena.h"
#include "run/run.h"

enum { LAG_NODES = 7 };

enum {
    LAG_REDUCE_AT, /* at the time `value` */
    LAG_REDUCE_MIN,
    LAG_REDUCE_MAX,
    LAG_REDUCE_TIME_OF_MIN,
    LAG_REDUCE_TIME_OF_MAX,
    LAG_REDUCE_RANGE, /* maximum - minimum */
    LAG_REDUCE_MEAN,
    LAG_REDUCE_RMS,
    LAG_REDUCE_FIRST_ABOVE, /* the first time that it is above `value` (or at it, see or_equal); NaN: never */
    LAG_REDUCE_FIRST_BELOW,
    LAG_REDUCE_LAST_ABOVE, /* the last time */
    LAG_REDUCE_LAST_BELOW
};

typedef struct {
    int32_t kind;     /* LAG_REDUCE_... */
    int32_t column;   /* of a row of results */
    int32_t rate;     /* the column of its rate, or -1 */
    int32_t absolute; /* of the absolute value */
    double value;
    int32_t or_equal; /* the condition of first and last holds at the level, too */
} LagReduction;

typedef struct {
    double low, high;           /* extremes so far */
    double time_low, time_high; /* and where they are */
    double integral, found;     /* of the quantity or its square; the result of at, first and last */
    double before, latest;      /* the quantity at the ends of the last two steps, NaN when unknown */
    double rate;                /* and its rate at the latest */
    int is_known;               /* nothing that comes can change it */
} LagReduced;

typedef struct {
    LagRun *run;
    size_t width;
    double *rows;            /* LAG_NODES x width; the first one is the last one of the window before */
    double time[LAG_NODES];
    double *end;             /* the row of the end of the step, at end_time */
    double end_time;
    double *inside;          /* a row between nodes */
    double basis[LAG_NODES][LAG_NODES]; /* coefficients of the Lagrange polynomials over -1 <= s <= 1, ascending */
} LagWindow;

void lag_window_layout(LagWindow *window, const LagModel *model, LagArena *arena);
void lag_window_init(LagWindow *window, LagRun *run);

/* The row of the start of the next window, at time t within the latest step. */
LagStatus lag_window_open(LagWindow *window, double t);

/* Makes one step; its end is kept in `end`. */
LagStatus lag_window_step(LagWindow *window);

/* Rows at the nodes from where the last window ended (or was opened) to t, at most the end of the step. */
LagStatus lag_window_fill(LagWindow *window, double t);

/* The window's end, or that of the step whose windows were not looked at, is the start of the next one. */
void lag_window_next(LagWindow *window);
void lag_window_skip(LagWindow *window);

void lag_reduce_start(LagReduced *reduced);
void lag_reduce_row(const LagReduction *what, LagReduced *reduced, const double *row);

/* The quantity starts anew at the window's start. */
void lag_reduce_open(const LagReduction *what, LagReduced *reduced, const LagWindow *window);

/* Looks at the ends of a step alone. Answers whether that was not enough, so that its windows are to be looked at. */
int lag_reduce_glance(const LagReduction *what, LagReduced *reduced, const LagWindow *window);
LagStatus lag_reduce_window(const LagReduction *what, LagReduced *reduced, LagWindow *window);

/* The result of a motion that took so long; NaN where there is none. */
double lag_reduce_result(const LagReduction *what, const LagReduced *reduced, double duration);

#endif
