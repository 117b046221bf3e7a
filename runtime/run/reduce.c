#include "run/reduce.h"

#include <math.h>
#include <string.h>

static const double FINEST = 1e-14; /* in s */
enum { HALVINGS = 60 };

typedef enum { AT, EXTREME, INTEGRAL, CROSSING, DWELL, ENDS, FLOW, WAVES } Family;

static Family family(const LagReduction *what)
{
    switch (what->kind) {
    case LAG_REDUCE_AT: return AT;
    case LAG_REDUCE_MIN: case LAG_REDUCE_MAX: case LAG_REDUCE_TIME_OF_MIN: case LAG_REDUCE_TIME_OF_MAX: case LAG_REDUCE_RANGE:
    case LAG_REDUCE_OVERSHOOT: return EXTREME;
    case LAG_REDUCE_MEAN: case LAG_REDUCE_RMS: case LAG_REDUCE_INTEGRAL: return INTEGRAL;
    case LAG_REDUCE_FIRST_ABOVE: case LAG_REDUCE_FIRST_BELOW: case LAG_REDUCE_LAST_ABOVE: case LAG_REDUCE_LAST_BELOW:
        return CROSSING;
    case LAG_REDUCE_SETTLING: return ENDS;
    case LAG_REDUCE_DAMAGE: return FLOW;
    case LAG_REDUCE_PEAK_FREQUENCY: case LAG_REDUCE_PEAK_AMPLITUDE: return WAVES;
    default: return DWELL;
    }
}

static double sized(const LagReduction *what, double y) { return what->absolute ? fabs(y) : y; }

static double quantity(const LagReduction *what, const double *row) { return row[what->column] - what->centre; }

/* ---------------------------------------------------------------- two runs */

LagReduction lag_reduce_first(const LagReduction *what)
{
    LagReduction first = *what;
    if (what->kind == LAG_REDUCE_PERIOD)
        first.kind = LAG_REDUCE_MEAN;
    return first;
}

int lag_reduce_takes_two(const LagReduction *what)
{
    return what->kind == LAG_REDUCE_PERIOD || what->kind == LAG_REDUCE_SETTLING;
}

LagReduction lag_reduce_second(const LagReduction *what, const LagReduced *reduced, double duration)
{
    LagReduction second = *what;
    if (what->kind == LAG_REDUCE_PERIOD) {
        second.kind = LAG_REDUCE_PERIOD_ABOVE;
        second.value = reduced->integral / duration;
    } else { /* |y - end| > band */
        second.kind = LAG_REDUCE_LAST_ABOVE;
        second.absolute = 1;
        second.centre = reduced->last;
        second.value = what->value * fabs(reduced->last - reduced->first);
    }
    return second;
}

/* ---------------------------------------------------------------- extremes and integrals */

static void note(LagReduced *reduced, double t, double y, int absolute)
{
    const double value = absolute ? fabs(y) : y;
    if (value < reduced->low) {
        reduced->low = value;
        reduced->time_low = t;
    }
    if (value > reduced->high) {
        reduced->high = value;
        reduced->time_high = t;
    }
}

/* Whether values as far as these could change the result. */
static int matters(const LagReduction *what, const LagReduced *reduced, double low, double high)
{
    const int kind = what->kind, wants_both = kind == LAG_REDUCE_RANGE || kind == LAG_REDUCE_OVERSHOOT;
    const int wants_low = kind == LAG_REDUCE_MIN || kind == LAG_REDUCE_TIME_OF_MIN || wants_both;
    const int wants_high = kind == LAG_REDUCE_MAX || kind == LAG_REDUCE_TIME_OF_MAX || wants_both;
    return (wants_low && !(low >= reduced->low)) || (wants_high && !(high <= reduced->high));
}

