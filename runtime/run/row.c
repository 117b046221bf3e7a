#include "run/row.h"

#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "run/run.h"
#include "state/account.h"
#include "state/evaluate.h"
#include "state/inside.h"
#include "steps/step.h"

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

static void leave_out(double *values, int count)
{
    for (int k = 0; k < count; ++k)
        values[k] = NAN;
}

/* A state beyond the range of numbers is no row: exact solvers reach there without a step that could fail. */
LagStatus lag_row_at(LagRun *run, double t, double *row, int parts)
{
    const int n = run->model->n, has_energies = parts & LAG_ROW_ENERGIES;
    double *y = run->inside, *outputs = row + 1 + 2 * n, *account = outputs + run->model->n_outputs;
    lag_held_state_inside(run, t, y);
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
    if (parts & LAG_ROW_OUTPUTS) {
        lag_outputs(run, t, y, outputs);
        lag_unsure_row(run, t, y, outputs);
    } else
        leave_out(outputs, run->model->n_outputs);
    if (has_energies)
        lag_account_note(run, t, y, account);
    else
        leave_out(account, LAG_ACCOUNT_SIZE);
    run->guards.row = t;
    return LAG_OK;
}
