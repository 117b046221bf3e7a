/* The course of one quantity in a window: points between which it rises or falls throughout. */
#ifndef LAG_COURSE_H
#define LAG_COURSE_H

#include "run/window.h"

enum { LAG_SLICES = 12, LAG_MOST_POINTS = LAG_NODES + LAG_SLICES };

typedef struct {
    int column, count;
    double centre; /* what is taken off the quantity */
    double y[LAG_NODES];
    double k[LAG_NODES]; /* of the polynomial, ascending */
    double s[LAG_MOST_POINTS], value[LAG_MOST_POINTS];
} LagCourse;

void lag_course_read(LagCourse *course, const LagWindow *window, int column, double centre);

/* The largest step from node to node: values more than this beyond the nodes would take a motion that the window is too long for. */
double lag_course_swing(const LagCourse *course);

/* Nodes and turning points, which get their true values; and, if wanted, the points at which the quantity changes its sign. */
LagStatus lag_course_trace(LagCourse *course, LagWindow *window, int with_zeros);

/* The true value at -1 <= s <= 1. */
LagStatus lag_course_value(LagWindow *window, const LagCourse *course, double s, double *value);

/* Of the polynomial, over s. */
double lag_course_integral(const LagCourse *course, double a, double b);

#endif
