/* The state of an instance as importers have it.
 *
 * The run has attitudes as s against references that its steps move on (state/attitudes.c), which an importer that integrates by
 * itself could not follow. To it an attitude is a unit quaternion Q, whose other lengths say nothing: with P = Q/|Q|, and w the
 * angular velocity,
 *
 *     dQ/dt = P (0, w)/2 + k (P - Q),
 *
 * so that errors of its length decay with the rate k, as those of closed loops do (exchange.c). To the run it is the reference P,
 * and s = 0; in Co-Simulation, where references are the run's own, s against them.
 */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "model/attitude_places.h"
#include "state/attitudes.h"
#include "state/state.h"

int lag_fmu_positions(const LagModel *m) { return m->n + m->n_attitudes; }

int lag_fmu_states(const LagModel *m) { return 2 * m->n + m->n_attitudes; }

int lag_fmu_outputs(const LagModel *m) { return m->n_outputs - 4 * m->n_attitudes; }

int lag_fmu_place(const LagModel *m, int k)
{
    int before = k >= m->n ? m->n_attitudes : 0;
    for (int i = 0; i < m->n_attitudes && k < m->n; ++i)
        before += lag_attitude_place(m->attitudes, i) + 3 <= k;
    return k + before;
}

void lag_fmu_by_coordinate(const LagModel *m, const double *states, double *values)
{
    for (int k = 0; k < 2 * m->n; ++k)
        values[k] = states[lag_fmu_place(m, k)];
}

int lag_fmu_count(const LagFmu *fmu, int group)
{
    const LagModel *m = fmu->model;
    switch (group) {
    case LAG_GROUP_TIME: return 1;
    case LAG_GROUP_STATE:
    case LAG_GROUP_SLOPE: return lag_fmu_states(m);
    case LAG_GROUP_OUTPUT: return lag_fmu_outputs(m);
    case LAG_GROUP_ENERGY: return LAG_ENERGIES;
    case LAG_GROUP_INPUT: return m->n_inputs;
    case LAG_GROUP_PARAMETER: return m->n_parameters;
    case LAG_GROUP_INDICATOR: return m->n_switches;
    case LAG_GROUP_KEPT_REAL: return fmu->n_kept_reals;
    case LAG_GROUP_KEPT_INTEGER: return fmu->n_kept_integers;
    case LAG_GROUP_KEPT_BOOLEAN: return fmu->n_kept_booleans;
    case LAG_GROUP_REAL: return fmu->n_reals;
    case LAG_GROUP_INTEGER: return fmu->n_integers;
    case LAG_GROUP_BOOLEAN: return fmu->n_booleans;
    case LAG_GROUP_STRING: return fmu->n_strings;
    default: return 0;
    }
}

int lag_fmu_first(const LagFmu *fmu, int group)
{
    int first = 0;
    for (int before = 0; before < group; ++before)
        first += lag_fmu_count(fmu, before);
    return first;
}

static double length_of(const double *quaternion)
{
    double square = 0;
    for (int k = 0; k < 4; ++k)
        square += quaternion[k] * quaternion[k];
    return sqrt(square);
}

int lag_instance_has_attitudes(const LagModel *m, const double *x)
{
    for (int i = 0; i < m->n_attitudes; ++i) {
        const double length = length_of(x + lag_fmu_place(m, lag_attitude_place(m->attitudes, i)));
        if (!(length > 0 && isfinite(length)))
            return 0;
    }
    return 1;
}

void lag_quintic(const double *p, const double *q, double h, double x, double *found)
{
    const double x2 = x * x, x3 = x2 * x;
    const double d = q[0] - p[0] - h * p[1] - h * h * p[2] / 2, e = h * (q[1] - p[1]) - h * h * p[2];
    const double f = h * h * (q[2] - p[2]);
    const double c3 = 10 * d - 4 * e + f / 2, c4 = -15 * d + 7 * e - f, c5 = 6 * d - 3 * e + f / 2;
    found[0] = p[0] + h * p[1] * x + h * h * p[2] * x2 / 2 + x3 * (c3 + x * (c4 + x * c5));
    found[1] = p[1] + h * p[2] * x + x2 * (3 * c3 + x * (4 * c4 + x * 5 * c5)) / h;
    found[2] = p[2] + x * (6 * c3 + x * (12 * c4 + x * 20 * c5)) / (h * h);
}

/* d2Q/dt2 of Q' = Q (0, w)/2. */
static void second_rate(const double *quaternion, const double *w, const double *slope, double *second)
{
    const double turn[4] = {0, w[0] / 2, w[1] / 2, w[2] / 2}, bend[4] = {0, slope[0] / 2, slope[1] / 2, slope[2] / 2};
    double rate[4], along[4];
    lag_quaternion_product(quaternion, turn, rate);
    lag_quaternion_product(rate, turn, second);
    lag_quaternion_product(quaternion, bend, along);
    for (int k = 0; k < 4; ++k)
        second[k] += along[k];
}

