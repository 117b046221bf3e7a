/* Birth, death and particulars of a run. */
#include "run/run.h"

#include <math.h>
#include <stdlib.h>

#include "events/accelerations.h"
#include "events/sampling.h"
#include "state/account.h"
#include "state/evaluate.h"
#include "model/function.h"
#include "choice/parts.h"
#include "steps/delays.h"
#include "steps/singular.h"

static size_t work_size(const LagModel *model)
{
    const LagFunction *functions[] = {&model->parameters, &model->hoist, &model->start, &model->initial, &model->momentum,
                                      &model->events, &model->modes, &model->rhs, &model->outputs, &model->energies,
                                      &model->place, &model->steer, &model->jacobian, &model->tangent, &model->velocity,
                                      &model->force, &model->regular, &model->residual, &model->nearest,
                                      &model->kick, &model->switches, &model->resets, &model->roots, &model->looks,
                                      &model->held_first, &model->samples, &model->lags, &model->delayed, &model->before,
                                      &model->guards, &model->loads, &model->requirements};
    size_t largest = 0;
    for (size_t i = 0; i < sizeof functions / sizeof *functions; ++i)
        largest = functions[i]->n_work > largest ? functions[i]->n_work : largest;
    return largest;
}

static void layout_vectors(LagRun *run, LagArena *arena)
{
    const LagModel *model = run->model;
    const size_t n = (size_t)model->n, events = (size_t)model->n_events, starts = 2 * (size_t)lag_start_size(model);
    run->p = lag_take(arena, (size_t)model->n_parameters);
    run->nothing_given = lag_take(arena, (size_t)model->n_parameters);
    run->c = lag_take(arena, (size_t)model->n_hoisted);
    run->c_kept = lag_take(arena, (size_t)model->n_hoisted);
    run->u = lag_take(arena, LAG_N_U(model));
    run->u_slope = lag_take(arena, LAG_N_U(model) + 1);
    run->d = lag_take(arena, (size_t)(model->n_modes + model->n_switches + model->n_resets + model->n_rests));
    run->d_before = lag_take(arena, (size_t)model->n_modes);
    run->d_given = lag_take(arena, (size_t)model->n_modes);
    run->event_a = lag_take(arena, events);
    run->event_b = lag_take(arena, events);
    lag_sampling_layout(run, arena);
    lag_delays_layout(run, arena);
    lag_retry_layout(&run->retry, model, arena);
    run->acceleration = lag_take(arena, n);
    run->power = lag_take(arena, (size_t)model->n_power);
    run->multipliers = lag_take(arena, (size_t)model->n_multipliers);
    run->start = lag_take(arena, starts);
    run->guesses = lag_take(arena, starts);
    run->lost = lag_take(arena, starts - 2 * n);
    run->inside = lag_take(arena, 2 * n + (size_t)model->n_power);
    run->inside_carry = lag_take(arena, 2 * n);
    run->careful_state = lag_take(arena, 2 * n);
    run->risen = lag_take(arena, n);
    run->fixed = (int *)lag_take(arena, starts);
    run->work = lag_take(arena, work_size(model));
}

static void layout(LagRun *run, LagArena *arena)
{
    const LagModel *model = run->model;
    layout_vectors(run, arena);
    if (lag_parts.assembly_layout)
        lag_parts.assembly_layout(&run->assembly, arena);
    lag_projection_layout(&run->projection, model, arena);
    lag_singular_layout(run, arena);
    lag_scale_layout(&run->scale, arena);
    lag_motion_layout(&run->motion, arena);
    lag_stiffness_layout(&run->stiffness, model->n, run->motion.size, arena);
    lag_switches_layout(&run->switches, model, run->motion.size, arena);
    lag_sliding_layout(&run->sliding, model, run->motion.size, arena);
    lag_impacts_layout(&run->impacts, model, run->motion.size, arena);
    lag_methods_layout(&run->methods, &run->settings, model, &run->motion, arena);
    lag_roots_layout(&run->roots, model, run->motion.size, arena);
    lag_looks_layout(&run->looks, model, run->motion.size, arena);
    lag_unsure_layout(&run->unsure, model, arena);
    lag_guards_layout(&run->guards, model, run->motion.size, arena);
    lag_branch_layout(&run->branch, model, arena);
    lag_orbit_layout(&run->orbit, model, &run->settings, arena);
}

static void connect_parts(LagRun *run, const LagModel *model)
{
    run->model = run->assembly.model = model;
    run->inputs.n = model->n_inputs;
    run->inputs.n_pieces = model->n_pieces;
    run->inputs.pieces = model->pieces;
    run->inputs.history = &run->history;
    run->motion.n = model->n;
    run->motion.size = 2 * model->n + model->n_power;
    run->motion.n_attitudes = model->n_attitudes;
    run->motion.attitudes = model->attitudes;
    run->motion.rhs = lag_accelerations;
    run->motion.flow = lag_flow;
    run->motion.context = run;
    run->choice = (LagChoice){lag_stiffness_reset, lag_stiffness_begin, lag_stiffness_watch, lag_stiffness_trouble};
}

int32_t lag_run_solver(const LagModel *model, const LagSettings *settings, LagDecision *decision)
{
    LagDecision first, behind;
    lag_methods_begin(model, settings, &first, &behind);
    LagRun *run = first.to == LAG_SOLVER_TRANSITION ? lag_run_new(model, settings) : NULL;
    if (run) {
        lag_run_set_parameters(run, NULL, NULL);
        first = lag_transition_serves(run) ? first : behind;
    }
    lag_run_free(run);
    if (decision)
        *decision = first;
    return lag_methods_way(first.to);
}

