#include "run/reduce.h"

#include <math.h>
#include <string.h>

/* Gauss-Lobatto-Legendre nodes and weights (M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, table 25.6). */
static const double NODE[LAG_NODES] = {-1, -0.830223896278566929872, -0.468848793470714213804, 0, 0.468848793470714213804,
                                       0.830223896278566929872, 1};
static const double WEIGHT[LAG_NODES] = {0.0476190476190476190476, 0.276826047361565948011, 0.431745381209862623417,
                                         0.487619047619047619048, 0.431745381209862623417, 0.276826047361565948011,
                                         0.0476190476190476190476};
/* Gauss-Legendre with four points: exact for the polynomial through the nodes. */
static const double PART_NODE[2] = {0.339981043584856264803, 0.861136311594052575224};
static const double PART_WEIGHT[2] = {0.652145154862546142627, 0.347854845137453857373};

static const double FINEST = 1e-14; /* in s */
enum { SLICES = 12, MOST_POINTS = LAG_NODES + SLICES, HALVINGS = 60 };

/* ---------------------------------------------------------------- windows */

void lag_window_layout(LagWindow *window, const LagModel *model, LagArena *arena)
{
    window->width = (size_t)lag_run_row_width(model);
    window->rows = lag_take(arena, LAG_NODES * window->width);
    window->inside = lag_take(arena, window->width);
    window->end = lag_take(arena, window->width);
}

void lag_window_init(LagWindow *window, LagRun *run)
{
    window->run = run;
    for (int j = 0; j < LAG_NODES; ++j) {
        double *k = window->basis[j];
        memset(k, 0, sizeof window->basis[j]);
        k[0] = 1;
        for (int i = 0, degree = 0; i < LAG_NODES; ++i) {
            if (i == j)
                continue;
            ++degree; /* times (s - s_i) / (s_j - s_i) */
            for (int m = degree; m >= 0; --m)
                k[m] = ((m > 0 ? k[m - 1] : 0) - NODE[i] * k[m]) / (NODE[j] - NODE[i]);
        }
    }
}

static LagStatus row_at(LagWindow *window, double t, double *row)
{
    int done = 0;
    return lag_run_advance(window->run, &t, 1, row, &done, 0);
}

LagStatus lag_window_open(LagWindow *window, double t)
{
    window->time[0] = t;
    return row_at(window, t, window->rows);
}

static double *node(const LagWindow *window, int j) { return window->rows + (size_t)j * window->width; }

LagStatus lag_window_step(LagWindow *window)
{
    int done = 0;
    const LagStatus status = lag_run_advance_steps(window->run, 1, window->end, &done, 0);
    window->end_time = lag_run_time(window->run);
    return status;
}

LagStatus lag_window_fill(LagWindow *window, double t)
{
    const double centre = (window->time[0] + t) / 2, length = (t - window->time[0]) / 2;
    LagStatus status = LAG_OK;
    for (int j = 1; j < LAG_NODES && status == LAG_OK; ++j) {
        window->time[j] = j < LAG_NODES - 1 ? centre + length * NODE[j] : t;
        if (window->time[j] == window->end_time)
            memcpy(node(window, j), window->end, window->width * sizeof *window->end);
        else
            status = row_at(window, window->time[j], node(window, j));
    }
    return status;
}

void lag_window_next(LagWindow *window)
{
    window->time[0] = window->time[LAG_NODES - 1];
    memcpy(window->rows, node(window, LAG_NODES - 1), window->width * sizeof *window->rows);
}

void lag_window_skip(LagWindow *window)
{
    window->time[0] = window->end_time;
    memcpy(window->rows, window->end, window->width * sizeof *window->rows);
}

static double middle(const LagWindow *window) { return (window->time[0] + window->time[LAG_NODES - 1]) / 2; }

static double half(const LagWindow *window) { return (window->time[LAG_NODES - 1] - window->time[0]) / 2; }

/* ---------------------------------------------------------------- one quantity in one window */

