/* An instance of an FMU, whatever the version of the standard: fmi2.c and fmi3.c translate.
 *
 * An instance holds all that it needs; instances share nothing that changes, and may live in threads of their own. Memory is
 * taken when an instance is made, initialised or saved, never while it steps.
 */
#ifndef LAG_INSTANCE_H
#define LAG_INSTANCE_H

#include "numbers/dense_lu.h"
#include "fmi/fmu.h"
#include "run/run.h"

/* The numbers of fmi2Status and fmi3Status. */
typedef enum { LAG_ANSWER_OK, LAG_ANSWER_WARNING, LAG_ANSWER_DISCARD, LAG_ANSWER_ERROR, LAG_ANSWER_FATAL } LagAnswer;

typedef enum { LAG_MODEL_EXCHANGE, LAG_CO_SIMULATION } LagFmuKind;

/* Where an instance is in its life: one bit each, so that sets of them can be written. */
enum {
    LAG_MODE_INSTANTIATED = 1,
    LAG_MODE_CONFIGURATION = 2,
    LAG_MODE_INITIALIZATION = 4,
    LAG_MODE_EVENT = 8,
    LAG_MODE_CONTINUOUS = 16,
    LAG_MODE_STEP = 32,
    LAG_MODE_INTERMEDIATE = 64,
    LAG_MODE_TERMINATED = 128,
    LAG_MODE_ERROR = 256
};

typedef enum {
    LAG_CALL_LOGGING, LAG_CALL_SETUP, LAG_CALL_ENTER_INITIALIZATION, LAG_CALL_EXIT_INITIALIZATION, LAG_CALL_ENTER_EVENT,
    LAG_CALL_UPDATE_DISCRETE, LAG_CALL_ENTER_CONTINUOUS, LAG_CALL_ENTER_STEP, LAG_CALL_ENTER_CONFIGURATION,
    LAG_CALL_EXIT_CONFIGURATION, LAG_CALL_TERMINATE, LAG_CALL_RESET, LAG_CALL_GET, LAG_CALL_SET, LAG_CALL_SAVE, LAG_CALL_DERIVE,
    LAG_CALL_SET_CONTINUOUS, LAG_CALL_GET_CONTINUOUS, LAG_CALL_NOMINALS, LAG_CALL_COUNTS, LAG_CALL_COMPLETED_STEP,
    LAG_CALL_INPUT_SLOPES, LAG_CALL_OUTPUT_SLOPES, LAG_CALL_DO_STEP, LAG_CALL_STATUS,
    LAG_CALLS
} LagCall;

typedef struct LagInstance LagInstance;
typedef struct LagSaved LagSaved;

typedef void (*LagLogger)(const LagInstance *instance, LagAnswer answer, const char *category, const char *message);

/* After an internal step. Returns 1 to end the communication step at `*time` or soon after it. */
typedef int (*LagIntermediate)(LagInstance *instance, double t, double *time);

/* Everything of an instance that is saved with its state and holds no address. */
typedef struct {
    int mode;
    int has_started;        /* the run has start values for what was set so far */
    int parameters_changed, inputs_changed;
    int has_slopes;         /* inputs are interpolated */
    int slope_is_current, outputs_are_current, energies_are_current;
    int has_stop;
    int is_over;            /* a guard has ended the simulation, as it was meant to */
    int is_told_jam;        /* that friction jams */
    int is_told_open;       /* that the energy account does not close */
    int told_parameter;     /* one more than the place of what is told of parameters; 0: nothing */
    double t, start, stop, tolerance;
    double start_energy, supports_energy; /* H, and T + V - H, at the start */
    double dissipated, work, last_time;   /* Model Exchange: the energy account up to the last completed step */
    double earlier_time;    /* of the step before that */
    int knows_inputs;       /* at the last one */
    int has_jump;           /* of inputs, there */
    int is_unaccounted;     /* there is a step of which it is not known, or an input with rates has changed within one */
    double steps, energy_size, energy_miss; /* completed; the largest of its entries, and of what it misses */
    double energy_doubt;    /* J: what inputs may have done otherwise than is known between completed steps */
} LagVital;

