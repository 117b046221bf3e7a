/* A step leads to the next row or event of the whole: every island is asked for its row there, which it may find inside a step
 * of its own. Powers and the work of supports add up; energies and outputs are those of the whole model. */
#include "run/islands.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run/advance.h"
#include "state/project.h"
#include "run/run.h"
#include "steps/step.h"

int lag_islands_open(LagIslands *s, const LagModel *model, const LagSettings *settings)
{
    LagSettings own = *settings;
    own.solver = LAG_SOLVER_AUTO;
    s->runs = calloc((size_t)model->n_islands, sizeof *s->runs);
    if (!s->runs)
        return 0;
    for (s->count = 0; s->count < model->n_islands; ++s->count) {
        s->runs[s->count] = lag_run_new(model->islands[s->count], &own);
        if (!s->runs[s->count])
            return 0;
    }
    return 1;
}

void lag_islands_close(LagIslands *s)
{
    for (int i = 0; i < s->count; ++i)
        lag_run_free(s->runs[i]);
    free(s->runs);
}

static void layout(void *self, const LagMotion *m, LagArena *arena)
{
    LagIslands *s = self;
    const LagModel *model = ((const LagRun *)m->context)->model;
    const size_t n_parameters = (size_t)model->n_parameters, states = 2 * (size_t)m->n;
    s->row = lag_take(arena, (size_t)lag_run_row_width(model));
    s->mask = lag_take(arena, n_parameters);
    s->p = lag_take(arena, n_parameters);
    s->values = lag_take(arena, states);
    s->taken = lag_take(arena, 2 * (size_t)model->n_islands);
    s->now = lag_take(arena, 2 * (size_t)model->n_islands);
}

static void restart(void *self, LagMotion *m)
{
    (void)self;
    (void)m;
}

static void give_parameters(LagIslands *s, const LagRun *run, LagRun *island)
{
    for (int i = 0; i < run->model->n_parameters; ++i)
        s->mask[i] = 1;
    lag_run_set_parameters(island, run->p, s->mask);
}

static LagStatus give_inputs(const LagRun *run, LagRun *island)
{
    const LagInputs *inputs = &run->inputs;
    return inputs->rows > 0 ? lag_run_set_inputs(island, inputs->times, inputs->values, inputs->rows) : LAG_OK;
}

static LagStatus failed(LagRun *run, int k, int first, LagStatus status)
{
    const LagFailure *failure = lag_run_failure(run->methods.islands.runs[k]);
    const int index = failure->index < 0 ? -1 : run->model->island[first + failure->index];
    run->motion.t = fmax(run->motion.t, failure->time);
    return lag_fail(run, status, index, failure->rate, failure->value);
}

/* The natural sizes that were found when the loops were closed. */
static void pass_sizes(LagIslands *s, const LagRun *run, int first, LagRun *island)
{
    for (int i = 0; i < island->model->n; ++i)
        s->values[i] = run->scale.size[run->model->island[first + i]];
    lag_scale_size(&island->scale, s->values);
    lag_scale_note(&island->scale, island->motion.y);
}

static LagStatus start(LagIslands *s, LagRun *run)
{
    const int n = run->model->n;
    for (int k = 0, first = 0; k < s->count; first += s->runs[k++]->model->n) {
        LagRun *island = s->runs[k];
        const int size = island->model->n;
        for (int i = 0; i < size; ++i) {
            s->values[i] = run->motion.y[run->model->island[first + i]];
            s->values[size + i] = run->motion.y[n + run->model->island[first + i]];
        }
        island->settings.t_start = run->motion.t;
        island->settings.t_stop = run->settings.t_stop;
        give_parameters(s, run, island);
        LagStatus status = give_inputs(run, island);
        if (status == LAG_OK)
            status = lag_run_start(island, s->values, s->values + size);
        if (status != LAG_OK)
            return failed(run, k, first, status);
        if (island->model->n_multipliers > 0)
            pass_sizes(s, run, first, island);
    }
    memset(s->taken, 0, 2 * (size_t)s->count * sizeof *s->taken);
    s->events = 0;
    s->are_started = 1;
    return LAG_OK;
}

/* Parameters and inputs that were set since. */
static LagStatus pass_on(LagIslands *s, LagRun *run)
{
    const size_t bytes = (size_t)run->model->n_parameters * sizeof *s->p;
    const int new_parameters = memcmp(s->p, run->p, bytes) != 0, new_inputs = s->inputs_version != run->inputs.version;
    LagStatus status = LAG_OK;
    if (!s->are_started)
        status = start(s, run);
    else if (new_parameters || new_inputs)
        for (int k = 0; k < s->count && status == LAG_OK; ++k) {
            status = lag_run_cut(s->runs[k], run->motion.t); /* those that are ahead come back: their equations change here */
            if (new_parameters)
                give_parameters(s, run, s->runs[k]);
            if (new_inputs && status == LAG_OK)
                status = give_inputs(run, s->runs[k]);
        }
    memcpy(s->p, run->p, bytes);
    s->inputs_version = run->inputs.version;
    return status;
}

