#include "events/accelerations.h"

#include <math.h>
#include <string.h>

#include "events/rest.h"
#include "events/spent.h"
#include "model/function.h"
#include "state/project.h"
#include "numbers/wide.h"
#include "model/wide_tape.h"

static const double MOMENT = 1e-11; /* s beside an event, where whole numbers of inputs are looked at: dynamics/impulses.py */

enum { DOUBTFUL_FOR = 100 }; /* evaluations */

/* Where careful, the slope at a state is the slope at its projection: on the constraints they are the same, so the order is
 * kept, and near a singular position the errors of the inner stages are not magnified. The rates, which are the slope of q,
 * are corrected in place. */
static const double *bring_back(LagRun *run, double t, const double *q, double *v)
{
    const size_t n = (size_t)run->model->n;
    memcpy(run->careful_state, q, n * sizeof *q);
    memcpy(run->careful_state + n, v, n * sizeof *q);
    lag_project_inside(run, t, run->careful_state);
    memcpy(v, run->careful_state + n, n * sizeof *q);
    return run->careful_state;
}

static inline void set_switches(LagRun *run, double t, const double *q, const double *v)
{
    if (run->switches.is_live)
        lag_switches_set(run, t, q, v);
}

static inline int evaluate(LagRun *run, const LagFunction *function, const double *const *in, double *const *out)
{
    if (lag_call(function, in, out, run->work) != 0)
        return 0;
    return lag_all_finite(out[0], run->model->n) && lag_all_finite(out[1], run->model->n_power);
}

/* With the multipliers. */
static inline int whole(LagRun *run, double t, const double *q, const double *v, double *a, double *power)
{
    const double *in[] = {&t, q, v, run->u, run->d, run->c};
    double *out[] = {a, power, run->multipliers};
    lag_inputs_at(&run->inputs, t, run->u);
    set_switches(run, t, q, v);
    return evaluate(run, &run->model->rhs, in, out);
}

/* Where the cheap way failed it is left alone for a while: constraints that repeat each other do so for good. */
static inline int accelerations(LagRun *run, double t, const double *q, const double *v, double *a, double *power)
{
    const LagModel *model = run->model;
    if (!lag_present(&model->regular))
        return whole(run, t, q, v, a, power);
    const double *in[] = {&t, q, v, run->u, run->d, run->c};
    double doubt = 0, *out[] = {a, power, &doubt};
    lag_inputs_at(&run->inputs, t, run->u);
    set_switches(run, t, q, v);
    if (run->doubtful == 0 && evaluate(run, &model->regular, in, out) && doubt == 0)
        return 1;
    run->doubtful = run->doubtful == 0 ? DOUBTFUL_FOR : run->doubtful - 1;
    return whole(run, t, q, v, a, power);
}

typedef int (*Way)(LagRun *run, double t, const double *q, const double *v, double *a, double *power);

/* With the shares of what slides. */
static inline int sliding(LagRun *run, Way way, double t, const double *q, const double *v, double *a, double *power)
{
    for (int tries = 0; way(run, t, q, v, a, power); ++tries) {
        const LagShares shares = run->sliding.count > 0 ? lag_sliding_correct(run, tries, t, q, v, a) : LAG_SHARES_KEPT;
        if (shares == LAG_SHARES_KEPT && (run->sliding.count > 0 || run->switches.calms))
            lag_rest_calm(run, v, a);
        if (shares != LAG_SHARES_CHANGED)
            return shares == LAG_SHARES_KEPT;
        ++run->motion.evaluations;
    }
    if (run->model->shares_bend && run->sliding.count > 0) /* shares went astray, where there are no accelerations */
        lag_switches_recall(run);
    return 0;
}

/* And no more of them than there is, where that is asked for. */
static inline int within_limits(LagRun *run, Way way, double t, const double *q, const double *v, double *a, double *power)
{
    if (!run->sliding.is_limited || run->sliding.count == 0)
        return sliding(run, way, t, q, v, a, power);
    lag_spent_begin(run);
    int is_found = sliding(run, way, t, q, v, a, power);
    while (is_found && lag_spent_reach(run))
        is_found = sliding(run, way, t, q, v, a, power);
    lag_spent_end(run);
    return is_found;
}

int lag_accelerations(void *context, double t, const double *q, double *v, double *a, double *power)
{
    LagRun *run = context;
    return within_limits(run, accelerations, t, run->careful ? bring_back(run, t, q, v) : q, v, a, power);
}

/* Of eight states, the way that serves them. Returns whether out[2] tells where that does not hold; -1: there is no such way. */
static int call_abreast(LagRun *run, const double *const *in, double *const *out, double *work)
{
    const LagModel *model = run->model;
    const int is_whole = lag_present(&model->regular) && run->doubtful > 0;
    const LagWideCode wide = is_whole ? model->wide_whole : model->wide;
    const LagTape *tape = is_whole ? model->rhs.tape : lag_usual_rhs(model)->tape;
    if (!wide && !tape)
        return -1;
    if (wide)
        wide(in, out);
    else
        lag_wide_tape_run(tape, in, LAG_TAPE_SHARED, out, work);
    run->doubtful -= run->doubtful < LAG_ABREAST ? run->doubtful : LAG_ABREAST;
    return wide || (lag_present(&model->regular) && !is_whole);
}

