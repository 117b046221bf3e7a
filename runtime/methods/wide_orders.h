/* How many orders the series of eight motions need (wide_taylor.h), and how long steps of all of them may be. */
#ifndef LAG_WIDE_ORDERS_H
#define LAG_WIDE_ORDERS_H

#include <float.h>

#include "methods/wide_taylor.h"
#include "numbers/wide_jets.h"
#include "numbers/wide_power.h"

/* The slot of the first input; the coefficients of a slot, and of an integrand of the energy account. */
static inline int lag_wide_input(const LagWideTaylor *s) { return 1 + 2 * s->lanes.n; }

static inline double *lag_wide_jet(const LagWideTaylor *s, int slot) { return s->series.jets + (size_t)slot * LAG_WIDE_JET; }

static inline const double *lag_wide_power_jet(const LagWideTaylor *s, int i)
{
    return lag_wide_jet(s, s->lanes.model->jet_places[s->lanes.n + i]);
}

/* 1 / units of positions and rates in steps between the present states and y, of the length `step`. */
LAG_UNROLLED void lag_wide_weigh(const LagWideTaylor *s, int lane, const double *y, LagWide step, double *weight)
{
    const LagWide zero = LAG_WIDE_OF(0), uncertain = LAG_WIDE_OF(DBL_EPSILON) * lag_wide_rough_inverse(step);
    for (int i = 0; i < s->lanes.n; ++i) {
        LagWide unit[2];
        lag_wide_scale_units(&s->lanes.scale, i, lane, s->lanes.y, y, step, uncertain, &unit[0], &unit[1]);
        for (int is_rate = 0; is_rate < 2; ++is_rate)
            lag_wide_write(weight + (size_t)(i + is_rate * s->lanes.n) * LAG_ABREAST + lane,
                           LAG_WIDE_SELECT(unit[is_rate] > zero, lag_wide_rough_inverse(unit[is_rate]), zero));
    }
}

/* The series from their first coefficients on, up to the order that the most demanding lane asks for: own, made_to, and reach, where some
 * lane asks for all orders. */
void lag_wide_orders_expand(LagWideTaylor *taylor);

/* Whether some lane does with fewer orders than all. */
int lag_wide_orders_differ(const LagWideTaylor *taylor);

#endif
