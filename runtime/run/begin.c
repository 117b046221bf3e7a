/* From parameters and guesses to a run that can advance. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "state/account.h"
#include "state/attitudes.h"
#include "events/contacts.h"
#include "events/sampling.h"
#include "state/evaluate.h"
#include "model/function.h"
#include "choice/parts.h"
#include "run/retry.h"
#include "run/run.h"
#include "steps/delays.h"
#include "steps/segment.h"
#include "steps/branch.h"
#include "state/stepper.h"

static int settings_valid(const LagSettings *s)
{
    return isfinite(s->t_start) && s->t_stop >= s->t_start && s->tolerance > 0 && isfinite(s->tolerance) && s->max_step >= 0
        && s->first_step >= 0;
}

/* Inputs at the start, for the equations of start values. */
static void look_at_inputs(LagRun *run)
{
    if (run->model->n_inputs == 0 || run->model->n_initial == 0)
        return;
    lag_inputs_enter(&run->inputs, run->motion.t);
    lag_inputs_at(&run->inputs, run->motion.t, run->u);
    run->assembly.newton.u = run->u;
}

/* They follow from parameters, which many runs may share. */
static void guess_by_parameters(LagRun *run)
{
    const int all = lag_start_size(run->model);
    const double *in[] = {run->p};
    double *out[] = {run->guesses, run->guesses + all};
    if (run->guesses_version != run->parameters_version)
        lag_call(&run->model->start, in, out, run->work);
    run->guesses_version = run->parameters_version;
    memcpy(run->start, run->guesses, 2 * (size_t)all * sizeof *run->start);
}

/* Guesses, and over them what was given, which is kept. */
static void guess(LagRun *run, const double *q_given, const double *v_given)
{
    const int n = run->model->n, lost = run->model->n_lost, all = n + lost;
    const double *given[] = {q_given, v_given};
    lag_retry_begin(run, q_given, v_given);
    guess_by_parameters(run);
    for (int i = 0; i < 2 * all; ++i) {
        const int k = i % all, is_rate = i / all;
        const double value = k >= n ? run->lost[is_rate * lost + k - n] : given[is_rate] ? given[is_rate][k] : NAN;
        if (run->model->n_initial > 0)
            run->fixed[i] = isnan(value) ? run->model->fixed[i] : LAG_START_FIXED;
        if (!isnan(value))
            run->start[i] = value;
    }
    if (run->model->n_attitudes > 0 && q_given)
        lag_attitudes_guess(run, q_given);
    look_at_inputs(run);
}

/* Of what a run was before, that which steps leave in it that are made elsewhere, too. */
static void clear_motion(LagRun *run)
{
    const size_t size = (size_t)run->motion.size * sizeof(double);
    memset(&run->statistics, 0, offsetof(LagStatistics, facts));
    run->statistics.tolerance_raised = run->settings.tolerance < LAG_SMALLEST_TOLERANCE;
    run->motion.t = run->settings.t_start;
    run->motion.evaluations = run->motion.dense_outputs = 0;
    memset(run->motion.y, 0, size);
    memset(run->motion.carry, 0, size);
    lag_scale_reset(&run->scale);
    run->carried_energy = 0;
    run->motion.energy = run->motion.looseness = 0;
    run->wanted = run->settings.t_start;
}

static void clear(LagRun *run)
{
    const LagFacts unknown = {0};
    clear_motion(run);
    run->statistics.facts = unknown;
    run->methods.islands.are_started = 0;
    lag_switches_reset(run);
    /* a run does not depend on what this memory was used for before */
    run->rests = run->troubled = run->careful = run->doubtful = run->plunged = run->plunges = run->sinking = 0;
    run->calm_step = run->refused = run->sunk_from = 0;
    lag_unsure_reset(run);
    lag_branch_forget(run);
    memset(run->risen, 0, (size_t)run->model->n * sizeof *run->risen);
    run->risen_energy = run->blurred_energy = 0;
    run->motion.doubt = run->motion.work_error = 0;
    run->paced = run->settings.t_start;
    run->row_spacing = 0;
    run->paused_before = run->looks.until = -INFINITY;
    run->logged = 0;
    run->scheduled = 0;
}

