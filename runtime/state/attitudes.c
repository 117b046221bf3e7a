/* The attitude of b against a is Q = Q_ref (1 - |s|^2/16, s/2) / (1 + |s|^2/16): s is four times the modified Rodrigues vector of
 * what b has turned since the reference, 4 tan(angle/4) along the axis, so that it is the angle itself where that is small. With the
 * angular velocity w in b's axes
 *
 *     ds/dt = N(s) w = (1 - |s|^2/16) w + s x w/2 + s (s.w)/8,   N(0) = 1
 *
 * (M.D. Shuster, A survey of attitude representations, J. Astronautical Sciences 41 (1993), eq. 338). It is regular up to a turn of
 * 360 degrees. Each step begins at s = 0: what the step before has turned goes into the reference, which is state and lies in four
 * modes, real part first. Its sums are compensated and its norm is kept, so that it neither drifts nor tires in long runs; and its
 * sign is continuous, as s is within a step.
 */
#include "state/attitudes.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "model/attitude_places.h"
#include "model/function.h"
#include "state/state.h"

void lag_attitude_rates(const double *s, const double *w, double *rates)
{
    const double square = s[0] * s[0] + s[1] * s[1] + s[2] * s[2], along = (s[0] * w[0] + s[1] * w[1] + s[2] * w[2]) / 8;
    const double kept = 1 - square / 16, x = w[0], y = w[1], z = w[2];
    rates[0] = kept * x + (s[1] * z - s[2] * y) / 2 + along * s[0];
    rates[1] = kept * y + (s[2] * x - s[0] * z) / 2 + along * s[1];
    rates[2] = kept * z + (s[0] * y - s[1] * x) / 2 + along * s[2];
}

void lag_attitudes_turn_slope(const LagMotion *m, const double *q, double *k)
{
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int place = lag_attitude_place(m->attitudes, i);
        lag_attitude_rates(q + place, k + place, k + place);
    }
}

/* With a real part that is not negative. */
static void declared(LagRun *run, int mode)
{
    double *reference = run->d + mode, square = 0;
    for (int k = 0; k < 4; ++k)
        square += reference[k] * reference[k];
    const double factor = copysign(1 / sqrt(square), reference[0] == 0 ? 1 : reference[0]);
    for (int k = 0; k < 4; ++k)
        reference[k] *= factor;
}

static void declare_all(LagRun *run)
{
    const double *in[] = {&run->settings.t_start, run->p, run->d_given};
    lag_call(&run->model->modes, in, &run->d, run->work);
    for (int i = 0; i < run->model->n_attitudes; ++i)
        declared(run, lag_attitude_mode(run->model->attitudes, i));
}

void lag_attitude_between(const double *r, const double *x, double *s)
{
    const double real = r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + r[3] * x[3], factor = 4 / (1 + fabs(real));
    const double turn[3] = {
        r[0] * x[1] - r[1] * x[0] - r[2] * x[3] + r[3] * x[2],
        r[0] * x[2] - r[2] * x[0] - r[3] * x[1] + r[1] * x[3],
        r[0] * x[3] - r[3] * x[0] - r[1] * x[2] + r[2] * x[1],
    };
    for (int k = 0; k < 3; ++k)
        s[k] = copysign(factor, real) * turn[k];
}

void lag_quaternion_product(const double *a, const double *b, double *c)
{
    c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    c[2] = a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3];
    c[3] = a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1];
}

void lag_attitude_present(const double *reference, const double *s, double *quaternion)
{
    const double square = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) / 16, half = 0.5 / (1 + square);
    const double turn[4] = {(1 - square) / (1 + square), s[0] * half, s[1] * half, s[2] * half};
    lag_quaternion_product(reference, turn, quaternion);
}

void lag_attitudes_guess(LagRun *run, const double *q_given)
{
    const double not_turned[4] = {1, 0, 0, 0};
    int is_declared = 0;
    for (int i = 0; i < run->model->n_attitudes; ++i) {
        const int place = lag_attitude_place(run->model->attitudes, i), mode = lag_attitude_mode(run->model->attitudes, i);
        double wanted[4];
        if (isnan(q_given[place]))
            continue;
        if (!is_declared)
            declare_all(run);
        is_declared = 1;
        lag_attitude_present(not_turned, q_given + place, wanted);
        lag_attitude_between(run->d + mode, wanted, run->start + place);
    }
}

