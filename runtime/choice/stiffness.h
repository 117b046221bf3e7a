/* Automatic choice between the explicit and the implicit method while a run goes on.
 *
 * Now and then the spectral radius of the equations is looked at. Where the explicit method's steps are as short as
 * stability asks, and not accuracy, the implicit one is tried, and kept if it gets on faster for the same work; it is left when
 * the explicit one would be faster. Work is counted in operations, not seconds: equal runs are equal to the last bit.
 */
#ifndef LAG_STIFFNESS_H
#define LAG_STIFFNESS_H

#include "base/arena.h"
#include "state/settings.h"

enum { LAG_PASSES = 4, LAG_RECOVERED = 64 }; /* steps left to another method at first; times that many without trouble end it */
enum { LAG_LOOK = 2 }; /* what a row counts, among steps without one */

typedef struct {
    int is_watching;        /* both methods are at hand */
    int32_t explicit_solver; /* the one that takes turns with implicit steps: series where the run began with them */
    int32_t next;           /* method to go on with: LAG_SOLVER_AUTO stands for the one in use */
    int passes;             /* steps left that the explicit method takes in place of another one */
    int32_t passed;         /* that one */
    int is_holding;         /* it passes since something slides, and is asked again when nothing does */
    int leads;              /* the first step of Adams' methods is one of another: that changes no solver */
    int relief;             /* passes in place of methods that leave trouble to others */
    int64_t relieved;       /* after so many steps of the run */
    int looks;              /* of rows into steps, of late */
    int steps, suspicions;  /* since the method in use began; looks in a row at which stability ruled */
    int look, interval;     /* the step to look at next; steps between looks */
    int wait, penalty;      /* steps before the implicit method is tried again; the same after it fails next time */
    double t, work;         /* when the present stretch began */
    int64_t events;         /* until then */
    double pace;            /* time gained per work by the explicit method, before the implicit one took over */
    double reached;         /* steps of the explicit method times spectral radius, at the last look */
    double square, rate;    /* largest eigenvalues of accelerations by positions, and by rates */
    double against;         /* cosine between a change of rates and what it does to them, turned round: 1 for what is damped */
    int damped;             /* looks in a row that found damping before all else */
    double *place_way, *rate_way; /* n: their eigenvectors */
    double *point, *slope, *base; /* 2 n, size, n */
} LagStiffness;

void lag_stiffness_layout(LagStiffness *stiffness, int n, int size, LagArena *arena);

/* A run starts. */
void lag_stiffness_reset(LagRun *run);

/* A method begins. */
void lag_stiffness_begin(LagRun *run);

/* A step was taken. */
void lag_stiffness_watch(LagRun *run);

/* A look out of turn, after steps of length h: how many in a row, this one among them, have found that stability rules. */
int lag_stiffness_look(LagRun *run, double h);

/* What goes on where the method in use, and those of the bits `tried`, were lost. Returns 0 where there is none. */
int lag_stiffness_retry(LagRun *run, int32_t tried, LagDecision *decision);

/* LAG_TROUBLE_...: what goes on. */
int32_t lag_stiffness_trouble(LagRun *run, int32_t trouble);

#endif
