/* Values that were set come into force: where they are, start values from them, and what they change in a run. */
#include <math.h>
#include <string.h>

#include "fmi/instance.h"

#include "model/function.h"
#include "state/evaluate.h"
#include "state/state.h"
#include "steps/segment.h"

int lag_instance_locate(const LagFmu *fmu, unsigned int reference, int *index)
{
    for (int group = 0; group < LAG_GROUPS; ++group) {
        const unsigned int count = (unsigned int)lag_fmu_count(fmu, group);
        if (reference < count) {
            *index = (int)reference;
            return group;
        }
        reference -= count;
    }
    return -1;
}

/* Inputs held at their present values, or going on with their slopes until t + h, or all that is known of them. */
static LagStatus set_inputs(LagInstance *s, double t)
{
    if (s->foreseen.rows > 0)
        return lag_run_set_inputs(s->run, s->foreseen.times, s->foreseen.values, s->foreseen.rows);
    const size_t n = (size_t)s->model->n_inputs;
    s->table[0] = t;
    if (n > 0)
        memcpy(s->table + 1, s->u, n * sizeof *s->u);
    return n > 0 ? lag_run_set_inputs(s->run, s->table, s->table + 1, 1) : LAG_OK;
}

/* Told when it begins. */
static void tell_parameters(LagInstance *s)
{
    const int told = lag_run_told_parameter(s->run);
    if (told >= 0 && told + 1 != s->vital.told_parameter)
        lag_instance_log(s, LAG_ANSWER_WARNING, "logStatusWarning", "%.600s", s->fmu->requirements[told]);
    s->vital.told_parameter = told + 1;
}

static LagAnswer check_parameters(LagInstance *s)
{
    const double *p = lag_run_parameters(s->run);
    const char *const *names = s->fmu->names + lag_fmu_first(s->fmu, LAG_GROUP_PARAMETER);
    const int wrong = lag_run_wrong_parameter(s->run, s->fmu->minimum, s->fmu->maximum), n = s->model->n_parameters;
    if (wrong < 0) {
        tell_parameters(s);
        return LAG_ANSWER_OK;
    }
    if (wrong >= n)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%.600s", s->fmu->requirements[wrong - n]);
    if (!isfinite(p[wrong]))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%.200s has no finite value", names[wrong]);
    return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "%.200s is %g, which is not from %g to %g", names[wrong],
                            p[wrong], s->fmu->minimum[wrong], s->fmu->maximum[wrong]);
}

/* Outputs, energies and state from a row of results. */
void lag_cosimulation_take(LagInstance *s)
{
    const LagModel *m = s->model;
    const size_t states = 2 * (size_t)m->n, outputs = (size_t)m->n_outputs;
    const double *row = s->row, *account = row + 1 + states + outputs;
    const double T = account[0], V = account[1], H = account[2], dissipated = account[3], work = account[4];
    s->vital.t = row[0];
    lag_instance_take_states(s, row + 1, row + 1 + states);
    memcpy(s->outputs, row + 1 + states, outputs * sizeof *row);
    s->energies[LAG_ENERGY_KINETIC] = T;
    s->energies[LAG_ENERGY_POTENTIAL] = V;
    s->energies[LAG_ENERGY_TOTAL] = T + V;
    s->energies[LAG_ENERGY_DISSIPATED] = dissipated;
    s->energies[LAG_ENERGY_WORK] = work + (T + V - H - s->vital.supports_energy);
    s->energies[LAG_ENERGY_RESIDUAL] = H - s->run->start_energy + dissipated - work;
    s->vital.slope_is_current = 0;
    s->vital.outputs_are_current = s->vital.energies_are_current = 1;
}

void lag_cosimulation_take_row(LagInstance *s)
{
    if (lag_run_row(s->run, s->row) == LAG_OK)
        lag_cosimulation_take(s);
}

