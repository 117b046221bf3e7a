#include "steps/turns.h"

#include <math.h>

#include "events/switches.h"
#include "model/function.h"
#include "state/account.h"
#include "numbers/extremes.h"
#include "state/first_step.h"
#include "state/state.h"
#include "state/stepper.h"

static const double STIFF = 1; /* steps times that rate: they would follow it */
static const double SMALL = 0.25; /* share of a first step of order 1 */
enum { MOST_RELIEF = 1 << 20 };   /* steps */

int lag_turn_evaluate(LagRun *run)
{
    LagMotion *m = &run->motion;
    if (lag_motion_slope(m, m->t, m->y, m->y + m->n, m->slope))
        return 1;
    return lag_switches_release(run) && lag_motion_slope(m, m->t, m->y, m->y + m->n, m->slope);
}

static int restart(LagRun *run, int32_t solver)
{
    LagMotion *m = &run->motion;
    const int weighed = run->methods.table->weighs_work, before = run->methods.solver;
    lag_stepper_choose(run, solver);
    m->t_old = m->t;
    if (!lag_turn_evaluate(run))
        return 0;
    run->methods.table->restart(run->methods.self, m);
    if (run->methods.table->begins_low) {
        const double slowness = lag_slowness(m, &run->scale, run->step, 0);
        run->step = SMALL * fmin(run->step, lag_first_step(&run->scale, slowness, run->methods.table->order));
        run->calm_step = run->model->loops_know_time ? run->calm_step : run->step;
    }
    if (weighed || run->methods.table->weighs_work)
        lag_account_weigh(run);
    const int is_quiet = before == LAG_SOLVER_ERK9 || before == LAG_SOLVER_PIRK || solver == LAG_SOLVER_PIRK;
    const int is_implicit = before == LAG_SOLVER_IMPLICIT || solver == LAG_SOLVER_IMPLICIT;
    run->statistics.switches += is_implicit || !(is_quiet || run->stiffness.leads);
    run->stiffness.looks = 0;
    return 1;
}

int lag_turn(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int32_t next = s->next;
    s->next = LAG_SOLVER_AUTO;
    if (next == LAG_SOLVER_AUTO || next == run->methods.solver)
        return 1;
    if (!restart(run, next))
        return 0;
    s->passes = s->leads = 0;
    if (next == s->explicit_solver) {
        const double largest = (s->rate + sqrt(s->rate * s->rate + 4 * lag_max(s->square, 0))) / 2;
        run->step = largest > 0 ? fmin(run->step, 1 / largest) : run->step;
    }
    run->choice.begin(run);
    return run->sliding.count <= run->methods.table->most_sliding || lag_turn_pass(run);
}

int lag_turn_fall_back(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    if (!s->is_watching || !restart(run, run->choice.trouble(run, LAG_TROUBLE_LEAVE)))
        return 0;
    s->explicit_solver = run->methods.explicit_solver;
    run->choice.begin(run);
    return 1;
}

/* Steps that are left to others: more if the method has not got far since the last ones. */
static int relief(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int64_t steps = run->statistics.steps;
    const int is_soon = steps - s->relieved < LAG_RECOVERED * s->relief;
    s->relief = is_soon ? (s->relief < MOST_RELIEF ? 2 * s->relief : s->relief) : LAG_PASSES;
    s->relieved = steps;
    return s->relief;
}

int lag_turn_creep(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int32_t solver = run->methods.solver;
    const int may_be_implicit = lag_present(&run->model->jacobian) || lag_present(&run->model->tangent);
    if (!(run->sliding.creep * run->step > STIFF) || !may_be_implicit)
        return 1;
    const int32_t passed = s->passes > 0 ? s->passed : solver;
    if (passed != LAG_SOLVER_IMPLICIT)
        s->passes = LAG_PASSES;
    s->passed = passed;
    return solver == LAG_SOLVER_IMPLICIT || restart(run, run->choice.trouble(run, LAG_TROUBLE_CREEPS));
}

int lag_turn_pass(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    const int32_t passed = run->methods.solver;
    const int leaves_trouble = run->methods.table->leaves_trouble;
    if (!restart(run, run->choice.trouble(run, LAG_TROUBLE_PASS)))
        return 0;
    if (run->sliding.count > 0) /* for longer than some steps */
        run->choice.begin(run);
    s->passes = leaves_trouble ? relief(run) : LAG_PASSES;
    s->passed = passed;
    s->is_holding = run->sliding.count > 0 && !leaves_trouble;
    return 1;
}

int lag_turn_release(LagRun *run)
{
    LagStiffness *s = &run->stiffness;
    if (s->passes == 0 || !s->is_holding || run->sliding.count > 0 || run->switches.is_live)
        return 1;
    s->next = s->passed;
    return lag_turn(run);
}