static double tolerance(const LagSettings *settings) { return fmax(settings->tolerance, LAG_SMALLEST_TOLERANCE); }

LagRun *lag_run_new(const LagModel *model, const LagSettings *settings)
{
    LagRun *run = calloc(1, sizeof *run);
    if (!run)
        return NULL;
    connect_parts(run, model);
    lag_scale_init(&run->scale, model->n, model->coordinate_kind, tolerance(settings));
    run->settings = *settings;
    LagArena arena = {NULL, 0};
    layout(run, &arena);
    run->block = calloc(arena.used + LAG_CACHE_LINE, sizeof *run->memory);
    if (!run->block) {
        lag_run_free(run);
        return NULL;
    }
    run->memory = lag_at_cache_line(run->block);
    run->memory_size = arena.used;
    arena.base = run->memory;
    arena.used = 0;
    layout(run, &arena);
    if (run->methods.first.to == LAG_SOLVER_ISLANDS && lag_methods_permit(model, LAG_SOLVER_ISLANDS)
        && !lag_parts.islands_open(&run->methods.islands, model, settings)) {
        lag_run_free(run);
        return NULL;
    }
    run->motion.t = settings->t_start;
    run->guesses_version = -1; /* none: a run may start without a word about parameters */
    lag_run_set_lost(run, NULL);
    return run;
}

void lag_run_free(LagRun *run)
{
    if (!run)
        return;
    lag_inputs_free(&run->inputs);
    lag_history_free(&run->history);
    if (lag_parts.islands_close)
        lag_parts.islands_close(&run->methods.islands);
    lag_retry_free(&run->retry);
    free(run->block);
    free(run);
}

void lag_run_set_lost(LagRun *run, const double *given)
{
    for (int i = 0; i < 2 * run->model->n_lost; ++i)
        run->lost[i] = given ? given[i] : NAN;
}

/* Events and hoisted values follow from the parameters. */
static void apply_parameters(LagRun *run)
{
    const double *in[] = {run->p, run->d_given};
    double *events[] = {run->event_a, run->event_b};
    lag_call(&run->model->hoist, in, &run->c, run->work);
    lag_call(&run->model->events, in, events, run->work);
    ++run->parameters_version;
}

LagStatus lag_run_set_parameters(LagRun *run, const double *given, const double *mask)
{
    const LagModel *model = run->model;
    if (run->started)
        lag_account_open(run);
    const double *in[] = {given ? given : run->nothing_given, mask ? mask : run->nothing_given};
    lag_call(&model->parameters, in, &run->p, run->work);
    apply_parameters(run);
    if (run->started && lag_delays_change(run))
        return run->failure.status;
    if (run->started) {
        lag_account_close(run);
        run->segment_over = 1;
        lag_project_forget(run);
        lag_retry_forget(run);
    }
    return run->started ? lag_guards_of_parameters(run) : LAG_OK;
}

const double *lag_run_parameters(const LagRun *run) { return run->p; }

/* That is not met, of those only told or of all others. */
static int first_requirement(const LagRun *run, int is_told)
{
    double first[2] = {-1, -1};
    const double *in[] = {run->p};
    double *out[] = {&first[0], &first[1]};
    lag_call(&run->model->requirements, in, out, run->work);
    return (int)first[is_told];
}

int lag_run_parameter_beyond(const LagRun *run, const double *least, const double *most)
{
    for (int i = 0; i < run->model->n_parameters; ++i)
        if (!isfinite(run->p[i]) || run->p[i] < least[i] || run->p[i] > most[i])
            return i;
    return -1;
}

int lag_run_wrong_parameter(const LagRun *run, const double *least, const double *most)
{
    const int beyond = lag_run_parameter_beyond(run, least, most), first = beyond < 0 ? first_requirement(run, 0) : -1;
    return first < 0 ? beyond : run->model->n_parameters + first;
}

int lag_run_told_parameter(const LagRun *run) { return first_requirement(run, 1); }

LagStatus lag_run_set_inputs(LagRun *run, const double *times, const double *values, int rows)
{
    const LagStatus status = lag_inputs_set(&run->inputs, times, values, rows);
    if (status != LAG_OK)
        return lag_fail(run, status, -1, 0, 0);
    if (run->started) {
        lag_inputs_enter(&run->inputs, run->motion.t);
        run->segment_over = 1;
        lag_project_forget(run);
        lag_retry_forget(run);
    }
    return LAG_OK;
}

void lag_run_set_stop(LagRun *run, double t_stop) { run->settings.t_stop = t_stop; }

double lag_run_time(const LagRun *run) { return run->motion.t; }

const LagStatistics *lag_run_statistics(LagRun *run)
{
    run->statistics.rhs_evaluations = run->motion.evaluations;
    run->statistics.dense_outputs = run->motion.dense_outputs;
    const int32_t solver = run->methods.solver;
    run->statistics.solver = lag_methods_way(solver == LAG_SOLVER_ORBIT ? run->orbit.solver : solver);
    const LagDecision *decision = run->stiffness.passes > 0 ? &run->passing : &run->decided;
    run->statistics.rule = decision->rule;
    run->statistics.chosen = lag_methods_way(decision->to);
    run->statistics.facts = decision->facts;
    return &run->statistics;
}

void lag_run_log_events(LagRun *run, double *times, int most)
{
    run->event_log = times;
    run->most_logged = most;
    run->logged = 0;
}

int lag_run_logged(const LagRun *run) { return run->logged; }

const LagFailure *lag_run_failure(const LagRun *run) { return &run->failure; }
