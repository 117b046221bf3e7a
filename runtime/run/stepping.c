#include "run/stepping.h"

#include <math.h>

#include "base/clock.h"
#include "run/advance.h"
#include "state/state.h"

/* Whether a table of one row with these values is in force. */
static int is_held(const LagInputs *inputs, const double *u)
{
    int equal = inputs->rows == 1 ? 0 : -1;
    while (equal >= 0 && equal < inputs->n && inputs->values[equal] == u[equal])
        ++equal;
    return equal == inputs->n;
}

LagStatus lag_run_hold(LagRun *run, const double *u)
{
    const double t = run->started ? run->motion.t : run->settings.t_start;
    return run->model->n_inputs == 0 || is_held(&run->inputs, u) ? LAG_OK : lag_run_set_inputs(run, &t, u, 1);
}

LagStatus lag_run_steps(LagRun *run, double begin, double dt, int64_t first, int steps, const double *u, double *rows, int *done,
                        double seconds)
{
    const size_t width = (size_t)lag_run_row_width(run->model), n = (size_t)run->model->n_inputs;
    LagStatus status = LAG_OK;
    run->deadline = seconds > 0 ? lag_clock() + seconds : INFINITY;
    run->row_spacing = dt;
    *done = 0;
    for (int k = 0; k < steps && status == LAG_OK; ++k) {
        const double end = begin + (double)(first + k + 1) * dt;
        lag_run_set_stop(run, end);
        status = u ? lag_run_hold(run, u + (size_t)k * n) : LAG_OK;
        if (status == LAG_OK)
            status = lag_advance_to(run, end, rows + (size_t)k * width);
        *done += status == LAG_OK;
    }
    return status;
}