static LagStatus extremes(const LagReduction *what, LagReduced *reduced, LagWindow *window, LagCourse *course)
{
    double low = INFINITY, high = -INFINITY;
    for (int j = 0; j < LAG_NODES; ++j) {
        note(reduced, window->time[j], course->y[j], what->absolute);
        low = fmin(low, sized(what, course->y[j]));
        high = fmax(high, sized(what, course->y[j]));
    }
    const double reach = lag_course_swing(course);
    if (!matters(what, reduced, low - reach, high + reach))
        return LAG_OK;
    const LagStatus status = lag_course_trace(course, window, what->absolute);
    for (int i = 0; i < course->count && status == LAG_OK; ++i)
        note(reduced, lag_window_time(window, course->s[i]), course->value[i], what->absolute);
    return status;
}

static LagStatus integrate(const LagReduction *what, LagReduced *reduced, LagWindow *window, LagCourse *course)
{
    const int squares = what->kind == LAG_REDUCE_RMS;
    double sum = 0;
    LagStatus status = LAG_OK;
    if (what->absolute && !squares) {
        status = lag_course_trace(course, window, 1);
        for (int i = 1; i < course->count; ++i)
            sum += fabs(lag_course_integral(course, course->s[i - 1], course->s[i]));
    } else
        for (int j = 0; j < LAG_NODES; ++j)
            sum += lag_window_weight[j] * (squares ? course->y[j] * course->y[j] : course->y[j]);
    reduced->integral += lag_window_half(window) * sum;
    return status;
}

/* ---------------------------------------------------------------- levels */

/* Above 0 while the condition holds. */
static double excess(const LagReduction *what, double y)
{
    const double value = sized(what, y);
    switch (what->kind) {
    case LAG_REDUCE_FIRST_BELOW: case LAG_REDUCE_LAST_BELOW: case LAG_REDUCE_COUNT_BELOW: case LAG_REDUCE_DURATION_BELOW:
    case LAG_REDUCE_PERIOD_BELOW: return what->value - value;
    default: return value - what->value;
    }
}

static int is_met(const LagReduction *what, double y)
{
    const double over = excess(what, y);
    return over > 0 || (what->or_equal && over == 0);
}

/* The time between points i - 1 and i at which the true quantity crosses: regula falsi, in which the value at an end that
 * stays is halved (Illinois), and now and then a bisection. */
static LagStatus crossing(const LagReduction *what, LagWindow *window, const LagCourse *course, int i, double *time)
{
    double a = course->s[i - 1], b = course->s[i], fa = excess(what, course->value[i - 1]), fb = excess(what, course->value[i]);
    double s = a, last = b;
    for (int k = 0, side = 0; k < HALVINGS && b - a > FINEST && fabs(s - last) > FINEST; ++k) {
        double y = 0;
        last = s;
        s = k % 8 == 7 ? (a + b) / 2 : fmin(b, fmax(a, (fa * b - fb * a) / (fa - fb)));
        const LagStatus status = lag_course_value(window, course, s, &y);
        if (status != LAG_OK)
            return status;
        const double f = excess(what, y);
        if ((f > 0) == (fb > 0)) {
            fa = side == 1 ? fa / 2 : fa;
            b = s, fb = f, side = 1;
        } else {
            fb = side == -1 ? fb / 2 : fb;
            a = s, fa = f, side = -1;
        }
    }
    *time = lag_window_time(window, s);
    return LAG_OK;
}

/* How far a window's nodes stay from the level, on which side, less what may lie between them: 0 where it may be crossed. */
static double clearance(const LagReduction *what, const LagCourse *course)
{
    double largest = -INFINITY, least = INFINITY;
    for (int j = 0; j < LAG_NODES; ++j) {
        largest = fmax(largest, excess(what, course->y[j]));
        least = fmin(least, excess(what, course->y[j]));
    }
    const double reach = lag_course_swing(course);
    return largest + reach < 0 ? largest + reach : least - reach > 0 ? least - reach : 0;
}

