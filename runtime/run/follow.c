#include "run/follow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "numbers/extremes.h"
#include "run/advance.h"
#include "run/row.h"
#include "run/stepping.h"
#include "state/account.h"
#include "state/state.h"

static const double PAUSE = 0.05; /* s between two looks at the caller's wish to stop */
enum { STEPS_PER_LOOK = 16, ROWS_PER_ACCOUNT = 8 };

static void layout(LagFollower *f, LagArena *arena)
{
    f->row = lag_take(arena, (size_t)lag_run_row_width(f->model));
    lag_window_layout(&f->window, f->model, arena);
}

static int is_output(const LagModel *model, int column)
{
    return column > 2 * model->n && column <= 2 * model->n + model->n_outputs;
}

int lag_follow_new(LagFollower *f, const LagModel *model, LagRun *run, const LagSweep *sweep, const int *at, int n_at)
{
    const size_t reductions = (size_t)sweep->n_reductions + 1;
    LagArena arena = {NULL, 0};
    const LagFollower fresh = {.model = model, .sweep = sweep, .run = run, .at = at, .n_at = n_at};
    *f = fresh;
    layout(f, &arena);
    f->memory = calloc(arena.used + 1, sizeof *f->memory);
    f->taken = malloc(reductions * sizeof *f->taken);
    f->reduced = calloc(reductions, sizeof *f->reduced);
    f->is_open = malloc(reductions * sizeof *f->is_open);
    if (!f->memory || !f->taken || !f->reduced || !f->is_open)
        return 0;
    arena.base = f->memory;
    arena.used = 0;
    layout(f, &arena);
    lag_window_init(&f->window, run);
    for (int i = 0; i < sweep->n_reductions; ++i)
        f->taken[i] = lag_reduce_first(&sweep->reductions[i]);
    f->needs_outputs = sweep->n_rows > 0;
    for (int i = 0; i < sweep->n_reductions; ++i) {
        const LagReduction *what = &sweep->reductions[i];
        f->needs_outputs |= is_output(model, what->column) || is_output(model, what->rate);
        f->window.has_energies |= what->column >= lag_run_row_width(model) - LAG_ACCOUNT_SIZE;
    }
    return 1;
}

void lag_follow_free(LagFollower *f)
{
    for (int i = 0; f->reduced && i < f->sweep->n_reductions; ++i) {
        lag_rainflow_free(&f->reduced[i].flow);
        lag_spectrum_free(&f->reduced[i].spectrum);
    }
    free(f->memory);
    free(f->taken);
    free(f->reduced);
    free(f->is_open);
}

int lag_follow_is_over(const LagFollower *f) { return *f->stop || (f->deadline < INFINITY && lag_clock() > f->deadline); }

static void keep_at(LagFollower *f, const double *row)
{
    const int i = f->at[f->next_at++];
    lag_reduce_row(&f->sweep->reductions[i], &f->reduced[i], row);
}

static double next_at(const LagFollower *f)
{
    return f->next_at < f->n_at ? f->sweep->reductions[f->at[f->next_at]].value : INFINITY;
}

static double next_row(const LagFollower *f)
{
    return f->next_row < f->sweep->n_rows ? f->sweep->row_times[f->next_row] : INFINITY;
}

static void find_next(LagFollower *f) { f->next = lag_min(next_at(f), next_row(f)); }

LagStatus lag_follow_hold(LagFollower *f)
{
    const int k = f->next_row > 0 ? f->next_row - 1 : 0;
    if (!f->held || k >= f->sweep->n_rows - 1)
        return LAG_OK;
    lag_run_set_stop(f->run, f->sweep->row_times[k + 1]);
    return lag_run_hold(f->run, f->held + (size_t)k * (size_t)f->model->n_inputs);
}

LagStatus lag_follow_resume(LagFollower *f, int row)
{
    f->next_row = row;
    find_next(f);
    return lag_follow_hold(f);
}

/* Whether the energy account is looked at in the row at `when`: at the end, and now and then. */
static int has_account(const LagFollower *f, double when)
{
    return f->window.has_energies || f->next_row % ROWS_PER_ACCOUNT == 0 || when >= f->sweep->t_stop;
}

/* The row of the present, with energies. */
static LagStatus present_row(LagFollower *f, double *row)
{
    const int is_whole = !f->is_led || f->needs_outputs;
    return is_whole ? lag_run_row(f->run, row) : lag_row_at(f->run, lag_guards_limit(f->run), row, LAG_ROW_ENERGIES);
}

