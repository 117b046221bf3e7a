#include "state/inside.h"

#include <string.h>

#include "state/holds.h"
#include "state/project.h"
#include "state/state.h"

void lag_state_inside(LagRun *run, double t, double *y)
{
    if (t == run->motion.t || run->rests) {
        memcpy(y, run->motion.y, (size_t)run->motion.size * sizeof *y);
    } else {
        run->careful = run->model->n_multipliers > 0; /* the stages of the dense output may lie near a singular position */
        run->methods.table->interpolate(run->methods.self, &run->motion, t, y);
        run->careful = 0;
        run->stiffness.looks += LAG_LOOK;
    }
}

void lag_held_state_inside(LagRun *run, double t, double *y)
{
    lag_state_inside(run, t, y);
    lag_holds_inside(run, t, y);
}

void lag_go_back(LagRun *run, double t)
{
    LagMotion *motion = &run->motion;
    lag_held_state_inside(run, t, run->inside);
    lag_project_inside(run, t, run->inside);
    memcpy(motion->y, run->inside, (size_t)motion->size * sizeof *motion->y);
    memset(motion->carry, 0, (size_t)motion->size * sizeof *motion->carry);
    motion->t = t;
    lag_project_forget(run);
}