/* Inputs over all time, linear between rows: of a page, which needs not wait for what its importer sets. */
typedef struct {
    int rows; /* 0: they are set as time goes on */
    const double *times, *values; /* rows; rows x n_inputs */
} LagForeseen;

struct LagInstance {
    const LagFmu *fmu;
    void *fmu_memory;        /* opening.h */
    const LagModel *model;
    const int *extents;      /* of the FMU; NULL: all variables are scalars */
    LagRun *run;             /* from initialization on */
    LagFmuKind kind;
    LagVital vital;
    int is_logging, uses_events, may_return_early;
    LagLogger logger;
    LagIntermediate intermediate;
    void *wrapper;           /* what the version of the standard keeps around it */
    char *name;
    LagSaved *states;        /* those that were saved and not freed */
    LagForeseen foreseen;

    double *memory;          /* all vectors below up to `scratch` */
    size_t saved_size;       /* so many of them are part of the state */
    double *given;           /* n_parameters */
    double *start;           /* states: start values given, NaN where none is */
    double *u, *u_slope;     /* n_inputs; slopes of the last step, or given for the next one */
    double *x, *slope;       /* states, as importers have them: states.c */
    double *outputs, *energies;
    double *power;           /* n_power */
    double *last, *last_slope, *last_power; /* at the last completed step */
    double *last_u, *last_rate, *earlier_u, *rate; /* n_inputs: there, and at the one before; rates now: exchange_steps.c */
    double *before_jump;     /* 3 n_inputs: the first three of these */
    double *least_u, *most_u; /* n_inputs: of those that were set since the last completed step */
    double *slack;           /* n_whens: of conditions of events, near their places: exchange.c */
    double *scratch, *projected; /* not saved */
    double *plain, *told;    /* 2 n, states: the same state as the run has it, and as importers have it */
    double *indicators, *switches; /* n_switches; 2 n_switches: what is held, lag_switches_keep */
    double *modes;                 /* n_modes, likewise */
    double *row, *mask, *table, *directions, *work;
    LagDenseLu held;         /* how the rates of what is held depend on its shares */
    double *held_rates;      /* as many as can be held */
};

/* What an importer says of an instance: the token shows that it has read the description of this very FMU. */
typedef struct {
    LagFmuKind kind;
    const char *name, *token, *resources;
    int is_logging;
    int has_arrays; /* as FMI 3 */
} LagBirth;

/* NULL when there is no memory, or what was said is wrong, which is logged. */
LagInstance *lag_instance_new(const LagBirth *birth, LagLogger logger, void *wrapper);
void lag_instance_free(LagInstance *instance);

/* 1 when the call is allowed now; else it is logged. NULL is no instance. */
int lag_instance_allows(LagInstance *instance, LagCall call, const char *function);
LagAnswer lag_instance_log(const LagInstance *instance, LagAnswer answer, const char *category, const char *format, ...);
#define LAG_ERROR_CATEGORY "logStatusError"

LagAnswer lag_instance_setup(LagInstance *instance, int has_tolerance, double tolerance, double start, int has_stop, double stop);
LagAnswer lag_instance_enter_initialization(LagInstance *instance);
LagAnswer lag_instance_exit_initialization(LagInstance *instance);
LagAnswer lag_instance_reset(LagInstance *instance);

/* Group of a value reference and its place there; -1: there is none. */
int lag_instance_locate(const LagFmu *fmu, unsigned int reference, int *index);
int lag_fmu_count(const LagFmu *fmu, int group);
/* The value reference of the first of a group. */
int lag_fmu_first(const LagFmu *fmu, int group);