LagStatus lag_follow_row(LagFollower *f) { return present_row(f, f->row); }

/* The row at `when`. LAG_PAUSED where the run's time is over. */
static LagStatus find_row(LagFollower *f, double when, double *row)
{
    LagStatus status = LAG_PAUSED;
    if (f->is_led && when == lag_run_time(f->run))
        return has_account(f, when) ? present_row(f, row) : lag_advance_motion_row(f->run, when, row);
    for (int done = 0; status == LAG_PAUSED;) {
        if (lag_follow_is_over(f))
            return LAG_PAUSED;
        status = lag_run_advance(f->run, &when, 1, row, &done, PAUSE);
    }
    return status;
}

/* One by one. */
LagStatus lag_follow_visit(LagFollower *f, double t)
{
    const size_t width = (size_t)lag_run_row_width(f->model);
    while (f->next <= t && f->next < INFINITY) {
        const double when = f->next;
        const int is_in_place = next_row(f) == when && when < f->sweep->t_stop; /* f->row is told of the end */
        double *row = is_in_place ? f->rows + (size_t)f->next_row * width : f->row;
        LagStatus status = find_row(f, when, row);
        if (status != LAG_OK)
            return status;
        while (next_at(f) == when)
            keep_at(f, row);
        for (f->next_row += is_in_place; next_row(f) == when; ++f->next_row)
            memcpy(f->rows + (size_t)f->next_row * width, row, width * sizeof *row);
        find_next(f);
        if ((status = lag_follow_hold(f)) != LAG_OK)
            return status;
    }
    return LAG_OK;
}

/* The end of the window from a, at the latest b: where a quantity begins or ceases to be taken, one ends. */
static double window_end(const LagFollower *f, double a, double b)
{
    for (int i = 0; i < f->sweep->n_reductions; ++i) {
        const LagReduction *what = &f->taken[i];
        if (f->is_open[i] && a < what->from && what->from < b)
            b = what->from;
        if (f->is_open[i] && a < what->to && what->to < b)
            b = what->to;
    }
    return b;
}

/* Everything in the windows of the step that started at a; what is known after one of them is not looked at in the next. */
static LagStatus look(LagFollower *f, double a)
{
    const double b = f->window.end_time, parts = fmax(1, ceil((b - a) / f->sweep->window * (1 - 1e-12)));
    LagStatus status = LAG_OK;
    for (double k = 1, t = a; k <= parts && status == LAG_OK;) {
        const double whole = k < parts ? a + (b - a) * (k / parts) : b, end = window_end(f, t, whole);
        status = lag_window_fill(&f->window, end);
        for (int i = 0; i < f->sweep->n_reductions && status == LAG_OK; ++i)
            if (f->is_open[i])
                status = lag_reduce_window(&f->taken[i], &f->reduced[i], &f->window);
        lag_window_next(&f->window);
        t = end;
        k += end == whole;
    }
    return status;
}

LagStatus lag_follow_enter(LagFollower *f, double t)
{
    const LagStatus status = lag_window_open(&f->window, t);
    for (int i = 0; i < f->sweep->n_reductions; ++i)
        lag_reduce_open(&f->taken[i], &f->reduced[i], &f->window);
    return status;
}

int lag_follow_glance(LagFollower *f)
{
    const int is_long = f->window.end_time - f->window.time[0] > f->sweep->window * (1 + 1e-12);
    int open = 0;
    for (int i = 0; i < f->sweep->n_reductions; ++i) {
        f->is_open[i] = lag_reduce_glance(&f->taken[i], &f->reduced[i], &f->window, is_long);
        open += f->is_open[i];
    }
    return open;
}

LagStatus lag_follow_watch(LagFollower *f, int open)
{
    LagStatus status = LAG_OK;
    if (open)
        status = look(f, f->window.time[0]);
    else
        lag_window_skip(&f->window);
    f->n_pending = 0;
    for (int i = 0; i < f->sweep->n_reductions; ++i) {
        f->reduced[i].is_known |= f->taken[i].kind != LAG_REDUCE_AT && f->window.end_time >= f->taken[i].to;
        f->n_pending += f->taken[i].kind != LAG_REDUCE_AT && !f->reduced[i].is_known;
    }
    return status;
}