/* Whether the cheap way fails at all of eight states, by the doubt of each. */
static int fails_everywhere(const double *doubt)
{
    int fails = 1;
    for (int i = 0; i < LAG_ABREAST; ++i)
        fails &= doubt[i] != 0;
    return fails;
}

/* The same; where the cheap way fails at all eight, the other one at once, if it serves eight: one state after another would go that
 * way, too. */
static int call_abreast_again(LagRun *run, const double *const *in, double *const *out, double *work)
{
    const int is_checked = call_abreast(run, in, out, work), has_other = !run->model->wide || run->model->wide_whole;
    if (is_checked <= 0 || !has_other || !fails_everywhere(out[2]))
        return is_checked;
    run->doubtful = DOUBTFUL_FOR + 1;
    const int is_checked_now = call_abreast(run, in, out, work);
    if (is_checked_now > 0 && fails_everywhere(out[2])) /* of angles beyond what wide sines bear */
        run->doubtful = 0;
    return is_checked_now;
}

/* Powers lie behind accelerations. */
int lag_accelerations_abreast(LagRun *run, const double *t, const double *q, const double *v, const double *u, double *const *out,
                              double *work)
{
    const LagModel *model = run->model;
    const double *in[] = {t, q, v, u, run->d, run->c};
    const int is_single = run->careful || run->switches.is_live || run->sliding.count > 0 || run->switches.calms;
    const int is_checked = is_single ? -1 : call_abreast_again(run, in, out, work);
    if (is_checked < 0)
        return 0;
    double each[LAG_ABREAST] = {0};
    LagWide sum = LAG_WIDE_OF(0);
    for (int i = 0; i < (is_checked ? LAG_ABREAST : 0); i += LAG_WIDE)
        sum += lag_wide_read(out[2] + i);
    for (int i = 0; i < LAG_ABREAST * (model->n + model->n_power); i += LAG_WIDE)
        sum += 0 * lag_wide_read(out[0] + i);
    lag_wide_write(each, sum);
    return lag_wide_total(each) == 0;
}

/* Accelerations and multipliers are evaluated anew: the latest may be those of another state, or no multipliers. */
int lag_jacobian(LagRun *run, double t, const double *y, LagImplicitMatrix *matrix)
{
    const double *q = y, *v = y + run->model->n;
    const double *in[] = {&t, q, v, run->acceleration, run->multipliers, run->u, run->d, run->c};
    sliding(run, whole, t, q, v, run->acceleration, run->power);
    ++run->motion.evaluations;
    ++run->statistics.jacobians;
    lag_implicit_matrix_evaluate(matrix, run->model, in, run->work);
    return lag_all_finite(matrix->part[0], matrix->entries) && lag_all_finite(matrix->part[1], matrix->entries)
        && lag_all_finite(matrix->part[2], matrix->entries);
}

/* A function of the state and of what follows from it. */
static void report(LagRun *run, const LagFunction *function, int needs_acceleration, double t, const double *y, double *results)
{
    const double *q = y, *v = y + run->model->n;
    const double *in[] = {&t, q, v, run->acceleration, run->multipliers, run->u, run->d, run->c};
    const int is_live = run->switches.is_live;
    lag_inputs_at(&run->inputs, t, run->u);
    if (is_live)
        lag_switches_settle(run, t, y);
    if (needs_acceleration || run->sliding.count > 0) {
        within_limits(run, whole, t, q, v, run->acceleration, run->power);
        ++run->motion.evaluations;
    }
    lag_call(function, in, &results, run->work);
    if (is_live)
        lag_switches_set_free(run, t, y);
}

void lag_outputs(LagRun *run, double t, const double *y, double *outputs)
{
    if (run->model->n_outputs > 0)
        report(run, &run->model->outputs, run->model->outputs_need_acceleration, t, y, outputs);
}

void lag_guards_at(LagRun *run, double t, const double *y, double *found)
{
    report(run, &run->model->guards, run->model->guards_need_acceleration, t, y, found);
}

void lag_outputs_beside(LagRun *run, double t, const double *beside, const double *y, double *outputs)
{
    const double *q = beside, *v = beside + run->model->n;
    const double *in[] = {&t, y, y + run->model->n, run->acceleration, run->multipliers, run->u, run->d, run->c};
    whole(run, t, q, v, run->acceleration, run->power);
    ++run->motion.evaluations;
    lag_call(&run->model->outputs, in, &outputs, run->work);
}

int lag_kick(LagRun *run, double t, double *y)
{
    const LagModel *model = run->model;
    const double *in[] = {&t, y, y + model->n, run->u, run->d, run->c, run->d_before};
    double *dv = run->acceleration;
    int is_kicked = memcmp(run->d, run->d_before, (size_t)model->n_modes * sizeof *run->d) != 0;
    if (!lag_present(&model->kick) || (!is_kicked && t - run->motion.t_old <= MOMENT * (1 + fabs(t))))
        return 0; /* the event before looked past this one: an input that comes to a whole number and turns back there is on none */
    lag_inputs_at(&run->inputs, t, run->u);
    if (lag_call(&model->kick, in, &dv, run->work) != 0 || !lag_all_finite(dv, model->n))
        return 0;
    for (int i = 0; i < model->n; ++i) {
        y[model->n + i] += dv[i];
        is_kicked |= dv[i] != 0; /* by whole numbers of inputs, which no mode tells */
    }
    return is_kicked;
}