/* Points between which the quantity rises or falls throughout, and (where its absolute value is asked for) keeps its sign. */
typedef struct {
    int column, count;
    double y[LAG_NODES];
    double k[LAG_NODES]; /* of the polynomial, ascending */
    double s[MOST_POINTS], value[MOST_POINTS];
} Course;

static double polynomial(const double *k, double s)
{
    double sum = 0;
    for (int m = LAG_NODES - 1; m >= 0; --m)
        sum = sum * s + k[m];
    return sum;
}

static double slope(const double *k, double s)
{
    double sum = 0;
    for (int m = LAG_NODES - 1; m >= 1; --m)
        sum = sum * s + m * k[m];
    return sum;
}

/* Where a function of the polynomial changes its sign between a and b. */
static double root(double (*f)(const double *, double), const double *k, double a, double b)
{
    const int rises = f(k, a) < 0;
    for (int i = 0; i < HALVINGS && b - a > 1e-12; ++i) {
        const double s = (a + b) / 2;
        if ((f(k, s) < 0) == rises)
            a = s;
        else
            b = s;
    }
    return (a + b) / 2;
}

static void read_course(Course *course, const LagWindow *window, int column)
{
    course->column = column;
    for (int j = 0; j < LAG_NODES; ++j)
        course->y[j] = node(window, j)[column];
    memset(course->k, 0, sizeof course->k);
    for (int j = 0; j < LAG_NODES; ++j)
        for (int m = 0; m < LAG_NODES; ++m)
            course->k[m] += course->y[j] * window->basis[j][m];
}

/* Values more than this above the largest node would take a motion that the window is too long for. */
static double swing(const Course *course)
{
    double largest = 0;
    for (int j = 1; j < LAG_NODES; ++j)
        largest = fmax(largest, fabs(course->y[j] - course->y[j - 1]));
    return largest;
}

static LagStatus true_value(LagWindow *window, const Course *course, double s, double *value)
{
    const LagStatus status = row_at(window, middle(window) + half(window) * s, window->inside);
    *value = window->inside[course->column];
    return status;
}

static void add_point(Course *course, double s, double value)
{
    if (course->count == MOST_POINTS)
        return;
    int place = course->count++;
    for (; place > 0 && course->s[place - 1] > s; --place) {
        course->s[place] = course->s[place - 1];
        course->value[place] = course->value[place - 1];
    }
    course->s[place] = s;
    course->value[place] = value;
}

/* Nodes and turning points, and the zeros if wanted. Turning points get their true values. */
static LagStatus trace(Course *course, LagWindow *window, int with_zeros)
{
    LagStatus status = LAG_OK;
    course->count = 0;
    for (int j = 0; j < LAG_NODES; ++j)
        add_point(course, NODE[j], course->y[j]);
    for (int i = 0; i < SLICES && status == LAG_OK; ++i) {
        const double a = -1 + 2.0 * i / SLICES, b = -1 + 2.0 * (i + 1) / SLICES;
        double value = 0;
        if ((slope(course->k, a) < 0) != (slope(course->k, b) < 0)) {
            const double s = root(slope, course->k, a, b);
            status = true_value(window, course, s, &value);
            add_point(course, s, value);
        }
    }
    if (!with_zeros)
        return status;
    for (int i = course->count - 1; i > 0; --i)
        if (course->value[i - 1] * course->value[i] < 0)
            add_point(course, root(polynomial, course->k, course->s[i - 1], course->s[i]), 0);
    return status;
}

/* ---------------------------------------------------------------- extremes, integrals, crossings */

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
    const int kind = what->kind;
    const int wants_low = kind == LAG_REDUCE_MIN || kind == LAG_REDUCE_TIME_OF_MIN || kind == LAG_REDUCE_RANGE;
    const int wants_high = kind == LAG_REDUCE_MAX || kind == LAG_REDUCE_TIME_OF_MAX || kind == LAG_REDUCE_RANGE;
    return (wants_low && !(low >= reduced->low)) || (wants_high && !(high <= reduced->high));
}

static double sized(const LagReduction *what, double y) { return what->absolute ? fabs(y) : y; }

