#include "run/bare_runs.h"

#include <math.h>
#include <string.h>

#include "events/accelerations.h"
#include "methods/wide_orders.h"
#include "methods/wide_starts.h"
#include "model/function.h"
#include "model/wide_tape.h"
#include "numbers/extremes.h"
#include "run/stepping.h"
#include "state/account.h"
#include "state/state.h"

enum { KINDS = LAG_BARE_ENERGIES };
enum { MANY_STEPS = 16 }; /* from so many on they are as strict at their ends as in between */

/* -------- which runs are such ones */

static int asks_for_ends(const LagBatch *batch)
{
    for (int i = 0; i < batch->sweep.n_reductions; ++i) {
        const LagReduction *what = &batch->sweep.reductions[i];
        if (what->kind != LAG_REDUCE_AT || what->value != batch->sweep.t_stop || what->column > 2 * batch->model->n)
            return 0;
    }
    return 1;
}

/* No rows, or such as begin and end with the run. */
static int keeps_whole_runs(const LagSweep *sweep)
{
    const int rows = sweep->n_rows;
    return rows == 0 || (sweep->row_times[0] == sweep->t_start && sweep->row_times[rows - 1] == sweep->t_stop);
}

int lag_bare_serve(const LagBatch *batch)
{
    const LagModel *model = batch->model;
    const LagSweep *sweep = &batch->sweep;
    const int has_energies = model->wide_energies || model->energies.tape;
    return lag_run_starts_again(model) && !batch->varies_parameters && !lag_account_may_carry(model) && has_energies
        && asks_for_ends(batch) && keeps_whole_runs(sweep) && sweep->seconds == 0 && sweep->t_stop > sweep->t_start;
}

void lag_bare_layout(LagBareRuns *s, const LagModel *model, int size, LagArena *arena)
{
    const size_t states = 2 * (size_t)model->n * LAG_ABREAST;
    double **const inputs[] = {&s->start_u, &s->first_u, &s->last_u, &s->pair_u};
    s->start = lag_take(arena, states);
    s->first = lag_take(arena, states);
    s->last = lag_take(arena, (size_t)size * LAG_ABREAST);
    s->pair = lag_take(arena, states);
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; ++i)
        *inputs[i] = lag_take(arena, (size_t)model->n_inputs * LAG_ABREAST);
    s->work = lag_take(arena, model->energies.n_work * LAG_ABREAST);
    s->row = lag_take(arena, 1 + 2 * (size_t)model->n);
}

/* -------- how they begin */

const double *lag_bare_find_start(const LagBareRuns *s, int64_t i, const LagRun *like)
{
    lag_batch_insert(s->batch, i);
    double *state = s->batch->state;
    for (int k = 0; k < 2 * s->batch->model->n; ++k)
        state[k] = isnan(state[k]) ? like->guesses[k] : state[k];
    return state;
}

/* Column `lane` of numbers that lie in rows of LAG_ABREAST, into column `to`. */
static void move(const double *from, int lane, double *into, int to, int count)
{
    for (int i = 0; i < count; ++i)
        into[i * LAG_ABREAST + to] = from[i * LAG_ABREAST + lane];
}

/* The present inputs of the lane, into column `to`: those that are held, or those of the one segment that is all of the run. */
static void note_inputs(const LagBareRuns *s, int lane, double *into, int to)
{
    const LagWideTaylor *taylor = s->taylor;
    const int n_inputs = s->batch->model->n_inputs;
    if (s->batch->sweep.n_rows > 0) {
        move(taylor->series.line + lag_wide_input(taylor) * LAG_ABREAST, lane, into, to, n_inputs);
        return;
    }
    for (int i = 0; i < n_inputs; ++i)
        into[i * LAG_ABREAST + to] = taylor->first_u[i] + taylor->first_slope[i] * (taylor->lanes.t[lane] - taylor->first_time);
}

/* -------- energies */