/* What energies are large is told by nominal rates, where it begins at rest. */
static double nominal_energy(LagInstance *s)
{
    const size_t n = (size_t)s->model->n;
    double energies[3];
    lag_fmu_by_coordinate(s->model, s->fmu->nominal, s->plain);
    memcpy(s->projected, s->run->motion.y, n * sizeof *s->projected);
    memcpy(s->projected + n, s->plain + n, n * sizeof *s->projected);
    lag_energies(s->run, s->vital.t, s->projected, energies);
    return isfinite(energies[0]) ? energies[0] : 0;
}

/* The state that the run has found. */
static void take_start(LagInstance *s)
{
    LagRun *run = s->run;
    LagVital *vital = &s->vital;
    double energies[3];
    vital->has_started = 1;
    vital->parameters_changed = vital->inputs_changed = 0;
    vital->t = run->motion.t;
    lag_instance_tell(s, run->motion.y, s->x);
    lag_energies(run, vital->t, run->motion.y, energies);
    vital->start_energy = energies[2];
    vital->supports_energy = energies[0] + energies[1] - energies[2];
    vital->dissipated = vital->work = 0;
    vital->steps = vital->energy_miss = vital->energy_doubt = 0;
    vital->energy_size = s->model->n > 0 ? nominal_energy(s) : 0;
    vital->is_unaccounted = vital->is_told_open = vital->is_told_jam = vital->knows_inputs = vital->has_jump = 0;
    lag_instance_forget(s);
    if (s->kind == LAG_CO_SIMULATION) {
        lag_cosimulation_take_row(s);
    } else {
        lag_fmu_by_coordinate(s->model, s->fmu->nominal, s->plain);
        lag_scale_note(&run->scale, s->plain); /* what is 0 at the start: projecting tells errors from rounding by size */
        lag_exchange_note(s);
    }
}

LagAnswer lag_instance_begin(LagInstance *s)
{
    LagRun *run = s->run;
    LagVital *vital = &s->vital;
    if (vital->has_started)
        return LAG_ANSWER_OK;
    run->started = 0;
    run->motion.t = vital->start; /* where the inputs begin */
    LagStatus status = lag_run_set_parameters(run, s->given, s->mask);
    if (check_parameters(s) != LAG_ANSWER_OK)
        return LAG_ANSWER_ERROR;
    const double *starts = lag_instance_starts(s);
    if (!starts)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "a quaternion of the length 0 is no attitude");
    if (status == LAG_OK)
        status = set_inputs(s, vital->start);
    if (status == LAG_OK)
        status = lag_run_start(run, starts, starts + s->model->n);
    if (status != LAG_OK) {
        const int mode = vital->mode; /* other values may still be set */
        lag_instance_failed(s, status);
        vital->mode = mode;
        return LAG_ANSWER_ERROR;
    }
    take_start(s);
    return LAG_ANSWER_OK;
}

static double total_energy(LagInstance *s)
{
    double energies[3];
    lag_energies(s->run, s->vital.t, lag_instance_plain(s, s->x), energies);
    return energies[2];
}

/* In Model Exchange the importer moves time and inputs: pieces begin where they are set, and go on from there. Where rates of supports may jump, they come into
 * force with the event's impulses. */
static LagStatus follow_inputs(LagInstance *s)
{
    LagRun *run = s->run;
    const LagModel *m = s->model;
    const int is_event = (s->vital.mode & LAG_MODE_EVENT) != 0, has_kick = lag_present(&m->kick);
    const size_t size = (size_t)m->n_modes * sizeof *run->d;
    double *after = run->d_before, jump = 0;
    if (m->n_pieces == 0)
        return LAG_OK;
    memcpy(after, run->d, size);
    lag_inputs_read(&run->inputs, after);
    const int is_tried = !is_event && run->d[m->pieces[3]] == s->vital.t; /* importers try other values, for derivatives */
    const int jumping = is_tried ? -1 : lag_inputs_jump(&run->inputs, run->d, after, s->vital.t, 1, &jump);
    if (jumping >= 0)
        return lag_fail(run, LAG_INPUT_JUMPS, jumping, 0, jump);
    if (!(is_event && has_kick))
        memcpy(run->d, after, size);
    return LAG_OK;
}

