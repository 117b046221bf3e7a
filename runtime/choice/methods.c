#include "choice/methods.h"

#include <string.h>

#include "model/function.h"
#include "steps/orbit.h"

void lag_methods_begin(const LagModel *model, const LagSettings *settings, LagDecision *first, LagDecision *behind)
{
    LagFacts facts = lag_facts(model, settings);
    lag_decide(LAG_BEGIN, facts.asked, &facts, first);
    facts.fits_transition = 0;
    lag_decide(LAG_BEGIN, facts.asked, &facts, behind);
}

int32_t lag_methods_way(int32_t solver) { return solver == LAG_SOLVER_TRANSITION ? LAG_SOLVER_LINEAR : solver; }

int lag_methods_permit(const LagModel *model, int32_t solver)
{
    if (model->n_delays > 0 && solver != LAG_SOLVER_ERK && solver != LAG_SOLVER_ERK5 && solver != LAG_SOLVER_ADAMS
        && solver != LAG_SOLVER_IMPLICIT)
        return 0;
    if (model->n_attitudes > 0 && solver != LAG_SOLVER_ERK && solver != LAG_SOLVER_ERK5 && solver != LAG_SOLVER_ERK9
        && solver != LAG_SOLVER_PIRK && solver != LAG_SOLVER_IMPLICIT && solver != LAG_SOLVER_TAYLOR)
        return 0;
    switch (solver) {
    case LAG_SOLVER_ERK:
    case LAG_SOLVER_ADAMS:
    case LAG_SOLVER_ERK5:
    case LAG_SOLVER_PIRK:
    case LAG_SOLVER_ERK9: return 1;
    case LAG_SOLVER_LINEAR: return lag_parts.linear && model->linear_pattern;
    case LAG_SOLVER_IMPLICIT: return model->jacobian_waits || lag_present(&model->jacobian) || lag_present(&model->tangent);
    case LAG_SOLVER_ISLANDS: return lag_parts.islands && model->n_islands > 1;
    case LAG_SOLVER_CONSERVATIVE: return lag_parts.explicit_conservative && (model->is_separable || lag_present(&model->velocity));
    case LAG_SOLVER_TAYLOR: return model->n_jets > 0;
    case LAG_SOLVER_TRANSITION: return lag_transition_possible(model);
    default: return 0;
    }
}

static int is_explicit(int32_t solver) { return solver == LAG_SOLVER_ERK || solver == LAG_SOLVER_ERK5; }

int lag_methods_turn(const LagSettings *settings)
{
    return settings->solver == LAG_SOLVER_AUTO || settings->solver == LAG_SOLVER_STEPWISE;
}

int lag_methods_alternate(const LagModel *model, int32_t solver)
{
    const int is_long = solver == LAG_SOLVER_TAYLOR || solver == LAG_SOLVER_ERK9 || solver == LAG_SOLVER_PIRK;
    const int is_one = is_explicit(solver) || is_long || solver == LAG_SOLVER_ADAMS || solver == LAG_SOLVER_IMPLICIT;
    return is_one && lag_methods_permit(model, LAG_SOLVER_IMPLICIT);
}

static const int32_t OTHERS[] = {LAG_SOLVER_PIRK, LAG_SOLVER_ERK, LAG_SOLVER_ERK9, LAG_SOLVER_IMPLICIT};
enum { COUNT_OF_OTHERS = sizeof OTHERS / sizeof *OTHERS, OWN = 5 }; /* solvers that a run may need besides */

int lag_methods_may_retry(const LagModel *model, const LagSettings *settings)
{
    return model->n_multipliers > 0 && lag_methods_turn(settings);
}

int32_t lag_methods_refused(const LagModel *model)
{
    int32_t refused = 0;
    for (int i = 0; i < COUNT_OF_OTHERS; ++i)
        refused |= lag_methods_permit(model, OTHERS[i]) ? 0 : 1 << OTHERS[i];
    return refused;
}

static LagStepper conservative(LagMethods *methods)
{
    if (methods->is_separable)
        return (LagStepper){lag_parts.explicit_conservative, &methods->nystrom};
    return (LagStepper){lag_parts.implicit_conservative, &methods->gauss};
}