static int is_first(const LagReduction *what)
{
    return what->kind == LAG_REDUCE_FIRST_ABOVE || what->kind == LAG_REDUCE_FIRST_BELOW;
}

static LagStatus cross(const LagReduction *what, LagReduced *reduced, LagWindow *window, LagCourse *course)
{
    const double clear = clearance(what, course);
    if (clear < 0)
        return LAG_OK;
    if (!is_first(what) && clear > 0) {
        reduced->found = window->time[LAG_NODES - 1];
        return LAG_OK;
    }
    LagStatus status = lag_course_trace(course, window, what->absolute);
    for (int i = 0; i < course->count && status == LAG_OK && !reduced->is_known; ++i) {
        const int holds = is_met(what, course->value[i]);
        const int held = i > 0 && is_met(what, course->value[i - 1]);
        if (holds && !is_first(what))
            reduced->found = i + 1 < course->count ? lag_window_time(window, course->s[i]) : window->time[LAG_NODES - 1];
        if (holds && is_first(what) && i == 0)
            reduced->found = window->time[0];
        else if (i > 0 && (is_first(what) ? holds : held && !holds))
            status = crossing(what, window, course, i, &reduced->found);
        reduced->is_known = is_first(what) && holds;
    }
    return status;
}

/* The condition holds, or not, from the time a to b, between which it does not change. */
static void stay(LagReduced *reduced, int holds, double a, double b)
{
    reduced->stretches += holds && reduced->holds != 1;
    if (holds && reduced->holds == 0) {
        reduced->entered_first = reduced->entered == 0 ? a : reduced->entered_first;
        reduced->entered_last = a;
        reduced->entered += 1;
    }
    if (holds)
        reduced->found = (isnan(reduced->found) ? 0 : reduced->found) + (b - a);
    reduced->holds = holds;
}

static LagStatus dwell(const LagReduction *what, LagReduced *reduced, LagWindow *window, LagCourse *course)
{
    const double clear = clearance(what, course);
    if (clear < 0 || clear > 0) {
        stay(reduced, clear > 0, window->time[0], window->time[LAG_NODES - 1]);
        return LAG_OK;
    }
    LagStatus status = lag_course_trace(course, window, what->absolute);
    double last = window->time[0];
    for (int i = 1; i < course->count && status == LAG_OK; ++i) {
        const double t = i + 1 < course->count ? lag_window_time(window, course->s[i]) : window->time[LAG_NODES - 1];
        const int held = is_met(what, course->value[i - 1]), holds = is_met(what, course->value[i]);
        double middle = t;
        if (held != holds)
            status = crossing(what, window, course, i, &middle);
        stay(reduced, held, last, middle);
        if (held != holds)
            stay(reduced, holds, middle, t);
        last = t;
    }
    return status;
}

/* ---------------------------------------------------------------- turning points */

static LagStatus flow_on(const LagReduction *what, LagReduced *reduced, LagWindow *window, LagCourse *course)
{
    const LagStatus status = lag_course_trace(course, window, what->absolute);
    for (int i = 0; i < course->count && status == LAG_OK; ++i)
        lag_rainflow_add(&reduced->flow, sized(what, course->value[i]));
    return reduced->flow.has_failed ? LAG_OUT_OF_MEMORY : status;
}

/* ---------------------------------------------------------------- vibrations */

static LagStatus wave_on(LagReduced *reduced, const LagWindow *window, const LagCourse *course)
{
    LagPiece piece = {.start = window->time[0], .half = lag_window_half(window)};
    memcpy(piece.k, course->k, sizeof piece.k);
    lag_spectrum_add(&reduced->spectrum, &piece);
    return reduced->spectrum.has_failed ? LAG_OUT_OF_MEMORY : LAG_OK;
}

