/* The force mu N against a slip (x, y) has no direction where that vanishes, and is smooth elsewhere. So no step passes that place: each
 * goes most of the way there, as the slip is slowed down now, and what is left is soon less than can be told. Then both components are
 * held like those of two brakes, whose shares 2 s - 1 are components of one force: it is torn off where they leave the circle of radius 1.
 */
#include "events/cones.h"

#include <math.h>
#include <string.h>

#include "numbers/extremes.h"
#include "events/conditions.h"
#include "events/sliding.h"
#include "model/schedule.h"
#include "state/evaluate.h"
#include "state/state.h"

static const double NEAR = 0.95; /* of the time in which a slip would stop */
static const double CREEPS = 4; /* times as fast as its speed changes, a slip turns into the direction of what pulls at it */
static const double FAINT = 1e-6; /* of what friction slows down: rounding, where it is torn off */
static const double NO_TIME = 1e-6; /* of what is left of a run; of a second, where that has no end */
static const double AT_ONCE = 16;  /* times what of a time is rounding: no step is so short */
static const double LEFT = 1e-6; /* of all that there is: enough to hold */
static const double OTHER_SPEED = 16; /* times: derivatives by rates are others */
static const double KNOWN_SLIP = 0.03; /* of a slip */
static const double JUST = 1e-9; /* of all that holds: where importers look for the place at which it is not enough */
static const double BEYOND = 2; /* times what a slip has gone back: it stopped */
static const double COARSE = 20; /* tolerances of an importer: errors of rates that are next to none */
static const double KNOWN = 16; /* times rounding: a slip has a direction */
static const double KICK = 0.5, LITTLE = 1e-2; /* of a slip that is taken for none; of that, where it can go one way only */

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

/* The slip that what rubs gives in no time. */
static double faintest_slip(const LagRun *run, const int *places)
{
    const double end = lag_min(run->segment_end, run->settings.t_stop), whole = isfinite(end) ? end - run->motion.t : 1;
    const double jump = lag_max(run->sliding.most_jump[places[0]], run->sliding.most_jump[places[1]]);
    return run->scale.tolerance * NO_TIME * whole * jump;
}

/* That of what is rounding of times. */
static double late_slip(const LagRun *run, const int *places)
{
    const double jump = lag_max(run->sliding.most_jump[places[0]], run->sliding.most_jump[places[1]]);
    return AT_ONCE * lag_time_resolution(run->motion.t) * jump;
}

/* The slip of rates that are errors of an importer's steps: their sizes are nominal values then. */
static double coarse_slip(LagRun *run, const int *places)
{
    LagSwitches *s = &run->switches;
    const int n = run->model->n;
    const double *y = run->motion.y;
    double slip = 0;
    for (int i = 0; i < n; ++i)
        s->state[i] = y[n + i] + COARSE * run->settings.tolerance * run->scale.largest[n + i];
    lag_conditions_by(run, run->motion.t, y, y + n, s->slope + n, s->g_begin, s->rate_begin);
    lag_conditions_by(run, run->motion.t, y, s->state, s->slope + n, s->g_inside, s->rate_inside);
    for (int j = 0; j < 2; ++j)
        slip = hypot(s->g_inside[places[j]] - s->g_begin[places[j]], slip);
    return slip;
}

/* What a slip is less than, to be taken for none. */
static double least_slip(LagRun *run, int k)
{
    const int *places = cone(run, k);
    const double drift = lag_min(lag_sliding_drift(run, places[0]), lag_sliding_drift(run, places[1]));
    const double known = lag_max(faintest_slip(run, places), drift); /* nothing tells of errors before the first step */
    return run->impacts.coarse > 0 ? lag_max(lag_max(coarse_slip(run, places), BEYOND * run->sliding.beyond[k]), known) : known;
}

int lag_cones_have(const LagRun *run, int i) { return cone_of(run, i) >= 0; }

