/* Switches: what conditions on the state decide. Steps hold them, and a run goes back to where one changed. */
#ifndef LAG_SWITCHES_H
#define LAG_SWITCHES_H

#include "base/arena.h"
#include "model/model.h"
#include "state/settings.h"

/* What becomes of each at the present time; the next two: what slid, or an event that has come, goes to that side. The last: an event
 * comes where its condition jumps. */
enum { LAG_STAYS, LAG_CHANGES, LAG_TO_0, LAG_TO_1, LAG_JUMPS };

typedef struct {
    int is_live;    /* they are evaluated with the accelerations: no step holds them */
    int live_steps; /* steps left to be taken so */
    int spell;      /* so many, the next time that one of them changes to and fro */
    int last;       /* the one that changed latest; -1: none */
    int hurried;    /* steps in a row in which it did */
    int again;      /* steps in a row that were taken back for a shorter one */
    int unlooked;   /* steps since one was looked at in between */
    double resolved; /* length of a step that is short enough for conditions to be simple in it */
    double *held;                              /* n_switches: 1 or 0 */
    double *g, *rate, *g_begin, *rate_begin;   /* at the present time; at the beginning of the latest step */
    double *g_inside, *rate_inside;            /* inside it */
    double *g_before, *g_after;                /* on both sides of the place that was found last */
    double *unknown;                           /* how well each is known, by rounding of the state */
    double *rounding;                          /* how well, by its last digits alone: of those that may stand, see standing.h */
    double *state, *slope;                     /* at some time inside it */
    double *error;                             /* 2 n: of a state, in units of which conditions are known */
    int *turned;                               /* those that change at the present time */
    int *slides;                               /* n_switches: held where forces jump: see sliding.h */
    int *is_idle;                              /* n_switches: nothing depends on them before the next event */
    int *stands;                               /* n_switches: what they compare is equal, and stays so: see standing.h */
    double *noise;                             /* n: of accelerations, what rounding of the state makes where something stands */
    int calms;                                 /* such accelerations are none: rest.h */
} LagSwitches;

void lag_switches_layout(LagSwitches *switches, const LagModel *model, int size, LagArena *arena);

/* A run starts. */
void lag_switches_reset(LagRun *run);

/* The same but for what is held and slides: it goes on from another state. */
void lag_switches_start_anew(LagRun *run);

/* Those that were to change do not, since the present time is another one. */
void lag_switches_forget(LagRun *run);

/* A segment begins at the present state: chooses what its steps hold. Returns whether it begins because one changed. */
int lag_switches_enter(LagRun *run);

/* Sets them as they are at a state. */
void lag_switches_set(LagRun *run, double t, const double *q, const double *v);

/* The same, and the accelerations by that, where conditions ask for them. */
void lag_switches_look(LagRun *run, double t, const double *y);

/* Where no step holds them: sets them as they are at a state, with the shares of what slides; and leaves them to the state again, but
 * for what rests at contacts. */
void lag_switches_settle(LagRun *run, double t, const double *y);
void lag_switches_set_free(LagRun *run, double t, const double *y);

/* Sets them as they are held. */
void lag_switches_recall(LagRun *run);

/* What is held: a number for each, NaN for what slides, then what is rounding of each; and that again, at the present state. Returns whether all that slid still
 * does: where it is just about to end, rounding may decide otherwise. */
void lag_switches_keep(const LagRun *run, double *kept);
int lag_switches_resume(LagRun *run, const double *kept);

/* The step being tried cannot be taken with what is held, which has no value (a root of what has become negative): the next attempts
 * go without. Returns 0 where they do already, or something slides. */
int lag_switches_release(LagRun *run);

/* A step is to be taken, after the last of those without held switches. */
void lag_switches_resolve(LagRun *run);

/* A step of a model with switches was taken: where one changed in it, that becomes the present time, and the segment is over. */
void lag_switches_watch(LagRun *run);

#endif
