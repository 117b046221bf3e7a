/* The motion in windows, each within one step of the solver: rows at the Gauss-Lobatto nodes, and the polynomial through them. */
#ifndef LAG_WINDOW_H
#define LAG_WINDOW_H

#include "base/arena.h"
#include "run/run.h"

enum { LAG_NODES = 7 };

typedef struct {
    LagRun *run;
    size_t width;
    double *rows;            /* LAG_NODES x width; the first one is the last one of the window before */
    double time[LAG_NODES];
    double *end;             /* the row of the end of the step, at end_time */
    double end_time;
    double *inside;          /* a row between nodes */
    int has_energies;        /* somebody asks for them */
    int is_led;              /* steps are made elsewhere, and nothing ends the run in between */
    int is_plain;            /* of rows within a step time, coordinates and rates are all that is wanted */
    double basis[LAG_NODES][LAG_NODES]; /* coefficients of the Lagrange polynomials over -1 <= s <= 1, ascending */
} LagWindow;

extern const double lag_window_node[LAG_NODES], lag_window_weight[LAG_NODES];

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

/* The row at t within the latest step is in `inside`. */
LagStatus lag_window_look(LagWindow *window, double t);

/* The row at a node, and the time at -1 <= s <= 1. */
const double *lag_window_row(const LagWindow *window, int node);
double lag_window_time(const LagWindow *window, double s);
double lag_window_half(const LagWindow *window);

#endif
