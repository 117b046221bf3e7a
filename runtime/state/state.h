/* What a run consists of. Private to the run time. */
#ifndef LAG_STATE_H
#define LAG_STATE_H

#include "start/assemble.h"
#include "events/impacts.h"
#include "model/inputs.h"
#include "choice/methods.h"
#include "steps/branch.h"
#include "steps/looks.h"
#include "steps/orbit.h"
#include "state/project.h"
#include "steps/roots.h"
#include "run/guards.h"
#include "run/retry.h"
#include "run/unsure.h"
#include "state/settings.h"
#include "events/sliding.h"
#include "choice/stiffness.h"
#include "events/switches.h"

/* Of the choice of methods, what steps call: they are told, and know no more of it. Set by run.c. */
typedef struct {
    void (*reset)(LagRun *run); /* a run starts, or goes on by a method that was not chosen for it */
    void (*begin)(LagRun *run); /* a method begins */
    void (*watch)(LagRun *run); /* a step was taken */
    int32_t (*trouble)(LagRun *run, int32_t trouble); /* LAG_TROUBLE_...; returns what goes on: LAG_SOLVER_... */
} LagChoice;

struct LagRun {
    const LagModel *model;
    LagChoice choice;
    LagSettings settings;
    LagStatistics statistics;
    LagFailure failure;

    double *memory; /* the part of the block in which all vectors below lie */
    size_t memory_size; /* doubles in it */
    void *block;
    double *p, *c, *c_kept, *u, *d, *d_before, *d_given; /* d_given: pieces of inputs alone */
    double *u_slope; /* of inputs, what is read late, and how much rounding is on the level of what is held: see edges.h */
    double *nothing_given;        /* n_parameters zeros */
    double *event_a, *event_b;
    double *fires, *held; /* n_held: whether it is found now; values */
    double *sampled;      /* n_samplers: the latest instant, counted from 0 */
    int *is_due;          /* n_samplers: whether it is at this time */
    double *acceleration, *power; /* for outputs */
    double *multipliers;          /* of the latest accelerations */
    double *start;                /* (q, lost ones, v, their rates) */
    double *guesses;              /* as start: those of the parameters */
    double *lost;                 /* (lost ones, their rates): values given, NaN where not */
    double *inside, *inside_carry; /* a state within a step */
    double *careful_state;         /* (q, v) */
    double *work;                 /* scratch of the model's functions */
    double *late_values, *late_first, *late_now; /* of a piece of the history; at the start; at one time */
    double *late_rates; /* rates and switches before an event */
    int *fixed;                   /* as start */

    LagInputs inputs;
    LagHistory history;
    LagAssembly assembly;
    LagProjection projection;
    LagScale scale;
    LagMotion motion;
    LagMethods methods;
    LagFacts facts;               /* what the next decision goes by */
    LagDecision decided, passing; /* on what is in use; on what takes some steps in its place */
    LagStiffness stiffness;
    LagSwitches switches;
    LagSliding sliding;
    LagImpacts impacts;
    LagOrbit orbit;
    LagRoots roots;
    LagLooks looks;
    LagUnsure unsure;
    LagGuards guards;
    LagBranch branch;
    LagRetry retry;

    int started;
    int is_starting;      /* no step since the segment began was as long as it could be */
    int troubled;         /* steps in a row that were rejected at first */
    double calm_step;     /* length of those that were not, lately */
    double refused;       /* length that the last step was first tried with that was rejected */
    int sinking;          /* steps that were rejected at first, each shorter than the one before, and none longer in between */
    double sunk_from;     /* refused length of the first of these */
    int plunged;          /* for so many steps more: one was much shorter than calm ones, to resolve a quick passage */
    int plunges;          /* of late, with few steps between them */
    int rests;            /* nothing moves, until something else happens: see rest.h */
    int careful;          /* slopes are taken at projected states: a singular position is near */
    int doubtful;         /* so many evaluations are made the way that bears dependent constraints */
    int segment_over;     /* an event was reached: the next step begins a new segment */
    int silent_table;     /* the table that says nothing in this segment; -1: none */
    int parameters_version; /* how often they were set */
    int guesses_version;    /* of the parameters that guesses are of */
    int inputs_version;   /* of the table of inputs that is in force in this segment */
    double segment_end;   /* time of the next event */
    double other_end;     /* the same, but for those of what is read late */
    double wanted;        /* time of the row that is asked for */
    double row_spacing;   /* of the rows that are asked for at once, on average; 0: nobody knows */
    double paused_before; /* the last of these, where a pause came before all were there; -INFINITY: none did */
    double paced;         /* when progress was looked at */
    double step;          /* length proposed for the next step */
    double *probe; /* 6 n: scratch of lag_singularity, with constraints */
    double start_energy, energy_before;
    double missed_energy; /* by the account, when steps were made stricter for it */
    double carried_energy; /* T that prescribed motion will give to what rests so far; 0: there are energies */
    double risen_energy;  /* T of loops, as their rates rose */
    double blurred_energy; /* by what the latter was uncertain */
    double *risen;        /* n: these rates */
    double jumps_seen;    /* up to this time jumps of energies in time are in the account */
    int jumps_in_time;    /* whether energies may jump in time at the present event */
    double given_energy;  /* by jumps of modes, inputs and parameters, where no work is integrated */
    double deadline;      /* by lag_clock, of the call under way; infinity: none */
    unsigned ticks;       /* steps and rows, to look at the clock now and then */
    double *event_log;    /* where the times of the first so many events go; NULL: nowhere */
    int logged, most_logged;
    int64_t scheduled;    /* events whose times were known before */
};

/* Records a failure and returns its status. */
static inline LagStatus lag_fail(LagRun *run, LagStatus status, int index, int rate, double value)
{
    const LagFailure failure = {(int32_t)status, index, rate, run->motion.t, value};
    run->failure = failure;
    return status;
}

#endif
