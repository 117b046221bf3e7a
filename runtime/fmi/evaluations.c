/* What follows from time, state and inputs: slopes, outputs, event indicators.
 *
 * In Model Exchange the importer integrates, and constraints of closed loops are kept by the slopes: see exchange.c. */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "events/accelerations.h"
#include "events/conditions.h"
#include "events/cones.h"
#include "model/schedule.h"
#include "state/state.h"

void lag_instance_forget(LagInstance *s)
{
    s->vital.slope_is_current = s->vital.outputs_are_current = s->vital.energies_are_current = 0;
}

/* The state on the constraints that equations and conditions are those of. */
double *lag_instance_projected(LagInstance *s, double t, const double *x)
{
    if (s->model->n > 0)
        memcpy(s->projected, lag_instance_plain(s, x), 2 * (size_t)s->model->n * sizeof *x);
    if (s->model->n_multipliers > 0 && s->kind == LAG_MODEL_EXCHANGE)
        lag_project_inside(s->run, t, s->projected);
    return s->projected;
}

/* Accelerations at rates v; in Model Exchange, where slips in the plane do not turn round within a step, and what slides does not give
 * more than it has. */
static int accelerations(LagInstance *s, double t, const double *q, double *v, double *a, double *power)
{
    const double *sizes = s->fmu->nominal + s->model->n;
    const int is_exchanged = s->kind == LAG_MODEL_EXCHANGE;
    double *mirrored = is_exchanged ? lag_cones_mirrored(s->run, t, q, v, sizes) : NULL;
    s->run->sliding.is_limited = is_exchanged;
    const int is_found = lag_accelerations(s->run, t, q, mirrored ? mirrored : v, a, power);
    s->run->sliding.is_limited = 0;
    return is_found;
}

/* Slopes that lead back to the constraints, and to unit quaternions; 1 when all are finite. */
static int held_slope_at(LagInstance *s, double t, const double *x, double *slope, double *power)
{
    const LagModel *m = s->model;
    const double k = s->kind == LAG_MODEL_EXCHANGE ? s->fmu->stabilisation : 0;
    double *projected = lag_instance_projected(s, t, x), *v = projected + m->n, probe = 0;
    lag_instance_tell(s, projected, s->told);
    if (!accelerations(s, t, projected, v, slope + lag_fmu_positions(m), power))
        return 0;
    lag_instance_pace(m, s->told, v, slope);
    for (int i = 0; i < lag_fmu_states(m); ++i) {
        slope[i] += k * (s->told[i] - x[i]);
        probe += 0 * slope[i];
    }
    return probe == 0;
}

/* Returns 1 when all are finite. */
int lag_instance_slope_at(LagInstance *s, double t, const double *x, double *slope, double *power)
{
    const int n = s->model->n;
    if ((s->model->n_multipliers > 0 && s->kind == LAG_MODEL_EXCHANGE) || s->model->n_attitudes > 0)
        return held_slope_at(s, t, x, slope, power);
    if (n > 0)
        memcpy(slope, x + n, (size_t)n * sizeof *slope);
    return accelerations(s, t, x, slope, slope + n, power);
}

/* Where an importer goes on beyond the end of a table that says nothing there. */
static int is_beyond_table(const LagInstance *s)
{
    const LagRun *run = s->run;
    return run && run->silent_table >= 0 && fabs(s->vital.t - run->motion.t) > lag_time_resolution(run->motion.t);
}

LagAnswer lag_instance_slope(LagInstance *s)
{
    if (s->vital.slope_is_current)
        return LAG_ANSWER_OK;
    if (is_beyond_table(s))
        return lag_instance_failed(s, lag_fail(s->run, LAG_TABLE_ENDED, -1, 0, s->run->silent_table));
    if (!s->run || !lag_instance_slope_at(s, s->vital.t, s->x, s->slope, s->power))
        return lag_instance_log(s, LAG_ANSWER_DISCARD, "logStatusDiscard", "at t = %.9g s the accelerations are not finite",
                                s->vital.t);
    s->vital.slope_is_current = 1;
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_outputs(LagInstance *s)
{
    if (!s->vital.outputs_are_current && s->run) {
        s->run->sliding.is_limited = s->kind == LAG_MODEL_EXCHANGE;
        lag_outputs(s->run, s->vital.t, lag_instance_projected(s, s->vital.t, s->x), s->outputs);
        s->run->sliding.is_limited = 0;
    }
    s->vital.outputs_are_current = 1;
    return LAG_ANSWER_OK;
}

static double slack_of(const LagInstance *s, int i)
{
    return lag_is_event(s->model, i) ? s->slack[i - lag_when(s->model, 0)] : 0;
}

/* Above 0 as long as the equations hold, with what is rounding around it. */
LagAnswer lag_instance_indicators(LagInstance *s)
{
    LagRun *run = s->run;
    if (!run || s->model->n_switches == 0)
        return LAG_ANSWER_OK;
    const LagSwitches *switches = &run->switches;
    lag_conditions(run, s->vital.t, lag_instance_projected(s, s->vital.t, s->x), switches->g_inside, switches->rate_inside);
    for (int i = 0; i < s->model->n_switches; ++i)
        s->indicators[i] = lag_depth(switches, i, switches->g_inside) + switches->unknown[i] + slack_of(s, i);
    lag_cones_turns(run, switches->g_inside, s->indicators);
    return LAG_ANSWER_OK;
}
