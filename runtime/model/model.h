/* A compiled mechanism: sizes and functions, all constant.
 *
 * One model serves any number of runs in any number of threads. Generated scene code exports one,
 * `LAG_API const LagModel lag_model`; a caller without a C compiler fills one with tapes (tape.h).
 *
 * Notation: q coordinates, v = dq/dt, a = dv/dt, t time, p parameters, c what depends on parameters alone ("hoisted"),
 * u inputs and, behind them, delayed values, d modes (values that change only at events) and, where steps are taken, switches, y outputs, lambda multipliers.
 * Corrections of constrained states are those of least kinetic energy: nearest in the mass metric.
 */
#ifndef LAG_MODEL_H
#define LAG_MODEL_H

#include <stddef.h>

#include "base/registers.h"

#if defined(LAG_STATIC)
#define LAG_API
#elif defined(_WIN32)
#define LAG_API __declspec(dllexport)
#elif defined(__GNUC__)
#define LAG_API __attribute__((visibility("default")))
#else
#define LAG_API
#endif

typedef struct LagTape LagTape;
typedef struct LagTable LagTable;

/* Vectors in, vectors out, all dense; `work` is scratch. Returns 0, or anything else when it has no value here. */
typedef int (*LagCode)(const double *const *in, double *const *out, double *work);

/* Taylor coefficients of the orders from `first` to before `end` of all jets, from those of lower order, and those of q and v of
 * one order more (jets.h); in: d, c. The first jets are t, q, v, u, and four an attitude: its quaternion, in the place of q and of its
 * reference; these lie once more behind the n_jets, in fours, order by order. */
typedef void (*LagJets)(int first, int end, const double *const *in, double *jets);

/* The same of eight motions at once (wide_jets.h): of order 0 in a line, from what is known there (first is 0), or of the orders from 1
 * to before `end`; numbers: what is constant in a step, of each motion. */
typedef void (*LagWideJets)(int first, int end, const double *numbers, double *jets, double *line);

/* t, q, v, u, d, c -> a, power, doubt of eight states at once (wide.h), which share d and c. Where doubt is not 0, it does not hold. */
typedef void (*LagWideCode)(const double *const *in, double *const *out);

/* Either `code` or `tape` is set; neither: the function is absent and its outputs are empty. */
typedef struct {
    int n_in, n_out;
    const int *in_size, *out_size;
    size_t n_work;
    LagCode code;
    const LagTape *tape;
} LagFunction;

/* How far assembly may move a start value: it is a guess, it is exact, or nobody said anything about it. */
enum { LAG_START_GUESS, LAG_START_FIXED, LAG_START_FREE, LAG_START_LOOSE }; /* FREE: nobody guessed it; LOOSE: and it moves no mass */

/* When the argument x(t) = a + b t causes an event: where it is 0, a whole number, or (LAG_EVENT_TABLE + k) a knot of table k. */
enum { LAG_EVENT_ZERO, LAG_EVENT_INTEGER, LAG_EVENT_TABLE };

/* Groups of like coordinates share one order of magnitude; angles have a natural one, so they are a group of their own. */
enum { LAG_KIND_ANGLE };

/* What a reset leaves may rest there: positions that do not approach any more, or a rate at the end of a one-way range. */
enum { LAG_KICK, LAG_CONTACT, LAG_ONE_WAY, LAG_KINDS = 3 };
/* Beside these: of a first-order state, without energy; at an event that comes where a condition changes, to whichever side; what is
 * set does not come from the motion, with whose errors. */
enum { LAG_SIGNAL = 4, LAG_CHANGE = 8, LAG_KNOWN = 16 };

/* A guard that breaks (g < 0) ends the run with a failure, warns, or ends it as it was meant to; with this bit, parameters decide it. */
enum {
    LAG_GUARD_ERROR,
    LAG_GUARD_WARNING,
    LAG_GUARD_END,
    LAG_GUARD_OF_PARAMETERS = 4,
    LAG_GUARD_HOLDS_ON_LEVEL = 8, /* where rates that resets have set meet what they are compared with */
    LAG_GUARD_BREAKS_ON_LEVEL = 16,
    LAG_GUARD_EVENTS = 32 /* times 1 + the event that tells whether this ends the run; 0: its own number does */
};

