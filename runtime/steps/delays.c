/* The method of steps (R. Bellman, 1961): no step is longer than the shortest delay, so that what is read late is known. Signals are
 * read off the dense output of each step into polynomials, as many as it takes to have them to a part of the tolerance. What breaks at
 * an event breaks again a delay later: there a segment ends, until the break is too smooth to matter.
 */
#include "steps/delays.h"

#include <math.h>
#include <string.h>

#include "model/function.h"
#include "model/schedule.h"
#include "numbers/extremes.h"
#include "state/inside.h"
#include "state/project.h"

/* Of the tolerance and of the largest value so far: what polynomials may miss. */
static const double SHARE = 0.01, ROUNDING = 1e-14;
enum { MOST_HALVES = 12 };

void lag_delays_layout(LagRun *run, LagArena *arena)
{
    const size_t n = (size_t)run->model->n_delays;
    lag_history_layout(&run->history, run->model->n_delays, arena);
    run->history.rises = run->model->breaks_rise;
    run->late_values = lag_take(arena, n * LAG_HISTORY_NODES);
    run->late_first = lag_take(arena, n);
    run->late_now = lag_take(arena, n);
    run->late_rates = lag_take(arena, n > 0 ? (size_t)(run->model->n + run->model->n_switches) : 0);
}

/* -------- signals */

static void in_state(LagRun *run, double t, const double *y, double *values)
{
    const double *in[] = {&t, y, y + run->model->n, run->u, run->d, run->c};
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&run->model->delayed, in, &values, run->work);
}

static void inside_step(LagRun *run, double t, double *values)
{
    double *y = run->inside;
    lag_held_state_inside(run, t, y);
    lag_project_inside(run, t, y);
    in_state(run, t, y, values);
}

/* Before the start: what is stated, else as at the start, which late_first has. */
static void before_start(LagRun *run, double t, double *values)
{
    const int n = run->model->n_delays;
    const double *in[] = {&t, run->p}, *first = run->late_first;
    if (lag_present(&run->model->before))
        lag_call(&run->model->before, in, &values, run->work);
    for (int k = 0; k < n; ++k)
        values[k] = run->model->stated[k] ? values[k] : first[k];
}

typedef void (*Signals)(LagRun *run, double t, double *values);

/* Up to `end`, in halves where one polynomial is not enough. */
static void note(LagRun *run, Signals signals, double end, int halves)
{
    LagHistory *h = &run->history;
    const int n = h->n;
    const double begin = h->known;
    double *now = run->late_now;
    int fits = 1;
    for (int j = 0; j < LAG_HISTORY_NODES; ++j) {
        signals(run, lag_history_node(begin, end, j), now);
        for (int k = 0; k < n; ++k) {
            run->late_values[k * LAG_HISTORY_NODES + j] = now[k];
            h->largest[k] = lag_max(h->largest[k], fabs(now[k]));
        }
    }
    const double most = lag_max(SHARE * run->settings.tolerance, ROUNDING);
    for (int k = 0; k < n; ++k)
        fits = fits && lag_history_error(run->late_values + k * LAG_HISTORY_NODES) <= most * h->largest[k];
    const double middle = begin + (end - begin) / 2;
    if (fits || halves == 0 || !(middle > begin && middle < end)) {
        lag_history_append(h, end, run->late_values);
        return;
    }
    note(run, signals, middle, halves - 1);
    note(run, signals, end, halves - 1);
}

/* -------- the run */

static LagStatus told(LagRun *run)
{
    return run->history.is_out_of_memory ? lag_fail(run, LAG_OUT_OF_MEMORY, -1, 0, 0) : LAG_OK;
}

static int lags_are_good(LagRun *run)
{
    const double *in[] = {run->p};
    lag_call(&run->model->lags, in, &run->history.lag, run->work);
    for (int k = 0; k < run->history.n; ++k)
        if (!(run->history.lag[k] > 0 && isfinite(run->history.lag[k]))) {
            lag_fail(run, LAG_BAD_DELAY, k, 0, run->history.lag[k]);
            return 0;
        }
    return 1;
}

