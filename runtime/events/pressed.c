#include "events/pressed.h"

#include <math.h>

#include "events/candidates.h"
#include "events/impacts.h"
#include "state/state.h"

static const double NONE = 1e-15; /* of the usual force of a contact: none, which a share of is not known */

/* The place of the only contact that presses the friction at place k; -1: none, or several. */
static int find_contact(const LagRun *run, int count, int k)
{
    const LagModel *model = run->model;
    int contact = -1, found = 0;
    for (int j = 0; j < model->n_rubs; ++j)
        if (model->rubs[3 * j] == run->sliding.which[k]) {
            contact = lag_contact(model, model->rubs[3 * j + 1]);
            found += model->rubs[3 * j + 2] ? 1 : 2;
        }
    return found == 1 ? lag_candidates_place(&run->sliding, count, contact) : -1;
}

/* What becomes of N (2 s - 1). */
static double change_of_force(const LagSliding *s, int k, int contact)
{
    return 2 * s->factored[contact] * s->change[k] + (2 * s->factored[k] - 1) * s->change[contact];
}

void lag_pressed_add(const LagRun *run, int count, double times, double *share)
{
    const LagSliding *s = &run->sliding;
    for (int k = 0; k < count; ++k) {
        const int contact = find_contact(run, count, k);
        if (contact < 0)
            continue;
        const double friction = share[contact] * (2 * share[k] - 1) + times * change_of_force(s, k, contact);
        const double presses = share[contact] + times * s->change[contact], none = NONE * s->unit[contact];
        share[k] = (friction / (fabs(presses) < none ? copysign(none, presses) : presses) + 1) / 2;
    }
    for (int k = 0; k < count; ++k)
        if (find_contact(run, count, k) < 0)
            share[k] += times * s->change[k];
}

double lag_pressed_change(const LagRun *run, int count, int k)
{
    const LagSliding *s = &run->sliding;
    const int contact = find_contact(run, count, k);
    return contact < 0 ? fabs(s->change[k]) / s->unit[k] : fabs(change_of_force(s, k, contact)) / (2 * s->unit[contact]);
}

int lag_pressed_is_pulled(const LagRun *run, int count, int k)
{
    const int contact = find_contact(run, count, k);
    return contact >= 0 && *lag_share(run, run->sliding.which[contact]) < 0;
}