typedef struct LagModel LagModel;

/* Of u: inputs and delayed values. */
#define LAG_N_U(model) ((size_t)((model)->n_inputs + (model)->n_delays))

struct LagModel {
    int n; /* coordinates */
    int n_parameters, n_hoisted, n_inputs, n_modes, n_events, n_outputs, n_initial;
    int n_power; /* 0: energy needs no quadrature; 2: {dissipated, work} */
    int n_holonomic;   /* constraints Phi(q, t) = 0 */
    int n_multipliers; /* constraints J v + dPhi/dt = 0: those of Phi first, then nonholonomic ones */
    int n_initial_positions; /* so many of the initial equations come first and depend on positions alone */
    int n_lost; /* coordinates that others give, and that start values are stated for: they follow q, their rates v, at the start */
    int n_switches; /* conditions on the state, which steps hold: they follow the modes in d, 1 where g > 0 and 0 where g < 0 */
    int n_lengths;  /* of them come first, and say where lengths pass through 0, which ordinary motion does not do */
    int n_whens;    /* events of conditions: the last of the switches are theirs, three of each: conditions.h */
    int n_loaded;   /* of these, whose conditions ask for forces: loaded.h */
    int n_rubs;     /* of friction that presses with the force of contacts */
    int n_resets;   /* rates that they reset, by impulses that follow the switches in d: forces of 1 when a way is looked for */
    int n_rests;    /* behind these: 1 where a switch is held at its jump, which may take more than what moves, else 0 */
    int n_roots;    /* of positions, in the forces: these bend where what stands under one touches 0 */
    int n_looks;    /* of functions in the forces that fade where what stands inside is large: these turn within a narrow range */
    int n_hiding;   /* of them, the last: of conditions that time alone decides, which may come and go within a step */
    int n_cones;    /* slips in the plane, of which a force holds both components */
    int n_lookups;  /* tables in time, whose pieces are modes */
    int n_pieces;   /* inputs that stand where functions of time do: polynomials between rows, whose coefficients are modes */
    int n_samplers; /* at whose instants held values change */
    int n_held;     /* values that are held between instants: modes */
    int n_delays;   /* delayed values */
    int n_attitudes; /* of three coordinates each, whose rates are angular velocities: attitudes.c */
    int n_kept;     /* discrete variables: first-order states at rest, which events set to the last digit */
    int n_guards;   /* conditions that have to hold during a run, or end it: guards.h */
    int n_seen;     /* what they compare, for people */
    int guards_need_acceleration;
    int breaks_rise; /* no delayed value is made of others at once: what breaks is smoother a lag later */
    const int *coordinate_kind; /* n + n_lost: group of like coordinates */
    const int *fixed;           /* 2 (n + n_lost): LAG_START_..., of positions then rates */
    const int *initial_pattern; /* of the start equations: starts (n_initial + 1), the values, q then v, of which each speaks */
    const int *mass_blocks;     /* n + n_lost: from 0 on; M is 0 between coordinates of different blocks */
    const int *event_kind;      /* n_events */
    const int *reset_places;    /* 3 n_resets: the event of each; LAG_CONTACT, ... of those at which something may rest; and the coordinate
                                 * whose rate itself it is, -1 of any other */
    const int *on_level;        /* n_whens: whether the event's condition is true where rates meet what they are compared with, and 2 more
                                 * where it compares nothing else; -1: by its parts, or there are none; -2: it compares places alone;
                                 * 4 more, or -3, where it compares several things that may be held */
    const int *loaded;          /* 2 n_loaded: the event of each, and whether it comes where its condition is true at the start */
    const int *order;           /* 3 n_whens: the rank of each at an instant, by what it reads; its `when`, and its branch there; NULL: they
                                 * read nothing of each other */
    const int *rubs;            /* 3 n_rubs: the switch of its slip, the event of the contact, whether no other force has the switch */
    const int *rests;           /* n_rests: the switch of each */
    const int *at_level;        /* n_switches but those of events: LAG_LEVEL_... of each, in standing.h */
    const int *cones;           /* 2 n_cones: the switches of both components */
    const int *lookups;         /* 2 n_lookups: the event whose argument a table is asked for, and the first of its modes */
    const int *pieces;          /* 4 n_pieces: the input, those that are its first two rates (-1: none), the first of its modes */
    const int *samplers;        /* n_samplers: the event whose argument is a whole number at its instants, from 0 on */
    const int *held;            /* 3 n_held: the mode of each, its sampler, and its rank at an instant */
    const int *stated;          /* n_delays: whether it is said what was before the start */
    const int *attitudes;       /* 2 n_attitudes: the first coordinate of each, and the first of four modes: its reference */
    const int *kept;            /* n_kept: the coordinate of each, whose rate it is */
    const int *guard_kinds;     /* n_guards: LAG_GUARD_... of each */
    const LagTable *tables;
    int outputs_need_acceleration; /* a or lambda */
    int switches_need_acceleration;
    const int *linear_pattern;     /* NULL unless the equations are linear: see linear_system.h */
    int solver;                    /* LAG_SOLVER_...: the one that fits the equations best */
    int n_entries;        /* of the matrix of implicit steps; 0: there is none */
    int n_lower, n_upper; /* most entries of its factors; 0: elimination is dense */
    int n_colours;        /* groups of the matrix's columns without common rows */
    int rhs_cost, jacobian_cost; /* operations in them */
    int has_corners;  /* forces bend or jump somewhere: what does not fall as steps shrink need not be rounding */
    int may_hide;     /* forces have exponentials of what changes, which may be narrow within a step */
    int may_be_narrow; /* those and others of rates, as in friction that is rubbed smooth, so that steps that are wide look twice */
    int loops_know_time; /* what moves in time stands in constraints: it may drive a linkage through dead points */
    int carries_in_time; /* T depends on time: what is moved in it carries something */
    int conditions_may_hide; /* some event's depends on time besides at time events, or jumps, or forces count whole numbers: no step of the
                              * motion tells how quick it is */
    int shares_bend;  /* accelerations are no linear functions of shares: friction feels reactions, which it changes */
    int is_swing;     /* one degree of freedom, energy is kept, and nothing but the state decides */
    int is_steady;    /* accelerations and conditions do not depend on time */
    int may_repeat;   /* constraints may repeat each other at all closed positions, as those of loops in space do */
    int is_separable; /* energy is kept, and accelerations follow from positions alone: M is constant */
    int jacobian_waits; /* it is made when it is asked for; until then there is none, and a run that wants it ends */
    const int *jacobian_pattern; /* of the matrix's columns: starts (size + 1), rows (n_entries), order (size = n + n_multipliers);
                                  * colours (n) of those of the coordinates */