static double peak(const LagReduction *what, const LagReduced *reduced)
{
    double frequency, amplitude;
    lag_spectrum_peak(&reduced->spectrum, &frequency, &amplitude);
    return what->kind == LAG_REDUCE_PEAK_FREQUENCY ? frequency : amplitude;
}

/* ---------------------------------------------------------------- reductions */

void lag_reduce_start(const LagReduction *what, LagReduced *reduced)
{
    reduced->found = NAN;
    reduced->is_known = 0;
    if (what->kind == LAG_REDUCE_AT) /* has no more */
        return;
    const LagRainflow flow = reduced->flow;
    const LagSpectrum spectrum = reduced->spectrum;
    const LagReduced nothing = {.low = INFINITY, .high = -INFINITY, .time_low = NAN, .time_high = NAN, .found = NAN,
                                .before = NAN, .latest = NAN, .rate = NAN, .first = NAN, .last = NAN, .entered_first = NAN,
                                .entered_last = NAN, .holds = -1, .flow = flow, .spectrum = spectrum};
    *reduced = nothing;
    lag_rainflow_start(&reduced->flow, what->value, what->size, what->keeps_cycles);
    lag_spectrum_start(&reduced->spectrum);
}

void lag_reduce_row(const LagReduction *what, LagReduced *reduced, const double *row)
{
    reduced->found = sized(what, quantity(what, row));
    reduced->is_known = 1;
}

static double rate_in(const LagReduction *what, const double *row) { return what->rate >= 0 ? row[what->rate] : NAN; }

void lag_reduce_open(const LagReduction *what, LagReduced *reduced, const LagWindow *window)
{
    reduced->before = NAN;
    reduced->latest = quantity(what, window->rows);
    reduced->rate = rate_in(what, window->rows);
}

/* Whether the quantity could turn or cross within a step whose ends are known, and whether that would matter. A quantity is
 * taken not to turn where its rate has the same sign at both ends; where the rate is not known it is taken not to reach
 * farther beyond the ends than it moved in this step or in the one before. */
static int is_open(const LagReduction *what, const LagReduced *reduced, double y, double rate)
{
    const double a = sized(what, reduced->latest), b = sized(what, y), change = fabs(y - reduced->latest);
    const int crosses_zero = what->absolute && !(reduced->latest * y > 0);
    const int is_monotonic = !crosses_zero && reduced->rate * rate > 0;
    const double reach = is_monotonic ? 0 : change + fabs(reduced->latest - reduced->before);
    switch (family(what)) {
    case INTEGRAL: case WAVES: return 1;
    case ENDS: return 0;
    case FLOW: return !is_monotonic;
    case EXTREME: return !is_monotonic && (isnan(reach) || matters(what, reduced, fmin(a, b) - reach, fmax(a, b) + reach));
    default: break;
    }
    return !(excess(what, reduced->latest) * excess(what, y) > 0) || !(fmin(fabs(a - what->value), fabs(b - what->value)) > reach);
}

/* What a step that is not looked into adds. */
static void add_step(const LagReduction *what, LagReduced *reduced, double a, double b, double y)
{
    const int holds = excess(what, y) > 0; /* all along, if at all */
    switch (family(what)) {
    case EXTREME:
        note(reduced, a, reduced->latest, what->absolute);
        note(reduced, b, y, what->absolute);
        break;
    case CROSSING:
        if (holds)
            reduced->found = is_first(what) ? a : b;
        reduced->is_known = holds && is_first(what);
        break;
    case DWELL: stay(reduced, holds, a, b); break;
    case FLOW:
        lag_rainflow_add(&reduced->flow, sized(what, reduced->latest));
        lag_rainflow_add(&reduced->flow, sized(what, y));
        break;
    default: break;
    }
    reduced->first = isnan(reduced->first) ? sized(what, reduced->latest) : reduced->first;
    reduced->last = sized(what, y);
}

