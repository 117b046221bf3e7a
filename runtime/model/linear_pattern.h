/* Where the numbers of a linear scene lie, x' = A x with x = (q, v, w): M v' = F x and w' = G w.
 *
 * The model's `linear_pattern` is
 *     n_w, n_inputs, changes, n_forms   states of loads, how many of them begin with inputs and their slopes; whether numbers
 *                                       depend on modes; forms: 0, or 2 for the powers x' Q x of the account
 *     order[n]                          order in which M is eliminated
 *     start[n + 1], column[]            rows below the diagonal of M's factor L in this order
 *     start[rows + 1], column[]         rows of F (n), of G (n_w), of each form (2 n + n_w)
 * and `linear` gives the diagonal of M in this order, its entries in the places of L, and those of F, G and the forms.
 */
#ifndef LAG_LINEAR_PATTERN_H
#define LAG_LINEAR_PATTERN_H

#include "model/model.h"

typedef struct {
    int rows;
    const int *start, *column;
} LagRows;

typedef struct {
    int n, n_w, n_inputs, changes, n_forms, size;
    const int *order;
    LagRows lower, F, G, form[2];
} LagLinearPattern;

static inline LagRows lag_rows_read(int rows, const int **pattern)
{
    const int *start = *pattern, *column = start + rows + 1;
    *pattern = column + start[rows];
    return (LagRows){rows, start, column};
}

static inline LagLinearPattern lag_linear_pattern(const LagModel *model)
{
    const int *numbers = model->linear_pattern, *next = numbers + 4 + model->n;
    LagLinearPattern p = {model->n, numbers[0], numbers[1], numbers[2], numbers[3], 2 * model->n + numbers[0], numbers + 4,
                          {0, NULL, NULL}, {0, NULL, NULL}, {0, NULL, NULL}, {{0, NULL, NULL}, {0, NULL, NULL}}};
    p.lower = lag_rows_read(p.n, &next);
    p.F = lag_rows_read(p.n, &next);
    p.G = lag_rows_read(p.n_w, &next);
    for (int f = 0; f < p.n_forms; ++f)
        p.form[f] = lag_rows_read(p.size, &next);
    return p;
}

#endif
