/* The force mu N against a slip (x, y) has no direction where that vanishes, and is smooth elsewhere. So no step passes that place: each
 * goes most of the way there, as the slip is slowed down now, and what is left is soon less than can be told. Then both components are
 * held like those of two brakes, whose shares 2 s - 1 are components of one force: it is torn off where they leave the circle of radius 1.
 */
#include "events/cones.h"

#include <math.h>

#include "numbers/extremes.h"
#include "events/sliding.h"
#include "state/state.h"

static const double NEAR = 0.95; /* of the time in which a slip would stop */
static const double FAINT = 1e-6; /* of what friction slows down: rounding, where it is torn off */
static const double KICK = 0.5;  /* of a slip that is taken for none */

static const int *cone(const LagRun *run, int k) { return run->model->cones + 2 * k; }

static int is_held(const LagRun *run, const int *places)
{
    return run->switches.slides[places[0]] && run->switches.slides[places[1]];
}

/* The cone that has switch i; -1: none. */
static int cone_of(const LagRun *run, int i)
{
    for (int k = 0; k < run->model->n_cones; ++k)
        if (cone(run, k)[0] == i || cone(run, k)[1] == i)
            return k;
    return -1;
}

/* A component of the force, by what it may be. */
static double component(const LagRun *run, int i) { return 2 * *lag_share(run, i) - 1; }

static double margin(const LagRun *run, const int *places)
{
    const double x = component(run, places[0]), y = component(run, places[1]);
    return 1 - x * x - y * y;
}

/* What a slip is less than, to be taken for none. */
static double least_slip(const LagRun *run, const int *places)
{
    return lag_min(lag_sliding_drift(run, places[0]), lag_sliding_drift(run, places[1]));
}

int lag_cones_have(const LagRun *run, int i) { return cone_of(run, i) >= 0; }

int lag_cones_hold(const LagRun *run, int i)
{
    const int k = cone_of(run, i);
    return k >= 0 && is_held(run, cone(run, k));
}

int lag_cones_break(const LagRun *run, int i)
{
    const int k = cone_of(run, i);
    return k >= 0 && (run->sliding.leaves[k] || !(margin(run, cone(run, k)) >= 0));
}

void lag_cones_note_torn(LagRun *run)
{
    int *turned = run->switches.turned;
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int x = cone(run, k)[0], y = cone(run, k)[1];
        run->sliding.leaves[k] = turned[x] > LAG_CHANGES && turned[y] > LAG_CHANGES;
        if (run->sliding.leaves[k])
            turned[x] = turned[y] = LAG_CHANGES;
    }
}

double lag_cones_kick(const LagRun *run, int i)
{
    const int k = cone_of(run, i);
    if (k < 0 || !run->sliding.is_lenient || !lag_cones_break(run, i))
        return 0;
    const int *places = cone(run, k);
    const double speed = hypot(run->sliding.g[places[0]], run->sliding.g[places[1]]), most = KICK * least_slip(run, places);
    const double kick = run->sliding.leaves[k] || speed == 0 ? most : lag_min(speed, most);
    return kick * component(run, i) / hypot(component(run, places[0]), component(run, places[1]));
}

void lag_cones_margins(const LagRun *run, double *g)
{
    for (int k = 0; k < run->model->n_cones; ++k)
        if (is_held(run, cone(run, k)))
            g[cone(run, k)[0]] = g[cone(run, k)[1]] = margin(run, cone(run, k));
}

void lag_cones_margin_rates(const LagRun *run, double *rate)
{
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int *places = cone(run, k);
        const double along = component(run, places[0]) * rate[places[0]] + component(run, places[1]) * rate[places[1]];
        if (is_held(run, places))
            rate[places[0]] = rate[places[1]] = -4 * along;
    }
}

void lag_cones_enter(LagRun *run)
{
    for (int k = 0; k < run->model->n_cones; ++k)
        for (int j = 0; j < 2 && !is_held(run, cone(run, k)); ++j) {
            run->switches.is_idle[cone(run, k)[j]] = 1;
            run->switches.unknown[cone(run, k)[j]] = INFINITY;
        }
}

int lag_cones_look(LagRun *run)
{
    LagSliding *s = &run->sliding;
    int some = 0;
    s->stops = INFINITY;
    if (run->model->n_cones > 0)
        lag_sliding_rates(run, run->motion.t, run->motion.y);
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int x = cone(run, k)[0], y = cone(run, k)[1];
        const double speed = hypot(s->g[x], s->g[y]), slows = -(s->g[x] * s->rate[x] + s->g[y] * s->rate[y]) / speed;
        if (is_held(run, cone(run, k)) || !(slows > FAINT * lag_max(s->most_jump[x], s->most_jump[y])))
            continue;
        s->stops = lag_min(run->motion.t + NEAR * speed / slows, s->stops);
        if (speed <= least_slip(run, cone(run, k)))
            some = run->switches.turned[x] = run->switches.turned[y] = 1;
    }
    return some;
}
