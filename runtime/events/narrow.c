#include "events/narrow.h"

#include <math.h>

#include "model/function.h"
#include "model/schedule.h"
#include "numbers/extremes.h"

enum { HALVINGS = 40 };

void lag_narrow_ask(LagRun *run, const LagNarrowView *view, double x, double *g)
{
    const LagMotion *m = &run->motion;
    const double t = m->t_old + x * (m->t - m->t_old), *y = view->state(run, x);
    const double *in[] = {&t, y, y + m->n, run->u, run->d, run->c};
    double *out[] = {g};
    lag_inputs_at(&run->inputs, t, run->u);
    lag_call(&run->model->looks, in, out, run->work);
}

void lag_narrow_look(LagRun *run, const LagNarrowView *view, double x, double *g, double *pace)
{
    const double ahead = x < 1 ? view->ahead : -view->ahead;
    lag_narrow_ask(run, view, x, g);
    lag_narrow_ask(run, view, x + ahead, run->looks.ahead);
    for (int i = 0; i < run->model->n_looks; ++i)
        pace[i] = (run->looks.ahead[i] - g[i]) / ahead;
}

void lag_narrow_close_in(LagRun *run, const LagNarrowView *view, int i, int turns, double fine, LagNarrowPart *part)
{
    const size_t between = (size_t)((LAG_LOOKS + 1) * run->model->n_looks);
    double *g = run->looks.g + between, *pace = run->looks.pace + between;
    for (int k = 0; k < HALVINGS; ++k) {
        const double length = part->high - part->low, steepest = lag_max(fabs(part->before), fabs(part->after));
        if ((turns ? length * steepest : fabs(part->after - part->before)) < fine)
            break;
        const double x = part->low + length / 2;
        lag_narrow_look(run, view, x, g, pace);
        const double here = turns ? pace[i] : g[i];
        if ((here < 0) == (part->before < 0)) {
            part->low = x;
            part->before = here;
        } else {
            part->high = x;
            part->after = here;
        }
    }
}
