#include "methods.h"

int32_t lag_methods_first(const LagSettings *settings, const LagModel *model)
{
    const int32_t asked = settings->solver != LAG_SOLVER_AUTO ? settings->solver : model->solver;
    return asked != LAG_SOLVER_AUTO ? asked : LAG_SOLVER_ERK;
}

void lag_methods_layout(LagMethods *methods, const LagSettings *settings, const LagModel *model, const LagMotion *motion,
                        LagArena *arena)
{
    if (lag_methods_first(settings, model) == LAG_SOLVER_ERK)
        lag_dop853.layout(&methods->dop853, motion, arena);
}

void lag_methods_choose(LagMethods *methods, int32_t solver)
{
    methods->solver = solver;
    methods->table = &lag_dop853;
    methods->self = &methods->dop853;
}