int lag_cones_partner(const LagRun *run, int i)
{
    const int k = cone_of(run, i);
    return k < 0 ? -1 : cone(run, k)[0] + cone(run, k)[1] - i;
}

int lag_cones_hold(const LagRun *run, int i)
{
    const int k = cone_of(run, i);
    return k >= 0 && is_held(run, cone(run, k));
}

int lag_cones_break(const LagRun *run, int i)
{
    const int k = cone_of(run, i);
    const int may_share = run->sliding.system.n_untold > 0; /* what others hold now is not torn off */
    const double most = k >= 0 && run->sliding.leaves[k] ? may_share ? LEFT : INFINITY : 0;
    return k >= 0 && !(margin(run, cone(run, k)) >= most);
}

double lag_cones_limited(const LagRun *run, int i)
{
    const int *places = cone(run, cone_of(run, i));
    const double asked = hypot(component(run, places[0]), component(run, places[1]));
    return asked > 1 ? 0.5 + component(run, i) / (2 * asked) : *lag_share(run, i);
}

int lag_cones_have_left(LagRun *run, int i)
{
    const int k = cone_of(run, i), *places = cone(run, k);
    return run->sliding.leaves[k] && hypot(run->sliding.g[places[0]], run->sliding.g[places[1]]) > least_slip(run, k);
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

double lag_cones_kick(LagRun *run, int i)
{
    const int k = cone_of(run, i);
    if (k < 0 || !run->sliding.is_lenient || !lag_cones_break(run, i))
        return 0;
    const int *places = cone(run, k);
    const double unknown = lag_max(run->switches.unknown[places[0]], run->switches.unknown[places[1]]);
    const double speed = hypot(run->sliding.g[places[0]], run->sliding.g[places[1]]);
    const double most = lag_max(KICK * least_slip(run, k), KNOWN * unknown);
    const double slow = lag_max(speed, faintest_slip(run, places));
    const int is_narrow = run->sliding.system.is_narrow[k] && run->impacts.coarse == 0; /* nothing is stiff aside */
    const double least = run->sliding.leaves[k] || run->impacts.coarse > 0 ? is_narrow ? lag_max(LITTLE * most, late_slip(run, places)) : most : 0;
    const double kick = lag_max(least, lag_min(slow, most));
    return kick * component(run, i) / hypot(component(run, places[0]), component(run, places[1]));
}

void lag_cones_note_left(LagRun *run)
{
    for (int k = 0; k < run->model->n_cones; ++k)
        run->sliding.leaves[k] |= run->sliding.is_lenient && is_held(run, cone(run, k)) && lag_cones_break(run, cone(run, k)[0]);
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

/* Errors of rates that count beside a slip: those across it turn the force; but rounding of states and of times does not. */
static double known_error(const LagRun *run, int k, double speed)
{
    const LagSliding *s = &run->sliding;
    const double rounding = KNOWN * lag_conditions_rounding(run, lag_max(s->error[cone(run, k)[0]], s->error[cone(run, k)[1]]));
    return lag_max(KNOWN_SLIP * speed, lag_max(rounding, late_slip(run, cone(run, k))));
}

int lag_cones_look(LagRun *run)
{
    LagSliding *s = &run->sliding;
    int some = 0;
    s->stops = s->known_error = INFINITY;
    s->creep = 0;
    if (run->model->n_cones > 0)
        lag_sliding_rates(run, run->motion.t, run->motion.y);
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int x = cone(run, k)[0], y = cone(run, k)[1];
        s->slip[2 * k] = s->g[x];
        s->slip[2 * k + 1] = s->g[y];
        const double speed = hypot(s->g[x], s->g[y]), slows = -(s->g[x] * s->rate[x] + s->g[y] * s->rate[y]) / speed;
        const double turns = lag_max(s->most_jump[x], s->most_jump[y]) / 2;
        if (!is_held(run, cone(run, k)) && turns > CREEPS * fabs(slows))
            s->creep = lag_max(turns / speed, s->creep);
        if (!is_held(run, cone(run, k)))
            s->known_error = lag_min(known_error(run, k, speed), s->known_error);
        if (is_held(run, cone(run, k)) || !(slows > FAINT * lag_max(s->most_jump[x], s->most_jump[y])))
            continue;
        s->stops = lag_min(run->motion.t + NEAR * speed / slows, s->stops);
        if (speed <= lag_max(least_slip(run, k), slows * AT_ONCE * lag_time_resolution(run->motion.t)))
            some = run->switches.turned[x] = run->switches.turned[y] = 1;
    }
    return some;
}

/* Along the direction that was noted. */
static double along(const LagRun *run, int k, const double *g)
{
    const double *slip = run->sliding.slip + 2 * k, speed = hypot(slip[0], slip[1]);
    return speed > 0 ? (slip[0] * g[cone(run, k)[0]] + slip[1] * g[cone(run, k)[1]]) / speed : 1;
}

static void find_slips(LagRun *run, double t, const double *y)
{
    const int n = run->model->n;
    if (run->model->n_cones > 0)
        lag_conditions_by(run, t, y, y + n, run->switches.slope + n, run->sliding.g, run->sliding.rate);
}

void lag_cones_note(LagRun *run, double t, const double *y)
{
    LagSliding *s = &run->sliding;
    find_slips(run, t, y);
    for (int k = 0; k < run->model->n_cones; ++k)
        for (int j = 0; j < 2; ++j)
            s->slip[2 * k + j] = s->g[cone(run, k)[j]];
}

void lag_cones_note_end(LagRun *run)
{
    LagSwitches *s = &run->switches;
    int some = 0;
    for (int k = 0; k < run->model->n_cones; ++k)
        some |= is_held(run, cone(run, k)) && s->g[cone(run, k)[0]] <= JUST;
    if (some)
        lag_conditions_with_rates(run, run->motion.t, run->motion.y, s->g, s->rate);
    for (int k = 0; k < run->model->n_cones && some; ++k) {
        const int *places = cone(run, k);
        if (is_held(run, places) && s->g[places[0]] <= JUST && s->rate[places[0]] < 0)
            s->turned[places[0]] = s->turned[places[1]] = LAG_TO_0;
    }
}

void lag_cones_begin(LagRun *run)
{
    LagSliding *s = &run->sliding;
    memset(s->beyond, 0, (size_t)run->model->n_cones * sizeof *s->beyond);
    for (int k = 0; k < run->model->n_cones; ++k)
        s->speed[k] = hypot(s->slip[2 * k], s->slip[2 * k + 1]);
}

void lag_cones_turns(const LagRun *run, const double *values, double *g)
{
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int *places = cone(run, k);
        const double speed = hypot(values[places[0]], values[places[1]]), begin = run->sliding.speed[k];
        if (is_held(run, places))
            continue;
        g[places[0]] = along(run, k, values);
        g[places[1]] = lag_min(speed - begin / OTHER_SPEED, begin * OTHER_SPEED - speed);
    }
}

