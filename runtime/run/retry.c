#include "run/retry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "choice/methods.h"
#include "run/run.h"
#include "state/account.h"
#include "state/inside.h"
#include "steps/step.h"
#include "steps/turns.h"

/* From nothing as yet, from the start, from what is kept; no more. */
enum { NOWHERE, START, KEPT, NEVER };
enum { STEPS = 256, MANY = 8 }; /* from one state that is kept to the next; times as many are too many for another choice */
enum { ROUNDS = 4, AT_ALL = 8 * MANY * STEPS }; /* and steps by other choices beyond as many as the run's own */
static const double SHORTER = 0.77, SHORT = 0.5; /* of the step before; of those since, on average: too near to trouble */
static const double SINGULAR = 1e-4; /* of singular values: where ways of moving meet */

void lag_retry_layout(LagRetry *retry, const LagModel *model, LagArena *arena)
{
    retry->given = lag_take(arena, 2 * (size_t)model->n);
    retry->told = lag_take(arena, (size_t)model->n_guards);
    retry->is_news = lag_take_ints(arena, (size_t)model->n_guards);
}

void lag_retry_free(LagRetry *retry) { free(retry->kept); }

static int bit(int32_t solver) { return 1 << solver; }

/* -------- what is kept */

/* What swings are read from stands last, and is not kept: it begins anew. */
static size_t vectors(const LagRun *run) { return (size_t)(run->orbit.begin - run->memory); }

static void keep(LagRun *run)
{
    LagRetry *s = &run->retry;
    const size_t bytes = vectors(run) * sizeof(double), past = lag_history_size(&run->history) * sizeof(double);
    const size_t size = sizeof *run + bytes + past;
    if (size > s->room) {
        unsigned char *more = realloc(s->kept, size);
        if (!more) {
            s->from = NEVER;
            return;
        }
        s->kept = more;
        s->room = size;
    }
    s->from = KEPT;
    s->steps = run->statistics.steps;
    s->t = run->motion.t;
    s->tried = bit(run->methods.solver);
    s->chosen = LAG_SOLVER_AUTO;
    s->round = 0;
    memcpy(s->kept, run, sizeof *run);
    memcpy(s->kept + sizeof *run, run->memory, bytes);
    lag_history_save(&run->history, s->kept + sizeof *run + bytes);
}

/* What has been told since stays told. */
static void keep_told(LagRun *run)
{
    const size_t guards = (size_t)run->model->n_guards;
    unsigned char *memory = run->retry.kept + sizeof *run;
    const unsigned char *own = (const unsigned char *)run->memory;
    memcpy(memory + ((const unsigned char *)run->guards.told - own), run->guards.told, guards * sizeof *run->guards.told);
    memcpy(memory + ((const unsigned char *)run->guards.is_news - own), run->guards.is_news, guards * sizeof *run->guards.is_news);
}

/* But for what its driver asks of it, the run is as it was. */
static LagStatus put_back(LagRun *run)
{
    const LagRetry *s = &run->retry;
    const size_t bytes = vectors(run) * sizeof(double);
    LagRun past;
    keep_told(run);
    memcpy(&past, s->kept, sizeof past);
    if (!lag_history_load(&run->history, &past.history, s->kept + sizeof past + bytes))
        return lag_fail(run, LAG_OUT_OF_MEMORY, -1, 0, 0);
    past.retry = *s;
    past.settings = run->settings;
    past.deadline = run->deadline;
    past.ticks = run->ticks;
    past.wanted = run->wanted;
    past.row_spacing = run->row_spacing;
    past.logged = past.event_log == run->event_log ? past.logged : 0;
    past.event_log = run->event_log;
    past.most_logged = run->most_logged;
    past.history.pieces = run->history.pieces;
    past.history.marks = run->history.marks;
    past.history.first = run->history.first;
    past.history.capacity = run->history.capacity;
    past.history.mark_capacity = run->history.mark_capacity;
    *run = past;
    memcpy(run->memory, s->kept + sizeof past, bytes);
    return LAG_OK;
}

