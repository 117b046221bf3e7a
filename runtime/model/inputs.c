/* Between two events one segment of the table is in force, chosen once; evaluating then needs no search and has no doubt
 * about which side of a jump is meant. */
#include "model/inputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double ROUNDING = 1e-9; /* of the size of an input */
static const double APART = 0.1; /* s: who tells rates of times so far apart, and what is between by straight lines, is off by their changes */

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

static double value(const LagInputs *inputs, int row, int column)
{
    return column < 0 ? 0 : inputs->values[row * inputs->n + column];
}

/* Of what has no input for its rate: that at which it moves on elsewhere. */
static double first_rate(const LagInputs *inputs, const int *places, int row)
{
    return places[1] < 0 && inputs->rates ? inputs->rates[places[0]] : value(inputs, row, places[1]);
}

/* Before the first row, behind the last one, or of one row: it goes on as the one row says, and is held where there are others. */
static void outer_piece(const LagInputs *inputs, const int *places, int row, double *piece)
{
    const double rate = inputs->rows == 1 ? first_rate(inputs, places, row) : 0;
    const double second = inputs->rows == 1 ? value(inputs, row, places[2]) : 0;
    piece[0] = inputs->times[row];
    piece[1] = value(inputs, row, places[0]);
    piece[2] = isfinite(rate) ? rate : 0;
    piece[3] = isfinite(second) ? second / 2 : 0;
    piece[4] = 0;
}

/* Straight, but where rates are known at both rows. */
static void inner_piece(const LagInputs *inputs, const int *places, double *piece)
{
    const int left = inputs->left;
    const double h = inputs->times[left + 1] - inputs->times[left];
    const double a = value(inputs, left, places[1]), b = value(inputs, left + 1, places[1]);
    const int is_cubic = places[1] >= 0 && isfinite(a) && isfinite(b);
    const double rise = (value(inputs, left + 1, places[0]) - value(inputs, left, places[0])) / h;
    piece[0] = inputs->times[left];
    piece[1] = value(inputs, left, places[0]);
    piece[2] = is_cubic ? a : rise;
    piece[3] = is_cubic ? (3 * rise - 2 * a - b) / h : 0;
    piece[4] = is_cubic ? (a + b - 2 * rise) / (h * h) : 0;
}

static void find_piece(const LagInputs *inputs, const int *places, double *piece)
{
    const int left = inputs->left, last = inputs->rows - 1;
    if (last < 0)
        memset(piece, 0, LAG_PIECE * sizeof *piece);
    else if (left < 0 || left >= last)
        outer_piece(inputs, places, left < 0 ? 0 : last, piece);
    else
        inner_piece(inputs, places, piece);
}

void lag_inputs_read(const LagInputs *inputs, double *d)
{
    for (int k = 0; k < inputs->n_pieces; ++k)
        find_piece(inputs, inputs->pieces + 4 * k, d + inputs->pieces[4 * k + 3]);
}

static double value_of(const double *piece, double t)
{
    const double x = t - piece[0];
    return piece[1] + x * (piece[2] + x * (piece[3] + x * piece[4]));
}

/* How far the rates of both let it be moved in the time between them, as exactly as importers know them. */
static double explained(const double *before, const double *after, double t)
{
    const double h = fabs(t - before[0]), apart = h > APART ? h : APART;
    return h * (fabs(before[2]) + fabs(after[2]) + apart * (fabs(before[3]) + fabs(after[3])));
}

int lag_inputs_jump(const LagInputs *inputs, const double *before, const double *after, double t, int is_new, double *jump)
{
    for (int k = 0; k < inputs->n_pieces; ++k) {
        const int *places = inputs->pieces + 4 * k;
        const double *old = before + places[3], *now = after + places[3], from = value_of(old, t), to = value_of(now, t);
        const double size = fabs(from) + fabs(to) + fabs(old[1]) + explained(old, now, t);
        *jump = to - from;
        if (places[1] >= 0 && fabs(*jump) > ROUNDING * size + (is_new ? explained(old, now, t) : 0))
            return places[0];
    }
    return -1;
}

static double rate_of(const double *piece, double t)
{
    const double x = t - piece[0];
    return piece[2] + x * (2 * piece[3] + x * 3 * piece[4]);
}

void lag_inputs_piece_slopes(const LagInputs *inputs, const double *d, double t, double *slope)
{
    for (int k = 0; k < inputs->n_pieces; ++k)
        slope[inputs->pieces[4 * k]] = rate_of(d + inputs->pieces[4 * k + 3], t);
}

static void set_pieces(const LagInputs *inputs, double t, double *u)
{
    for (int k = 0; k < inputs->n_pieces; ++k) {
        const int *places = inputs->pieces + 4 * k;
        double piece[LAG_PIECE];
        find_piece(inputs, places, piece);
        u[places[0]] = value_of(piece, t);
        if (places[1] >= 0) {
            u[places[1]] = rate_of(piece, t);
            u[places[2]] = 2 * piece[3] + (t - piece[0]) * 6 * piece[4];
        }
    }
}

static void find_values(const LagInputs *inputs, double t, double *u)
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
        slope[i] = is_held ? (inputs->rates ? inputs->rates[i] : 0) : (u0[n] - u0[0]) / (inputs->times[left + 1] - inputs->times[left]);
    }
    for (int k = 0; k < 4 * inputs->n_pieces; ++k) /* nobody reads what pieces say */
        if (k % 4 < 3 && inputs->pieces[k] >= 0)
            slope[inputs->pieces[k]] = 0;
}

void lag_inputs_find(const LagInputs *inputs, double t, double *u)
{
    find_values(inputs, t, u);
    if (inputs->n_pieces > 0)
        set_pieces(inputs, t, u);
    if (inputs->history->n > 0)
        lag_history_at(inputs->history, t, u + inputs->n);
}

double lag_inputs_next(const LagInputs *inputs, double t)
{
    const int next = rows_until(inputs, t);
    return inputs->rows > 1 && next < inputs->rows ? inputs->times[next] : INFINITY;
}
