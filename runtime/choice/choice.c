#include "choice/choice.h"

#include <math.h>
#include <stddef.h>

#include "choice/methods.h"

/* -------- limits of the beginning */

/* Tolerance up to which Gauss collocation pays, in closed loops, where wheels roll, and elsewhere. By times to the same error, of 25
 * scenes: at loose ones steps are as long as sweeps bear, not as errors allow. */
static const double PIRK_CONSTRAINED = 2e-4, PIRK_ROLLING = 1.5e-2, PIRK_FREE = 2e-3;
/* Operations of an evaluation, for each coordinate, from which on it pays in loops up to the tolerance PIRK_ROLLING: what it takes
 * beside evaluations of eight states at once are sums for each coordinate. What swings back is read from few steps anyway. */
static const double PIRK_COUPLED = 75, PIRK_TURNING = 55; /* the latter where attitudes turn: such loops are rougher */
/* Operations of an evaluation, and more for each coordinate, from which on Adams' methods pay: an evaluation takes some 0.3 ns an
 * operation, what they do beside it 140 ns and 4 ns a coordinate. */
static const double ADAMS_STEP = 700, ADAMS_COORDINATE = 20;
/* Tolerance up to which Verner's method pays where few rows are asked for. By evaluations to the same error: it takes 5 to 25
 * % fewer at small tolerances, more where loops are rough. */
static const double ERK9_CONSTRAINED = 1.5e-2, ERK9_FREE = 2e-4;
/* Tolerance above which Tsitouras' method pays. By evaluations to the same error on the scenes of the benchmark suite. Motions
 * of closed loops and of coordinates that are all coupled (equations of more operations a coordinate than ROUGH, as of chains)
 * are rough enough for short steps to pay; in smooth ones (springs, single pendulums) the high order nearly always does. */
static const double ERK5_CONSTRAINED = 5e-6, ERK5_ROUGH = 5e-5, ERK5_SMOOTH = 5e-3, ROUGH = 40;

/* -------- limits of steps */

/* Steps times spectral radius above which stability rules (that of Dormand-Prince 8 ends near 6 on the negative axis, that of
 * Tsitouras 5 at 3.5, those of Adams' methods between 0.2 and 1; sweeps of iterated collocation come nearer up to some 5;
 * series of order p are stable to about 1.35 + 0.37 p). */
static const double RULES = 3.5, RULES5 = 2, RULES_ADAMS = 0.25, RULES_PIRK = 2.5, RULES_SERIES = 0.95;
/* The same from which on what has long died out, being damped, can be all that limits steps of Runge-Kutta methods: tolerances
 * near rounding are missed well before stability is. */
static const double RULES_DAMPED = 0.5;
/* The same of iterated collocation from which on limits by sweeps are those of stability; the share of steps that are limited
 * so. */
static const double SWEPT = 1, MOSTLY = 0.7;
/* Looks in a row. A trial of implicit steps costs as much as 75 steps by series of a small scene. */
enum { LOOKS = 8, LOOKS_OF_OTHERS = 3, LOOKS_SERIES = 24 };
/* Steps times spectral radius below which series are limited by poles of the motion, not by vibration: there iterated collocation
 * costs less, unless there are more rows to a step of series than this, as those of series cost nothing. */
static const double POLES = 0.6, MOST_ROWS = 1.6;
enum { LOOK_FOR_POLES = 4 }; /* steps of series */
/* How much farther others must get for the same work than implicit steps: what a turn costs is not counted. */
static const double FASTER = 1.2;
/* Steps from row to row: fewer ask for dense output, or for one that costs less; that of closed loops costs projections of its
 * own. */
static const double STEPS_A_ROW = 1.5, STEPS_A_ROW_OF_LOOPS = 0.4, STEPS_A_ROW_OF_PIRK = 0.01;
/* Rows inside steps, of late, where nobody knows how far they are apart: LAG_LOOK each, less one for each step without. */
enum { MOST_LOOKS = 6 };

/* -------- at the beginning */

static int is_sure(const LagFacts *f)
{
    (void)f;
    return 1;
}