void lag_attitudes_keep(LagRun *run)
{
    for (int i = 0; i < run->model->n_attitudes; ++i) {
        const int mode = lag_attitude_mode(run->model->attitudes, i);
        memcpy(run->d + mode, run->d_before + mode, 4 * sizeof *run->d);
    }
}

/* Only what it changes by is rounded, and that by rounding of itself. The excess of the norm comes off what it is then: that before lies
 * against it where a step turns more than half a turn. */
void lag_attitude_turn_on(const double *s, double *reference, double *carry)
{
    const double *r = reference;
    const double square = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) / 16, half = 0.5 / (1 + square);
    const double real = -4 * square * half, x = s[0] * half, y = s[1] * half, z = s[2] * half; /* less 1 */
    const double norm = r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3];
    const double excess = fabs(norm - 1) > 4 * DBL_EPSILON ? (norm - 1) / 2 : 0;
    const double change[4] = {
        r[0] * real - r[1] * x - r[2] * y - r[3] * z, r[1] * real + r[0] * x + r[2] * z - r[3] * y,
        r[2] * real + r[0] * y + r[3] * x - r[1] * z, r[3] * real + r[0] * z + r[1] * y - r[2] * x,
    };
    double next[4];
    for (int k = 0; k < 4; ++k) {
        const double whole = change[k] - excess * (r[k] + change[k]) + carry[k], sum = r[k] + whole, taken = sum - r[k];
        next[k] = sum;
        carry[k] = (r[k] - (sum - taken)) + (whole - taken);
    }
    memcpy(reference, next, sizeof next);
}

/* What was given stands as it is, without the rounding of a turn, where nothing has moved it. */
static int is_as_given(const double *reference, const double *given, const double *s, double *wanted)
{
    const double not_turned[4] = {1, 0, 0, 0};
    double asked[3];
    if (isnan(given[0]))
        return 0;
    lag_attitude_present(not_turned, given, wanted);
    lag_attitude_between(reference, wanted, asked);
    return memcmp(asked, s, sizeof asked) == 0;
}

void lag_attitudes_begin(LagRun *run, const double *q_given)
{
    const LagModel *model = run->model;
    if (model->n_attitudes == 0)
        return;
    declare_all(run);
    memset(run->motion.attitude_carry, 0, 4 * (size_t)model->n_attitudes * sizeof *run->motion.attitude_carry);
    for (int i = 0; i < model->n_attitudes; ++i) {
        const int place = lag_attitude_place(model->attitudes, i), mode = lag_attitude_mode(model->attitudes, i);
        double *s = run->motion.y + place, *size = run->scale.size + place, wanted[4];
        if (q_given && is_as_given(run->d + mode, q_given + place, s, wanted))
            memcpy(run->d + mode, wanted, sizeof wanted);
        else
            lag_attitude_turn_on(s, run->d + mode, run->motion.attitude_carry + 4 * i);
        declared(run, mode); /* what the start has turned it by may have made the real part negative */
        memset(s, 0, 3 * sizeof *s);
        memset(run->motion.attitude_carry + 4 * i, 0, 4 * sizeof *run->motion.attitude_carry);
        for (int k = 0; k < 3; ++k)
            size[k] = fmax(size[k], 1);
    }
}

/* An angle that has turned so far is known by shares of that. */
static void note_way(LagScale *scale, int place, const double *s)
{
    const double way = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (int k = place; k < place + 3; ++k)
        scale->largest[k] = fmin(scale->largest[k] + way, scale->cap[k]);
}

void lag_attitudes_move(LagRun *run)
{
    const LagModel *model = run->model;
    LagMotion *m = &run->motion;
    int moves = 0;
    for (int i = 0; i < model->n_attitudes; ++i) {
        const int place = lag_attitude_place(model->attitudes, i);
        double *s = m->y + place;
        if (s[0] == 0 && s[1] == 0 && s[2] == 0)
            continue;
        moves = 1;
        lag_attitude_turn_on(s, run->d + lag_attitude_mode(model->attitudes, i), m->attitude_carry + 4 * i);
        note_way(&run->scale, place, s);
        memset(s, 0, 3 * sizeof *s);
        memset(m->carry + place, 0, 3 * sizeof *s);
    }
    double *slope = moves && run->methods.table->slope ? run->methods.table->slope(run->methods.self) : NULL;
    for (int i = 0; i < model->n_attitudes && slope; ++i) {
        const int place = lag_attitude_place(model->attitudes, i);
        memcpy(slope + place, m->y + m->n + place, 3 * sizeof *slope);
    }
}
