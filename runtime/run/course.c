#include "run/course.h"

#include <math.h>
#include <string.h>

/* Gauss-Legendre with four points: exact for the polynomial through the nodes. */
static const double PART_NODE[2] = {0.339981043584856264803, 0.861136311594052575224};
static const double PART_WEIGHT[2] = {0.652145154862546142627, 0.347854845137453857373};

enum { HALVINGS = 60 };
/* Of the swing: the polynomial is not the quantity; of a window: two times are one. */
static const double ROUGH = 1e-6, CLOSE = 1e-9;

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

void lag_course_read(LagCourse *course, const LagWindow *window, int column, double centre)
{
    course->column = column;
    course->centre = centre;
    for (int j = 0; j < LAG_NODES; ++j)
        course->y[j] = lag_window_row(window, j)[column] - centre;
    memset(course->k, 0, sizeof course->k);
    for (int j = 0; j < LAG_NODES; ++j)
        for (int m = 0; m < LAG_NODES; ++m)
            course->k[m] += course->y[j] * window->basis[j][m];
}

double lag_course_swing(const LagCourse *course)
{
    double largest = 0;
    for (int j = 1; j < LAG_NODES; ++j)
        largest = fmax(largest, fabs(course->y[j] - course->y[j - 1]));
    return largest;
}

LagStatus lag_course_value(LagWindow *window, const LagCourse *course, double s, double *value)
{
    const LagStatus status = lag_window_look(window, lag_window_time(window, s));
    *value = window->inside[course->column] - course->centre;
    return status;
}

static void add_point(LagCourse *course, double s, double value)
{
    if (course->count == LAG_MOST_POINTS)
        return;
    int place = course->count++;
    for (; place > 0 && course->s[place - 1] > s; --place) {
        course->s[place] = course->s[place - 1];
        course->value[place] = course->value[place - 1];
    }
    course->s[place] = s;
    course->value[place] = value;
}

/* The true turning point between a and b, where the polynomial does not follow the quantity, as at a kink: golden section. */
static LagStatus turn_truly(LagCourse *course, LagWindow *window, double a, double b, int is_high, double *s, double *value)
{
    const double share = 0.381966011250105152;
    double x[2] = {a + share * (b - a), b - share * (b - a)}, y[2];
    LagStatus status = lag_course_value(window, course, x[0], &y[0]);
    if (status == LAG_OK)
        status = lag_course_value(window, course, x[1], &y[1]);
    for (int i = 0; i < HALVINGS && b - a > CLOSE && status == LAG_OK; ++i) {
        const int keeps_low = (y[0] > y[1]) == is_high, kept = !keeps_low;
        *(keeps_low ? &b : &a) = x[!kept];
        x[!kept] = x[kept], y[!kept] = y[kept];
        x[kept] = keeps_low ? a + share * (b - a) : b - share * (b - a);
        status = lag_course_value(window, course, x[kept], &y[kept]);
    }
    const int best = (y[1] > y[0]) == is_high;
    *s = x[best];
    *value = y[best];
    return status;
}

LagStatus lag_course_trace(LagCourse *course, LagWindow *window, int with_zeros)
{
    const double rough = ROUGH * lag_course_swing(course);
    LagStatus status = LAG_OK;
    course->count = 0;
    for (int j = 0; j < LAG_NODES; ++j)
        add_point(course, lag_window_node[j], course->y[j]);
    for (int i = 0; i < LAG_SLICES && status == LAG_OK; ++i) {
        const double a = -1 + 2.0 * i / LAG_SLICES, b = -1 + 2.0 * (i + 1) / LAG_SLICES;
        double value = 0;
        if ((slope(course->k, a) < 0) != (slope(course->k, b) < 0)) {
            double s = root(slope, course->k, a, b);
            status = lag_course_value(window, course, s, &value);
            if (status == LAG_OK && fabs(value - polynomial(course->k, s)) > rough)
                status = turn_truly(course, window, fmax(-1, a - 2.0 / LAG_SLICES), fmin(1, b + 2.0 / LAG_SLICES),
                                    slope(course->k, a) > 0, &s, &value);
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

double lag_course_integral(const LagCourse *course, double a, double b)
{
    double sum = 0;
    for (int i = 0; i < 2; ++i)
        for (int sign = -1; sign <= 1; sign += 2)
            sum += PART_WEIGHT[i] * polynomial(course->k, (a + b) / 2 + sign * PART_NODE[i] * (b - a) / 2);
    return sum * (b - a) / 2;
}