static int is_asked(const LagFacts *f) { return f->asked != LAG_SOLVER_AUTO && f->asked != LAG_SOLVER_STEPWISE; }

static int is_named(const LagFacts *f) { return f->is_named; }

static int fits_transition(const LagFacts *f) { return f->fits_transition; }

static int has_cheap_series(const LagFacts *f) { return f->series_cost < f->erk_cost; }

static double pirk_limit(const LagFacts *f)
{
    const double coupled = f->has_attitudes ? PIRK_TURNING : PIRK_COUPLED;
    const int is_coupled = f->constraints > 0 && f->rhs_cost > coupled * f->coordinates && !f->is_swing;
    return f->rolls || is_coupled ? PIRK_ROLLING : f->constraints > 0 ? PIRK_CONSTRAINED : PIRK_FREE;
}

/* Changes at conditions of the state are read from dense output. */
static int is_smooth(const LagFacts *f)
{
    const int is_rough = f->has_conditions || f->has_corners || f->may_hide;
    return f->has_jacobian && !is_rough && f->tolerance <= pirk_limit(f);
}

static double adams_limit(const LagFacts *f) { return ADAMS_STEP + ADAMS_COORDINATE * f->coordinates; }

/* Motions that begin anew again and again, at events and corners, are left to methods of one step; so are closed loops, whose
 * singular positions long steps lead across, where short ones lead into them. */
static int is_long(const LagFacts *f)
{
    const int begins_anew = f->has_attitudes || f->has_conditions || f->has_modes || f->has_inputs || f->has_corners;
    return !begins_anew && f->constraints == 0 && f->rhs_cost > adams_limit(f);
}

static double erk9_limit(const LagFacts *f) { return f->constraints > 0 ? ERK9_CONSTRAINED : ERK9_FREE; }

/* What can swing back the way it came, or change at conditions of the state, needs dense output. */
static int is_tight(const LagFacts *f)
{
    return f->has_jacobian && !f->is_swing && !f->has_conditions && f->tolerance <= erk9_limit(f);
}

static double erk5_limit(const LagFacts *f)
{
    return f->constraints > 0 ? ERK5_CONSTRAINED : f->rhs_cost > ROUGH * f->coordinates ? ERK5_ROUGH : ERK5_SMOOTH;
}

static int is_loose(const LagFacts *f) { return f->tolerance > erk5_limit(f); }

/* -------- after steps */

double lag_most_reach(const LagFacts *f)
{
    if (f->is_series)
        return RULES_SERIES * (1.35 + 0.37 * f->order);
    const int is_low = f->explicit_solver == LAG_SOLVER_ERK5;
    return f->solver == LAG_SOLVER_ADAMS ? RULES_ADAMS : f->solver == LAG_SOLVER_PIRK ? RULES_PIRK : is_low ? RULES5 : RULES;
}

int lag_is_ruled(const LagFacts *f)
{
    const int is_runge_kutta = f->solver == f->explicit_solver || f->solver == LAG_SOLVER_ERK9;
    const int is_dead = is_runge_kutta && f->is_damped;
    const int is_swept = f->solver == LAG_SOLVER_PIRK && f->swept > MOSTLY * f->steps;
    return f->reach > lag_most_reach(f) || (is_swept && f->reach > SWEPT) || (is_dead && f->reach > RULES_DAMPED);
}

static int is_ruled_long(const LagFacts *f)
{
    const int is_other = f->solver == LAG_SOLVER_ADAMS || f->solver == LAG_SOLVER_PIRK;
    return f->looks >= (f->is_series ? LOOKS_SERIES : is_other ? LOOKS_OF_OTHERS : LOOKS);
}

static int is_ruled_before_adams(const LagFacts *f) { return f->rows_solver == LAG_SOLVER_ADAMS && is_ruled_long(f); }

static double poles(const LagFacts *f)
{
    (void)f;
    return POLES;
}

int lag_may_find_poles(const LagFacts *f) { return is_smooth(f) && f->pirk_cost < f->poles_cost; }

int lag_looks_for_poles(const LagFacts *f) { return f->steps == LOOK_FOR_POLES && f->row_spacing * MOST_ROWS > f->step; }