static LagStatus extremes(const LagReduction *what, LagReduced *reduced, LagWindow *window, Course *course)
{
    double low = INFINITY, high = -INFINITY;
    for (int j = 0; j < LAG_NODES; ++j) {
        note(reduced, window->time[j], course->y[j], what->absolute);
        low = fmin(low, sized(what, course->y[j]));
        high = fmax(high, sized(what, course->y[j]));
    }
    const double reach = swing(course);
    if (!matters(what, reduced, low - reach, high + reach))
        return LAG_OK;
    const LagStatus status = trace(course, window, what->absolute);
    for (int i = 0; i < course->count && status == LAG_OK; ++i)
        note(reduced, middle(window) + half(window) * course->s[i], course->value[i], what->absolute);
    return status;
}

static double part_integral(const Course *course, double a, double b)
{
    double sum = 0;
    for (int i = 0; i < 2; ++i)
        for (int sign = -1; sign <= 1; sign += 2)
            sum += PART_WEIGHT[i] * polynomial(course->k, (a + b) / 2 + sign * PART_NODE[i] * (b - a) / 2);
    return sum * (b - a) / 2;
}

static LagStatus integrate(const LagReduction *what, LagReduced *reduced, LagWindow *window, Course *course)
{
    double sum = 0;
    LagStatus status = LAG_OK;
    if (what->kind == LAG_REDUCE_MEAN && what->absolute) {
        status = trace(course, window, 1);
        for (int i = 1; i < course->count; ++i)
            sum += fabs(part_integral(course, course->s[i - 1], course->s[i]));
    } else
        for (int j = 0; j < LAG_NODES; ++j)
            sum += WEIGHT[j] * (what->kind == LAG_REDUCE_RMS ? course->y[j] * course->y[j] : course->y[j]);
    reduced->integral += half(window) * sum;
    return status;
}

/* Above 0 while the condition holds. */
static double excess(const LagReduction *what, double y)
{
    const double value = sized(what, y);
    const int is_above = what->kind == LAG_REDUCE_FIRST_ABOVE || what->kind == LAG_REDUCE_LAST_ABOVE;
    return is_above ? value - what->value : what->value - value;
}

static int is_met(const LagReduction *what, double y)
{
    const double over = excess(what, y);
    return over > 0 || (what->or_equal && over == 0);
}

/* The time between points i - 1 and i at which the true quantity crosses: regula falsi, in which the value at an end that
 * stays is halved (Illinois), and now and then a bisection. */
