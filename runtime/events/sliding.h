/* Sliding: forces that jump with a velocity, as dry friction does, may hold it at their jump. The share of the jump that keeps the
 * velocity there stands in d then, between 0 and 1, in place of what a condition says. */
#ifndef LAG_SLIDING_H
#define LAG_SLIDING_H

#include "events/shares.h"
#include "numbers/dense_lu.h"
#include "model/model.h"
#include "state/settings.h"

/* Pivots below this are those of shares that hold the same: corners of a box that is all but flat. */
#define LAG_SLIDING_DEPENDENT 1e-9

/* What a switch holds while it slides: holds.c. */
typedef enum { LAG_HELD_UNKNOWN, LAG_HELD_PLACE, LAG_HELD_RATE, LAG_HELD_NEITHER } LagHeld;

typedef struct {
    int count, most; /* switches that slide; no more of them can */
    int *which;      /* most: which they are */
    int *state, *next; /* most: of candidates */
    int *is_new;     /* most: nothing is known of its jump */
    int *is_light;   /* most: its jump moves no mass, but first-order states */
    int *open, *known; /* most: whether nothing tells at the present time what they do, and what they did before that was asked */
    double *known_share, *known_rate; /* most: the same; the latter with the jump of friction */
    double *known_rest; /* n_rests: what held */
    double *share;   /* most */
    double *jump;    /* most x most, column-major: change of dg/dt by a share */
    double *middle;  /* most: dg/dt at the shares `base` */
    LagDenseLu lu;   /* of the jump of those that slide */
    LagShareSystem system; /* that it is of */
    double *change;  /* most: of the shares */
    double *factored; /* most: the shares at which lu was found */
    double *base, *least, *limit; /* most: the share that jumps are measured from; the least and the largest that slide */
    double *unit;    /* most: what shares are measured by; 1 but for contacts */
    double *noise;   /* most: dg/dt that is rounding */
    int *is_tied;    /* n_switches: nothing moves its g from 0 on the side where it is held, but rounding and errors */
    double *error;   /* n_switches: of g that is one tolerance */
    double *most_jump; /* n_switches: change of dg/dt by the own share, the largest so far */
    double *before;  /* n_switches: how far g was from 0 before the impact of this moment; infinity: there was none */
    double *g, *rate;      /* n_switches: at the latest evaluation, of which g is one of the conditions themselves */
    double *state_here; /* size */
    double *share_here; /* most */
    double *state_before, *slope_before; /* the same a moment before */
    double *slope_without; /* and without jumps */
    double latest, first; /* of the latest changes: the largest, and the first one */
    double left;     /* of the rates that they are to end, by jumps: the largest */
    int jams;        /* no forces hold contacts that close, since friction presses them further */
    int is_lenient;  /* what is held in the plane may take more than there is: it is being stopped */
    int *partner;    /* n_switches: the other component of a slip in the plane; -1: there is none */
    int *leaves;     /* n_cones: torn off at the present time */
    double *slip;    /* 2 n_cones: where the next step begins */
    double *beyond;  /* n_cones: how far it has gone back, in a step of an importer that passed the place where it stops */
    double *speed;   /* n_cones: after the latest event of an importer */
    double *mirrored; /* n: rates, of which slips that have turned round are as they were */
    double stops;    /* the time up to which the next step may go, so that it does not pass where a slip in the plane stops */
    double drawn;    /* s: of an importer's step in which what is held was drawn away, as by an input whose rate it did not know; 0: it was not */
    double creep;    /* of slips in the plane that hardly gain or lose speed, the largest rate at which they turn into their force; 0: none */
    double known_error;   /* errors of rates that count where the next step begins, beside what slips in the plane; infinity: nothing does */
    int grows;       /* something that slides had no force when it began to */
    int is_fresh;    /* the jumps that are known are those of the latest evaluation */
    int is_lost;     /* the latest evaluation found no shares */
    int is_limited;  /* they are limited to what there is: spent.h */
    int all, *which_all; /* so many slide, and which, while some of them have come to their limit; most */
    double *of_all;  /* 2 most: what they are measured by, and rounding */
    int *is_spent;   /* most: the latest that were limited gave all that there is, and held nothing */
    int *still;      /* n: coordinates that rest: rest.h */
    double *way;     /* most x n: change of accelerations by the share of each */
    int *holds;      /* n_switches: what each holds, LagHeld */
    double *drift;   /* 2 most: of what is held */
    LagDenseLu held; /* how g of what is held changes along the ways */
    double energy;   /* of what the jumps would set in motion in a second */
} LagSliding;