static int has_poles(const LagFacts *f) { return lag_looks_for_poles(f) && lag_may_find_poles(f) && f->reach < POLES; }

static int is_slow(const LagFacts *f) { return f->pace < f->pace_before || f->pace * FASTER < f->pace_possible; }

/* -------- at rows */

static double fewest_steps_a_row(const LagFacts *f)
{
    return f->solver == LAG_SOLVER_PIRK ? STEPS_A_ROW_OF_PIRK : f->constraints > 0 ? STEPS_A_ROW_OF_LOOPS : STEPS_A_ROW;
}

/* What swings back is read from its steps, most rows without any other step. */
static int has_many_rows(const LagFacts *f) { return !f->is_swing && f->row_spacing < fewest_steps_a_row(f) * f->step; }

static int has_close_rows(const LagFacts *f) { return f->row_spacing > 0 && has_many_rows(f); }

static double most_looks(const LagFacts *f)
{
    (void)f;
    return MOST_LOOKS;
}

static int meets_rows(const LagFacts *f) { return !(f->row_spacing > 0) && f->row_looks > MOST_LOOKS; }

/* -------- in trouble */

static int holds(const LagFacts *f) { return f->trouble == LAG_TROUBLE_PASS && f->holding > 0; }

static int passes(const LagFacts *f) { return f->trouble == LAG_TROUBLE_PASS; }

static int leaves(const LagFacts *f) { return f->trouble == LAG_TROUBLE_LEAVE; }

static int leads(const LagFacts *f) { return f->trouble == LAG_TROUBLE_LEAD; }

static int is_crossed(const LagFacts *f) { return f->trouble == LAG_TROUBLE_CROSSED; }

static int is_far(const LagFacts *f) { return f->trouble == LAG_TROUBLE_HORIZON; }

static int comes_back(const LagFacts *f) { return f->trouble == LAG_TROUBLE_SWING; }

static int creeps(const LagFacts *f) { return f->trouble == LAG_TROUBLE_CREEPS; }

static int is_disturbed(const LagFacts *f) { return f->trouble == LAG_TROUBLE_DISTURBED; }

static int is_lost(const LagFacts *f, int32_t solver) { return f->trouble == LAG_TROUBLE_LOST && !(f->tried & 1 << solver); }

static int is_lost_before_pirk(const LagFacts *f) { return is_lost(f, LAG_SOLVER_PIRK); }

static int is_lost_before_erk(const LagFacts *f) { return is_lost(f, LAG_SOLVER_ERK); }

static int is_lost_before_erk9(const LagFacts *f) { return is_lost(f, LAG_SOLVER_ERK9); }

static int is_lost_before_implicit(const LagFacts *f) { return is_lost(f, LAG_SOLVER_IMPLICIT); }

/* -------- the table */

/* Besides numbers LAG_SOLVER_...: members of LagFacts, by what they are to a run. */
#define LOST "what went on before gave up, or its energy account missed, where rounding decides"
enum { ANY = -1, ASKED = -2, EXPLICIT = -3, ROWS = -4, TURNS = -5, NEXT = -6 };