void lag_cones_note_beyond(LagRun *run)
{
    LagSliding *s = &run->sliding;
    find_slips(run, run->motion.t, run->motion.y);
    for (int k = 0; k < run->model->n_cones; ++k)
        s->beyond[k] = is_held(run, cone(run, k)) ? 0 : lag_max(0, -along(run, k, s->g));
}

/* Changes v so that slip k changes by s[2], as little as sizes allow: slips are linear in rates. */
static void change_slip(LagRun *run, int k, double t, const double *q, double *v, const double *size, const double *s)
{
    const int n = run->model->n, *places = cone(run, k);
    double *x = run->sliding.slope_before, *y = x + n, *g = run->switches.g_inside, xx = 0, xy = 0, yy = 0;
    const double *slope = run->switches.slope + n;
    lag_conditions_by(run, t, q, v, slope, run->switches.g_begin, run->switches.rate_begin);
    for (int i = 0; i < n; ++i) {
        const double before = v[i];
        v[i] += size[i];
        lag_conditions_by(run, t, q, v, slope, g, run->switches.rate_inside);
        v[i] = before;
        x[i] = g[places[0]] - run->switches.g_begin[places[0]];
        y[i] = g[places[1]] - run->switches.g_begin[places[1]];
        xx += x[i] * x[i];
        xy += x[i] * y[i];
        yy += y[i] * y[i];
    }
    const double whole = xx + yy, determinant = xx * yy - xy * xy;
    const int is_narrow = !(determinant > FAINT * whole * whole);
    const double a = is_narrow ? s[0] / whole : (yy * s[0] - xy * s[1]) / determinant;
    const double b = is_narrow ? s[1] / whole : (xx * s[1] - xy * s[0]) / determinant;
    for (int i = 0; i < n && whole > 0; ++i)
        v[i] += size[i] * (x[i] * a + y[i] * b);
}