/* So many switches of a model can slide at most. */
int lag_sliding_most(const LagModel *model);

void lag_sliding_layout(LagSliding *sliding, const LagModel *model, int size, LagArena *arena);

/* A run starts. */
void lag_sliding_reset(LagRun *run);

/* Nothing slides. */
void lag_sliding_end(LagRun *run);

/* The share in d of switch i; of a contact, the force in N that holds it. */
double *lag_share(const LagRun *run, int i);

/* By how much the share of the one at place k of sliding.which is changed, to see what depends on it: between its ends, or by the force
 * that is usual. */
double lag_share_step(const LagRun *run, int k);

/* Whether a share ends at 1, as that of a jump does: contacts push with any force, and do not pull. */
int lag_may_have_all(const LagRun *run, int i);

/* In d: 1 where the switch of rests[k] of the model is held, which may take more than what moves. */
double *lag_rest(const LagRun *run, int k);

/* dg/dt at a state by the shares in d, while none is corrected: into `rate`. */
void lag_sliding_rates(LagRun *run, double t, const double *y);

/* Chooses at a state what slides among `candidates` (n_switches: 1), whose g is 0 but for rounding: into which, d and what the
 * switches hold; the others go either way. Where that is not possible since friction jams: into jams. */
void lag_sliding_settle(LagRun *run, double t, const double *y, const int *candidates);

/* How dg/dt of those that slide depends on their shares at a state, and the shares by that. */
void lag_sliding_refresh(LagRun *run, double t, const double *y);

/* A step was taken: what had no force when it began to slide may have some now, which tells what is rounding. */
void lag_sliding_grow(LagRun *run);

/* What rounding has left of the g of those that slide goes, by an impulse of what holds them on the present state: accelerations are
 * linear in the shares. */
void lag_sliding_stop(LagRun *run);

typedef enum { LAG_SHARES_KEPT, LAG_SHARES_CHANGED, LAG_SHARES_LOST } LagShares;

/* Corrects the shares by the accelerations a[n] that they lead to, which are to be evaluated anew where they have changed. tries: so
 * many times they have at this state. */
LagShares lag_sliding_correct(LagRun *run, int tries, double t, const double *q, const double *v, const double *a);

/* How far the shares of the latest evaluation are from 0 and 1, into g (n_switches) of those that slide: negative beyond, and where it
 * found none. */
void lag_sliding_margins(const LagRun *run, int is_held, double *g);

/* The same and its rates, at a state whose slope is known; `span`: a time in which little changes. */
void lag_sliding_margin_rates(LagRun *run, double t, const double *y, const double *slope, double span, double *rate);

/* How far g of switch i may go from 0 while it slides; FAR times as far where its velocity has jumped, as inputs do. */
double lag_sliding_drift(const LagRun *run, int i);
#define LAG_SLIDING_FAR 10

/* So far g of switch i may be from 0 where it is still held: 0 if it was not. Where an impact has come, what it has moved is not. */
double lag_sliding_held(const LagRun *run, int i);

/* An impact comes, before which conditions are g[n_switches]; what is held has been chosen after it. */
void lag_sliding_note_impact(LagRun *run, const double *g);
void lag_sliding_forget_impact(LagRun *run);

/* A step was taken. Returns 0 where those that slide should be chosen anew: their g have drifted. */
int lag_sliding_lasts(LagRun *run);

#endif
