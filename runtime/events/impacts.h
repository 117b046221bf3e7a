/* Impacts: where a condition of an event has come true, rates are reset by impulses. */
#ifndef LAG_IMPACTS_H
#define LAG_IMPACTS_H

#include "events/edges.h"
#include "events/held_ways.h"
#include "events/loaded.h"
#include "numbers/complementarity.h"
#include "model/model.h"
#include "state/settings.h"

typedef struct {
    int *fires;      /* n_whens: those whose rates are reset now */
    int *has_contact; /* n_whens: LAG_CONTACT, LAG_ONE_WAY where one of its resets is such a one; 0: none */
    int *is_plastic; /* n_whens: of contacts, whether they have stopped what approached at this moment */
    int onward;      /* 1 + a contact that approaches, and whose reset turns nothing back; 0: none */
    int *is_on;      /* n_whens: of those that are no contacts, whether their conditions are true */
    int *comes;      /* n_whens: those whose conditions have come true by themselves at this instant, and were not looked at since */
    int comes_next;  /* whether one came by what was chosen last to hold: it is struck before a step is taken */
    int *is_level;   /* n_whens: of those that are no contacts, whether what they compare is held at their level: levels.h */
    LagHeldWays ways;
    LagEdges edges;
    LagLoaded loaded;
    int *at_once;    /* n_whens: those of all ranks that come together */
    int *which;      /* n_resets: the resets of these */
    double *rate, *wanted, *rate_after; /* n_resets */
    double *chosen;  /* n_resets: what is wanted by those that come together */
    double *way;     /* (n_resets + n_rubs) x n: change of the rates by an impulse of 1, of resets and then of what rubs */
    int *place;      /* n_rubs: among the ways; -1: it does not act */
    double *slip;    /* n_rubs: where nothing moves but supports */
    double *sense;   /* n_resets: in which contacts push, 1 or -1 */
    LagComplementarity problem;
    double *impulse; /* n_resets */
    double *after;   /* n: rates after them */
    double *state, *slope, *slope_without; /* size */
    LagDenseLu lu;   /* changes of what is reset by impulses of 1 */
    double coarse;   /* by how much more than one tolerance states may be off, where another integrator finds the events; 0: ours */
    double *before;  /* n_whens: their conditions before a time at which they may jump, or resets; positive: true */
    double *came;    /* n_whens: of those that are no contacts, when they came last; where guards ask for it: NaN before (run/guards.c) */
    double *gap_before; /* n_whens: of contacts, before resets of discrete variables */
    double *carried; /* n_whens: of contacts, how far inputs that were set anew have moved their places: walls.h */
    double *rounding; /* 2 n: by how much resets may miss rates by rounding; positions stay as they are */
    double struck;   /* the time of the latest resets; NaN: of none yet, or what they set came from the motion, with its errors */
    double *met;     /* n_whens: how far conditions may be off by that */
    double *by_time; /* n_whens: how much of a gap, or else of the condition, cannot be told since the time cannot */
    double *known_at, *known; /* where, and by which units and what is held, sliding.error was found last: see lag_contacts_find_errors;
                               * and the errors (3 n_whens) */
    int is_known;
    double *slack;   /* n_whens: how far what rests may pass, which others hold, without being an event */
    double seen;     /* the time up to which the next step may go, so that a short bounce is seen in it */
    int in_a_row;    /* events in a row between which no time passed */
    int is_felt;     /* whether the latest resets changed rates by more than their errors */
    int has_changed; /* whether events of the present round have changed rates or discrete variables at all */
} LagImpacts;

void lag_impacts_layout(LagImpacts *impacts, const LagModel *model, int size, LagArena *arena);

/* A run starts. */
void lag_impacts_reset(LagRun *run);

/* At the present state: resets the rates of events that switches.turned tells of, and of contacts that these bring about. Returns
 * LAG_OK, or a failure where such events do not end. */
LagStatus lag_impacts_strike(LagRun *run);

/* 1 + the first event whose rates are reset now; 0: none. */
int lag_impacts_striking(const LagRun *run);

/* At the present state: contacts in switches.turned that no forces hold, since friction presses them further, take the impulse that stops
 * their slip (an impact without a collision). Returns 0 where there is none. */
int lag_impacts_press(LagRun *run);

/* At a state and a time: before modes, inputs and rates jump; and afterwards, where the conditions that have come true by that are
 * told of in switches.turned: whether there are some. */
void lag_impacts_await_jump(LagRun *run, double t, const double *y);
int lag_impacts_note_jump(LagRun *run, double t, const double *y);

/* Events are held as they were before such a jump: at the start nothing holds them yet. */
void lag_impacts_hold_as_before(LagRun *run);

/* The places among the switches of event k: of its condition; of the gap of a contact, or the rate that may go one way; and of what
 * rests there: the rate of the gap, or once more that rate. Whether switch i is the first of them. */
static inline int lag_when(const LagModel *model, int k) { return model->n_switches - 3 * model->n_whens + k; }
static inline int lag_gap(const LagModel *model, int k) { return model->n_switches - 2 * model->n_whens + k; }
static inline int lag_contact(const LagModel *model, int k) { return model->n_switches - model->n_whens + k; }
static inline int lag_is_event(const LagModel *model, int i) { return i >= lag_when(model, 0) && i < lag_gap(model, 0); }

/* The event of a reset; LAG_CONTACT, LAG_ONE_WAY, or 0; and what there is beside. */
static inline int lag_event_of(const LagModel *model, int reset) { return model->reset_places[3 * reset]; }
static inline int lag_is_contact(const LagModel *model, int reset) { return model->reset_places[3 * reset + 1] & LAG_KINDS; }
static inline int lag_is_signal(const LagModel *model, int reset) { return model->reset_places[3 * reset + 1] & LAG_SIGNAL; }
static inline int lag_is_known(const LagModel *model, int reset) { return model->reset_places[3 * reset + 1] & LAG_KNOWN; }

/* Of event k: how many others come before it at an instant, in a row; its `when`, and its branch there. */
static inline int lag_rank_of(const LagModel *model, int k) { return model->order ? model->order[3 * k] : 0; }
static inline int lag_chain_of(const LagModel *model, int k) { return model->order[3 * k + 1]; }
static inline int lag_branch_of(const LagModel *model, int k) { return model->order[3 * k + 2]; }

/* The coordinate whose rate itself is reset; -1: it is of something else. */
static inline int lag_own_place(const LagModel *model, int reset) { return model->reset_places[3 * reset + 2]; }

/* How far the condition i of an event may be beyond its place at least, before it comes. */
static inline double lag_slack(const LagModel *model, const LagImpacts *s, int i) { return s->slack[i - lag_when(model, 0)]; }

#endif
