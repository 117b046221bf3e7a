#include "events/hiding.h"

#include "model/function.h"
#include "model/schedule.h"
#include "numbers/extremes.h"

static const double AHEAD = 1e-7; /* share of a step: by which paces are told */
enum { LOOKS = 64, HALVINGS = 40 };

/* g of all looks at a share of the latest step: of those that hide, which time alone decides, whatever the state is. */
static void ask(LagRun *run, double x, double *g)
{
    const LagMotion *m = &run->motion;
    const double t = m->t_old + x * (m->t - m->t_old), *y = m->y;
    const double *in[] = {&t, y, y + m->n, run->u, run->d, run->c};
    double *out[] = {g};
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&run->model->looks, in, out, run->work);
}

/* g and its changes over a little time. */
static void look(LagRun *run, double x, double *g, double *pace)
{
    ask(run, x < 1 ? x + AHEAD : x - AHEAD, run->looks.ahead);
    ask(run, x, g);
    for (int i = 0; i < run->model->n_looks; ++i)
        pace[i] = (run->looks.ahead[i] - g[i]) * (x < 1 ? 1 : -1);
}

/* Where g of look i is 0, or turns, between two places; `before`: what it is at the first of them. */
static double close_in(LagRun *run, int i, double low, double high, int turns, double before)
{
    LagLooks *s = &run->looks;
    const int end = LAG_LOOKS * run->model->n_looks;
    for (int k = 0; k < HALVINGS; ++k) {
        const double x = low + (high - low) / 2;
        look(run, x, s->g + end, s->pace + end);
        *(((turns ? s->pace : s->g)[end + i] < 0) == (before < 0) ? &low : &high) = x;
    }
    return high;
}

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
    look(run, 0, s->g, s->pace);
    for (int k = 1; k <= LOOKS; ++k) {
        const int old = (k - 1) % 2 * n, new = k % 2 * n;
        look(run, (double)k / LOOKS, s->g + new, s->pace + new);
        for (int i = first; i < n; ++i)
            for (int turns = 0; turns < 2 && found < LAG_HIDDEN; ++turns) {
                const double *all = turns ? s->pace : s->g;
                if ((all[old + i] < 0) == (all[new + i] < 0)) /* which may be 0 at a look itself */
                    continue;
                const double place = close_in(run, i, (k - 1.0) / LOOKS, (double)k / LOOKS, turns, all[old + i]);
                for (int side = 0; side < (turns ? 3 : 1) && found < LAG_HIDDEN; ++side) /* paces look ahead: it turns in between */
                    found = put(places, found, lag_min(place + side * AHEAD / 2, 1));
            }
    }
    return found;
}