/* What has been told since stays told here, too, whether the choice that follows comes to it or not. */
static LagStatus start_again(LagRun *run)
{
    const LagRetry before = run->retry;
    const double wanted = run->wanted, spacing = run->row_spacing;
    const size_t guards = (size_t)run->model->n_guards;
    memcpy(before.told, run->guards.told, guards * sizeof *before.told);
    memcpy(before.is_news, run->guards.is_news, guards * sizeof *before.is_news);
    const LagStatus status = lag_run_start(run, before.has_q ? before.given : NULL, before.has_v ? before.given + run->model->n : NULL);
    run->retry = before;
    memcpy(run->guards.told, before.told, guards * sizeof *before.told);
    memcpy(run->guards.is_news, before.is_news, guards * sizeof *before.is_news);
    run->wanted = wanted;
    run->row_spacing = spacing;
    return status;
}

static LagStatus go_back(LagRun *run) { return run->retry.from == START ? start_again(run) : put_back(run); }

/* -------- when */

static int is_of_steps(int32_t solver)
{
    return solver == LAG_SOLVER_ERK || solver == LAG_SOLVER_ERK5 || solver == LAG_SOLVER_ERK9 || solver == LAG_SOLVER_PIRK
        || solver == LAG_SOLVER_ADAMS || solver == LAG_SOLVER_TAYLOR || solver == LAG_SOLVER_IMPLICIT;
}

static int may_choose(const LagRun *run)
{
    return lag_methods_may_retry(run->model, &run->settings) && is_of_steps(run->methods.solver);
}

void lag_retry_begin(LagRun *run, const double *q_given, const double *v_given)
{
    LagRetry *s = &run->retry;
    const size_t n = (size_t)run->model->n;
    s->from = may_choose(run) ? START : NEVER;
    s->steps = 0;
    s->t = run->motion.t;
    s->tried = bit(run->methods.solver);
    s->chosen = LAG_SOLVER_AUTO;
    s->round = 0;
    s->spent = 0;
    s->has_q = q_given != NULL;
    s->has_v = v_given != NULL;
    if (s->from == START && s->has_q)
        memmove(s->given, q_given, n * sizeof *s->given);
    if (s->from == START && s->has_v)
        memmove(s->given + n, v_given, n * sizeof *s->given);
}

void lag_retry_forget(LagRun *run)
{
    run->retry.from = run->retry.from == NEVER ? NEVER : NOWHERE;
    run->retry.steps = run->statistics.steps;
    run->retry.t = run->motion.t;
}

/* Where nothing is kept, as inputs have changed, the first step that was rejected is early enough. */
static int is_time_to_keep(const LagRun *run)
{
    const LagRetry *s = &run->retry;
    const int64_t steps = run->statistics.steps - s->steps;
    const int is_calm = run->troubled == 0 && run->step * (double)steps > SHORT * (run->motion.t - s->t);
    return s->from == NOWHERE ? steps >= STEPS || run->troubled > 0 : s->from != NEVER && steps >= STEPS && is_calm;
}

/* -------- steps */

/* What may turn out to have ended the run in this step is waited for from there on: a later step ends it where that was, and no row
 * comes in between. */
static void wait_for_guards(LagRun *run)
{
    const double t = lag_guards_pending(run);
    if (!(t < run->motion.t))
        return;
    lag_go_back(run, t);
    run->segment_over = 1;
    lag_switches_forget(run);
    lag_guards_forget(run, t);
}

static LagStatus step(LagRun *run)
{
    const LagStatus status = lag_step(run);
    const int turned = run->branch.turned;
    const int is_lost = status == LAG_OK && turned >= 0 && lag_unsure_is_singular(run, SINGULAR);
    if (is_lost)
        return lag_fail(run, LAG_TURNED_OFF, turned, 1, 0);
    if (status == LAG_OK) {
        lag_guards_watch(run);
        wait_for_guards(run);
    }
    return status;
}