/* Constants and discrete variables that are whole (LAG_GROUP_INTEGER) or true or false (_BOOLEAN), which have no arrays. */
LagAnswer lag_instance_get_whole(LagInstance *instance, int group, const unsigned int *references, size_t count, double *values);
LagAnswer lag_instance_get_strings(LagInstance *instance, const unsigned int *references, size_t count, const char **values);
LagAnswer lag_instance_get(LagInstance *instance, const unsigned int *references, size_t count, double *values, size_t size);
LagAnswer lag_instance_set(LagInstance *instance, const unsigned int *references, size_t count, const double *values, size_t size);
/* How many numbers a value reference stands for; 0: there is no such variable. */
size_t lag_instance_extent(const LagInstance *instance, unsigned int reference);
/* Whether references stand for `size` numbers in all; else it is logged. */
LagAnswer lag_instance_fits(const LagInstance *instance, const unsigned int *references, size_t count, size_t size, const char *what);
LagAnswer lag_instance_no_set(LagInstance *instance, size_t count, const char *type);

/* Start values from all that was set; does nothing when that is done. */
LagAnswer lag_instance_begin(LagInstance *instance);
/* Parameters and inputs that were set come into force. */
LagAnswer lag_instance_settle(LagInstance *instance);
/* The state or the time changed: what follows from them is worked out anew. */
void lag_instance_forget(LagInstance *instance);
LagAnswer lag_instance_slope(LagInstance *instance);

/* States (states.c): positions, where the three coordinates of an attitude are a unit quaternion, then rates. */
int lag_fmu_positions(const LagModel *model);
int lag_fmu_states(const LagModel *model);
/* Where the k-th position or rate of the run (0 .. 2 n - 1) is among them: of an attitude the first three parts. */
int lag_fmu_place(const LagModel *model, int k);
/* Outputs, without the quaternions that are states: these come first among the run's. */
int lag_fmu_outputs(const LagModel *model);
/* Values by place among the run's positions and rates. */
void lag_fmu_by_coordinate(const LagModel *model, const double *states, double *values);
/* The state as the run has it (q, v); valid until the next call. In Model Exchange references become those of the state. */
double *lag_instance_plain(LagInstance *instance, const double *x);
/* The run's (q, v), against its references, as the importer has it. */
void lag_instance_tell(LagInstance *instance, const double *y, double *x);
/* From a row of results: its positions and rates, and its outputs. */
void lag_instance_take_states(LagInstance *instance, const double *y, const double *outputs);
/* Start values for the run, NaN where nothing was given: those of an attitude all where one part of its quaternion was. NULL: that is
 * none, its length is 0. */
double *lag_instance_starts(LagInstance *instance);
/* Rates of positions at rates v (n) of the run, from a state. */
void lag_instance_pace(const LagModel *model, const double *x, const double *v, double *pace);
/* A value, its rate and the rate of that at the share x of a step of h, by the polynomial of degree 5 through these (3) at both its ends. */
void lag_quintic(const double *begin, const double *end, double h, double x, double *found);
/* Of attitudes: the state at the share x of the last step, by such polynomials of quaternions, and rates of angular velocities. */
void lag_attitudes_between(const LagInstance *instance, double x, double h, double *state, double *acceleration);
/* Whether all quaternions of a state can be ones. */
int lag_instance_has_attitudes(const LagModel *model, const double *x);
/* The slope at another state and its power; 1 when all are finite. */
int lag_instance_slope_at(LagInstance *instance, double t, const double *x, double *slope, double *power);
/* The state on the constraints that equations and conditions are those of; valid until the next call. */
double *lag_instance_projected(LagInstance *instance, double t, const double *x);
LagAnswer lag_instance_outputs(LagInstance *instance);
LagAnswer lag_instance_energies(LagInstance *instance);
/* Explains why the run did not go on. */
LagAnswer lag_instance_failed(LagInstance *instance, LagStatus status);
/* Warnings of guards that are news; and that one of them has ended the simulation. */
void lag_instance_warn(LagInstance *instance);
void lag_instance_end(LagInstance *instance);

