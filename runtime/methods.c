#include "methods.h"

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
    methods->table = solver == LAG_SOLVER_LINEAR ? &lag_linear_method : &lag_dop853;
    methods->self = solver == LAG_SOLVER_LINEAR ? (void *)&methods->linear : (void *)&methods->dop853;
}
