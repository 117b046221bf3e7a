#include "methods/wide_attitudes.h"

#include <math.h>

#include "model/attitude_places.h"
#include "numbers/extremes.h"
#include "state/attitudes.h"
#include "state/state.h"

static double *mode_of(const LagWideSteps *s, int i)
{
    return s->reference + (size_t)lag_attitude_mode(s->model->attitudes, i) * LAG_ABREAST;
}

void lag_wide_attitudes_load(LagWideSteps *s, int lane, const LagRun *run)
{
    const LagModel *model = s->model;
    for (int i = 0; i < model->n_attitudes; ++i) {
        lag_wide_place(mode_of(s, i), lane, run->d + lag_attitude_mode(model->attitudes, i), 4);
        lag_wide_place(s->turn_carry + 4 * i * LAG_ABREAST, lane, run->motion.attitude_carry + 4 * i, 4);
    }
}

void lag_wide_attitudes_show(const LagWideSteps *s, int lane, LagRun *run)
{
    const LagModel *model = s->model;
    for (int i = 0; i < model->n_attitudes; ++i) {
        lag_wide_take(mode_of(s, i), lane, run->d + lag_attitude_mode(model->attitudes, i), 4);
        lag_wide_take(s->turn_carry + 4 * i * LAG_ABREAST, lane, run->motion.attitude_carry + 4 * i, 4);
    }
}

static void move(LagWideSteps *s, int lane, int i)
{
    const size_t place = (size_t)lag_attitude_place(s->model->attitudes, i) * LAG_ABREAST;
    double turn[3], reference[4], carry[4];
    lag_wide_take(s->y + place, lane, turn, 3);
    const double way = sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
    if (way == 0)
        return;
    lag_wide_take(mode_of(s, i), lane, reference, 4);
    lag_wide_take(s->turn_carry + 4 * i * LAG_ABREAST, lane, carry, 4);
    lag_attitude_turn_on(turn, reference, carry);
    lag_wide_place(mode_of(s, i), lane, reference, 4);
    lag_wide_place(s->turn_carry + 4 * i * LAG_ABREAST, lane, carry, 4);
    for (int k = 0; k < 3; ++k) {
        const size_t at = place + (size_t)k * LAG_ABREAST + (size_t)lane;
        s->scale.largest[at] = lag_min(s->scale.largest[at] + way, s->scale.cap[at / LAG_ABREAST]);
        s->y[at] = s->carry[at] = 0;
    }
}

void lag_wide_attitudes_move(LagWideSteps *s)
{
    for (int i = 0; i < s->model->n_attitudes; ++i)
        for (int lane = 0; lane < LAG_ABREAST; ++lane)
            if (s->moves[lane] > 0 && s->taken[lane] > 0)
                move(s, lane, i);
}

void lag_wide_attitudes_present(const LagWideSteps *s, const double *y, double *quaternions)
{
    for (int i = 0; i < s->model->n_attitudes; ++i) {
        const double *turned = y + (size_t)lag_attitude_place(s->model->attitudes, i) * LAG_ABREAST;
        for (int lane = 0; lane < LAG_ABREAST; ++lane) {
            double turn[3], reference[4], present[4];
            lag_wide_take(turned, lane, turn, 3);
            lag_wide_take(mode_of(s, i), lane, reference, 4);
            lag_attitude_present(reference, turn, present);
            lag_wide_place(quaternions + 4 * i * LAG_ABREAST, lane, present, 4);
        }
    }
}

void lag_wide_attitudes_turn_slope(const LagModel *model, const double *q, double *k)
{
    for (int i = 0; i < model->n_attitudes; ++i) {
        const size_t place = (size_t)lag_attitude_place(model->attitudes, i) * LAG_ABREAST;
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            const double *s = q + place + lane;
            double *rates = k + place + lane;
            const LagWide a = lag_wide_of(s, 0, 0), b = lag_wide_of(s, 1, 0), c = lag_wide_of(s, 2, 0), half = LAG_WIDE_OF(0.5);
            const LagWide x = lag_wide_of(rates, 0, 0), y = lag_wide_of(rates, 1, 0), z = lag_wide_of(rates, 2, 0);
            const LagWide kept = LAG_WIDE_OF(1) - (a * a + b * b + c * c) * LAG_WIDE_OF(1.0 / 16);
            const LagWide along = (a * x + b * y + c * z) * LAG_WIDE_OF(1.0 / 8);
            lag_wide_write(rates, kept * x + (b * z - c * y) * half + along * a);
            lag_wide_write(rates + LAG_ABREAST, kept * y + (c * x - a * z) * half + along * b);
            lag_wide_write(rates + 2 * LAG_ABREAST, kept * z + (a * y - b * x) * half + along * c);
        }
    }
}