    int n_islands;      /* groups of coordinates that do not interact; 0: the model is not divided */
    const int *island;  /* n: the coordinates of the first one, then those of the next, ... */
    const LagModel *const *islands; /* each as a model of its own, with the same parameters and inputs */

    LagFunction parameters; /* given, mask          -> p               given values kept, dependent ones computed */
    LagFunction hoist;      /* p                    -> c */
    LagFunction start;      /* p                    -> q, v            guesses */
    LagFunction initial;    /* q, v, p              -> g, dg/d(q, v)   where initial_pattern says; of q, v, p, u where inputs decide */
    LagFunction momentum;   /* q, v, p              -> M v             at the start; absent: start values have no mass */
    LagFunction events;     /* p, d                 -> a, b            event arguments a + b t; of d pieces of inputs alone */
    LagFunction modes;      /* t, p, d              -> d               of the first d pieces of inputs alone */
    LagFunction rhs;        /* t, q, v, u, d, c     -> a, power, lambda */
    LagFunction outputs;    /* t, q, v, a, lambda, u, d, c -> y */
    LagFunction energies;   /* t, q, v, u, d, c     -> {T, V, H}       H - H(0) + dissipated - work = 0; inputs in them are pieces */
    LagFunction place;      /* t, q, u, d, c        -> dq              one Newton correction of q */
    LagFunction steer;      /* t, q, v, u, d, c     -> dv              the same for v */
    LagFunction linear;     /* p, d                 -> numbers of the linear equations; always a tape */
    LagFunction waves;      /* t, p, d              -> states of its loads; always a tape */
    /* The matrix of implicit steps mu S0 + S1 + S2/mu, written out or by its products with directions: derivatives of
     * M a + h + J^T lambda and of J a + bias (jacobians.py). One of the two is there, or neither. */
    LagFunction jacobian;   /* t, q, v, a, lambda, u, d, c         -> S0, S1, S2 */
    LagFunction tangent;    /* t, q, v, a, lambda, u, d, c, dq, dv -> S0 (dv, 0), S1 (dv, 0) + S2 (dq, 0) */
    LagFunction velocity;   /* q, p, c              -> v = M^-1 p      these two only where energy is kept */
    LagFunction force;      /* q, v, c              -> dp/dt = dT/dq - dV/dq */
    LagFunction residual;   /* t, q, v, u, d, c     -> Phi(q, t), J v + dPhi/dt */
    /* t, q, v, u, d, c -> a, power, doubt: where constraints are independent; cheaper than rhs, and as good if doubt is 0. */
    LagFunction regular;
    /* t, q, v, u, d, c -> dq, dv, Phi, J v + dPhi/dt, {T, V, H}, doubt: place and steer in one, both in the metric of q, where
     * constraints are independent; dv, the residuals and the energies belong to the state that has its corrections. */
    LagFunction nearest;
    /* t, q, v, u, d, c, d_before -> dv: what the impulse of supports whose rate jumps at an event does; absent where none does. */
    LagFunction kick;
    LagFunction switches;   /* t, q, v, a, u, du/dt, modes, c -> g, dg/dt   n_switches each */
    LagFunction resets;     /* t, q, v, u, modes, c -> rates, and what they become at their events   n_resets each */
    LagFunction roots;      /* t, q, v, u, d, c -> g, dg/dt   n_roots each */
    LagFunction looks;      /* t, q, v, u, d, c -> g          n_looks: what stands inside of these */
    LagFunction held_first; /* p                -> held values before any instant */
    LagFunction samples;    /* t, q, v, u, d, p, fires -> held values, where samplers fire (1) or not (0) */
    LagFunction lags;       /* p                -> by how much each delayed value is late */
    LagFunction delayed;    /* t, q, v, u, d, c -> what is read late   n_delays each */
    LagFunction before;     /* t, p             -> what that was before the start; where nothing is said, 0 */
    LagFunction guards;     /* as outputs       -> g of the guards, and what they compare   n_guards + n_seen */
    LagFunction loads;      /* as outputs       -> conditions of events that ask for forces   n_loaded */
    LagFunction requirements; /* p              -> the first of what is required of parameters that is not met, or -1; the same of
                               *                   what is only told */