/* All that comes is for `solver`; nothing else takes turns with it until it has passed. */
static int turn_to(LagRun *run, int32_t solver)
{
    LagStiffness *stiffness = &run->stiffness;
    run->orbit.is_open = 0;
    if (solver == LAG_SOLVER_AUTO)
        return 1;
    stiffness->next = solver;
    stiffness->explicit_solver = solver == LAG_SOLVER_IMPLICIT ? stiffness->explicit_solver : solver;
    stiffness->passes = 0;
    stiffness->is_watching = 0;
    const int turns = lag_turn(run);
    run->step *= pow(SHORTER, run->retry.round);
    return turns;
}

static int is_over(const LagRetry *s) { return (s->stop && *s->stop) || (s->limit > 0 && lag_clock() > s->limit); }

static LagStatus go(LagRun *run, int32_t solver, double goal, int64_t steps)
{
    LagStatus status = go_back(run);
    const int is_watching = run->stiffness.is_watching;
    const int64_t first = run->statistics.steps, most = first + steps;
    if (status == LAG_OK && !turn_to(run, solver))
        status = lag_fail(run, LAG_NOT_FINITE, -1, 0, 0);
    while (status == LAG_OK && run->motion.t < goal && !run->guards.broken)
        status = is_over(&run->retry) ? LAG_PAUSED : run->statistics.steps < most ? step(run) : lag_step_give_up(run, run->statistics.worst);
    run->stiffness.is_watching = is_watching;
    run->retry.spent += run->statistics.steps - first;
    return status;
}

/* The next choice; after all of them, each again in steps of another length. */
static int next(LagRun *run, LagDecision *decision)
{
    LagRetry *s = &run->retry;
    while (!lag_stiffness_retry(run, s->tried, decision)) {
        if (++s->round == ROUNDS)
            return 0;
        s->tried = 0;
    }
    s->tried |= bit(decision->to);
    return 1;
}

LagStatus lag_retry(LagRun *run, double goal)
{
    LagRetry *s = &run->retry;
    const LagFailure failure = run->failure;
    const int32_t before = s->chosen;
    const int64_t own = run->statistics.steps;
    for (LagDecision decision; s->spent < own + AT_ALL && !is_over(s) && next(run, &decision);) {
        const int passes = go(run, decision.to, goal, MANY * STEPS) == LAG_OK && !lag_account_misses(run);
        run->decided = decision;
        s->chosen = decision.to;
        if (passes)
            return LAG_OK;
    }
    const LagStatus status = is_over(s) ? LAG_PAUSED : go(run, before, goal, own + MANY * STEPS);
    if (status != LAG_OUT_OF_MEMORY && failure.status != LAG_OK)
        run->failure = failure;
    s->from = NEVER;
    return status;
}

static int may_retry(const LagRun *run) { return run->retry.from == START || run->retry.from == KEPT; }

/* Before a step: renews what is kept, or goes back to it if the account has come to miss since. */
static LagStatus look(LagRun *run)
{
    if (!is_time_to_keep(run))
        return LAG_OK;
    const int misses = lag_account_misses(run);
    if (!misses)
        keep(run);
    else if (may_retry(run))
        return lag_retry(run, run->motion.t);
    else
        run->retry.from = NEVER;
    return LAG_OK;
}

LagStatus lag_retry_step(LagRun *run)
{
    LagStatus status = look(run);
    const double begin = run->motion.t;
    if (status == LAG_OK)
        status = step(run);
    const int gives_up = status == LAG_STEP_TOO_SMALL || status == LAG_TURNED_OFF;
    return gives_up && may_retry(run) ? lag_retry(run, nextafter(begin, INFINITY)) : status;
}

int lag_retry_is_due(const LagRun *run, LagStatus status, int was_open)
{
    const int is_open = status == LAG_OK && run->statistics.energy_is_open && !was_open;
    return (status == LAG_CONSTRAINTS_OPEN || is_open) && may_retry(run);
}