/* {T, V, H} of eight states at the times t. */
static void find_energies(LagBareRuns *s, const LagRun *like, const double *t, const double *y, const double *u, double *energies)
{
    const LagModel *model = s->batch->model;
    double doubt[LAG_ABREAST] = {0}, *out[] = {energies, NULL, doubt};
    const double *in[] = {t, y, y + (size_t)model->n * LAG_ABREAST, u, like->d, like->c};
    if (!model->wide_energies) {
        lag_wide_tape_run(model->energies.tape, in, LAG_TAPE_SHARED | LAG_TAPE_ALL_SINES, out, s->work);
        return;
    }
    model->wide_energies(in, out);
    for (int k = 0; k < LAG_ABREAST; ++k)
        if (doubt[k] > 0) /* angles are too large for it */
            energies[k] = energies[LAG_ABREAST + k] = energies[2 * LAG_ABREAST + k] = NAN;
}

void lag_bare_look(LagBareRuns *s, const LagRun *like)
{
    const LagWideSteps *steps = &s->taylor->lanes;
    if (steps->model->n_power == 0)
        return;
    for (int lane = 0; lane < LAG_ABREAST; ++lane)
        note_inputs(s, lane, s->pair_u, lane);
    find_energies(s, like, steps->t, steps->y, s->pair_u, s->energies);
}

/* Errors of quadratures are weighed as by lag_account_unit, with the energies {T, V, H} at the start, or the first that there are. */
static void weigh(LagBareRuns *s, int lane, const double *energies, const LagRun *like)
{
    LagWideSteps *steps = &s->taylor->lanes;
    double *seen = &s->seen[lane];
    for (int k = 0; k < KINDS; ++k)
        *seen = isfinite(energies[k]) ? lag_max(fabs(energies[k]), *seen) : *seen;
    for (int i = 2 * steps->n; i < steps->size; ++i)
        *seen = lag_max(fabs(steps->y[i * LAG_ABREAST + lane]), *seen);
    steps->energy[lane] = *seen > 0 ? 1 / (like->settings.tolerance * *seen) : 0;
}

static void weigh_present(LagBareRuns *s, int lane, const LagRun *like)
{
    double energies[KINDS];
    lag_wide_take(s->energies, lane, energies, KINDS);
    weigh(s, lane, energies, like);
}

/* -------- rows */

/* The present row of run i in the lane, and what else lies there: with what is in force as it comes there. */
static void tell_rows(LagBareRuns *s, int lane, int64_t i, LagRun *run)
{
    const LagSweep *sweep = &s->batch->sweep;
    const LagWideSteps *steps = &s->taylor->lanes;
    const int states = 2 * steps->n, outputs = steps->model->n_outputs, width = 1 + states + outputs + LAG_ACCOUNT_SIZE;
    int next = s->next_row[lane];
    for (double *row = s->batch->rows + (i * sweep->n_rows + next) * width;
         next < sweep->n_rows && sweep->row_times[next] <= steps->t[lane]; ++next, row += width) {
        double *account = row + width - LAG_ACCOUNT_SIZE;
        row[0] = sweep->row_times[next];
        lag_wide_take(steps->y, lane, row + 1, states);
        if (outputs > 0)
            lag_outputs(run, row[0], row + 1, row + 1 + states);
        for (int k = 0; k < LAG_ACCOUNT_SIZE; ++k)
            account[k] = NAN;
    }
    s->next_row[lane] = next;
}

/* The inputs from the latest row to the next. */
static void hold(const LagBareRuns *s, int lane, int64_t i, LagRun *run)
{
    const LagSweep *sweep = &s->batch->sweep;
    const LagModel *model = s->batch->model;
    const int next = s->next_row[lane];
    const double *held = s->batch->held + (i * (sweep->n_rows - 1) + next - 1) * model->n_inputs;
    lag_wide_starts_hold(s->taylor, lane, held, sweep->row_times[next]);
    if (model->n_outputs > 0 && lag_run_hold(run, held) != LAG_OK)
        s->taylor->lanes.stop[lane] = NAN; /* there is no memory: no step gets on, and the run is made alone */
}

void lag_bare_pass(LagBareRuns *s, int lane, int64_t i, LagRun *run)
{
    tell_rows(s, lane, i, run);
    if (s->taylor->lanes.model->n_power > 0 && s->seen[lane] == 0) {
        lag_bare_look(s, run);
        weigh_present(s, lane, run);
    }
    hold(s, lane, i, run);
}

