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
#include "run/run.h"
#include "model/schedule.h"
#include "steps/step.h"

enum { TICKS_PER_LOOK = 64 };
static const double SINGULAR = 1e-4; /* of singular values: where ways of moving meet */
static const double CLOSED = 1e-9; /* residuals of rows, relative to the motion: near singular positions rounding leaves as much */

int lag_run_row_width(const LagModel *model) { return 1 + 2 * model->n + model->n_outputs + LAG_ACCOUNT_SIZE; }

/* As lag_project_row: most scenes are sooner done. */
static double closed(LagRun *run, double t, double *y, double *energies, double most)
{
    if (run->model->n_multipliers > 0)
        return lag_project_row(run, t, y, energies, most);
    lag_energies(run, t, y, energies);
    return 0;
}

/* A state beyond the range of numbers is no row: exact solvers reach there without a step that could fail. */
static LagStatus row_at(LagRun *run, double t, double *row, int has_energies)
{
    const int n = run->model->n;
    double *y = run->inside, *outputs = row + 1 + 2 * n, *account = outputs + run->model->n_outputs;
    lag_state_inside(run, t, y);
    lag_holds_inside(run, t, y);
    const double most = fmax(run->settings.tolerance, CLOSED), open = has_energies ? closed(run, t, y, account, most) : 0;
    const int i = lag_first_not_finite(y, 2 * n);
    if (n > 0 && !isfinite(y[i]))
        return lag_step_give_up(run, i);
    if (open > most) {
        lag_fail(run, LAG_CONSTRAINTS_OPEN, -1, 0, open);
        run->failure.time = t;
        return LAG_CONSTRAINTS_OPEN;
    }
    row[0] = t;
    memcpy(row + 1, y, 2 * (size_t)n * sizeof *row);
    lag_outputs(run, t, y, outputs);
    lag_unsure_row(run, t, y, outputs);
    if (has_energies)
        lag_account_note(run, t, y, account);
    for (int i = 0; i < (has_energies ? 0 : LAG_ACCOUNT_SIZE); ++i)
        account[i] = NAN;
    run->guards.row = t;
    return LAG_OK;
}

static int time_is_over(LagRun *run) { return ++run->ticks % TICKS_PER_LOOK == 0 && lag_clock() > run->deadline; }

static void set_deadline(LagRun *run, double seconds) { run->deadline = seconds > 0 ? lag_clock() + seconds : INFINITY; }

/* What may turn out to have ended the run in this step is waited for from there on: a later step ends it where that was, and no row
 * comes in between. */
static void wait_for_guards(LagRun *run)
{
    const double t = lag_guards_pending(run);
    if (!(t < run->motion.t))
        return;
    lag_go_back(run, t);
    run->segment_over = 1;
    lag_switches_forget(run);
    lag_guards_forget(run, t);
}

LagStatus lag_advance_step(LagRun *run)
{
    if (run->guards.broken)
        return lag_guards_tell(run);
    const LagStatus status = lag_step(run);
    const int turned = run->branch.turned;
    const int is_lost = status == LAG_OK && turned >= 0 && lag_unsure_is_singular(run, SINGULAR);
    if (is_lost)
        return lag_fail(run, LAG_TURNED_OFF, turned, 1, 0);
    if (status == LAG_OK) {
        lag_guards_watch(run);
        wait_for_guards(run);
    }
    return status;
}

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

LagStatus lag_advance_to(LagRun *run, double t, double *row)
{
    const double time = not_after_stop(run, t);
    const LagStatus status = reach(run, time);
    return status == LAG_OK ? row_at(run, time, row, 1) : status;
}

LagStatus lag_advance_motion_row(LagRun *run, double t, double *row)
{
    run->deadline = INFINITY;
    const double time = not_after_stop(run, t);
    const LagStatus status = reach(run, time);
    return status == LAG_OK ? row_at(run, time, row, run->model->n_multipliers > 0) : status;
}

/* The row at which the run ends as it was meant to, if it was not told already. */
static int is_last_row(LagRun *run, double *row)
{
    return !(run->guards.row >= run->guards.end) && row_at(run, run->guards.end, row, 1) == LAG_OK;
}

LagStatus lag_run_advance(LagRun *run, const double *times, int rows, double *results, int *done, double seconds)
{
    const size_t width = (size_t)lag_run_row_width(run->model);
    set_deadline(run, seconds);
    *done = 0;
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    run->row_spacing = rows > 0 ? (times[rows - 1] - run->motion.t) / rows : 0;
    for (int i = 0; i < rows; ++i) {
        double *row = results + (size_t)i * width;
        const LagStatus status = lag_advance_to(run, times[i], row);
        *done = i + (status == LAG_OK || (status == LAG_ENDED && is_last_row(run, row)));
        if (status != LAG_OK)
            return status == LAG_ENDED ? lag_guards_tell(run) : status;
    }
    return rows > 0 && run->guards.broken && times[rows - 1] >= run->guards.end ? lag_guards_tell(run) : LAG_OK;
}

LagStatus lag_run_advance_steps(LagRun *run, int rows, double *results, int *done, double seconds)
{
    const size_t width = (size_t)lag_run_row_width(run->model);
    set_deadline(run, seconds);
    *done = 0;
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    while (*done < rows && run->motion.t < run->settings.t_stop) {
        LagStatus status = time_is_over(run) ? LAG_PAUSED : lag_advance_step(run);
        if (status == LAG_OK)
            status = row_at(run, lag_guards_limit(run), results + (size_t)*done * width, 1);
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
    return LAG_OK;
}

LagStatus lag_run_row(LagRun *run, double *row)
{
    if (!run->started)
        return lag_fail(run, LAG_NOT_STARTED, -1, 0, 0);
    return row_at(run, lag_guards_limit(run), row, 1);
}