/* The exact solver's steps are as long as they may be, and a row far inside of one costs as much as a step. */
static void limit_step(const LagFollower *f, double a)
{
    if (lag_run_statistics(f->run)->solver == LAG_SOLVER_LINEAR)
        lag_run_set_stop(f->run, fmin(a + f->sweep->window, f->sweep->t_stop));
}

LagStatus lag_follow_begin(LagFollower *f)
{
    const LagStatus status = lag_follow_visit(f, f->sweep->t_start);
    return status == LAG_OK && f->n_pending > 0 ? lag_follow_enter(f, f->sweep->t_start) : status;
}

LagStatus lag_follow_step(LagFollower *f)
{
    LagRun *run = f->run;
    const double a = lag_run_time(run);
    const int64_t events = lag_run_statistics(run)->events;
    limit_step(f, a);
    LagStatus status = lag_window_step(&f->window);
    if (status == LAG_OK && lag_run_statistics(run)->events != events)
        status = lag_follow_enter(f, a); /* things may have jumped there */
    if (status == LAG_OK)
        status = lag_follow_visit(f, f->window.end_time);
    return status == LAG_OK ? lag_follow_watch(f, lag_follow_glance(f)) : status;
}

LagStatus lag_follow_end(LagFollower *f)
{
    if (!f->held)
        lag_run_set_stop(f->run, f->sweep->t_stop);
    const LagStatus status = lag_follow_visit(f, INFINITY);
    return status == LAG_OK ? lag_guards_tell(f->run) : status;
}

static LagStatus follow(LagFollower *f)
{
    LagStatus status = lag_follow_begin(f);
    for (int64_t steps = 1; status == LAG_OK && f->n_pending > 0 && lag_run_time(f->run) < f->sweep->t_stop; ++steps) {
        if (steps % STEPS_PER_LOOK == 0 && lag_follow_is_over(f))
            return LAG_PAUSED;
        status = lag_follow_step(f);
    }
    return status == LAG_OK ? lag_follow_end(f) : status;
}

/* A guard has ended the run, as it was meant to: what is asked for at its end is there. */
static LagStatus end_early(LagFollower *f)
{
    int done = 0;
    f->end = lag_run_failure(f->run)->time;
    const LagStatus status = lag_run_advance(f->run, &f->end, 1, f->row, &done, 0);
    for (; f->next_at < f->n_at && done > 0; ++f->next_at) {
        const int i = f->at[f->next_at];
        if (f->sweep->reductions[i].or_equal)
            lag_reduce_row(&f->sweep->reductions[i], &f->reduced[i], f->row);
    }
    return status == LAG_ENDED ? LAG_OK : status;
}

LagStatus lag_follow_run(LagFollower *f)
{
    const LagStatus status = follow(f);
    return status == LAG_ENDED ? end_early(f) : status;
}

void lag_follow_start(LagFollower *f)
{
    f->next_at = f->next_row = 0;
    find_next(f);
    f->row[0] = NAN;
    f->end = f->sweep->t_stop;
    f->n_pending = f->sweep->n_reductions - f->n_at;
    for (int i = 0; i < f->sweep->n_reductions; ++i) {
        if (lag_reduce_takes_two(&f->sweep->reductions[i])) /* what the second asked for is another one */
            f->taken[i] = lag_reduce_first(&f->sweep->reductions[i]);
        lag_reduce_start(&f->taken[i], &f->reduced[i]);
    }
}

static double duration(const LagFollower *f, const LagReduction *what)
{
    return fmin(f->end, what->to) - fmax(f->sweep->t_start, what->from);
}

int lag_follow_again(LagFollower *f)
{
    f->n_pending = 0;
    for (int i = 0; i < f->sweep->n_reductions; ++i) {
        const LagReduction *what = &f->sweep->reductions[i];
        f->reduced[i].is_known = 1;
        if (!lag_reduce_takes_two(what))
            continue;
        f->taken[i] = lag_reduce_second(what, &f->reduced[i], duration(f, what));
        lag_reduce_start(&f->taken[i], &f->reduced[i]);
        ++f->n_pending;
    }
    return f->n_pending > 0;
}

void lag_follow_results(LagFollower *f, LagStatus status, double *results)
{
    for (int i = 0; i < f->sweep->n_reductions; ++i) {
        const LagReduction *what = &f->sweep->reductions[i];
        const double begin = fmax(f->sweep->t_start, what->from);
        results[i] = status == LAG_OK || f->reduced[i].is_known
            ? lag_reduce_result(what, &f->taken[i], &f->reduced[i], begin, duration(f, what)) : NAN;
    }
}
