#include "methods.h"

#include "function.h"

int32_t lag_methods_first(const LagSettings *settings, const LagModel *model)
{
    const int32_t asked = settings->solver != LAG_SOLVER_AUTO ? settings->solver : model->solver;
    return asked != LAG_SOLVER_AUTO ? asked : LAG_SOLVER_ERK;
}

int lag_methods_permit(const LagModel *model, int32_t solver)
{
    switch (solver) {
    case LAG_SOLVER_ERK: return 1;
    case LAG_SOLVER_LINEAR: return model->linear_pattern != NULL;
    case LAG_SOLVER_IMPLICIT: return lag_present(&model->jacobian) || lag_present(&model->tangent);
    default: return 0;
    }
}

void lag_methods_layout(LagMethods *methods, const LagSettings *settings, const LagModel *model, const LagMotion *motion,
                        LagArena *arena)
{
    const int32_t solver = lag_methods_first(settings, model);
    if (!lag_methods_permit(model, solver))
        return;
    lag_methods_choose(methods, solver);
    methods->table->layout(methods->self, motion, arena);
}

void lag_methods_choose(LagMethods *methods, int32_t solver)
{
    methods->solver = solver;
    switch (solver) {
    case LAG_SOLVER_LINEAR:
        methods->table = &lag_linear_method;
        methods->self = &methods->linear;
        break;
    case LAG_SOLVER_IMPLICIT:
        methods->table = &lag_radau;
        methods->self = &methods->radau;
        break;
    default:
        methods->table = &lag_dop853;
        methods->self = &methods->dop853;
    }
}
