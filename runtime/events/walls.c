#include "events/walls.h"

#include <math.h>
#include <string.h>

#include "events/conditions.h"
#include "numbers/extremes.h"
#include "model/schedule.h"
#include "state/evaluate.h"

static const double LEAST = 1e-14; /* m, or rad: rounding of what a gap is made of, where its parts are some 50 m or less */
static const double GONE = 64;     /* times what may be carried along: no drift */

/* How far the place of contact k may jump and carry along what rests there. Where all is at 0 nothing has a size, and the least jump,
 * by rounding of what the gap is made of, would be larger. */
static double carries(const LagRun *run, int k)
{
    const int i = lag_gap(run->model, k);
    return lag_max(lag_max(run->switches.unknown[i], run->sliding.error[i]), LEAST) + run->impacts.carried[k];
}

void lag_walls_await_inputs(LagRun *run, double t, const double *y)
{
    const LagModel *model = run->model;
    const LagInputs *inputs = &run->inputs;
    LagSwitches *s = &run->switches;
    const size_t size = (size_t)model->n_modes * sizeof *run->d;
    if (model->n_whens == 0 || inputs->n_pieces == 0 || run->inputs_version == inputs->version)
        return;
    memcpy(run->d_before, run->d, size);
    lag_inputs_read(inputs, run->d);
    for (const int *places = inputs->pieces; places < inputs->pieces + 4 * inputs->n_pieces; places += 4)
        if (places[1] < 0)
            memcpy(run->d + places[3], run->d_before + places[3], LAG_PIECE * sizeof *run->d);
    lag_conditions_by(run, t, y, y + model->n, s->slope + model->n, s->g_inside, s->rate_inside);
    for (int k = 0; k < model->n_whens; ++k)
        run->impacts.carried[k] = fabs(s->g_inside[lag_gap(model, k)] - run->impacts.gap_before[k]);
    memcpy(run->d, run->d_before, size);
}

void lag_walls_await_errors(LagRun *run)
{
    for (int k = 0; k < run->model->n_whens; ++k)
        if (run->switches.slides[lag_contact(run->model, k)])
            run->impacts.carried[k] += fabs(run->impacts.gap_before[k]);
}

int lag_walls_have_moved(LagRun *run, int k, double gap)
{
    const int is_place = run->impacts.has_contact[k] == LAG_CONTACT;
    const int is_moved = is_place && fabs(gap - run->impacts.gap_before[k]) > carries(run, k);
    if (is_moved)
        run->switches.slides[lag_contact(run->model, k)] = 0;
    return is_moved;
}

void lag_walls_let_go(LagRun *run, int k)
{
    LagSwitches *s = &run->switches;
    const double gap = s->g[lag_gap(run->model, k)];
    int *slides = &s->slides[lag_contact(run->model, k)];
    if (!*slides || run->impacts.has_contact[k] != LAG_CONTACT || fabs(gap) <= GONE * carries(run, k))
        return;
    *slides = 0;
    if (gap > 0)
        s->turned[lag_when(run->model, k)] = LAG_JUMPS;
}