void lag_attitudes_between(const LagInstance *s, double x, double h, double *state, double *acceleration)
{
    const LagModel *m = s->model;
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int place = lag_attitude_place(m->attitudes, i), first = lag_fmu_place(m, place), r = lag_fmu_place(m, m->n + place);
        double before[4], after[4], of[3][4], w[4], bend[4];
        second_rate(s->last + first, s->last + r, s->last_slope + r, before);
        second_rate(s->x + first, s->x + r, s->slope + r, after);
        for (int k = 0; k < 4; ++k) {
            const double begin[3] = {s->last[first + k], s->last_slope[first + k], before[k]};
            const double end[3] = {s->x[first + k], s->slope[first + k], after[k]};
            double found[3];
            lag_quintic(begin, end, h, x, found);
            for (int j = 0; j < 3; ++j)
                of[j][k] = found[j];
        }
        const double square = length_of(of[0]) * length_of(of[0]), back[4] = {of[0][0], -of[0][1], -of[0][2], -of[0][3]};
        lag_quaternion_product(back, of[1], w);
        lag_quaternion_product(back, of[2], bend);
        memcpy(state + first, of[0], sizeof of[0]);
        for (int k = 0; k < 3; ++k) {
            state[r + k] = 2 * w[1 + k] / square;
            acceleration[place + k] = 2 * bend[1 + k] / square;
        }
    }
}

double *lag_instance_plain(LagInstance *s, const double *x)
{
    const LagModel *m = s->model;
    lag_fmu_by_coordinate(m, x, s->plain);
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int place = lag_attitude_place(m->attitudes, i);
        const double *quaternion = x + lag_fmu_place(m, place);
        double *reference = s->run->d + lag_attitude_mode(m->attitudes, i), length = length_of(quaternion), unit[4];
        for (int k = 0; k < 4; ++k)
            unit[k] = quaternion[k] / length;
        if (s->kind == LAG_MODEL_EXCHANGE) {
            memcpy(reference, unit, sizeof unit);
            memset(s->plain + place, 0, 3 * sizeof *s->plain);
        } else {
            lag_attitude_between(reference, unit, s->plain + place);
        }
    }
    return s->plain;
}

void lag_instance_tell(LagInstance *s, const double *y, double *x)
{
    const LagModel *m = s->model;
    for (int k = 0; k < 2 * m->n; ++k)
        x[lag_fmu_place(m, k)] = y[k];
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int place = lag_attitude_place(m->attitudes, i);
        lag_attitude_present(s->run->d + lag_attitude_mode(m->attitudes, i), y + place, x + lag_fmu_place(m, place));
    }
}

void lag_instance_take_states(LagInstance *s, const double *y, const double *outputs)
{
    const LagModel *m = s->model;
    for (int k = 0; k < 2 * m->n; ++k)
        s->x[lag_fmu_place(m, k)] = y[k];
    for (int i = 0; i < m->n_attitudes; ++i) /* which come first among the outputs */
        memcpy(s->x + lag_fmu_place(m, lag_attitude_place(m->attitudes, i)), outputs + 4 * i, 4 * sizeof *outputs);
}

double *lag_instance_starts(LagInstance *s)
{
    const LagModel *m = s->model;
    const double not_turned[4] = {1, 0, 0, 0};
    lag_fmu_by_coordinate(m, s->start, s->plain);
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int place = lag_attitude_place(m->attitudes, i), first = lag_fmu_place(m, place);
        double wanted[4];
        int some = 0;
        for (int k = 0; k < 4; ++k) {
            const int is_given = !isnan(s->start[first + k]);
            wanted[k] = is_given ? s->start[first + k] : s->fmu->state_start[first + k];
            some |= is_given;
        }
        const double length = length_of(wanted);
        if (!(length > 0 && isfinite(length)))
            return NULL;
        for (int k = 0; k < 4; ++k)
            wanted[k] /= length;
        s->plain[place] = s->plain[place + 1] = s->plain[place + 2] = NAN;
        if (some)
            lag_attitude_between(not_turned, wanted, s->plain + place);
    }
    return s->plain;
}

void lag_instance_pace(const LagModel *m, const double *x, const double *v, double *pace)
{
    for (int k = 0; k < m->n; ++k)
        pace[lag_fmu_place(m, k)] = v[k];
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int place = lag_attitude_place(m->attitudes, i), first = lag_fmu_place(m, place);
        const double half[4] = {0, v[place] / 2, v[place + 1] / 2, v[place + 2] / 2};
        lag_quaternion_product(x + first, half, pace + first);
    }
}
