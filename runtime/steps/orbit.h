/* What swings with one degree of freedom, and keeps its energy, swings back the way it came: the motion is even in time about each
 * moment of rest. Between two of these it is computed in steps, which are kept; from then on it is read from them, at any time.
 *
 * Times after the first turn t1 are folded into the half swing: u = (t - t1) mod 2 D for half swings of length D, and back where
 * u > D, with the rates reversed. What goes round and never rests is stepped as ever.
 */
#ifndef LAG_ORBIT_H
#define LAG_ORBIT_H

#include "state/method.h"
#include "model/model.h"
#include "state/settings.h"

enum { LAG_ORBIT_STEPS = 320 };

typedef struct {
    int is_open;    /* steps are being kept */
    int count;      /* so many are */
    int has_turned; /* once */
    int32_t solver; /* LAG_SOLVER_...: whose steps they are */
    double first, span; /* the first turn, and how long a half swing takes */
    size_t room;    /* doubles a step */
    double *begin;  /* LAG_ORBIT_STEPS + 1: where steps begin, and where the last one ends */
    double *kept, *y;
} LagOrbit;

void lag_orbit_layout(LagOrbit *orbit, const LagModel *model, const LagSettings *settings, LagArena *arena);

/* Begins anew at the present state, by the method that steps are taken with. */
void lag_orbit_restart(struct LagRun *run);

/* A step was made: it is kept. After the second turn the run goes on by reading. */
void lag_orbit_follow(struct LagRun *run);

extern const LagMethod lag_orbit;

#endif
