#include "state/stepper.h"

#include "state/state.h"

LagStepper lag_stepper_of(const LagRun *run, int32_t solver)
{
    const int is_known = solver >= 0 && solver < LAG_SOLVERS; /* settings may hold any number, until they are looked at */
    return run->methods.steppers[is_known ? solver : LAG_SOLVER_ERK];
}

void lag_stepper_choose(LagRun *run, int32_t solver)
{
    const LagStepper stepper = lag_stepper_of(run, solver);
    run->methods.solver = solver;
    run->methods.table = stepper.table;
    run->methods.self = stepper.self;
}

void lag_stepper_lead(LagRun *run)
{
    run->stiffness.leads = run->stiffness.passes = 1;
    run->stiffness.passed = run->methods.solver;
    lag_stepper_choose(run, run->choice.trouble(run, LAG_TROUBLE_LEAD));
}
