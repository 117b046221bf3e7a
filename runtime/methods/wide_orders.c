#include "methods/wide_orders.h"

#include <math.h>

#include "methods/taylor.h"
#include "methods/taylor_attitudes.h"
#include "numbers/extremes.h"

/* The first order that short steps are looked at after; steps that are so many times longer than the one before are not short. */
enum { FEWEST = 4 };
static const double NEAR = 4;

/* -------- of as many lanes from `lane` on as a register holds */

/* Where no step has: by that before, whose end is the present. */
static void weigh_entered(LagWideTaylor *s, int lane)
{
    const LagWide entered = lag_wide_read(s->entered + lane);
    if (!lag_wide_is_some(entered))
        return;
    lag_wide_weigh(s, lane, s->lanes.old, lag_wide_read(s->lanes.length + lane), s->next_weight);
    lag_wide_take_over(s->weight, s->next_weight, 2 * s->lanes.n, lane, entered, 0);
    lag_wide_write(s->entered + lane, LAG_WIDE_OF(0));
}

/* The coefficients of the orders p and p - 1 in units of error: what they are at lengths of 1. */
LAG_UNROLLED void last_terms(const LagWideTaylor *s, int lane, int p, LagWide *last, LagWide *before)
{
    *last = *before = LAG_WIDE_OF(0);
    for (int i = 0; i < 2 * s->lanes.n; ++i) {
        if (lag_taylor_is_turned(s->lanes.model, i))
            continue;
        const double *c = lag_wide_jet(s, 1 + i) + lane;
        const LagWide weight = lag_wide_of(s->weight, i, lane);
        *last = lag_wide_max(LAG_WIDE_ABS(LAG_WIDE_TERM(c, p)) * weight, *last);
        *before = lag_wide_max(LAG_WIDE_ABS(LAG_WIDE_TERM(c, p - 1)) * weight, *before);
    }
    for (int i = 0; i < 4 * s->lanes.model->n_attitudes; ++i) {
        const double *c = lag_wide_jet(s, lag_wide_quaternion(s->lanes.model, 0) + i) + lane;
        const int place = lag_attitude_place(s->lanes.model->attitudes, i / 4);
        const LagWide weight = LAG_WIDE_OF(2) * lag_wide_of(s->weight, place, lane);
        *last = lag_wide_max(LAG_WIDE_ABS(LAG_WIDE_TERM(c, p)) * weight, *last);
        *before = lag_wide_max(LAG_WIDE_ABS(LAG_WIDE_TERM(c, p - 1)) * weight, *before);
    }
    for (int i = 0; i < s->lanes.size - 2 * s->lanes.n; ++i) {
        const double *c = lag_wide_power_jet(s, i) + lane;
        const LagWide weight = lag_wide_read(s->lanes.energy + lane);
        *last = lag_wide_max(LAG_WIDE_ABS(LAG_WIDE_TERM(c, p - 1)) * LAG_WIDE_OF(lag_inverse[p - 1]) * weight, *last);
        *before = lag_wide_max(LAG_WIDE_ABS(LAG_WIDE_TERM(c, p - 2)) * LAG_WIDE_OF(lag_inverse[p - 2]) * weight, *before);
    }
}

/* The lengths at which the last two coefficients are worth a unit of error: all but for ever where these are 0, next to none where they
 * are no numbers. The next step waits for them, and so nothing is divided. */
LAG_UNROLLED LagWide length_of(const LagWideTaylor *s, int lane)
{
    const int p = s->order;
    LagWide last, before;
    last_terms(s, lane, p, &last, &before);
    const LagWide by_last = (LAG_WIDE_OF(s->last) - lag_wide_log2(last)) * LAG_WIDE_OF(lag_inverse[p - 1]);
    const LagWide by_before = (LAG_WIDE_OF(s->before_last) - lag_wide_log2(before)) * LAG_WIDE_OF(lag_inverse[p - 2]);
    return lag_wide_exp2_of_few(lag_wide_min(by_last, by_before));
}

/* Lengths of steps to the ends of segments. */
LAG_UNROLLED LagWide left_of(const LagWideTaylor *s, int lane)
{
    return lag_wide_read(s->lanes.stop + lane) - lag_wide_read(s->lanes.t + lane);
}

