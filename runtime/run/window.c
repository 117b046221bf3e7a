#include "run/window.h"

#include <string.h>

#include "run/advance.h"
#include "state/inside.h"

/* Gauss-Lobatto-Legendre nodes and weights (M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, table 25.6). */
const double lag_window_node[LAG_NODES] = {-1, -0.830223896278566929872, -0.468848793470714213804, 0, 0.468848793470714213804,
                                           0.830223896278566929872, 1};
const double lag_window_weight[LAG_NODES] = {0.0476190476190476190476, 0.276826047361565948011, 0.431745381209862623417,
                                             0.487619047619047619048, 0.431745381209862623417, 0.276826047361565948011,
                                             0.0476190476190476190476};

void lag_window_layout(LagWindow *window, const LagModel *model, LagArena *arena)
{
    window->width = (size_t)lag_run_row_width(model);
    window->rows = lag_take(arena, LAG_NODES * window->width);
    window->inside = lag_take(arena, window->width);
    window->end = lag_take(arena, window->width);
}

void lag_window_init(LagWindow *window, LagRun *run)
{
    window->run = run;
    for (int j = 0; j < LAG_NODES; ++j) {
        double *k = window->basis[j];
        memset(k, 0, sizeof window->basis[j]);
        k[0] = 1;
        for (int i = 0, degree = 0; i < LAG_NODES; ++i) {
            if (i == j)
                continue;
            ++degree; /* times (s - s_i) / (s_j - s_i) */
            for (int m = degree; m >= 0; --m)
                k[m] = ((m > 0 ? k[m - 1] : 0) - lag_window_node[i] * k[m]) / (lag_window_node[j] - lag_window_node[i]);
        }
    }
}

static LagStatus row_at(LagWindow *window, double t, double *row)
{
    int done = 0;
    if (!window->is_plain && window->is_led && !window->has_energies)
        return lag_advance_motion_row(window->run, t, row);
    if (!window->is_plain)
        return lag_run_advance(window->run, &t, 1, row, &done, 0);
    row[0] = t;
    lag_state_inside(window->run, t, row + 1); /* there is room for quadratures: those of rows come behind */
    return LAG_OK;
}

LagStatus lag_window_open(LagWindow *window, double t)
{
    window->time[0] = t;
    return row_at(window, t, window->rows);
}

static double *node(const LagWindow *window, int j) { return window->rows + (size_t)j * window->width; }

LagStatus lag_window_step(LagWindow *window)
{
    int done = 0;
    const LagStatus status = lag_run_advance_steps(window->run, 1, window->end, &done, 0);
    window->end_time = done > 0 ? window->end[0] : lag_run_time(window->run);
    return status;
}

LagStatus lag_window_fill(LagWindow *window, double t)
{
    const double centre = (window->time[0] + t) / 2, length = (t - window->time[0]) / 2;
    LagStatus status = LAG_OK;
    for (int j = 1; j < LAG_NODES && status == LAG_OK; ++j) {
        window->time[j] = j < LAG_NODES - 1 ? centre + length * lag_window_node[j] : t;
        if (window->time[j] == window->end_time)
            memcpy(node(window, j), window->end, window->width * sizeof *window->end);
        else
            status = row_at(window, window->time[j], node(window, j));
    }
    return status;
}

void lag_window_next(LagWindow *window)
{
    window->time[0] = window->time[LAG_NODES - 1];
    memcpy(window->rows, node(window, LAG_NODES - 1), window->width * sizeof *window->rows);
}

void lag_window_skip(LagWindow *window)
{
    window->time[0] = window->end_time;
    memcpy(window->rows, window->end, window->width * sizeof *window->rows);
}

LagStatus lag_window_look(LagWindow *window, double t) { return row_at(window, t, window->inside); }

const double *lag_window_row(const LagWindow *window, int j) { return node(window, j); }

double lag_window_time(const LagWindow *window, double s)
{
    return (window->time[0] + window->time[LAG_NODES - 1]) / 2 + lag_window_half(window) * s;
}

double lag_window_half(const LagWindow *window) { return (window->time[LAG_NODES - 1] - window->time[0]) / 2; }
