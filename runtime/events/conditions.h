/* What the conditions of switches are at a state: g, positive where a switch is 1. Of those that slide, how far their shares are from
 * their ends stands in its place. */
#ifndef LAG_CONDITIONS_H
#define LAG_CONDITIONS_H

#include "state/state.h"

/* The last 3 n_whens conditions are those of events (of contacts all but the gap); the gaps of contacts, positive where they are
 * passed; and the rates of these, which slide where something rests. What is not asked for is said to be far from everything: gaps,
 * and what does not rest. While something rests it is asked whether all but the gap still holds. */

/* g and its rates (n_switches) at a state (q, v); without accelerations, rates that depend on them are none. */
void lag_conditions(LagRun *run, double t, const double *y, double *g, double *rate);
void lag_conditions_with_rates(LagRun *run, double t, const double *y, double *g, double *rate);

/* Of positions q and rates v, with accelerations a (n). */
void lag_conditions_by(LagRun *run, double t, const double *q, const double *v, const double *a, double *g, double *rate);

/* The same of a state, and nothing is said to be far; and at the present state. */
void lag_conditions_at(LagRun *run, double t, const double *y, const double *a, double *g, double *rate);
void lag_conditions_of_events(LagRun *run, double *g, double *rate);

/* Errors (2 n) of `share` tolerances in each component of a state (q, v); and that state with them, up or down by one of some patterns
 * of signs: any two near each other have the same sign in one, and not in another (what an impact has stopped is a difference of equal
 * numbers). Discrete variables have no errors. */
enum { LAG_PATTERNS = 4 };
int lag_conditions_patterns(int components); /* the first of them: the others differ in none of the first so many components */
void lag_conditions_units(const LagRun *run, const double *y, double share, double *error);
void lag_conditions_disturb(const LagRun *run, const double *y, const double *error, int pattern, double *state);

/* Into switches.unknown: how much rounding of a state, as it adds up in steps, changes switches.g, its conditions. */
void lag_conditions_find_unknown(LagRun *run, double t, const double *y);

/* What counts as an error of g of one tolerance, by what is unknown of it. */
double lag_conditions_error(const LagRun *run, double unknown);

/* And back: what of a condition cannot be told, where one tolerance is `error`. */
double lag_conditions_rounding(const LagRun *run, double error);

/* What was to change at its level, and is far from it, as an event has made a rate another one, is held as it is now; but not what the step of
 * an importer has passed. */
void lag_conditions_note_kick(LagRun *run, int i);

/* An event comes by what a segment chooses to hold: it is struck before a step is taken. */
void lag_conditions_come(LagRun *run, int i);

/* The condition of an event that a segment finds otherwise than it is held: it comes where it is true amid a run, else it is so. */
void lag_conditions_take(LagRun *run, int i, int is_true);

/* How far condition i is from changing; negative: it has. What is neither has on both sides. */
static inline double lag_depth(const LagSwitches *s, int i, const double *g)
{
    const int is_half = s->stands[i] && s->held[i] == 0.5;
    return (s->slides[i] || s->held[i] > 0) && !(is_half && g[i] > 0) ? g[i] : -g[i];
}

#endif