/* Orders that are known before there are any coefficients: 0 where a short step may do with less. Their latest orders tell where to
 * look first. */
static void wait_for_order(LagWideTaylor *s, int lane)
{
    lag_wide_write(s->first + lane, lag_wide_read(s->own + lane) - LAG_WIDE_OF(2));
    const LagWide zero = LAG_WIDE_OF(0), few = LAG_WIDE_OF((double)FEWEST), all = LAG_WIDE_OF((double)s->order);
    const LagWide near = lag_wide_min(LAG_WIDE_OF(NEAR) * lag_wide_read(s->lanes.length + lane), LAG_WIDE_OF(s->lanes.longest));
    const LagWide most = lag_wide_min(near, lag_wide_read(s->limit + lane));
    const LagWide own = LAG_WIDE_SELECT(left_of(s, lane) <= most, zero, all);
    lag_wide_write(s->own + lane, LAG_WIDE_SELECT(lag_wide_read(s->lanes.moves + lane) > zero, own, few));
}

/* Whether the order p is enough. */
static void look_at_order(LagWideTaylor *s, int lane, int p)
{
    const LagWide h = left_of(s, lane), own = lag_wide_read(s->own + lane);
    LagWide last, before, power = h;
    last_terms(s, lane, p, &last, &before);
    for (int k = 2; k < p; ++k)
        power *= h;
    const LagWide most = lag_wide_max(last * h, before) * power;
    const LagWide few = lag_wide_max(LAG_WIDE_OF(s->rate) * h, LAG_WIDE_OF(s->faint));
    const LagWide order = LAG_WIDE_OF((double)p), found = LAG_WIDE_SELECT(most <= few, order, own);
    const LagWide asked = LAG_WIDE_SELECT(lag_wide_read(s->first + lane) <= order, found, own);
    lag_wide_write(s->own + lane, LAG_WIDE_SELECT(own == LAG_WIDE_OF(0), asked, own));
}

/* The highest order that is needed; 0 where some lane is not sure. */
static int highest_of(const LagWideTaylor *s)
{
    double highest = 0;
    for (int lane = 0; lane < LAG_ABREAST; ++lane) {
        if (s->own[lane] == 0)
            return 0;
        highest = lag_max(s->own[lane], highest);
    }
    return (int)highest;
}

/* Where the first lane looks. */
static int first_order(const LagWideTaylor *s)
{
    double first = s->order;
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        first = s->own[lane] == 0 ? lag_min(s->first[lane], first) : first;
    return first > FEWEST ? (int)first / 2 * 2 : FEWEST;
}

int lag_wide_orders_differ(const LagWideTaylor *s)
{
    LagWide missing = LAG_WIDE_OF(0);
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
        missing += LAG_WIDE_OF((double)s->order) - lag_wide_read(s->own + lane);
    return lag_wide_is_some(missing);
}

/* The orders of short steps: their coefficients are made by twos until they suffice. Returns the order before which they are made. */
static int find_orders(LagWideTaylor *s)
{
    int made = 1;
    s->made_to = highest_of(s);
    for (int p = first_order(s); s->made_to == 0 && p < s->order; p += 2) {
        lag_wide_series_go_on(&s->series, made, p);
        made = p;
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)
            look_at_order(s, lane, p);
        s->made_to = highest_of(s);
    }
    for (int lane = 0; lane < LAG_ABREAST && s->made_to == 0; ++lane)
        s->own[lane] = s->own[lane] == 0 ? s->order : s->own[lane];
    s->made_to = highest_of(s);
    return made;
}

void lag_wide_orders_expand(LagWideTaylor *s)
{
    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
        weigh_entered(s, lane);
        if (s->is_cut)
            wait_for_order(s, lane);
        else
            lag_wide_write(s->own + lane, LAG_WIDE_OF((double)s->order));
    }
    s->made_to = s->order;
    const int made = s->is_cut && lag_wide_orders_differ(s) ? find_orders(s) : 1;
    if (made < s->made_to)
        lag_wide_series_go_on(&s->series, made, s->made_to);
    for (int lane = 0; lane < LAG_ABREAST && s->made_to == s->order; lane += LAG_WIDE)
        lag_wide_write(s->reach + lane, length_of(s, lane));
}