/* The state of island k at t, put into its places of motion->other. */
static LagStatus ask(LagIslands *s, LagRun *run, int k, int first, double t)
{
    LagRun *island = s->runs[k];
    const int n = run->model->n, size = island->model->n, *place = run->model->island + first;
    lag_run_set_stop(island, run->settings.t_stop);
    island->deadline = run->deadline;
    island->row_spacing = run->row_spacing; /* by which methods are chosen that dread rows */
    island->retry.stop = run->retry.stop;
    island->retry.limit = run->retry.limit;
    if (run->event_log)
        lag_run_log_events(island, run->event_log + run->logged, run->most_logged - run->logged);
    const LagStatus status = lag_advance_to(island, t, s->row);
    run->logged += island->logged;
    if (status != LAG_OK)
        return status == LAG_PAUSED ? status : failed(run, k, first, status);
    for (int i = 0; i < size; ++i) {
        run->motion.other[place[i]] = s->row[1 + i];
        run->motion.other[n + place[i]] = s->row[1 + size + i];
    }
    const double *quadratures = s->row + lag_run_row_width(island->model) - 2;
    s->now[2 * k] = quadratures[0];
    s->now[2 * k + 1] = quadratures[1];
    return LAG_OK;
}

static void add_quadratures(LagIslands *s, LagMotion *m)
{
    const int first = 2 * m->n;
    for (int i = 0; i < m->size - first; ++i) {
        double sum = m->y[first + i], carry = m->carry[first + i];
        for (int k = 0; k < s->count; ++k) {
            const double whole = s->now[2 * k + i] - s->taken[2 * k + i] + carry, next = sum + whole;
            carry = whole - (next - sum);
            sum = next;
        }
        m->other[first + i] = sum;
        m->other_carry[first + i] = carry;
    }
    memcpy(s->taken, s->now, 2 * (size_t)s->count * sizeof *s->taken);
}

/* The component that last limited the steps of island k, whose coordinates begin at `first` in the list, in the whole. */
static int32_t worst_of(const LagIslands *s, const LagModel *model, int k, int first)
{
    const int32_t worst = s->runs[k]->statistics.worst, size = s->runs[k]->model->n;
    return worst < size ? model->island[first + worst] : model->n + model->island[first + worst - size];
}

static void add(LagStatistics *all, const LagStatistics *one)
{
    all->steps += one->steps;
    all->rejected += one->rejected;
    all->switches += one->switches;
    all->projections += one->projections;
    all->implicit_steps += one->implicit_steps;
    all->jacobians += one->jacobians;
    all->factorisations += one->factorisations;
    all->tolerance_missed += one->tolerance_missed;
    all->smallest_step = fmin(all->smallest_step, one->smallest_step);
    all->largest_step = fmax(all->largest_step, one->largest_step);
    for (int k = 0; k < LAG_SOLVERS; ++k)
        all->steps_by[k] += one->steps_by[k];
}

/* Those of all islands; what limits the steps is what limits those of the busiest. */
static void add_statistics(LagIslands *s, LagRun *run)
{
    LagStatistics *all = &run->statistics;
    int64_t most = -1, events = 0;
    all->steps = all->rejected = all->projections = all->implicit_steps = all->jacobians = all->factorisations = 0;
    all->switches = all->tolerance_missed = 0;
    all->largest_step = 0;
    memset(all->steps_by, 0, sizeof all->steps_by);
    all->smallest_step = INFINITY;
    run->motion.evaluations = run->motion.dense_outputs = 0;
    for (int k = 0, first = 0; k < s->count; first += s->runs[k++]->model->n) {
        const LagStatistics *one = lag_run_statistics(s->runs[k]);
        add(all, one);
        events += one->events - s->runs[k]->scheduled; /* those are events of the whole, too */
        if (one->steps > most)
            all->worst = worst_of(s, run->model, k, first);
        most = one->steps > most ? one->steps : most;
        run->motion.evaluations += one->rhs_evaluations;
        run->motion.dense_outputs += one->dense_outputs;
    }
    all->events += events - s->events;
    s->events = events;
}

static LagStatus step(LagRun *run)
{
    LagIslands *s = run->methods.self;
    LagMotion *m = &run->motion;
    const double t = m->t, t_new = lag_step_aim(run);
    LagStatus status = pass_on(s, run);
    for (int k = 0, first = 0; k < s->count && status == LAG_OK; first += s->runs[k++]->model->n)
        status = ask(s, run, k, first, t_new);
    if (status != LAG_OK)
        return status;
    memset(m->other_carry, 0, (size_t)m->size * sizeof *m->other_carry);
    add_quadratures(s, m);
    lag_motion_take(m, t_new);
    m->t_old = t_new; /* the islands do not go back */
    lag_step_record(run, t_new - t);
    add_statistics(s, run);
    return LAG_OK;
}

static void interpolate(void *self, LagMotion *m, double t, double *y)
{
    (void)self;
    (void)t;
    memcpy(y, m->y, (size_t)m->size * sizeof *y);
}

const LagMethod lag_islands_method = {
    .name = "islands", .order = 8, .layout = layout, .restart = restart, .step = step, .interpolate = interpolate, .stride = 1,
    .is_exact = 1,
};
