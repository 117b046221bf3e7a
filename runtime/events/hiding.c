#include "events/hiding.h"

#include "events/narrow.h"
#include "numbers/extremes.h"

enum { LOOKS = 64 };

/* Time alone decides about what hides, whatever the state is. */
static const double *any_state(LagRun *run, double x)
{
    (void)x;
    return run->motion.y;
}

static const LagNarrowView VIEW = {any_state, 1e-7};

/* Puts a place among others, in order. */
static int put(double *places, int count, double x)
{
    int k = count;
    for (; k > 0 && places[k - 1] > x; --k)
        places[k] = places[k - 1];
    places[k] = x;
    return count + 1;
}

int lag_hiding_places(LagRun *run, double *places)
{
    LagLooks *s = &run->looks;
    const int n = run->model->n_looks, first = n - run->model->n_hiding;
    int found = 0;
    if (first == n)
        return 0;
    lag_narrow_look(run, &VIEW, 0, s->g, s->pace);
    for (int k = 1; k <= LOOKS; ++k) {
        const int old = (k - 1) % 2 * n, new = k % 2 * n;
        lag_narrow_look(run, &VIEW, (double)k / LOOKS, s->g + new, s->pace + new);
        for (int i = first; i < n; ++i)
            for (int turns = 0; turns < 2 && found < LAG_HIDDEN; ++turns) {
                const double *all = turns ? s->pace : s->g;
                if ((all[old + i] < 0) == (all[new + i] < 0)) /* which may be 0 at a look itself */
                    continue;
                LagNarrowPart part = {(k - 1.0) / LOOKS, (double)k / LOOKS, all[old + i], all[new + i]};
                lag_narrow_close_in(run, &VIEW, i, turns, 0, &part);
                for (int side = 0; side < (turns ? 3 : 1) && found < LAG_HIDDEN; ++side) /* paces look ahead: it turns in between */
                    found = put(places, found, lag_min(part.high + side * VIEW.ahead / 2, 1));
            }
    }
    return found;
}