static const LagRule RULES_OF_CHOICE[] = {
    /* of those asked for, AUTO and STEPWISE let others choose */
    {"few states", "linear equations of few states, and doubles have the digits",
     LAG_BEGIN, LAG_SOLVER_AUTO, LAG_SOLVER_TRANSITION, fits_transition, NULL},
    {"few states", "linear equations of few states, and doubles have the digits",
     LAG_BEGIN, LAG_SOLVER_LINEAR, LAG_SOLVER_TRANSITION, fits_transition, NULL},
    {"islands", "parts that do not interact, and are not alike",
     LAG_BEGIN, LAG_SOLVER_ISLANDS, LAG_SOLVER_ISLANDS, is_named, NULL},
    {"linear", "linear equations",
     LAG_BEGIN, LAG_SOLVER_LINEAR, LAG_SOLVER_LINEAR, is_named, NULL},
    {"asked", "asked for", LAG_BEGIN, ANY, ASKED, is_asked, NULL},
    {"cheap series", "series take {series_share} of the time that steps of erk take, at the tolerance {tolerance}",
     LAG_BEGIN, ANY, LAG_SOLVER_TAYLOR, has_cheap_series, NULL},
    {"smooth", "smooth, {rhs_cost} operations a call, the tolerance {tolerance} at most {limit}",
     LAG_BEGIN, LAG_SOLVER_AUTO, LAG_SOLVER_PIRK, is_smooth, pirk_limit},
    {"long equations", "{rhs_cost} operations a call, more than {limit}",
     LAG_BEGIN, ANY, LAG_SOLVER_ADAMS, is_long, adams_limit},
    {"tight", "the tolerance {tolerance} at most {limit}",
     LAG_BEGIN, LAG_SOLVER_AUTO, LAG_SOLVER_ERK9, is_tight, erk9_limit},
    {"loose", "the tolerance {tolerance} above {limit}, {rhs_cost} operations a call",
     LAG_BEGIN, ANY, LAG_SOLVER_ERK5, is_loose, erk5_limit},
    {"usual", "the tolerance {tolerance}, {rhs_cost} operations a call, and nothing that promises to cost less",
     LAG_BEGIN, ANY, LAG_SOLVER_ERK, is_sure, NULL},

    {"loose beside", "", LAG_BESIDE, LAG_SOLVER_ERK9, LAG_SOLVER_ERK5, is_loose, erk5_limit},
    {"itself", "", LAG_BESIDE, LAG_SOLVER_ERK5, LAG_SOLVER_ERK5, is_sure, NULL},
    {"beside", "", LAG_BESIDE, ANY, LAG_SOLVER_ERK, is_sure, NULL},

    {"poles", "poles of the motion keep series short: steps by spectral radius {reach}, below {limit}",
     LAG_STEP, LAG_SOLVER_TAYLOR, LAG_SOLVER_PIRK, has_poles, poles},
    {"slow sweeps", "sweeps hardly came nearer: steps by spectral radius {reach} in the last of {looks} looks",
     LAG_STEP, LAG_SOLVER_PIRK, LAG_SOLVER_ADAMS, is_ruled_before_adams, NULL},
    {"slow sweeps", "sweeps hardly came nearer: steps by spectral radius {reach} in the last of {looks} looks",
     LAG_STEP, LAG_SOLVER_PIRK, EXPLICIT, is_ruled_long, NULL},
    {"unstable", "stability ruled: steps by spectral radius {reach}, above {limit}, in the last of {looks} looks",
     LAG_STEP, LAG_SOLVER_ADAMS, EXPLICIT, is_ruled_long, lag_most_reach},
    {"no longer stiff", "no longer stiff: {gain} times as far as implicit steps for the same work",
     LAG_STEP, LAG_SOLVER_IMPLICIT, TURNS, is_slow, NULL},
    {"stiff", "stability ruled: steps by spectral radius {reach} in the last of {looks} looks",
     LAG_STEP, ANY, LAG_SOLVER_IMPLICIT, is_ruled_long, NULL},

    {"many rows", "rows {rows_apart} steps apart, fewer than {limit}, {rhs_cost} operations a call",
     LAG_ROW, LAG_SOLVER_PIRK, ROWS, has_many_rows, fewest_steps_a_row},
    {"many rows", "rows {rows_apart} steps apart, fewer than {limit}, {rhs_cost} operations a call",
     LAG_ROW, ANY, EXPLICIT, has_close_rows, fewest_steps_a_row},
    {"rows inside", "rows fell into steps of late: {row_looks}, more than {limit}",
     LAG_ROW, ANY, EXPLICIT, meets_rows, most_looks},

    {"holding", "{holding} forces that jump, of friction or contacts, hold the motion", LAG_TROUBLE, ANY, EXPLICIT, holds, NULL},
    {"pass", "it takes steps that another cannot", LAG_TROUBLE, ANY, EXPLICIT, passes, NULL},
    {"leave", "what went on before cannot", LAG_TROUBLE, ANY, EXPLICIT, leaves, NULL},
    {"lead", "it takes the first step", LAG_TROUBLE, ANY, EXPLICIT, leads, NULL},
    {"crossing", "a condition changed, which steps of equal length do not meet", LAG_TROUBLE, ANY, EXPLICIT, is_crossed, NULL},
    {"long horizon", "exponentials in doubles would lose digits that the tolerance {tolerance} asks for",
     LAG_TROUBLE, ANY, NEXT, is_far, NULL},
    {"swing", "from one moment of rest to the next it swings back the way it came",
     LAG_TROUBLE, ANY, LAG_SOLVER_ORBIT, comes_back, NULL},
    {"creeping", "a slip in the plane has hardly begun, or hardly goes on, and is stiff across",
     LAG_TROUBLE, ANY, LAG_SOLVER_IMPLICIT, creeps, NULL},
    {"another", LOST, LAG_TROUBLE, ANY, LAG_SOLVER_PIRK, is_lost_before_pirk, NULL},
    {"another", LOST, LAG_TROUBLE, ANY, LAG_SOLVER_ERK, is_lost_before_erk, NULL},
    {"another", LOST, LAG_TROUBLE, ANY, LAG_SOLVER_ERK9, is_lost_before_erk9, NULL},
    {"another", LOST, LAG_TROUBLE, ANY, LAG_SOLVER_IMPLICIT, is_lost_before_implicit, NULL},
    {"swing over", "the state or the equations are others now", LAG_TROUBLE, ANY, TURNS, is_disturbed, NULL},
};

