/* Between two events one segment of the table is in force, chosen once; evaluating then needs no search and has no doubt
 * about which side of a jump is meant. */
#include "model/inputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int ascending(const double *times, int rows)
{
    for (int i = 0; i < rows; ++i)
        if (!isfinite(times[i]) || (i > 0 && times[i] < times[i - 1]))
            return 0;
    return rows > 0;
}

static LagStatus reserve(LagInputs *inputs, int rows)
{
    if (rows <= inputs->capacity)
        return LAG_OK;
    const size_t count = (size_t)rows * (size_t)(1 + inputs->n);
    double *block = malloc(count * sizeof *block);
    if (!block)
        return LAG_OUT_OF_MEMORY;
    free(inputs->times);
    inputs->times = block;
    inputs->values = block + rows;
    inputs->capacity = rows;
    return LAG_OK;
}

LagStatus lag_inputs_set(LagInputs *inputs, const double *times, const double *values, int rows)
{
    if (!ascending(times, rows))
        return LAG_BAD_INPUTS;
    const LagStatus status = reserve(inputs, rows);
    if (status != LAG_OK)
        return status;
    memcpy(inputs->times, times, (size_t)rows * sizeof *times);
    memcpy(inputs->values, values, (size_t)rows * (size_t)inputs->n * sizeof *values);
    inputs->rows = rows;
    ++inputs->version;
    return LAG_OK;
}

void lag_inputs_free(LagInputs *inputs) { free(inputs->times); }

/* Number of rows at or before t. */
static int rows_until(const LagInputs *inputs, double t)
{
    int low = 0, high = inputs->rows;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (inputs->times[middle] <= t)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

void lag_inputs_enter(LagInputs *inputs, double t) { inputs->left = rows_until(inputs, t) - 1; }

void lag_inputs_at(const LagInputs *inputs, double t, double *u)
{
    const int n = inputs->n, last = inputs->rows - 1, left = inputs->left;
    if (n == 0)
        return;
    if (left < 0 || left >= last) { /* held; a model whose inputs were never set sees zeros */
        for (int i = 0; i < n; ++i)
            u[i] = last < 0 ? 0 : inputs->values[(left < 0 ? 0 : last) * n + i];
        return;
    }
    const double *t0 = inputs->times + left, *u0 = inputs->values + left * n, *u1 = u0 + n;
    const double x = (t - t0[0]) / (t0[1] - t0[0]);
    for (int i = 0; i < n; ++i)
        u[i] = u0[i] + x * (u1[i] - u0[i]);
}

void lag_inputs_slope(const LagInputs *inputs, double *slope)
{
    const int n = inputs->n, left = inputs->left, is_held = left < 0 || left >= inputs->rows - 1;
    for (int i = 0; i < n; ++i) {
        const double *u0 = inputs->values + (is_held ? 0 : left * n + i);
        slope[i] = is_held ? 0 : (u0[n] - u0[0]) / (inputs->times[left + 1] - inputs->times[left]);
    }
}

double lag_inputs_next(const LagInputs *inputs, double t)
{
    const int next = rows_until(inputs, t);
    return inputs->rows > 1 && next < inputs->rows ? inputs->times[next] : INFINITY;
}
