/* The polynomial is kept in shifted Legendre polynomials: P_0 = 1, P_1 = z, (k + 1) P_k+1 = (2 k + 1) z P_k - k P_k-1 with
 * z = 2 x - 1; their integrals from 0 are (P_k+1 - P_k-1)/(2 (2 k + 1)). Powers of x would lose four digits with 7 stages.
 */
#include "methods/collocation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "model/attitude_places.h"
#include "state/attitudes.h"

enum { MOST_TURNS = 30 };

void lag_collocation_layout(LagCollocation *s, const LagMotion *m, LagArena *arena)
{
    s->rate = lag_take(arena, LAG_RADAU_STAGES * (size_t)m->n);
    s->way = lag_take(arena, m->n_attitudes > 0 ? LAG_RADAU_STAGES * (size_t)m->n : 0);
    s->power = lag_take(arena, LAG_RADAU_STAGES * (size_t)(m->size - 2 * m->n));
    s->slope = lag_take(arena, (size_t)m->size);
}

/* Weights of the stage values in the polynomial at x, and in its integral from 0 to x. */
static void weigh(const LagRadauTableau *tableau, double x, double *value, double *integral)
{
    const int s = tableau->stages;
    const double z = 2 * x - 1;
    double p[LAG_RADAU_STAGES + 2] = {1, z};
    for (int k = 1; k <= s; ++k)
        p[k + 1] = ((2 * k + 1) * z * p[k] - k * p[k - 1]) / (k + 1);
    for (int i = 0; i < s; ++i) {
        value[i] = integral[i] = 0;
        for (int k = 0; k <= s; ++k) {
            const double coefficient = tableau->legendre[k * s + i];
            value[i] += coefficient * p[k];
            integral[i] += coefficient * (k == 0 ? x : (p[k + 1] - p[k - 1]) / (4 * k + 2));
        }
    }
}

/* One sweep: rates of positions by the places as they are known, and places from these. Returns the largest change, rad. */
static double turn_stages(LagCollocation *step, const LagMotion *m, int first, double h, double *place)
{
    const LagRadauTableau *tableau = step->tableau;
    const int n = m->n, stages = tableau->stages;
    const double *w = m->y + n + first;
    double largest = 0;
    for (int i = 0; i < stages; ++i) {
        const double *z = step->rate + i * n + first, now[3] = {w[0] + z[0], w[1] + z[1], w[2] + z[2]};
        double *way = step->way + i * n + first;
        lag_attitude_rates(place + i * n + first, now, way);
        for (int k = 0; k < 3; ++k)
            way[k] -= w[k];
    }
    for (int i = 0; i < stages; ++i)
        for (int k = 0; k < 3; ++k) {
            double sum = tableau->node[i] * w[k], *at = place + i * n + first + k;
            for (int j = 0; j < stages; ++j)
                sum += tableau->a[i * stages + j] * step->way[j * n + first + k];
            largest = fmax(largest, fabs(h * sum - *at));
            *at = h * sum;
        }
    return largest;
}

/* Sweeps come nearer by half of what a step turns at most, each in a few operations: nothing is evaluated. Where a step turns too
 * far for that, its iterations do not converge either. */
void lag_collocation_turn(LagCollocation *step, const LagMotion *m, double h, double *place)
{
    for (int i = 0; i < m->n_attitudes; ++i) {
        double change = INFINITY;
        for (int k = 0; k < MOST_TURNS && change > DBL_EPSILON; ++k) {
            const double next = turn_stages(step, m, lag_attitude_place(m->attitudes, i), h, place);
            if (!(next < change))
                break;
            change = next;
        }
    }
}

void lag_collocation_foresee(const LagCollocation *step, int n, const LagRadauTableau *tableau, double h, double *rate)
{
    const int s = step->tableau->stages;
    double value[LAG_RADAU_STAGES], integral[LAG_RADAU_STAGES];
    for (int i = 0; i < tableau->stages; ++i) {
        weigh(step->tableau, 1 + tableau->node[i] * h / step->h, value, integral);
        value[s - 1] -= 1;
        for (int k = 0; k < n; ++k) {
            double sum = 0;
            for (int j = 0; j < s; ++j)
                sum += value[j] * step->rate[j * n + k];
            rate[i * n + k] = sum;
        }
    }
}

void lag_collocation_at(const LagCollocation *step, const LagMotion *m, const double *y, double x, double *at)
{
    const int n = m->n, s = step->tableau->stages, n_power = m->size - 2 * n;
    const double h = step->h;
    double value[LAG_RADAU_STAGES], integral[LAG_RADAU_STAGES];
    weigh(step->tableau, x, value, integral);
    for (int k = 0; k < n; ++k) {
        double rate = 0, place = x * y[n + k];
        for (int j = 0; j < s; ++j) {
            rate += value[j] * step->rate[j * n + k];
            place += integral[j] * step->rate[j * n + k];
        }
        at[k] = y[k] + h * place;
        at[n + k] = y[n + k] + rate;
    }
    for (int i = 0; i < 3 * m->n_attitudes; ++i) {
        const int k = lag_attitude_place(m->attitudes, i / 3) + i % 3;
        double place = x * y[n + k];
        for (int j = 0; j < s; ++j)
            place += integral[j] * step->way[j * n + k];
        at[k] = y[k] + h * place;
    }
    for (int k = 0; k < n_power; ++k) {
        double energy = x * step->slope[2 * n + k];
        for (int j = 0; j < s; ++j)
            energy += integral[j] * step->power[j * n_power + k];
        at[2 * n + k] = y[2 * n + k] + h * energy;
    }
}