enum { RULE_COUNT = sizeof RULES_OF_CHOICE / sizeof *RULES_OF_CHOICE };

const LagRule *lag_rule(int32_t number) { return number > 0 && number <= RULE_COUNT ? &RULES_OF_CHOICE[number - 1] : NULL; }

static int32_t taken(int32_t to, const LagFacts *f)
{
    switch (to) {
    case ASKED: return f->asked;
    case EXPLICIT: return f->explicit_solver;
    case ROWS: return f->rows_solver;
    case TURNS: return f->turns_solver;
    case NEXT: return f->next;
    default: return to;
    }
}

int lag_decide(int32_t moment, int32_t from, const LagFacts *facts, LagDecision *decision)
{
    for (int32_t k = 0; k < RULE_COUNT; ++k) {
        const LagRule *rule = &RULES_OF_CHOICE[k];
        if (rule->moment != moment || (rule->from != ANY && rule->from != from) || !rule->holds(facts))
            continue;
        decision->facts = *facts;
        decision->facts.limit = rule->limit ? rule->limit(facts) : 0;
        decision->rule = k + 1;
        decision->to = taken(rule->to, facts);
        return 1;
    }
    return 0;
}

/* -------- what is known before */

LagFacts lag_facts(const LagModel *model, const LagSettings *settings)
{
    const int has_series = !model->series_may_hide && lag_methods_permit(model, LAG_SOLVER_TAYLOR);
    const double tolerance = settings->tolerance, erk_cost = lag_taylor_erk_cost(model);
    const double series_cost = has_series ? lag_taylor_cost(model, tolerance) : INFINITY;
    return (LagFacts){
        .tolerance = tolerance,
        .coordinates = model->n,
        .constraints = model->n_multipliers,
        .islands = model->n_islands,
        .rhs_cost = model->rhs_cost,
        .erk_cost = erk_cost,
        .series_cost = series_cost,
        .series_share = series_cost / erk_cost,
        .pirk_cost = has_series ? lag_pirk_cost(model) : 0,
        .poles_cost = has_series ? lag_pirk_series_cost(model, tolerance) : 0,
        .asked = settings->solver != LAG_SOLVER_AUTO ? settings->solver : model->solver,
        .is_named = settings->solver == LAG_SOLVER_AUTO,
        .fits_transition = lag_transition_fits(model, settings),
        .has_jacobian = lag_methods_permit(model, LAG_SOLVER_IMPLICIT),
        .has_conditions = model->n_switches > model->n_lengths || model->n_delays > 0,
        .has_corners = model->has_corners,
        .has_modes = model->n_modes > 0,
        .has_inputs = model->n_inputs > 0,
        .is_swing = model->is_swing,
        .may_hide = model->may_hide || model->n_looks > 0,
        .has_attitudes = model->n_attitudes > 0,
        .rolls = model->n_multipliers > model->n_holonomic,
    };
}
