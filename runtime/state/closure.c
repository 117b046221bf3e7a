/* Residuals have units of their own: lengths, angles, whatever a user writes. J v + dPhi/dt is linear in v, so two states of rates tell
 * what J makes of any displacement: here of all coordinates moved by their sizes, in directions of mixed signs.
 */
#include "state/closure.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "model/function.h"
#include "state/state.h"

enum { LOOKS = 64, WAYS = 3 };
static const double ROUNDINGS = 1e3, FAINT = 1e-10;

void lag_closure_layout(LagClosureMeasure *s, const LagModel *model, LagArena *arena)
{
    const size_t m = (size_t)model->n_multipliers;
    s->reach = lag_take(arena, m);
    s->pace = lag_take(arena, m);
    s->still = lag_take(arena, m);
    s->moved = lag_take(arena, m);
    s->way = lag_take(arena, m > 0 ? (size_t)model->n : 0);
    s->place = lag_take(arena, m > 0 ? (size_t)model->n : 0);
    s->phi = lag_take(arena, (size_t)model->n_holonomic);
}

void lag_closure_forget(LagClosureMeasure *s) { s->left = 0; }

static int rates_of(LagRun *run, double t, const double *q, const double *v, double *rate)
{
    const double *in[] = {&t, q, v, run->u, run->d, run->c};
    double *out[] = {run->projection.measure.phi, rate};
    return lag_call(&run->model->residual, in, out, run->work) == 0;
}

/* Size of position i, or of a rate from n on: the largest so far, the natural one, an angle of 1. */
static double size_of(const LagRun *run, int i, const double *y)
{
    const LagScale *scale = &run->scale;
    const int n = run->model->n;
    const double seen = lag_max(fabs(y[i]), scale->largest[i]);
    return i >= n ? seen : lag_max(seen, isfinite(scale->cap[i]) ? 1 : scale->size[i]);
}

/* What positions (first 0) or rates (first n) make of each constraint at q: raises `found`. */
static void look(LagRun *run, double t, const double *q, const double *y, int way, int first, double *found)
{
    LagClosureMeasure *s = &run->projection.measure;
    for (int i = 0; i < run->model->n; ++i)
        s->way[i] = (i >> way & 1 ? -1 : 1) * size_of(run, first + i, y);
    if (!rates_of(run, t, q, s->way, s->moved))
        return;
    for (int j = 0; j < run->model->n_multipliers; ++j)
        if (isfinite(s->moved[j] - s->still[j]))
            found[j] = lag_max(fabs(s->moved[j] - s->still[j]), found[j]);
}

static int look_both(LagRun *run, double t, const double *q, const double *y, int way)
{
    LagClosureMeasure *s = &run->projection.measure;
    memset(s->way, 0, (size_t)run->model->n * sizeof *s->way);
    if (!rates_of(run, t, q, s->way, s->still))
        return 0;
    for (int j = 0; j < run->model->n_holonomic; ++j)
        if (isfinite(s->phi[j]))
            s->reach[j] = lag_max(fabs(s->phi[j]), s->reach[j]);
    look(run, t, q, y, way, 0, s->reach);
    look(run, t, q, y, way, run->model->n, s->pace);
    return 1;
}

/* What repeats others by its form is rounding everywhere: it has no measure. */
static void forget_faint(const LagRun *run, const double *y, int first, double *found)
{
    const int n = run->model->n, m = run->model->n_multipliers;
    double largest = lag_largest(found, (size_t)m);
    for (int i = first; i < first + n; ++i)
        largest = lag_max(size_of(run, i, y), largest);
    for (int j = 0; j < m; ++j)
        found[j] = found[j] > FAINT * largest ? found[j] : 0;
}

/* Here, and as far away as coordinates go: at singular positions some constraints make nothing of any motion. */
static int find_measures(LagRun *run, double t, const double *y)
{
    LagClosureMeasure *s = &run->projection.measure;
    const size_t size = (size_t)run->model->n_multipliers * sizeof *s->reach;
    int is_known = 0;
    memset(s->reach, 0, size);
    memset(s->pace, 0, size);
    lag_inputs_at(&run->inputs, t, run->u);
    for (int way = 0; way < WAYS; ++way) {
        is_known |= look_both(run, t, y, y, way);
        for (int i = 0; i < run->model->n; ++i)
            s->place[i] = y[i] + (i >> way & 1 ? -1 : 1) * size_of(run, i, y);
        is_known |= look_both(run, t, s->place, y, way);
    }
    forget_faint(run, y, 0, s->reach);
    forget_faint(run, y, run->model->n, s->pace);
    return is_known;
}

static double largest_open(const LagRun *run, const double *phi, const double *rate)
{
    const LagClosureMeasure *s = &run->projection.measure;
    const double h = run->motion.t - run->motion.t_old;
    double largest = 0;
    for (int j = 0; j < run->model->n_holonomic; ++j)
        if (s->reach[j] > 0)
            largest = lag_max(fabs(phi[j]) / s->reach[j], largest);
    for (int j = 0; j < run->model->n_multipliers && h > 0; ++j) {
        const double rounding = ROUNDINGS * DBL_EPSILON * s->reach[j] / h, open = fabs(rate[j]) - rounding;
        if (open > 0 && s->pace[j] > 0)
            largest = lag_max(open / s->pace[j], largest);
    }
    return largest;
}

double lag_closure_open(LagRun *run, double t, const double *y, const double *phi, const double *rate, double most)
{
    LagClosureMeasure *s = &run->projection.measure;
    const double found = s->left-- > 0 ? largest_open(run, phi, rate) : INFINITY;
    if (found <= most)
        return found;
    s->left = LOOKS;
    return find_measures(run, t, y) ? largest_open(run, phi, rate) : INFINITY;
}