/* In Model Exchange the run only holds what belongs to the parameters and the segment; the state is the importer's. */
static LagStatus settle_exchange(LagInstance *s)
{
    LagRun *run = s->run;
    const int is_event = (s->vital.mode & LAG_MODE_EVENT) != 0, is_back = s->vital.t == s->vital.last_time;
    /* Importers that repeat a step come back to inputs that have not jumped. */
    const int has_jumped = is_back && memcmp(s->u, s->last_u, (size_t)s->model->n_inputs * sizeof *s->u) != 0;
    const int is_jump = is_event || has_jumped || (is_back && s->vital.parameters_changed); /* else it is of the step */
    const double before = total_energy(s);
    LagStatus status = LAG_OK;
    run->motion.t = s->vital.t;
    if (s->vital.parameters_changed) {
        run->started = 0; /* the account is kept here */
        status = lag_run_set_parameters(run, s->given, s->mask);
        run->started = 1;
        lag_segment_enter(run);
    }
    if (status == LAG_OK && s->vital.inputs_changed) {
        run->started = 0;
        status = set_inputs(s, s->vital.t);
        run->started = 1;
        if (status == LAG_OK)
            status = follow_inputs(s);
        if (has_jumped)
            run->sliding.drawn = 0; /* what is held does not jump with them */
        if (has_jumped && !is_event)
            lag_exchange_jump_inputs(s);
        lag_exchange_draw_inputs(s);
        lag_exchange_hold_inputs(s);
    }
    if (is_jump)
        s->vital.work += total_energy(s) - before;
    return status;
}

static LagStatus settle_cosimulation(LagInstance *s)
{
    LagRun *run = s->run;
    LagStatus status = lag_run_cut(run, s->vital.t);
    if (status == LAG_OK && s->vital.parameters_changed)
        status = lag_run_set_parameters(run, s->given, s->mask);
    if (status == LAG_OK && s->vital.inputs_changed)
        status = set_inputs(s, s->vital.t);
    if (status == LAG_OK)
        status = lag_segment_next(run);
    if (status == LAG_OK)
        lag_cosimulation_take_row(s);
    return status;
}

LagAnswer lag_instance_settle(LagInstance *s)
{
    LagVital *vital = &s->vital;
    if (!s->run || (vital->mode & (LAG_MODE_TERMINATED | LAG_MODE_ERROR | LAG_MODE_INTERMEDIATE)))
        return LAG_ANSWER_OK;
    if (!vital->has_started)
        return lag_instance_begin(s);
    if (!vital->parameters_changed && !vital->inputs_changed)
        return LAG_ANSWER_OK;
    const LagStatus status = s->kind == LAG_MODEL_EXCHANGE ? settle_exchange(s) : settle_cosimulation(s);
    if (status != LAG_OK)
        return lag_instance_failed(s, status);
    lag_instance_forget(s);
    vital->outputs_are_current = vital->energies_are_current = s->kind == LAG_CO_SIMULATION;
    if (vital->parameters_changed && check_parameters(s) != LAG_ANSWER_OK)
        return LAG_ANSWER_ERROR;
    vital->parameters_changed = vital->inputs_changed = 0;
    return LAG_ANSWER_OK;
}

LagAnswer lag_instance_enter_initialization(LagInstance *s)
{
    const int steps_alone = s->kind == LAG_CO_SIMULATION;
    const LagSettings settings = {.t_start = s->vital.start, .t_stop = s->vital.has_stop && steps_alone ? s->vital.stop : INFINITY,
                                  .tolerance = s->vital.tolerance,
                                  .solver = steps_alone ? LAG_SOLVER_AUTO : LAG_SOLVER_ERK};
    lag_run_free(s->run);
    s->run = lag_run_new(s->model, &settings);
    memset(s->table, 0, 2 * (1 + (size_t)s->model->n_inputs) * sizeof *s->table);
    /* Room for a table of two rows is taken now. */
    if (!s->run || lag_run_set_inputs(s->run, s->table, s->table + 2, 2) != LAG_OK)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no memory is left");
    s->run->inputs.rates = steps_alone ? NULL : s->rate;
    s->vital.has_started = 0;
    s->vital.mode = LAG_MODE_INITIALIZATION;
    return LAG_ANSWER_OK;
}
