#include "methods.h"

#include "function.h"
#include "parts.h"

/* But for transition matrices. */
static int32_t usual(const LagSettings *settings, const LagModel *model)
{
    const int32_t asked = settings->solver != LAG_SOLVER_AUTO ? settings->solver : model->solver;
    if (asked != LAG_SOLVER_AUTO && asked != LAG_SOLVER_STEPWISE)
        return asked;
    if (lag_taylor_pays(model, settings->tolerance))
        return LAG_SOLVER_TAYLOR;
    if (lag_adams_pays(model))
        return LAG_SOLVER_ADAMS;
    return lag_erk5_pays(model, settings->tolerance) ? LAG_SOLVER_ERK5 : LAG_SOLVER_ERK;
}

int32_t lag_methods_first(const LagSettings *settings, const LagModel *model)
{
    return lag_transition_fits(model, settings) ? LAG_SOLVER_TRANSITION : usual(settings, model);
}

int32_t lag_methods_way(int32_t solver) { return solver == LAG_SOLVER_TRANSITION ? LAG_SOLVER_LINEAR : solver; }

int lag_methods_permit(const LagModel *model, int32_t solver)
{
    switch (solver) {
    case LAG_SOLVER_ERK:
    case LAG_SOLVER_ADAMS:
    case LAG_SOLVER_ERK5: return 1;
    case LAG_SOLVER_LINEAR: return lag_parts.linear && model->linear_pattern;
    case LAG_SOLVER_IMPLICIT: return lag_present(&model->jacobian) || lag_present(&model->tangent);
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
    const int is_one = is_explicit(solver) || solver == LAG_SOLVER_TAYLOR || solver == LAG_SOLVER_ADAMS || solver == LAG_SOLVER_IMPLICIT;
    return is_one && lag_methods_permit(model, LAG_SOLVER_IMPLICIT);
}

void lag_methods_layout(LagMethods *methods, const LagSettings *settings, const LagModel *model, const LagMotion *motion,
                        LagArena *arena)
{
    const int32_t solver = methods->next = usual(settings, model);
    if (lag_methods_first(settings, model) == LAG_SOLVER_TRANSITION)
        lag_transition.layout(&methods->transition, motion, arena);
    if (!lag_methods_permit(model, solver))
        return;
    const int may_turn = lag_methods_turn(settings) && lag_methods_alternate(model, solver);
    if (solver == LAG_SOLVER_LINEAR)
        lag_parts.linear->layout(&methods->linear, motion, arena);
    if (solver == LAG_SOLVER_ISLANDS)
        lag_parts.islands->layout(&methods->islands, motion, arena);
    if (solver == LAG_SOLVER_TAYLOR)
        lag_taylor.layout(&methods->taylor, motion, arena);
    if (solver == LAG_SOLVER_ADAMS)
        lag_adams.layout(&methods->adams, motion, arena);
    if (solver == LAG_SOLVER_CONSERVATIVE && model->is_separable)
        lag_parts.explicit_conservative->layout(&methods->nystrom, motion, arena);
    if (solver == LAG_SOLVER_CONSERVATIVE && !model->is_separable)
        lag_parts.implicit_conservative->layout(&methods->gauss, motion, arena);
    methods->is_separable = model->is_separable;
    methods->explicit_solver = is_explicit(solver) ? solver : LAG_SOLVER_ERK;
    if (solver == LAG_SOLVER_ERK5)
        lag_tsit5.layout(&methods->tsit5, motion, arena);
    else if (solver == LAG_SOLVER_ERK || solver == LAG_SOLVER_ADAMS || solver == LAG_SOLVER_CONSERVATIVE || lag_methods_alternate(model, solver)
             || model->n_switches > 0)
        lag_dop853.layout(&methods->dop853, motion, arena);
    if (solver == LAG_SOLVER_IMPLICIT || may_turn)
        lag_radau.layout(&methods->radau, motion, arena);
}

static void use(LagMethods *methods, const LagMethod *table, void *self)
{
    methods->table = table;
    methods->self = self;
}

static void use_conservative(LagMethods *methods)
{
    if (methods->is_separable)
        use(methods, lag_parts.explicit_conservative, &methods->nystrom);
    else
        use(methods, lag_parts.implicit_conservative, &methods->gauss);
}

void lag_methods_choose(LagMethods *methods, int32_t solver)
{
    methods->solver = solver;
    switch (solver) {
    case LAG_SOLVER_LINEAR: use(methods, lag_parts.linear, &methods->linear); break;
    case LAG_SOLVER_TRANSITION: use(methods, &lag_transition, &methods->transition); break;
    case LAG_SOLVER_IMPLICIT: use(methods, &lag_radau, &methods->radau); break;
    case LAG_SOLVER_ISLANDS: use(methods, lag_parts.islands, &methods->islands); break;
    case LAG_SOLVER_CONSERVATIVE: use_conservative(methods); break;
    case LAG_SOLVER_TAYLOR: use(methods, &lag_taylor, &methods->taylor); break;
    case LAG_SOLVER_ADAMS: use(methods, &lag_adams, &methods->adams); break;
    case LAG_SOLVER_ERK5: use(methods, &lag_tsit5, &methods->tsit5); break;
    default: use(methods, &lag_dop853, &methods->dop853);
    }
}
