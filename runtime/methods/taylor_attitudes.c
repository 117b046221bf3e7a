#include "methods/taylor_attitudes.h"

#include <math.h>

#include "model/attitude_places.h"
#include "numbers/extremes.h"
#include "numbers/jets.h"
#include "state/attitudes.h"

static const double MOST_TURN = LAG_TAYLOR_MOST_TURN;

/* The jets of attitude i; and the same in fours, order by order. */
static double *parts_of(const LagModel *model, double *jets, int i)
{
    return jets + (size_t)(1 + 2 * model->n + model->n_inputs + 4 * i) * LAG_JET_STRIDE;
}

static double *fours_of(const LagModel *model, double *jets, int i)
{
    return jets + (size_t)(model->n_jets + 4 * i) * LAG_JET_STRIDE;
}

void lag_taylor_place_turned(const LagRun *run, const double *y, double *jets)
{
    const LagModel *model = run->model;
    for (int i = 0; i < model->n_attitudes; ++i) {
        double *here = fours_of(model, jets, i), *c = parts_of(model, jets, i);
        lag_attitude_present(run->d + lag_attitude_mode(model->attitudes, i), y + lag_attitude_place(model->attitudes, i), here);
        for (int k = 0; k < 4; ++k)
            c[k * LAG_JET_STRIDE] = here[k];
    }
}

/* What a quaternion changes by in a step: in two chains. */
#ifdef LAG_HAS_VECTORS
static void change(const double *fours, int order, double h, double *x)
{
    const LagLanes length = LAG_LANES_OF(h), square = LAG_LANES_OF(h * h);
    LagLanes even = LAG_LANES_OF(0), odd = LAG_LANES_OF(0), c;
    if (order % 2 == 0)
        memcpy(&even, fours + 4 * order, sizeof even);
    for (int k = (order - 1) / 2 * 2 + 1; k > 0; k -= 2) {
        memcpy(&c, fours + 4 * k, sizeof c);
        odd = LAG_LANES_FUSED(odd, square, c);
        if (k == 1)
            break;
        memcpy(&c, fours + 4 * k - 4, sizeof c);
        even = LAG_LANES_FUSED(even, square, c);
    }
    even = LAG_LANES_FUSED(even, length, odd) * length;
    memcpy(x, &even, sizeof even);
}
#else
static void change(const double *fours, int order, double h, double *x)
{
    for (int i = 0; i < 4; ++i) {
        double sum = 0;
        for (int k = order; k > 0; --k)
            sum = sum * h + fours[4 * k + i];
        x[i] = sum * h;
    }
}
#endif

/* 4 times the imaginary part of r* x, which is small where x is, over |r + x| and the real part of r* (r + x). */
void lag_taylor_turned_by(const double *r, const double *x, double *s)
{
    const double real = 1 + r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + r[3] * x[3];
    const double turn[3] = {
        r[0] * x[1] - r[1] * x[0] - r[2] * x[3] + r[3] * x[2],
        r[0] * x[2] - r[2] * x[0] - r[3] * x[1] + r[1] * x[3],
        r[0] * x[3] - r[3] * x[0] - r[1] * x[2] + r[2] * x[1],
    };
    const double square = real * real + turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2];
    const double factor = 4 / (sqrt(square) + real);
    for (int k = 0; k < 3; ++k)
        s[k] = factor * turn[k];
}

void lag_taylor_turn(const LagModel *model, const double *jets, int order, double h, double *step)
{
    for (int i = 0; i < model->n_attitudes; ++i) {
        const double *r = fours_of(model, (double *)jets, i);
        double *s = step + lag_attitude_place(model->attitudes, i), x[4];
        change(r, order, h, x);
        lag_taylor_turned_by(r, x, s);
    }
}

void lag_taylor_weigh_turned(LagRun *run, const double *end, double *last, double *before)
{
    const LagModel *model = run->model;
    const LagTaylor *s = &run->methods.taylor;
    for (int i = 0; i < model->n_attitudes; ++i) {
        const int place = lag_attitude_place(model->attitudes, i);
        const double unit = lag_scale_unit(&run->scale, place, run->motion.y, end), weight = unit > 0 ? 2 / unit : 0;
        const double *c = fours_of(model, s->jets, i) + 4 * s->order;
        for (int k = 0; k < 4; ++k) {
            if (fabs(c[k]) * weight > *last) {
                *last = fabs(c[k]) * weight;
                run->statistics.worst = place + (k > 0 ? k - 1 : 0);
            }
            *before = lag_max(fabs(c[k - 4]) * weight, *before);
        }
    }
}

int lag_taylor_turns_too_far(const LagRun *run, const double *y, double h)
{
    for (int i = 0; i < run->model->n_attitudes; ++i) {
        const double *w = y + run->model->n + lag_attitude_place(run->model->attitudes, i);
        if ((w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * h * h > MOST_TURN * MOST_TURN)
            return 1;
    }
    return 0;
}

double lag_taylor_longest_turn(const LagRun *run, const double *y)
{
    double fastest = 0;
    for (int i = 0; i < run->model->n_attitudes; ++i) {
        const double *w = y + run->model->n + lag_attitude_place(run->model->attitudes, i);
        fastest = lag_max(w[0] * w[0] + w[1] * w[1] + w[2] * w[2], fastest);
    }
    return MOST_TURN / sqrt(fastest);
}

int lag_taylor_top_of_turned(const LagModel *model, const double *jets, int most)
{
    const double *c = fours_of(model, (double *)jets, 0);
    for (int k = model->n_attitudes > 0 ? most : 1; k > 1; --k)
        for (int i = 0; i < model->n_attitudes; ++i)
            for (int m = 0; m < 4; ++m)
                if (c[4 * LAG_JET_STRIDE * i + 4 * k + m] != 0)
                    return k;
    return 1;
}