/* What a number stands for; where it stands for none of them, an explicit method serves. */
static void fill(LagMethods *methods)
{
    const LagStepper explicit_one = {&lag_dop853, &methods->dop853};
    const LagStepper all[LAG_SOLVERS] = {
        [LAG_SOLVER_AUTO] = explicit_one,
        [LAG_SOLVER_STEPWISE] = explicit_one,
        [LAG_SOLVER_ERK] = explicit_one,
        [LAG_SOLVER_LINEAR] = {lag_parts.linear, &methods->linear},
        [LAG_SOLVER_IMPLICIT] = {&lag_radau, &methods->radau},
        [LAG_SOLVER_ISLANDS] = {lag_parts.islands, &methods->islands},
        [LAG_SOLVER_CONSERVATIVE] = conservative(methods),
        [LAG_SOLVER_TAYLOR] = {&lag_taylor, &methods->taylor},
        [LAG_SOLVER_ERK5] = {&lag_tsit5, &methods->tsit5},
        [LAG_SOLVER_ADAMS] = {&lag_adams, &methods->adams},
        [LAG_SOLVER_TRANSITION] = {&lag_transition, &methods->transition},
        [LAG_SOLVER_ORBIT] = {&lag_orbit, NULL},
        [LAG_SOLVER_ERK9] = {&lag_verner9, &methods->verner9},
        [LAG_SOLVER_PIRK] = {&lag_pirk, &methods->pirk},
    };
    memcpy(methods->steppers, all, sizeof all);
}

/* What goes on where the method chosen cannot. */
static int32_t beside(LagFacts facts, int32_t solver)
{
    LagDecision decision;
    lag_decide(LAG_BESIDE, solver, &facts, &decision);
    return decision.to;
}

/* What may go on in steps between which rows are looked at. */
static int32_t stepwise(LagFacts facts)
{
    LagDecision decision;
    facts.asked = LAG_SOLVER_STEPWISE;
    lag_decide(LAG_BEGIN, facts.asked, &facts, &decision);
    return decision.to;
}

void lag_methods_layout(LagMethods *methods, const LagSettings *settings, const LagModel *model, const LagMotion *motion,
                        LagArena *arena)
{
    LagDecision *behind = &methods->behind;
    lag_methods_begin(model, settings, &methods->first, behind);
    const int32_t solver = behind->to;
    if (methods->first.to == LAG_SOLVER_TRANSITION)
        lag_transition.layout(&methods->transition, motion, arena);
    methods->is_separable = model->is_separable;
    fill(methods);
    if (!lag_methods_permit(model, solver))
        return;
    methods->explicit_solver = beside(behind->facts, solver);
    methods->rows_solver = stepwise(behind->facts);
    const int may_turn = lag_methods_turn(settings) && lag_methods_alternate(model, solver);
    const int may_creep = model->n_cones > 0 && lag_methods_permit(model, LAG_SOLVER_IMPLICIT);
    const int leaves = methods->steppers[solver].table->leaves_trouble || solver == LAG_SOLVER_CONSERVATIVE;
    const int needs_other = leaves || lag_methods_alternate(model, solver) || model->n_switches > 0;
    methods->may_find_poles = may_turn && solver == LAG_SOLVER_TAYLOR && settings->solver != LAG_SOLVER_STEPWISE
        && lag_may_find_poles(&behind->facts);
    int32_t asked[OWN + COUNT_OF_OTHERS] = {
        solver, needs_other ? methods->explicit_solver : solver, may_turn || may_creep ? LAG_SOLVER_IMPLICIT : solver,
        may_turn && solver == LAG_SOLVER_PIRK ? methods->rows_solver : solver, methods->may_find_poles ? LAG_SOLVER_PIRK : solver};
    size_t count = OWN;
    for (int i = 0; i < COUNT_OF_OTHERS && lag_methods_may_retry(model, settings); ++i)
        if (lag_methods_permit(model, OTHERS[i]))
            asked[count++] = OTHERS[i];
    for (size_t i = 0; i < count; ++i) {
        int is_new = 1;
        for (size_t j = 0; j < i; ++j)
            is_new = is_new && asked[j] != asked[i];
        const LagStepper stepper = methods->steppers[asked[i]];
        if (is_new)
            stepper.table->layout(stepper.self, motion, arena);
    }
}
