/* Steps of eight motions at once, each at its own time and with steps of its own: what series (wide_taylor.h) and Runge-Kutta pairs
 * (wide_explicit.h) do alike. No motion knows of the others, and so none depends on which these are.
 */
#ifndef LAG_WIDE_STEPS_H
#define LAG_WIDE_STEPS_H

#include <float.h>

#include "model/model.h"
#include "state/settings.h"
#include "state/wide_scale.h"

typedef struct {
    const LagModel *model;
    int n, size;    /* size = 2 n + n_power: what a state has */
    int32_t solver; /* LAG_SOLVER_...: what makes them */
    double longest; /* that steps may be */
    LagWideScale scale;
    double *y, *carry, *old;   /* present states, and those before the latest steps; `old` without quadratures is what units ask */
    double *made, *made_carry; /* of the steps that are tried */
    double *reference, *turn_carry; /* n_modes: those of attitudes; 4 n_attitudes: what rounding took from them */
    int is_fresh;              /* some motion goes on by other inputs or modes, or has just begun */
    double t[LAG_ABREAST], t_old[LAG_ABREAST], stop[LAG_ABREAST];
    double length[LAG_ABREAST]; /* of the latest step */
    double next[LAG_ABREAST];   /* where the steps that are tried end */
    double energy[LAG_ABREAST]; /* 1 / what counts as a unit of error in quadratures; 0: they do not */
    double moves[LAG_ABREAST];  /* 1: there is a motion in the lane */
    double taken[LAG_ABREAST];  /* 1: the latest step was good */
    double steps[LAG_ABREAST], in_vain[LAG_ABREAST], missed[LAG_ABREAST]; /* taken; no good, since the last one that was; taken though
                                                                           * they were none, for rounding */
} LagWideSteps;

/* How much of a lane its run is given: the present state; that before its latest step and units of error, too; all that dense output
 * asks for. */
typedef enum { LAG_SHOWN_STATE, LAG_SHOWN_STEP, LAG_SHOWN_DENSE } LagShown;

/* A way of making them: `self` begins with LagWideSteps. */
typedef struct {
    int32_t solver; /* of a run whose dense output tells of its steps */

    void (*layout)(void *self, const LagRun *like, LagArena *arena);

    /* The motion of a run goes on here, or begins. Returns 0 where it cannot: what is at rest has to be set in motion first. */
    int (*load)(void *self, int lane, LagRun *run);

    /* A motion begins here from the state y (2 n), and has all else in common with the one that was loaded last at its start. NULL: no
     * such thing. */
    void (*place)(void *self, int lane, const double *y);

    /* After motions have come that begin here, all at once: those which have to be set in motion first do not move. NULL: nothing to do. */
    void (*settle)(void *self);

    /* The motion in the lane, which is where that of the run is, has come into the segment that the run is in. */
    void (*enter)(void *self, int lane, LagRun *run);

    /* The lane's state, and that of its latest step, as if the run had made it. */
    void (*show)(void *self, int lane, LagRun *run, LagShown shown);

    /* Tries a step in each lane. */
    void (*step)(void *self);

    int ends_at_rows; /* its steps do */
} LagWideMethod;

void lag_wide_steps_layout(LagWideSteps *steps, const LagRun *like, LagArena *arena);

/* What all ways do when a motion comes, and when it is looked at. */
void lag_wide_steps_load(LagWideSteps *steps, int lane, const LagRun *run);
void lag_wide_steps_show(LagWideSteps *steps, int lane, LagRun *run, LagShown shown);

/* A vector of one motion, in and out. */
static inline void lag_wide_place(double *wide, int lane, const double *one, int count)
{
    for (int i = 0; i < count; ++i)
        wide[i * LAG_ABREAST + lane] = one[i];
}

static inline void lag_wide_take(const double *wide, int lane, double *one, int count)
{
    for (int i = 0; i < count; ++i)
        one[i] = wide[i * LAG_ABREAST + lane];
}

/* -------- of as many lanes from `lane` on as a register holds */

/* The shortest step from t: lag_step_smallest. */
LAG_UNROLLED LagWide lag_wide_smallest(LagWide t)
{
    return lag_wide_max(LAG_WIDE_OF(4 * DBL_EPSILON) * LAG_WIDE_ABS(t), LAG_WIDE_OF(DBL_MIN));
}

/* Where the next step ends: lag_step_end. */
LAG_UNROLLED LagWide lag_wide_end_of(const LagWideSteps *s, int lane, LagWide t, LagWide h)
{
    const LagWide stop = lag_wide_read(s->stop + lane), left = stop - t, half = LAG_WIDE_OF(0.5) * left;
    return LAG_WIDE_SELECT(h >= left, stop, t + LAG_WIDE_SELECT(h + h > left, half, h));
}

/* Component `place` of the states that are tried: that of the present ones and a way, compensated. */
LAG_UNROLLED LagWide lag_wide_add(const LagWideSteps *s, size_t place, LagWide way)
{
    const LagWide y = lag_wide_read(s->y + place), whole = way + lag_wide_read(s->carry + place), sum = y + whole, taken = sum - y;
    lag_wide_write(s->made + place, sum);
    lag_wide_write(s->made_carry + place, (y - (sum - taken)) + (whole - taken));
    return sum;
}

LAG_UNROLLED void lag_wide_choose(double *numbers, int i, int lane, LagWide is_good, LagWide good)
{
    double *place = numbers + (size_t)i * LAG_ABREAST + lane;
    lag_wide_write(place, LAG_WIDE_SELECT(is_good > LAG_WIDE_OF(0), good, lag_wide_read(place)));
}

/* Numbers that lie elsewhere take the place of `count` where steps are good; `are_all`: they all are, and nothing waits for a
 * judgement, as processors guess it. */
LAG_UNROLLED void lag_wide_take_over(double *to, const double *from, int count, int lane, LagWide good, int are_all)
{
    for (int i = 0; i < count && are_all; ++i)
        lag_wide_write(to + (size_t)i * LAG_ABREAST + lane, lag_wide_of(from, i, lane));
    for (int i = 0; i < count && !are_all; ++i)
        lag_wide_choose(to, i, lane, good, lag_wide_of(from, i, lane));
}

/* Steps of length h are taken where they are good. Returns whether they all are. */
LAG_UNROLLED int lag_wide_accept(LagWideSteps *s, int lane, LagWide good, LagWide h)
{
    const LagWide zero = LAG_WIDE_OF(0), one = LAG_WIDE_OF(1);
    const int are_all = !lag_wide_is_some(good - one);
    lag_wide_take_over(s->old, s->y, s->size, lane, good, are_all);
    lag_wide_take_over(s->y, s->made, s->size, lane, good, are_all);
    lag_wide_take_over(s->carry, s->made_carry, s->size, lane, good, are_all);
    lag_wide_take_over(s->t_old, s->t, 1, lane, good, are_all);
    lag_wide_take_over(s->t, s->next, 1, lane, good, are_all);
    if (are_all)
        lag_wide_write(s->length + lane, h);
    else
        lag_wide_choose(s->length, 0, lane, good, h);
    lag_wide_scale_note(&s->scale, lane, s->y);
    lag_wide_write(s->taken + lane, good);
    lag_wide_write(s->steps + lane, lag_wide_read(s->steps + lane) + good);
    const LagWide vain = lag_wide_read(s->in_vain + lane) + one;
    lag_wide_write(s->in_vain + lane, LAG_WIDE_SELECT(good > zero, zero, vain));
    return are_all;
}

#endif
