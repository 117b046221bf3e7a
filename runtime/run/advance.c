/* The run loop: steps until a time is reached, rows on the way. */
#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "state/account.h"
#include "run/advance.h"
#include "base/clock.h"
#include "state/evaluate.h"
#include "state/holds.h"
#include "state/inside.h"
#include "run/retry.h"
#include "run/row.h"
#include "run/run.h"
#include "model/schedule.h"
#include "steps/step.h"

enum { TICKS_PER_LOOK = 64 };

static int time_is_over(LagRun *run) { return ++run->ticks % TICKS_PER_LOOK == 0 && lag_clock() > run->deadline; }

static void set_deadline(LagRun *run, double seconds) { run->deadline = seconds > 0 ? lag_clock() + seconds : INFINITY; }

LagStatus lag_advance_step(LagRun *run) { return run->guards.broken ? lag_guards_tell(run) : lag_retry_step(run); }

/* Steps until t is not after the present time. */
static LagStatus reach(LagRun *run, double t)
{
    if (t > run->settings.t_stop)
        return lag_fail(run, LAG_PAST_STOP, -1, 0, 0);
    if (t < run->motion.t_old)
        return lag_fail(run, LAG_TIME_PASSED, -1, 0, 0);
    LagStatus status = time_is_over(run) ? LAG_PAUSED : LAG_OK;
    run->wanted = t;
    while (status == LAG_OK && run->motion.t < t)
        status = time_is_over(run) ? LAG_PAUSED : lag_advance_step(run);
    return status == LAG_OK && t > lag_guards_limit(run) ? lag_guards_tell(run) : status;
}

/* Times a rounding error after t_stop mean t_stop. */
static double not_after_stop(const LagRun *run, double t)
{
    const double stop = run->settings.t_stop;
    return t > stop && t <= stop + lag_time_resolution(stop) ? stop : t;
}

static LagStatus row_of(LagRun *run, double t, double *row)
{
    const LagStatus status = reach(run, t);
    return status == LAG_OK ? lag_row_at(run, t, row, LAG_ROW_WHOLE) : status;
}

/* What `find` makes of the run until t; by another choice where it leaves constraints or the energy account open. */
static LagStatus find_surely(LagRun *run, double t, double *row, LagStatus (*find)(LagRun *run, double t, double *row))
{
    const int was_open = run->statistics.energy_is_open;
    LagStatus status = find(run, t, row);
    while (lag_retry_is_due(run, status, was_open)) {
        status = lag_retry(run, t);
        if (status == LAG_OK)
            status = find(run, t, row);
    }
    return status;
}

LagStatus lag_advance_to(LagRun *run, double t, double *row) { return find_surely(run, not_after_stop(run, t), row, row_of); }

LagStatus lag_advance_motion_row(LagRun *run, double t, double *row)
{
    run->deadline = INFINITY;
    if (run->model->n_multipliers > 0)
        return lag_advance_to(run, t, row);
    const double time = not_after_stop(run, t);
    const LagStatus status = reach(run, time);
    return status == LAG_OK ? lag_row_at(run, time, row, LAG_ROW_OUTPUTS) : status;
}

/* The row at which the run ends as it was meant to, if it was not told already. */
static int is_last_row(LagRun *run, double *row)
{
    return !(run->guards.row >= run->guards.end) && lag_row_at(run, run->guards.end, row, LAG_ROW_WHOLE) == LAG_OK;
}

/* After a pause it stays what it was: what rows lie in the latest step depends on when that came, and no choice may. */
static void note_spacing(LagRun *run, const double *times, int rows)
{
    if (rows == 0)
        run->row_spacing = 0;
    else if (times[rows - 1] != run->paused_before)
        run->row_spacing = (times[rows - 1] - run->motion.t) / rows;
}

static LagStatus rows_of(LagRun *run, const double *times, int rows, double *results, int *done)
{
    const size_t width = (size_t)lag_run_row_width(run->model);
    for (int i = 0; i < rows; ++i) {
        double *row = results + (size_t)i * width;
        const LagStatus status = lag_advance_to(run, times[i], row);
        *done = i + (status == LAG_OK || (status == LAG_ENDED && is_last_row(run, row)));
        if (status != LAG_OK)
            return status == LAG_ENDED ? lag_guards_tell(run) : status;
    }
    return rows > 0 && run->guards.broken && times[rows - 1] >= run->guards.end ? lag_guards_tell(run) : LAG_OK;
}

LagStatus lag_run_advance(LagRun *run, const double *times, int rows, double *results, int *done, double seconds)
{
    set_deadline(run, seconds);
    *done = 0;
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    note_spacing(run, times, rows);
    const LagStatus status = rows_of(run, times, rows, results, done);
    run->paused_before = status == LAG_PAUSED ? times[rows - 1] : -INFINITY;
    return status;
}

/* A step, unless it was made already, and the row at its end. */
static LagStatus row_of_step(LagRun *run, double behind, double *row)
{
    const LagStatus status = run->motion.t < behind ? lag_advance_step(run) : LAG_OK;
    return status == LAG_OK ? lag_row_at(run, lag_guards_limit(run), row, LAG_ROW_WHOLE) : status;
}

static LagStatus stride(LagRun *run, double *row) { return find_surely(run, nextafter(run->motion.t, INFINITY), row, row_of_step); }

LagStatus lag_run_advance_steps(LagRun *run, int rows, double *results, int *done, double seconds)
{
    const size_t width = (size_t)lag_run_row_width(run->model);
    set_deadline(run, seconds);
    *done = 0;
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    while (*done < rows && run->motion.t < run->settings.t_stop) {
        const LagStatus status = time_is_over(run) ? LAG_PAUSED : stride(run, results + (size_t)*done * width);
        if (status != LAG_OK)
            return status;
        ++*done;
    }
    return *done < rows ? lag_guards_tell(run) : LAG_OK;
}

LagStatus lag_run_cut(LagRun *run, double t)
{
    LagMotion *motion = &run->motion;
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    if (t == motion->t)
        return LAG_OK;
    if (!(t >= motion->t_old && t < motion->t))
        return lag_fail(run, t > motion->t ? LAG_PAST_STOP : LAG_TIME_PASSED, -1, 0, 0);
    lag_go_back(run, t);
    motion->t_old = t;
    run->segment_over = 1;
    lag_switches_forget(run);
    lag_guards_forget(run, t);
    lag_retry_forget(run);
    return LAG_OK;
}

LagStatus lag_run_row(LagRun *run, double *row)
{
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    return lag_row_at(run, lag_guards_limit(run), row, LAG_ROW_WHOLE);
}
