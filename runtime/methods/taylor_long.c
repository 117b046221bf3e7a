#include "methods/taylor_long.h"

#include "numbers/lanes.h"

/* The coefficients of q are those of v over the next order, so only these are read: it is reading that takes the time. */
void lag_long_displacement(const LagModel *model, const double *jets, int order, double h, double *step, double *slope)
{
    const int n = model->n, pitch = model->jet_pitch;
    double place[LAG_JET_STRIDE], rate[LAG_JET_STRIDE], change[LAG_JET_STRIDE], power = 1, *rates = slope + n + LAG_LANES;
    for (int k = 1; k <= order; ++k) {
        change[k] = k * power;
        power *= h;
        rate[k] = power;
        place[k - 1] = power * lag_inverse[k - 1];
    }
    for (int i = 0; i < n; i += LAG_LANES) {
        const double *row = jets + order * pitch + 1 + n + i;
        LagLanes c, to_q = LAG_LANES_OF(0), to_v, to_a;
        memcpy(&c, row, sizeof c);
        to_v = c * LAG_LANES_OF(rate[order]);
        to_a = c * LAG_LANES_OF(change[order]);
        for (int k = order - 1; k > 0; --k) {
            row -= pitch;
            memcpy(&c, row, sizeof c);
            to_q += c * LAG_LANES_OF(place[k]);
            to_v += c * LAG_LANES_OF(rate[k]);
            to_a += c * LAG_LANES_OF(change[k]);
        }
        memcpy(&c, row - pitch, sizeof c);
        to_q += c * LAG_LANES_OF(place[0]);
        memcpy(step + i, &to_q, sizeof to_q);
        memcpy(slope + i, &to_a, sizeof to_a);
        memcpy(rates + i, &to_v, sizeof to_v);
    }
    memcpy(step + n, rates, (size_t)n * sizeof *step); /* over what went beyond the end of the positions */
}

void lag_long_weigh(LagRun *run, const double *end, double *last, double *before)
{
    const LagTaylor *s = &run->methods.taylor;
    const int pitch = run->model->jet_pitch, size = 2 * run->model->n;
    const double *latest = s->jets + 1 + s->order * pitch, *earlier = latest - pitch;
    const LagLanes one = LAG_LANES_OF(1), zero = LAG_LANES_OF(0);
    LagLanes most = zero, most_before = zero;
    lag_scale_units(&run->scale, run->motion.y, end, s->unit);
    for (int i = 0; i < size; i += LAG_LANES) { /* the padding of units is 0 */
        LagLanes unit, weight, c, d;
        memcpy(&unit, s->unit + i, sizeof unit);
        memcpy(&c, latest + i, sizeof c);
        memcpy(&d, earlier + i, sizeof d);
        weight = LAG_LANES_SELECT(unit > zero, one / unit, zero);
        c = LAG_LANES_ABS(c) * weight;
        d = LAG_LANES_ABS(d) * weight;
        memcpy(s->share + i, &c, sizeof c);
        most = LAG_LANES_MAX(c, most);
        most_before = LAG_LANES_MAX(d, most_before);
    }
    *last = lag_lanes_largest(&most, *last);
    *before = lag_lanes_largest(&most_before, *before);
    for (run->statistics.worst = 0; run->statistics.worst < size - 1 && s->share[run->statistics.worst] < *last;)
        ++run->statistics.worst;
}

double lag_long_gap(LagRun *run)
{
    const LagTaylor *s = &run->methods.taylor;
    const int n = run->model->n;
    const double *found = s->old_jets + 1 + n + run->model->jet_pitch;
    const LagLanes zero = LAG_LANES_OF(0);
    LagLanes most = zero;
    lag_scale_units(&run->scale, run->motion.y, run->motion.other, s->unit);
    for (int i = 0; i < n; i += LAG_LANES) { /* the padding of units is 0 */
        LagLanes slope, there, unit;
        memcpy(&slope, s->share + i, sizeof slope);
        memcpy(&there, found + i, sizeof there);
        memcpy(&unit, s->unit + n + i, sizeof unit);
        slope -= there;
        slope = LAG_LANES_SELECT(unit > zero, LAG_LANES_ABS(slope) / unit, zero);
        most = LAG_LANES_MAX(slope, most);
    }
    return lag_lanes_largest(&most, 0);
}