    int n_jets;            /* 0: there are no series */
    int jet_pitch;         /* distance between the coefficients of a jet: 1, or n_jets and more where they lie order by order */
    int n_products;        /* sums of products among the jets: their cost grows with the order */
    int n_weighed;         /* jets by which costs are weighed: n_jets, and what was left out of them since */
    int series_rhs_cost;   /* of one evaluation of rhs, in tenths of a nanosecond of some machine */
    const int *jet_places; /* n + n_power: the jets of accelerations and powers; n_power in a long state: of powers */
    int is_long_state;     /* jets lie order by order, and accelerations are not kept: the rates of one order more tell them */
    int series_may_hide;   /* terms may be too faint for any coefficient to tell of them, and large within a step */
    LagJets taylor;
    /* The same as instructions, which are run where `taylor` is not there: jet_tape.h. */
    int n_jet_instructions;
    int n_jet_slots;       /* jets, with those of which only the present coefficient is asked for */
    int n_angles;          /* coordinates whose sines and cosines are computed together */
    const int *jet_code;
    const int *jet_rates;  /* n: the slots of the accelerations */
    LagFunction series;    /* d, c -> numbers that are constant in a step */

    LagWideCode wide; /* NULL: states are evaluated one by one */
    LagWideCode wide_whole; /* the same by rhs, with constraints that repeat each other; NULL: one by one, or by the tape */
    LagWideCode wide_each; /* as wide, where each state has d and c of its own; NULL: by the tape */
    LagWideCode wide_roots; /* `roots` likewise */
    LagWideCode wide_energies; /* `energies`, of states that share d and c; NULL: by the tape */
    LagWideJets wide_taylor; /* NULL: by the instructions */
};

#endif