/* What is held and what is read late: either may be made of the other. Conditions of events are looked at before: those that what is
 * sampled makes true come at the start. */
static LagStatus take_first(LagRun *run)
{
    const double t = run->motion.t, *y = run->motion.y;
    const LagStatus status = lag_delays_begin(run);
    if (status != LAG_OK || run->model->n_held == 0)
        return status;
    lag_switches_look(run, t, y);
    lag_impacts_await_jump(run, t, y);
    if (!lag_sampling_meet(run, t))
        return LAG_OK;
    for (int rank = 0; rank <= lag_sampling_last_rank(run->model); ++rank)
        lag_sampling_take(run, t, y, rank);
    return lag_delays_begin(run);
}

static void choose(LagRun *run)
{
    run->decided = run->methods.first;
    if (run->decided.to == LAG_SOLVER_TRANSITION && !lag_transition_serves(run))
        run->decided = run->methods.behind;
    run->facts = run->decided.facts;
    lag_stepper_choose(run, run->decided.to);
}

static void place_start(LagRun *run)
{
    const size_t n = (size_t)run->model->n;
    memcpy(run->motion.y, run->start, n * sizeof *run->start);
    memcpy(run->motion.y + n, run->start + lag_start_size(run->model), n * sizeof *run->start);
}

LagStatus lag_run_start(LagRun *run, const double *q_given, const double *v_given)
{
    run->started = 0;
    clear(run);
    choose(run);
    if (!settings_valid(&run->settings) || !lag_methods_permit(run->model, run->methods.solver))
        return lag_fail(run, LAG_BAD_SETTINGS, -1, 0, 0);
    guess(run, q_given, v_given);
    if (lag_guards_reset(run) != LAG_OK)
        return run->failure.status;
    if (run->model->n_initial > 0 && !lag_parts.assemble)
        return lag_fail(run, LAG_BAD_SETTINGS, -1, 0, 0);
    const int worst = run->model->n_initial > 0 ? lag_parts.assemble(&run->assembly, run->p, run->fixed, run->start, run->work) : -1;
    if (worst >= 0)
        return lag_fail(run, LAG_INITIAL_FAILED, worst, 0, run->assembly.newton.g[worst]);
    if (run->model->n_initial > 0 && run->model->n_multipliers > 0)
        lag_scale_size(&run->scale, run->assembly.reach);
    place_start(run);
    lag_attitudes_begin(run, q_given);
    lag_scale_note(&run->scale, run->motion.y);
    if (lag_sampling_begin(run) != LAG_OK)
        return run->failure.status;
    lag_segment_enter(run);
    lag_project_present(run);
    if (take_first(run) != LAG_OK)
        return run->failure.status;
    lag_account_start(run);
    lag_stiffness_reset(run);
    LagStatus status = lag_segment_begin(run);
    if (status == LAG_OK)
        status = lag_guards_meet(run, run->motion.t, run->motion.y);
    run->statistics.passed = lag_contacts_find_passed(run);
    run->started = status == LAG_OK;
    return status;
}

int lag_run_starts_again(const LagModel *model)
{
    const int happens = model->n_modes + model->n_events + model->n_switches + model->n_cones + model->n_delays + model->n_guards;
    const int is_tied = model->n_multipliers + model->n_initial + model->n_lost + model->n_attitudes + model->n_islands;
    return happens + is_tied == 0;
}

LagStatus lag_run_start_again(LagRun *run, const double *q_given, const double *v_given)
{
    run->started = 0;
    clear_motion(run);
    guess(run, q_given, v_given);
    place_start(run);
    lag_scale_note(&run->scale, run->motion.y);
    lag_segment_enter(run);
    lag_account_start(run);
    const LagStatus status = lag_segment_evaluate(run);
    run->started = status == LAG_OK;
    return status;
}
