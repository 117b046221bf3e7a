#include "methods/wide_starts.h"

#include <math.h>
#include <string.h>

#include "methods/wide_attitudes.h"
#include "methods/wide_orders.h"
#include "state/onset.h"

static const double FIRST_PART = 0.5; /* of the time in which what moves changes: about a first step */

void lag_wide_starts_learn(LagWideTaylor *s, int lane)
{
    s->first_time = s->lanes.t[lane];
    s->first_stop = s->lanes.stop[lane];
    s->first_length = s->lanes.length[lane];
    lag_wide_take(s->series.line + lag_wide_input(s) * LAG_ABREAST, lane, s->first_u, s->lanes.model->n_inputs);
    lag_wide_take(s->slope, lane, s->first_slope, s->lanes.model->n_inputs);
}

void lag_wide_starts_place(void *self, int lane, const double *y)
{
    LagWideTaylor *s = self;
    LagWideSteps *steps = &s->lanes;
    lag_wide_scale_forget(&steps->scale, lane);
    lag_wide_place(steps->y, lane, y, 2 * steps->n);
    for (int i = 0; i < steps->size; ++i)
        steps->carry[i * LAG_ABREAST + lane] = 0;
    for (int i = 2 * steps->n; i < steps->size; ++i)
        steps->y[i * LAG_ABREAST + lane] = steps->old[i * LAG_ABREAST + lane] = 0;
    s->series.line[lane] = s->first_time;
    lag_wide_place(s->series.line + LAG_ABREAST, lane, y, 2 * steps->n);
    lag_wide_place(s->series.line + lag_wide_input(s) * LAG_ABREAST, lane, s->first_u, steps->model->n_inputs);
    lag_wide_place(s->slope, lane, s->first_slope, steps->model->n_inputs);
    steps->t[lane] = steps->t_old[lane] = s->first_time;
    steps->stop[lane] = s->first_stop;
    steps->length[lane] = s->first_length;
    steps->moves[lane] = steps->taken[lane] = s->entered[lane] = 1;
    steps->steps[lane] = steps->in_vain[lane] = steps->missed[lane] = steps->energy[lane] = s->own[lane] = 0;
    s->limit[lane] = s->wrong[lane] = INFINITY;
    steps->is_fresh = 1;
    s->begins[lane] = LAG_BEGINS_UNSEEN;
}

void lag_wide_starts_hold(LagWideTaylor *s, int lane, const double *u, double stop)
{
    double *line = s->series.line + lag_wide_input(s) * LAG_ABREAST;
    for (int i = 0; i < s->lanes.model->n_inputs; ++i) {
        line[i * LAG_ABREAST + lane] = u[i];
        s->slope[i * LAG_ABREAST + lane] = 0;
    }
    s->lanes.stop[lane] = stop;
    s->lanes.is_fresh = 1;
    s->entered[lane] = 1;
}

/* -------- of as many lanes from `lane` on as a register holds */

static LagWide root_of(LagWide x)
{
    double each[LAG_WIDE];
    memcpy(each, &x, sizeof each);
    for (int i = 0; i < LAG_WIDE; ++i)
        each[i] = sqrt(each[i]);
    memcpy(&x, each, sizeof each);
    return x;
}

static LagWide acceleration(const LagWideTaylor *s, int lane, int i)
{
    return lag_wide_of(s->series.line, s->lanes.model->jet_places[i], lane);
}

/* How long what moves takes to become another motion, about, of the kind for which that is soonest: the step that a run plans itself,
 * which asks for more accelerations, is not worth its time here, as series tell how long they serve. */
static LagWide pace_of(const LagWideTaylor *s, int lane)
{
    const LagWideSteps *steps = &s->lanes;
    const LagWide zero = LAG_WIDE_OF(0);
    LagWide soonest = lag_wide_read(steps->length + lane);
    for (int kind = 0; kind < steps->scale.kinds; ++kind) {
        LagWide place = zero, rate = zero, change = zero;
        for (int i = 0; i < steps->n; ++i) {
            if (steps->scale.kind[i] != kind)
                continue;
            place = lag_wide_max(LAG_WIDE_ABS(lag_wide_of(steps->y, i, lane)), place);
            rate = lag_wide_max(LAG_WIDE_ABS(lag_wide_of(steps->y, steps->n + i, lane)), rate);
            change = lag_wide_max(LAG_WIDE_ABS(acceleration(s, lane, i)), change);
        }
        const LagWide time = (rate + root_of(change * place)) / change;
        soonest = LAG_WIDE_SELECT(change > zero, LAG_WIDE_SELECT(time > zero, lag_wide_min(time, soonest), soonest), soonest);
    }
    return soonest;
}

/* 1 where some kind rests so far; and where such a one is moved by nothing, into `is_still`. */
static LagWide is_resting(const LagWideTaylor *s, int lane, LagWide *is_still)
{
    const LagWideScale *scale = &s->lanes.scale;
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1);
    LagWide rests = zero;
    *is_still = zero;
    for (int i = 0; i < scale->n; ++i) {
        const LagWide moving = lag_wide_of(scale->group, scale->kinds + scale->kind[i], lane);
        LagWide pushed = moving;
        for (int k = 0; k < scale->n; ++k)
            if (scale->kind[k] == scale->kind[i])
                pushed = lag_wide_max(LAG_WIDE_ABS(acceleration(s, lane, k)), pushed);
        rests = LAG_WIDE_SELECT(moving > zero, rests, one);
        *is_still = LAG_WIDE_SELECT(pushed < LAG_WIDE_OF(LAG_ONSET_FAINT), one, *is_still);
    }
    return rests;
}

/* About where the first steps of motions that begin lead: states which units of error are taken for. Those for which nothing tells how fast
 * something will be that rests so far move no more. */
static void foresee(LagWideTaylor *s, int lane)
{
    LagWideSteps *steps = &s->lanes;
    const int n = steps->n;
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1), half = LAG_WIDE_OF(0.5), begins = lag_wide_read(s->begins + lane);
    const LagWide h = LAG_WIDE_OF(FIRST_PART) * pace_of(s, lane);
    LagWide is_still, probe = zero, is_told = one;
    const LagWide rests = is_resting(s, lane, &is_still);
    for (int i = 0; i < n; ++i) {
        const LagWide a = acceleration(s, lane, i), v = lag_wide_of(steps->y, n + i, lane), rate = v + h * a;
        lag_wide_choose(steps->old, i, lane, begins, lag_wide_of(steps->y, i, lane) + h * (v + h * half * a));
        lag_wide_choose(steps->old, n + i, lane, begins, rate);
        probe += zero * rate;
        is_told = LAG_WIDE_SELECT(LAG_WIDE_ABS(rate) > zero, is_told, one - rests);
    }
    const LagWide unseen = LAG_WIDE_SELECT(begins > one, rests * is_still, zero); /* nobody has looked at loads to come */
    const LagWide is_finite = LAG_WIDE_SELECT(probe == zero, is_told, zero);
    const LagWide goes = LAG_WIDE_SELECT(h > zero, LAG_WIDE_SELECT(unseen > zero, zero, is_finite), zero);
    lag_wide_choose(steps->length, 0, lane, begins, h);
    lag_wide_choose(steps->moves, 0, lane, begins, goes);
    lag_wide_write(s->begins + lane, zero);
}

void lag_wide_starts_settle(void *self)
{
    LagWideTaylor *s = self;
    lag_wide_taylor_begin(s);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        lag_wide_scale_note(&s->lanes.scale, lane, s->lanes.y);
        foresee(s, lane);
    }
}