int lag_reduce_glance(const LagReduction *what, LagReduced *reduced, const LagWindow *window, int is_long)
{
    const double y = quantity(what, window->end), rate = rate_in(what, window->end), a = window->time[0], b = window->end_time;
    if (what->kind == LAG_REDUCE_AT || reduced->is_known)
        return 0;
    const int is_cut = (a < what->from && what->from < b) || (a < what->to && what->to < b);
    const int is_inside = what->from <= a && b <= what->to;
    const int open = is_cut || (is_inside && (is_long || is_open(what, reduced, y, rate)));
    if (!open && is_inside)
        add_step(what, reduced, a, b, y);
    reduced->before = reduced->latest;
    reduced->latest = y;
    reduced->rate = rate;
    return open;
}

LagStatus lag_reduce_window(const LagReduction *what, LagReduced *reduced, LagWindow *window)
{
    const double middle = lag_window_time(window, 0);
    if (what->kind == LAG_REDUCE_AT || reduced->is_known || middle < what->from || middle > what->to)
        return LAG_OK;
    LagCourse course;
    lag_course_read(&course, window, what->column, what->centre);
    reduced->first = isnan(reduced->first) ? sized(what, course.y[0]) : reduced->first;
    reduced->last = sized(what, course.y[LAG_NODES - 1]);
    switch (family(what)) {
    case EXTREME: return extremes(what, reduced, window, &course);
    case INTEGRAL: return integrate(what, reduced, window, &course);
    case CROSSING: return cross(what, reduced, window, &course);
    case DWELL: return dwell(what, reduced, window, &course);
    case FLOW: return flow_on(what, reduced, window, &course);
    case WAVES: return wave_on(reduced, window, &course);
    default: return LAG_OK;
    }
}

static double overshoot(const LagReduced *reduced)
{
    const double way = reduced->last - reduced->first;
    return way > 0 ? (reduced->high - reduced->last) / way : way < 0 ? (reduced->low - reduced->last) / way : NAN;
}

double lag_reduce_result(const LagReduction *what, const LagReduction *taken, LagReduced *reduced, double start, double duration)
{
    if (what->kind == LAG_REDUCE_SETTLING)
        return !(taken->value > 0) ? NAN : isnan(reduced->found) ? 0 : reduced->found - start;
    switch (taken->kind) {
    case LAG_REDUCE_MIN: return isfinite(reduced->low) ? reduced->low : NAN;
    case LAG_REDUCE_MAX: return isfinite(reduced->high) ? reduced->high : NAN;
    case LAG_REDUCE_TIME_OF_MIN: return reduced->time_low;
    case LAG_REDUCE_TIME_OF_MAX: return reduced->time_high;
    case LAG_REDUCE_RANGE: return isfinite(reduced->high) ? reduced->high - reduced->low : NAN;
    case LAG_REDUCE_OVERSHOOT: return overshoot(reduced);
    case LAG_REDUCE_MEAN: return reduced->integral / duration;
    case LAG_REDUCE_RMS: return sqrt(reduced->integral / duration);
    case LAG_REDUCE_INTEGRAL: return reduced->integral;
    case LAG_REDUCE_COUNT_ABOVE: case LAG_REDUCE_COUNT_BELOW: return reduced->stretches;
    case LAG_REDUCE_DURATION_ABOVE: case LAG_REDUCE_DURATION_BELOW: return isnan(reduced->found) ? 0 : reduced->found;
    case LAG_REDUCE_PERIOD_ABOVE: case LAG_REDUCE_PERIOD_BELOW:
        return reduced->entered > 1 ? (reduced->entered_last - reduced->entered_first) / (reduced->entered - 1) : NAN;
    case LAG_REDUCE_DAMAGE: lag_rainflow_end(&reduced->flow); return reduced->flow.damage;
    case LAG_REDUCE_PEAK_FREQUENCY: case LAG_REDUCE_PEAK_AMPLITUDE: return peak(taken, reduced);
    default: return reduced->found;
    }
}