static LagStatus crossing(const LagReduction *what, LagWindow *window, const Course *course, int i, double *time)
{
    double a = course->s[i - 1], b = course->s[i], fa = excess(what, course->value[i - 1]), fb = excess(what, course->value[i]);
    double s = a, last = b;
    for (int k = 0, side = 0; k < HALVINGS && b - a > FINEST && fabs(s - last) > FINEST; ++k) {
        double y = 0;
        last = s;
        s = k % 8 == 7 ? (a + b) / 2 : fmin(b, fmax(a, (fa * b - fb * a) / (fa - fb)));
        const LagStatus status = true_value(window, course, s, &y);
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
    *time = middle(window) + half(window) * s;
    return LAG_OK;
}

static LagStatus cross(const LagReduction *what, LagReduced *reduced, LagWindow *window, Course *course)
{
    const int is_first = what->kind == LAG_REDUCE_FIRST_ABOVE || what->kind == LAG_REDUCE_FIRST_BELOW;
    double largest = -INFINITY, least = INFINITY;
    for (int j = 0; j < LAG_NODES; ++j) {
        largest = fmax(largest, excess(what, course->y[j]));
        least = fmin(least, excess(what, course->y[j]));
    }
    const double reach = swing(course);
    if (largest + reach < 0)
        return LAG_OK;
    if (!is_first && least - reach > 0) {
        reduced->found = window->time[LAG_NODES - 1];
        return LAG_OK;
    }
    LagStatus status = trace(course, window, what->absolute);
    for (int i = 0; i < course->count && status == LAG_OK && !reduced->is_known; ++i) {
        const int holds = is_met(what, course->value[i]);
        const int held = i > 0 && is_met(what, course->value[i - 1]);
        if (holds && !is_first)
            reduced->found = i + 1 < course->count ? middle(window) + half(window) * course->s[i] : window->time[LAG_NODES - 1];
        if (holds && is_first && i == 0)
            reduced->found = window->time[0];
        else if (i > 0 && (is_first ? holds : held && !holds))
            status = crossing(what, window, course, i, &reduced->found);
        reduced->is_known = is_first && holds;
    }
    return status;
}

/* ---------------------------------------------------------------- reductions */

void lag_reduce_start(LagReduced *reduced)
{
    const LagReduced nothing = {INFINITY, -INFINITY, NAN, NAN, 0, NAN, NAN, NAN, NAN, 0};
    *reduced = nothing;
}

void lag_reduce_row(const LagReduction *what, LagReduced *reduced, const double *row)
{
    const double y = row[what->column];
    reduced->found = sized(what, y);
    reduced->is_known = 1;
}

static double rate_in(const LagReduction *what, const double *row) { return what->rate >= 0 ? row[what->rate] : NAN; }

void lag_reduce_open(const LagReduction *what, LagReduced *reduced, const LagWindow *window)
{
    reduced->before = NAN;
    reduced->latest = window->rows[what->column];
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
    if (what->kind <= LAG_REDUCE_RANGE)
        return !is_monotonic && (isnan(reach) || matters(what, reduced, fmin(a, b) - reach, fmax(a, b) + reach));
    return !(excess(what, reduced->latest) * excess(what, y) > 0) || !(fmin(fabs(a - what->value), fabs(b - what->value)) > reach);
}

int lag_reduce_glance(const LagReduction *what, LagReduced *reduced, const LagWindow *window)
{
    const double y = window->end[what->column], rate = rate_in(what, window->end);
    if (what->kind == LAG_REDUCE_AT || reduced->is_known)
        return 0;
    const int is_integral = what->kind == LAG_REDUCE_MEAN || what->kind == LAG_REDUCE_RMS;
    const int open = is_integral || is_open(what, reduced, y, rate);
    if (!open && what->kind <= LAG_REDUCE_RANGE) {
        note(reduced, window->time[0], reduced->latest, what->absolute);
        note(reduced, window->end_time, y, what->absolute);
    } else if (!open && excess(what, y) > 0) { /* all along */
        const int is_first = what->kind == LAG_REDUCE_FIRST_ABOVE || what->kind == LAG_REDUCE_FIRST_BELOW;
        reduced->found = is_first ? window->time[0] : window->end_time;
        reduced->is_known = is_first;
    }
    reduced->before = reduced->latest;
    reduced->latest = y;
    reduced->rate = rate;
    return open;
}

LagStatus lag_reduce_window(const LagReduction *what, LagReduced *reduced, LagWindow *window)
{
    if (what->kind == LAG_REDUCE_AT || reduced->is_known)
        return LAG_OK;
    Course course;
    read_course(&course, window, what->column);
    if (what->kind <= LAG_REDUCE_RANGE)
        return extremes(what, reduced, window, &course);
    if (what->kind <= LAG_REDUCE_RMS)
        return integrate(what, reduced, window, &course);
    return cross(what, reduced, window, &course);
}

double lag_reduce_result(const LagReduction *what, const LagReduced *reduced, double duration)
{
    switch (what->kind) {
    case LAG_REDUCE_MIN: return isfinite(reduced->low) ? reduced->low : NAN;
    case LAG_REDUCE_MAX: return isfinite(reduced->high) ? reduced->high : NAN;
    case LAG_REDUCE_TIME_OF_MIN: return reduced->time_low;
    case LAG_REDUCE_TIME_OF_MAX: return reduced->time_high;
    case LAG_REDUCE_RANGE: return isfinite(reduced->high) ? reduced->high - reduced->low : NAN;
    case LAG_REDUCE_MEAN: return reduced->integral / duration;
    case LAG_REDUCE_RMS: return sqrt(reduced->integral / duration);
    default: return reduced->found;
    }
}
