/* Taylor steps: A. Jorba, M. Zou, Experimental Mathematics 14 (2005). The order follows from the tolerance, -ln(eps)/2 + 1,
 * which makes digits cheapest; the length of a step from the last two coefficients, so hardly a step is ever rejected. The
 * series at the end of a step, differentiated, is compared with the accelerations there: a check that costs nothing, as they
 * are the first coefficients of the next step.
 */
#include "taylor.h"

#include <math.h>
#include <string.h>

#include "segment.h"
#include "step.h"

enum { LEAST_ORDER = 4 };
/* What the last coefficient and the last but one may be worth in units of error, so that errors are those of Dormand-Prince at
 * the same tolerance; by how much a step may be wrong at its end; shrinking after a step that was. */
static const double LAST = 0.15, BEFORE_LAST = 1.1, WRONG = 20, SHRINK = 0.5, GROW = 100;

/* What a step costs, in tenths of a nanosecond, here and by Dormand-Prince 8(5,3), and by how much its steps of order 8 are
 * longer than eps^(1/8) radii of convergence: measured on pendulums, springs, chains of springs and Kepler orbits. */
static const double STEP = 1600, JET = 6, PRODUCT = 2, OTHER_STEP = 1000, OTHER_SUM = 600, OTHER_STAGES = 12, OTHER_LENGTH = 1.25;

static double *jet(double *jets, int slot) { return jets + (size_t)slot * LAG_JET_STRIDE; }

static void layout(void *self, const LagMotion *motion, LagArena *arena)
{
    LagTaylor *s = self;
    const size_t size = (size_t)motion->n_jets * LAG_JET_STRIDE;
    s->jets = lag_take(arena, size);
    s->old_jets = lag_take(arena, size);
}

static void restart(void *self, LagMotion *motion)
{
    LagTaylor *s = self;
    s->begun = 0;
    motion->t_old = motion->t;
}

/* Coefficients of time and inputs, which are linear in a segment. */
static void place_known(LagRun *run, double *jets)
{
    const LagMotion *m = &run->motion;
    const int n_inputs = run->model->n_inputs, first = 1 + 2 * m->n;
    double *t = jet(jets, 0);
    memset(t, 0, LAG_JET_STRIDE * sizeof *t);
    t[0] = m->t;
    t[1] = 1;
    for (int i = 0; i < n_inputs; ++i)
        memset(jet(jets, first + i), 0, LAG_JET_STRIDE * sizeof *t);
    if (n_inputs == 0)
        return;
    lag_inputs_at(&run->inputs, m->t + 1, run->u);
    for (int i = 0; i < n_inputs; ++i)
        jet(jets, first + i)[1] = run->u[i];
    lag_inputs_at(&run->inputs, m->t, run->u);
    for (int i = 0; i < n_inputs; ++i) {
        jet(jets, first + i)[0] = run->u[i];
        jet(jets, first + i)[1] -= run->u[i];
    }
}

/* The coefficients of order k of everything, and from them those of order k + 1 of the state. Returns 1 when finite. */
static int expand(LagRun *run, double *jets, int k)
{
    const LagModel *model = run->model;
    const int n = model->n;
    const double *in[] = {run->d, run->c};
    double probe = 0;
    model->taylor(k, in, jets);
    for (int i = 0; i < n; ++i) {
        const double a = jet(jets, model->jet_places[i])[k];
        jet(jets, 1 + i)[k + 1] = jet(jets, 1 + n + i)[k] / (k + 1);
        jet(jets, 1 + n + i)[k + 1] = a / (k + 1);
        probe += 0 * a;
    }
    for (int i = 0; i < model->n_power; ++i)
        probe += 0 * jet(jets, model->jet_places[n + i])[k];
    return probe == 0;
}

/* The series at the present state up to the given order. Returns 1 when all is finite. */
static int build(LagRun *run, LagTaylor *s, int order)
{
    const LagMotion *m = &run->motion;
    if (s->begun == 0) {
        place_known(run, s->jets);
        for (int i = 0; i < 2 * m->n; ++i)
            jet(s->jets, 1 + i)[0] = m->y[i];
        ++run->motion.evaluations;
    }
    for (; s->begun < order; ++s->begun)
        if (!expand(run, s->jets, s->begun))
            return 0;
    return 1;
}

/* sum of coefficients from 1 to the order times h^k, Horner. */
static double series(const double *coefficient, int order, double h)
{
    double sum = 0;
    for (int k = order; k > 0; --k)
        sum = (sum + coefficient[k]) * h;
    return sum;
}

/* What a step of length h adds to the state. */
static void displacement(const LagRun *run, const double *jets, int order, double h, double *step)
{
    const LagModel *model = run->model;
    const int n = model->n;
    for (int i = 0; i < 2 * n; ++i)
        step[i] = series(jet((double *)jets, 1 + i), order, h);
    for (int i = 0; i < model->n_power; ++i) { /* the integral of a series */
        const double *power = jet((double *)jets, model->jet_places[n + i]);
        double sum = 0;
        for (int k = order - 1; k >= 0; --k)
            sum = sum * h + power[k] / (k + 1);
        step[2 * n + i] = sum * h;
    }
}