/* Model Exchange (exchange.c). */
typedef struct {
    int values_changed, has_next;
    double next;
} LagEventInfo;
LagAnswer lag_instance_set_time(LagInstance *instance, double t);
LagAnswer lag_instance_set_states(LagInstance *instance, const double *x, size_t count);
LagAnswer lag_instance_get_states(LagInstance *instance, double *x, size_t count);
LagAnswer lag_instance_get_slopes(LagInstance *instance, double *slope, size_t count);
/* Event indicators, into `indicators`; and for an importer. */
LagAnswer lag_instance_indicators(LagInstance *instance);
LagAnswer lag_instance_get_indicators(LagInstance *instance, double *indicators, size_t count);
LagAnswer lag_instance_nominals(LagInstance *instance, double *nominal, size_t count);
LagAnswer lag_instance_completed_step(LagInstance *instance, int *needs_event);
/* Also of Co-Simulation with events. */
LagAnswer lag_instance_update_discrete(LagInstance *instance, LagEventInfo *info);

/* Between completed steps of Model Exchange (exchange_steps.c). A step is completed, or an event is over: */
void lag_exchange_note(LagInstance *instance);
/* The run stands at a state (q, v). */
void lag_exchange_stand_at(LagInstance *instance, double t, const double *x);
/* Rates of inputs at the present time; and inputs have jumped where the last step ended. */
void lag_exchange_draw_inputs(LagInstance *instance);
/* They are what they are at the present time, whatever their rates. */
void lag_exchange_hold_inputs(LagInstance *instance);
/* How such a rate changes with its input, 1/s; 0 in Co-Simulation. */
double lag_exchange_rate_by_input(const LagInstance *instance, int input);
void lag_exchange_jump_inputs(LagInstance *instance);
/* Notes that one has been set within a step. */
void lag_exchange_widen(LagInstance *instance, int input);
/* Whether they have at the present event. */
int lag_exchange_has_jumped(const LagInstance *instance);
/* Takes the last step into the account; returns whether the equations are the same after it. */
int lag_exchange_keep_account(LagInstance *instance);
/* Dissipated and work since the last completed step, of a state in between; 0 where that is not known. */
int lag_exchange_account_so_far(LagInstance *instance, double *sum);
/* A warning as long as the energy account misses more than errors of the importer's method explain; told when it begins. */
LagAnswer lag_exchange_judge_account(LagInstance *instance);

/* Co-Simulation (cosimulation.c). */
typedef struct {
    int is_event, is_early;
    double time;
} LagStepResult;
LagAnswer lag_instance_step(LagInstance *instance, double t, double h, LagStepResult *result);
LagAnswer lag_instance_input_slope(LagInstance *instance, unsigned int reference, int order, double value);
LagAnswer lag_instance_output_slope(LagInstance *instance, unsigned int reference, int order, double *value);
/* Outputs, energies and state from the row of results at hand; from that of the present time. */
void lag_cosimulation_take(LagInstance *instance);
void lag_cosimulation_take_row(LagInstance *instance);

/* Derivatives along a direction and their adjoints (partial.c). */
/* Value references, and as many numbers as they stand for. */
typedef struct {
    const unsigned int *references;
    size_t count, size;
} LagVariables;
LagAnswer lag_instance_forward(LagInstance *instance, LagVariables unknowns, LagVariables knowns, const double *seed,
                               double *sensitivity);
LagAnswer lag_instance_adjoint(LagInstance *instance, LagVariables unknowns, LagVariables knowns, const double *seed,
                               double *sensitivity);
size_t lag_partial_size(const LagFmu *fmu);

/* States to come back to (saved.c): blocks of bytes that know their size. Each belongs to its instance, which takes no other
 * address for one. */
LagAnswer lag_instance_save(LagInstance *instance, LagSaved **saved);
LagAnswer lag_instance_restore(LagInstance *instance, const LagSaved *saved);
int lag_saved_is_known(const LagInstance *instance, const LagSaved *saved);
void lag_saved_free(LagInstance *instance, LagSaved *saved);
size_t lag_saved_size(const LagSaved *saved);
void lag_saved_write(const LagSaved *saved, unsigned char *bytes);
LagAnswer lag_saved_read(LagInstance *instance, const unsigned char *bytes, size_t size, LagSaved **saved);

#endif
