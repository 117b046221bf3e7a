#include "methods/taylor_defect.h"

#include <math.h>

#include "methods/taylor_long.h"
#include "numbers/extremes.h"

static const double WRONG = LAG_TAYLOR_WRONG, JUMP = 0.25; /* of the largest acceleration of a kind */

/* The largest acceleration of the kind of i at the end of the step. */
static double largest_like(const LagRun *run, int i)
{
    const LagModel *model = run->model;
    double size = 0;
    for (int k = 0; k < model->n; ++k)
        if (model->coordinate_kind[k] == model->coordinate_kind[i])
            size = lag_max(fabs(*lag_taylor_jet(model, run->methods.taylor.old_jets, model->jet_places[k])), size);
    return size;
}

/* By how much acceleration i at the end of the step is another than the slope of the series there. */
static double miss_of(const LagRun *run, double h, int i)
{
    const LagTaylor *s = &run->methods.taylor;
    const LagModel *model = run->model;
    const int place = model->jet_places[i];
    const double slope = lag_jet_value(lag_taylor_jet(model, s->jets, place), model->jet_pitch, s->order - 1, h);
    return fabs(*lag_taylor_jet(model, s->old_jets, place) - slope);
}

/* Of rate i, in a step of length h: where nothing of its kind has moved yet, by what the accelerations at its end would make. */
static double unit_of(const LagRun *run, double h, int i)
{
    const double unit = lag_scale_unit(&run->scale, run->motion.n + i, run->motion.y, run->motion.other);
    return unit > 0 ? unit : run->scale.tolerance * h * largest_like(run, i);
}

/* How far the accelerations at the end of the step are from the slope of the series there, in units of rates, which are
 * worth `share` of an error each: but for the rounding of the largest one of its kind. */
static double gap(LagRun *run, double h, double share)
{
    double largest = 0;
    for (int i = 0; i < run->motion.n; ++i) {
        const double unit = unit_of(run, h, i), miss = miss_of(run, h, i);
        if (unit > 0 && miss / unit > largest && (miss / unit * share <= WRONG || miss > LAG_TAYLOR_ROUNDING * largest_like(run, i)))
            largest = miss / unit;
    }
    return largest;
}

/* Whether one of them jumps by more than may be wrong, as where two points pass through each other. */
static int jumps(const LagRun *run, double h, double share)
{
    for (int i = 0; i < run->motion.n; ++i) {
        const double miss = miss_of(run, h, i);
        if (miss * share > WRONG * unit_of(run, h, i) && miss > JUMP * largest_like(run, i))
            return 1;
    }
    return 0;
}

double lag_taylor_defect(LagRun *run, double h, int *is_jump)
{
    const double share = h / (run->methods.taylor.order + 1);
    *is_jump = run->model->n_roots > 0 && jumps(run, h, share);
    return (run->model->is_long_state ? lag_long_gap(run) : gap(run, h, share)) * share;
}