void lag_bare_place(LagBareRuns *s, int lane, int64_t i, LagRun *run)
{
    const LagSweep *sweep = &s->batch->sweep;
    int *next = &s->next_row[lane];
    for (*next = 0; *next < sweep->n_rows && sweep->row_times[*next] <= sweep->t_start;)
        ++*next;
    if (*next > 0)
        hold(s, lane, i, run);
}

void lag_bare_begin(LagBareRuns *s, int lane, int64_t i, LagRun *run)
{
    s->is_bare[lane] = 1;
    s->next_row[lane] = 0;
    tell_rows(s, lane, i, run);
    move(s->taylor->lanes.y, lane, s->start, lane, 2 * s->batch->model->n);
    note_inputs(s, lane, s->start_u, lane);
    s->seen[lane] = 0;
    if (s->batch->model->n_power > 0)
        weigh_present(s, lane, run);
}

/* -------- their accounts */

int lag_bare_closes(LagBareRuns *s, int lane, const LagRun *like)
{
    const LagWideSteps *steps = &s->taylor->lanes;
    double energies[KINDS * LAG_ABREAST], first[KINDS], last[KINDS], given[2] = {0, 0}, t[LAG_ABREAST] = {0};
    t[0] = s->taylor->first_time;
    t[1] = steps->t[lane];
    move(s->start, lane, s->pair, 0, 2 * steps->n);
    move(steps->y, lane, s->pair, 1, 2 * steps->n);
    move(s->start_u, lane, s->pair_u, 0, s->batch->model->n_inputs);
    note_inputs(s, lane, s->pair_u, 1);
    find_energies(s, like, t, s->pair, s->pair_u, energies);
    lag_wide_take(energies, 0, first, KINDS);
    lag_wide_take(energies, 1, last, KINDS);
    lag_wide_take(steps->y + 2 * (size_t)steps->n * LAG_ABREAST, lane, given, steps->size - 2 * steps->n);
    if (steps->model->n_power > 0 && s->seen[lane] == 0)
        weigh(s, lane, last, like);
    return !isnan(lag_account_between(like, first, last, given, steps->steps[lane], 0));
}

void lag_bare_end(LagBareRuns *s, int lane, int64_t i, LagRun *run)
{
    const LagSweep *sweep = &s->batch->sweep;
    const LagWideSteps *steps = &s->taylor->lanes;
    double *results = s->batch->results + i * sweep->n_reductions;
    tell_rows(s, lane, i, run);
    s->is_bare[lane] = 0;
    s->ended[s->count] = i;
    s->steps[s->count] = steps->steps[lane];
    move(s->start, lane, s->first, s->count, 2 * steps->n);
    move(s->start_u, lane, s->first_u, s->count, s->batch->model->n_inputs);
    move(steps->y, lane, s->last, s->count, steps->size);
    note_inputs(s, lane, s->last_u, s->count);
    ++s->count;
    s->row[0] = sweep->t_stop;
    lag_wide_take(steps->y, lane, s->row + 1, 2 * steps->n);
    for (int k = 0; k < sweep->n_reductions; ++k) {
        LagReduced reduced;
        lag_reduce_row(&sweep->reductions[k], &reduced, s->row);
        results[k] = reduced.found;
    }
}

void lag_bare_close(LagBareRuns *s, const LagRun *like, double *misses)
{
    const int size = s->taylor->lanes.size, states = 2 * s->taylor->lanes.n;
    double begin[LAG_ABREAST], end[LAG_ABREAST], before[KINDS * LAG_ABREAST], after[KINDS * LAG_ABREAST];
    for (int k = 0; k < LAG_ABREAST; ++k) {
        begin[k] = s->taylor->first_time;
        end[k] = s->batch->sweep.t_stop;
    }
    find_energies(s, like, begin, s->first, s->first_u, before);
    find_energies(s, like, end, s->last, s->last_u, after);
    for (int k = 0; k < s->count; ++k) {
        double first[KINDS], last[KINDS], given[2] = {0, 0};
        lag_wide_take(before, k, first, KINDS);
        lag_wide_take(after, k, last, KINDS);
        lag_wide_take(s->last + states * LAG_ABREAST, k, given, size - states);
        misses[k] = lag_account_between(like, first, last, given, s->steps[k], s->steps[k] < MANY_STEPS);
    }
    s->count = 0;
}
