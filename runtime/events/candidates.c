#include "events/candidates.h"

#include <math.h>

#include "numbers/extremes.h"
#include "events/shares.h"
#include "state/state.h"

int lag_candidates_place(const LagSliding *s, int count, int i)
{
    for (int j = 0; j < count; ++j)
        if (s->which[j] == i)
            return j;
    return -1;
}

double lag_candidates_rate(const LagSliding *s, int count, int k, int by_all)
{
    double rate = s->middle[k];
    for (int j = 0; j < count; ++j)
        if (by_all || s->state[j] != LAG_SLIDES)
            rate += s->jump[k + j * count] * (s->share[j] - s->base[j]);
    return rate;
}

static double size_of(const LagSliding *s, int count, int k)
{
    double size = fabs(s->middle[k]);
    for (int j = 0; j < count; ++j)
        size += fabs(s->jump[k + j * count] * s->unit[j]);
    return size;
}

double lag_candidates_size(const LagSliding *s, int count, int k)
{
    const int other = lag_candidates_place(s, count, s->partner[s->which[k]]);
    return lag_max(other < 0 ? 0 : size_of(s, count, other), size_of(s, count, k));
}

double lag_candidates_tie(const LagSliding *s, int count, int k, double rounding)
{
    return s->is_light[k] ? rounding * lag_candidates_size(s, count, k) / fabs(s->jump[k + k * count]) : 0;
}

void lag_candidates_solve(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    int free = 0;
    for (int k = 0; k < count; ++k)
        free += s->state[k] == LAG_SLIDES;
    s->lu.size = free;
    for (int k = 0, row = 0; k < count; ++k) {
        if (s->state[k] != LAG_SLIDES)
            continue;
        s->system.place[row] = s->which[k];
        s->change[row] = -lag_candidates_rate(s, count, k, 0);
        for (int j = 0, column = 0; j < count; ++j)
            if (s->state[j] == LAG_SLIDES)
                s->lu.re[row + free * column++] = s->jump[k + j * count];
        ++row;
    }
    lag_shares_factor(run);
    lag_shares_solve(run, s->change);
    for (int k = 0, row = 0; k < count; ++k)
        if (s->state[k] == LAG_SLIDES) {
            s->factored[row] = s->base[k];
            s->change[row++] += s->base[k];
        }
    lag_shares_spread(run, s->change);
    for (int k = 0, row = 0; k < count; ++k)
        if (s->state[k] == LAG_SLIDES)
            s->share[k] = s->change[row++];
}

void lag_candidates_set(const LagRun *run, int count)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k)
        *lag_share(run, s->which[k]) = lag_max(lag_min(0, s->least[k]), lag_min(s->limit[k], s->share[k]));
}

void lag_candidates_balance(LagRun *run, int count)
{
    LagSliding *s = &run->sliding;
    for (int k = 0, row = 0; k < count; ++k)
        if (s->state[k] == LAG_SLIDES)
            s->change[row++] = s->share[k];
    lag_shares_balance(run, s->change);
    for (int k = 0, row = 0; k < count; ++k)
        if (s->state[k] == LAG_SLIDES)
            s->share[k] = s->change[row++];
    lag_candidates_set(run, count);
}