void lag_cones_throw(LagRun *run)
{
    LagSliding *s = &run->sliding;
    LagMotion *m = &run->motion;
    for (int i = 0; i < m->n && run->model->n_cones > 0; ++i)
        s->mirrored[i] = 1; /* sizes: what leaves is less than can be told */
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int *places = cone(run, k);
        if (!is_held(run, places) || !lag_cones_break(run, places[0]))
            continue;
        find_slips(run, m->t, m->y);
        const double kick[2] = {lag_cones_kick(run, places[0]), lag_cones_kick(run, places[1])};
        const double change[2] = {kick[0] - s->g[places[0]], kick[1] - s->g[places[1]]};
        if (hypot(change[0], change[1]) > KICK * hypot(kick[0], kick[1]))
            change_slip(run, k, m->t, m->y, m->y + m->n, s->mirrored, change);
    }
}

double *lag_cones_mirrored(LagRun *run, double t, const double *q, const double *v, const double *size)
{
    LagSliding *s = &run->sliding;
    const double *slope = run->switches.slope + run->model->n;
    double *result = NULL;
    for (int k = 0; k < run->model->n_cones; ++k) {
        lag_conditions_by(run, t, q, result ? result : v, slope, run->switches.g_inside, run->switches.rate_inside);
        const double passed = along(run, k, run->switches.g_inside), speed = hypot(s->slip[2 * k], s->slip[2 * k + 1]);
        if (is_held(run, cone(run, k)) || passed >= 0)
            continue;
        if (!result)
            memcpy(s->mirrored, v, (size_t)run->model->n * sizeof *v);
        const double change[2] = {-2 * passed * s->slip[2 * k] / speed, -2 * passed * s->slip[2 * k + 1] / speed};
        change_slip(run, k, t, q, s->mirrored, size, change);
        result = s->mirrored;
    }
    return result;
}

int lag_cones_have_turned(LagRun *run, double t, const double *y)
{
    LagSwitches *s = &run->switches;
    const double *slip = run->sliding.slip;
    const int n = run->model->n;
    int some = 0;
    lag_conditions_by(run, t, y, y + n, s->slope + n, s->g_inside, s->rate_inside);
    for (int k = 0; k < run->model->n_cones; ++k) {
        const int *places = cone(run, k);
        some |= !is_held(run, places) && slip[2 * k] * s->g_inside[places[0]] + slip[2 * k + 1] * s->g_inside[places[1]] < 0;
    }
    return some;
}

int lag_cones_turn_round(LagRun *run)
{
    const LagMotion *m = &run->motion;
    if (run->model->n_cones == 0 || m->t - m->t_old <= AT_ONCE * lag_time_resolution(m->t))
        return 0;
    return lag_cones_have_turned(run, m->t, m->y);
}