/* What is read late has so many derivatives at the present time, at which a segment begins. */
static void mark(LagRun *run, int order)
{
    LagHistory *h = &run->history;
    const double t = run->motion.t;
    if (order <= LAG_HISTORY_ORDERS)
        lag_history_mark(h, t, order);
    lag_history_enter(h, t, lag_time_resolution(t));
    run->segment_end = lag_min(run->other_end, h->due);
}

LagStatus lag_delays_begin(LagRun *run)
{
    LagHistory *h = &run->history;
    const int n = h->n;
    const double t = run->motion.t;
    double *first = run->late_first, *now = run->late_now;
    if (n == 0)
        return LAG_OK;
    if (!lags_are_good(run))
        return run->failure.status;
    lag_history_clear(h, t - 1);
    if (run->model->n_switches > 0)
        lag_switches_set_free(run, t, run->motion.y);
    memset(run->late_values, 0, (size_t)n * LAG_HISTORY_NODES * sizeof *run->late_values);
    for (int pass = 0; pass <= n; ++pass) { /* those that are made of others know them in the next one */
        lag_history_clear(h, t - 1);
        lag_history_append(h, t, run->late_values);
        in_state(run, t, run->motion.y, first);
        for (int k = 0; k < n; ++k) {
            before_start(run, t - h->lag[k], now);
            for (int j = 0; j < LAG_HISTORY_NODES; ++j)
                run->late_values[k * LAG_HISTORY_NODES + j] = now[k];
        }
    }
    lag_history_clear(h, lag_present(&run->model->before) ? t - h->longest : t - 1);
    note(run, before_start, t, MOST_HALVES);
    run->other_end = run->segment_end;
    mark(run, 0);
    return told(run);
}

double lag_delays_enter(LagRun *run, double end)
{
    LagHistory *h = &run->history;
    const double t = run->motion.t, resolution = lag_time_resolution(t);
    if (h->n == 0 || !run->started)
        return end;
    const int is_back = fabs(t - h->due) <= resolution && !(fabs(t - run->other_end) <= resolution);
    const int order = is_back ? h->due_order + h->rises : 0;
    run->other_end = end;
    lag_history_drop(h, t);
    mark(run, order);
    return run->segment_end;
}

void lag_delays_await_kick(LagRun *run)
{
    if (run->history.n > 0)
        memcpy(run->late_rates, run->motion.y + run->motion.n, (size_t)run->motion.n * sizeof *run->late_rates);
}

void lag_delays_look_for_kick(LagRun *run)
{
    const size_t size = (size_t)run->motion.n * sizeof *run->late_rates;
    if (run->history.n > 0 && memcmp(run->late_rates, run->motion.y + run->motion.n, size) != 0)
        mark(run, 0);
}

int lag_delays_look_for_bend(LagRun *run, int is_bend)
{
    const double *now = run->d + run->model->n_modes;
    double *before = run->late_rates + run->motion.n;
    const size_t size = (size_t)run->model->n_switches * sizeof *before;
    if (run->history.n == 0 || size == 0)
        return is_bend;
    if (memcmp(before, now, size) != 0)
        mark(run, 0);
    memcpy(before, now, size);
    return is_bend;
}

LagStatus lag_delays_note(LagRun *run)
{
    const int looks = run->stiffness.looks; /* these are none of rows */
    lag_history_drop(&run->history, run->motion.t_old);
    note(run, inside_step, run->motion.t, MOST_HALVES);
    run->stiffness.looks = looks;
    return told(run);
}

int lag_delays_change(LagRun *run)
{
    const double *in[] = {run->p};
    double *now = run->late_now;
    if (run->history.n == 0)
        return 0;
    lag_call(&run->model->lags, in, &now, run->work);
    for (int k = 0; k < run->history.n; ++k)
        if (now[k] != run->history.lag[k]) {
            lag_fail(run, LAG_BAD_DELAY, k, 1, now[k]);
            return 1;
        }
    return 0;
}