/* The states at both ends of a step like the planned one, which units are taken for. */
static void look_at_units(LagRun *run, const LagTaylor *s)
{
    LagMotion *m = &run->motion;
    displacement(run, s->jets, s->order, run->step, m->sum);
    for (int i = 0; i < 2 * m->n; ++i)
        m->point[i] = m->y[i] + m->sum[i];
}

/* The largest coefficient of order k, in units of error; *worst is its component. */
static double largest(const LagRun *run, const LagTaylor *s, int k, int32_t *worst)
{
    const LagMotion *m = &run->motion;
    double most = 0;
    for (int i = 0; i < 2 * m->n; ++i) {
        const double unit = lag_scale_unit(&run->scale, i, m->y, m->point), value = fabs(jet(s->jets, 1 + i)[k]);
        if (unit > 0 && value > most * unit) {
            most = value / unit;
            *worst = i;
        }
    }
    return most;
}

/* The length at which the last two coefficients are worth a unit of error. */
static double length_of(LagRun *run, const LagTaylor *s)
{
    const int p = s->order;
    int32_t other = 0;
    look_at_units(run, s);
    const double last = largest(run, s, p, &run->statistics.worst) / LAST, before = largest(run, s, p - 1, &other) / BEFORE_LAST;
    return fmin(pow(last, -1.0 / p), pow(before, -1.0 / (p - 1)));
}

/* How far the accelerations at the end of the step are from the slope of the series there, as an error of the rates in units. */
static double defect(LagRun *run, const LagTaylor *s, double h)
{
    const LagMotion *m = &run->motion;
    const int n = m->n;
    double largest = 0;
    for (int i = 0; i < n; ++i) {
        const double *v = jet(s->jets, 1 + n + i), a = jet(s->old_jets, run->model->jet_places[i])[0];
        const double unit = lag_scale_unit(&run->scale, n + i, m->y, m->other);
        double slope = 0;
        for (int k = s->order; k > 0; --k)
            slope = slope * h + k * v[k];
        if (unit > 0)
            largest = fmax(largest, fabs(a - slope) * h / ((s->order + 1) * unit));
    }
    return largest;
}

/* The first coefficients of the next step, in the place of those of the step before this one. */
static int look_ahead(LagRun *run, LagTaylor *s, double t_new)
{
    LagMotion *m = &run->motion;
    const double t = m->t;
    m->t = t_new;
    place_known(run, s->old_jets);
    m->t = t;
    for (int i = 0; i < 2 * m->n; ++i)
        jet(s->old_jets, 1 + i)[0] = m->other[i];
    ++m->evaluations;
    return expand(run, s->old_jets, 0);
}

static int order_for(double tolerance)
{
    const int order = (int)ceil(1 - 0.5 * log(tolerance));
    return order < LEAST_ORDER ? LEAST_ORDER : order < LAG_JET_ORDER ? order : LAG_JET_ORDER;
}

static LagStatus step(LagRun *run)
{
    LagTaylor *s = &run->methods.taylor;
    LagMotion *m = &run->motion;
    int worst = 0;
    s->order = order_for(run->scale.tolerance);
    if (!build(run, s, s->order))
        return lag_step_give_up(run, worst);
    double h = fmin(length_of(run, s), GROW * run->step); /* at rest a series says nothing of what comes */
    if (run->settings.max_step > 0)
        h = fmin(h, run->settings.max_step);
    for (;; h *= SHRINK) {
        const double t_new = lag_step_end(run, h), length = t_new - m->t;
        if (!(length >= lag_step_smallest(m->t)))
            return lag_step_give_up(run, run->statistics.worst);
        displacement(run, s->jets, s->order, length, m->sum);
        lag_motion_add(m, m->sum);
        m->t_old = m->t;
        if (lag_project_step(run, t_new, &worst) && look_ahead(run, s, t_new) && defect(run, s, length) <= WRONG) {
            double *jets = s->jets;
            s->jets = s->old_jets;
            s->old_jets = jets;
            s->begun = 1;
            lag_motion_take(m, t_new);
            run->step = length;
            lag_step_record(run, length);
            return LAG_OK;
        }
        ++run->statistics.rejected;
        h = fmin(h, length);
    }
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    const LagTaylor *s = self;
    const LagRun *run = m->context;
    displacement(run, s->old_jets, s->order, t - m->t_old, y);
    for (int i = 0; i < m->size; ++i)
        y[i] += m->other[i];
}

int lag_taylor_pays(const LagModel *model, double tolerance)
{
    const double eps = lag_scale_caution(tolerance), p = order_for(eps);
    const double length = exp(log(eps) / p), other_length = OTHER_LENGTH * pow(eps, 1.0 / 8); /* in radii of convergence */
    const double cost = STEP + p * (JET * model->n_jets + PRODUCT * p / 2 * model->n_products);
    const double other_cost = OTHER_STEP + OTHER_SUM * model->n + OTHER_STAGES * model->series_rhs_cost;
    return model->n_jets > 0 && cost * other_length < other_cost * length;
}

const LagMethod lag_taylor = {"taylor", 8, layout, restart, step, NULL, NULL, interpolate};
