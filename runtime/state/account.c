#include "state/account.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "model/schedule.h"
#include "state/evaluate.h"
#include "numbers/extremes.h"

enum { KINETIC, POTENTIAL, TOTAL, DISSIPATED, WORK };

/* What a run may miss in its account, in its tolerance: at all, and where powers are integrated, whose rounding dead points magnify; for
 * each step, at most of all energy, and where that is loose. Of 5 400 runs of examples, cases and faults by all solvers at 1e-3 to 1e-12
 * none that was right missed by more than 5 tolerances and 0.007 for each of up to 120 000 steps, 70 with powers. Multiples of estimates, and of
 * rounding; of tolerances, what estimates excuse: where they are as large, they tell of rows that are not those of the scene. */
static const double BASE = 10, POWERS = 100, EACH = 0.01, MOST = 0.1, FEW = 10, DOUBTS = 3, EXCUSED = 1e4, ROUNDINGS = 100, NOISES = 1e3;
/* Errors of the energy quadratures in a step, in its tolerance, where motion has errors of its own to limit it: above these they limit it
 * as well, as where motion is prescribed. */
static const double LOOSE = 10;
/* Errors of steps may all have one sign, as those of low orders on loops and over many narrow places have: where the account has missed
 * by another part of the tolerance, and by more than rounding of each step explains, steps are made stricter; until energies have become
 * so large that it was little. */
static const double DRIFT = 0.5, STEP_ROUNDING = 4 * DBL_EPSILON, STRICTER = 0.1, STRICTEST = 1e-3, LITTLE = 0.1;
/* Where in the rest of a segment one looks for what prescribed motion will carry; energies that are less than this part of it are nothing. */
static const double PLACES[] = {0.15, 0.4}, NOTHING = 1e-12;
static const double RISEN = 2; /* rates, since energies were looked at */
enum { ROUGH = 2 }; /* shorter attempts, with none in between that was much better */
/* How far from an event energies are looked at, where time or inputs let them jump: in what tells times apart, and of a step. */
static const double ASIDE = 64, PART_ASIDE = 1e-8;

typedef struct {
    double total, largest; /* the largest of T, V, H */
} Seen;

/* The present energies, of which the statistics take notice. */
static Seen look(LagRun *run)
{
    LagStatistics *statistics = &run->statistics;
    double energies[3] = {0, 0, 0}, largest = 0;
    lag_energies(run, run->motion.t, run->motion.y, energies);
    for (int i = KINETIC; i <= TOTAL; ++i)
        if (isfinite(energies[i]))
            largest = lag_max(fabs(energies[i]), largest);
    statistics->energy_stored = lag_max(largest, statistics->energy_stored);
    return (Seen){energies[TOTAL], largest};
}

/* Whether energies may jump where nothing moves, as a spring's that floor(u) draws: only conditions tell of that. */
static int may_jump(const LagModel *model) { return model->n_switches > 0 && !(model->is_steady && model->n_inputs == 0); }

/* Of the present time: of the step before it, or of the segment that begins. */
static double aside(const LagRun *run)
{
    const LagMotion *m = &run->motion;
    const double end = lag_min(run->segment_end, run->settings.t_stop), rest = isfinite(end) ? end - m->t : 1;
    return lag_max(ASIDE * lag_time_resolution(m->t), PART_ASIDE * (m->t > m->t_old ? m->t - m->t_old : rest));
}

/* H at t as it is from one side on a straight line through two times there, or through two states along the motion. */
static double limit_of(LagRun *run, double t, const double *y, double later, double further)
{
    const int n = run->model->n;
    double *moved = run->motion.point, total[2], energies[3];
    memcpy(moved, y, 2 * (size_t)n * sizeof *moved);
    for (int k = 0; k < 2; ++k) {
        const double times = 1 + 2 * k;
        for (int i = 0; i < n; ++i)
            moved[i] = y[i] + times * further * y[n + i];
        lag_energies(run, t + times * later, moved, energies);
        total[k] = energies[TOTAL];
    }
    return total[0] + (total[0] - total[1]) / 2;
}

/* H as it is come to at the present time, where what jumps there may be counted already; what the state decides, too, takes an impulse
 * that is missing, and is no work. */
static double total_before(LagRun *run, double total)
{
    const LagMotion *m = &run->motion;
    const double d = aside(run);
    run->jumps_in_time = may_jump(run->model);
    if (!run->jumps_in_time)
        return total;
    const double after = limit_of(run, m->t, m->y, d, 0);
    if (m->t - 3 * d < run->jumps_seen)
        return after;
    const double before = limit_of(run, m->t, m->y, -d, 0);
    run->jumps_in_time = fabs(after - before) > NOTHING * run->statistics.energy_stored;
    if (!run->jumps_in_time)
        return total;
    const double moved = limit_of(run, m->t, m->y, 0, d) - limit_of(run, m->t, m->y, 0, -d);
    run->jumps_in_time = fabs(moved) <= fabs(after - before) / 2;
    return run->jumps_in_time ? before : total;
}

/* H of a row, which may stand where they jump: as the account has it by now. */
static double total_of_row(LagRun *run, double t, const double *y, double total)
{
    const double d = aside(run);
    if (!may_jump(run->model))
        return total;
    if (t < run->jumps_seen)
        return limit_of(run, t, y, d, 0);
    return run->motion.t - t < 3 * d ? limit_of(run, t, y, -d, 0) : total;
}

/* By how much the energies are uncertain by rounding of a state: what changes when each coordinate and rate is moved by the rounding
 * of the largest of its kind, of its natural size, or of an angle of 1; in two ways, so that changes do not cancel in both. */
static double rounding_of(LagRun *run, double t, const double *y)
{
    const LagScale *scale = &run->scale;
    const int n = run->model->n;
    double *moved = run->motion.point, before[3], after[3], largest = 0;
    lag_energies(run, t, y, before);
    for (int way = 1; way <= 2; ++way) {
        for (int i = 0; i < 2 * n; ++i) {
            const int place = i % n, kind = scale->kind[place];
            const double *group = scale->group + kind, own = i < n ? lag_max(group[0], scale->size[place]) : group[scale->kinds];
            const double size = i < n && isfinite(scale->cap[i]) ? lag_max(1, own) : own;
            moved[i] = y[i] + (i / way % 2 ? DBL_EPSILON : -DBL_EPSILON) * size;
        }
        lag_energies(run, t, moved, after);
        for (int i = KINETIC; i <= TOTAL; ++i)
            largest = lag_max(fabs(after[i] - before[i]), largest);
    }
    return largest;
}

/* The same of what loads do to what they do not move: rounding of what they would have made of it in a step, where nothing held it. Loads
 * without bound explain nothing. */
static double rounding_of_loads(LagRun *run, double t, const double *y)
{
    const LagScale *scale = &run->scale;
    const int n = run->model->n;
    const double step = (t - run->settings.t_start) / (1 + (double)run->statistics.steps);
    double *moved = run->motion.point, energies[3];
    memcpy(moved, y, 2 * (size_t)n * sizeof *moved);
    for (int i = 0; i < n; ++i)
        moved[n + i] = scale->onset[i] / DBL_EPSILON * step;
    lag_energies(run, t, moved, energies);
    return isfinite(energies[KINETIC]) ? DBL_EPSILON * fabs(energies[KINETIC]) : 0;
}

/* The kinetic energy of the largest rates so far: between looks energies may have come and gone, as in a pulse both ways, and of what
 * stands still on a support that moves they cancel. Loops have rates at dead points that are none elsewhere: there of the present ones,
 * which cancel no more the other way round, and of those that were looked at as they rose. */
static double energy_of_rates(LagRun *run, double t, const double *y)
{
    const int n = run->model->n, is_loop = run->model->n_multipliers > 0;
    double *moved = run->motion.point, energies[3] = {0, 0, 0};
    memcpy(moved, y, (size_t)n * sizeof *moved);
    for (int i = n; i < 2 * n; ++i)
        moved[i] = is_loop ? -y[i] : run->scale.largest[i];
    lag_energies(run, t, moved, energies);
    return lag_max(isfinite(energies[KINETIC]) ? energies[KINETIC] : 0, run->risen_energy);
}

/* The kinetic energy where rates are off by what the latest step may make of rounding of its places (scale.h), or of its own change of
 * them: in a narrow pulse they may be hardly more than that. */
static double blurred_energy(LagRun *run)
{
    const int n = run->model->n;
    const LagMotion *m = &run->motion;
    const LagScale *scale = &run->scale;
    double *moved = m->point, energies[3] = {0, 0, 0};
    memcpy(moved, m->y, (size_t)n * sizeof *moved);
    for (int i = 0; i < n; ++i) {
        const double rate = m->y[n + i], place = lag_max(lag_scale_magnitude(scale, i, m->y[i], m->other[i]), scale->size[i]);
        moved[n + i] = rate + copysign(lag_min(DBL_EPSILON * place / (m->t - m->t_old), fabs(rate - m->other[n + i])), rate);
    }
    lag_energies(run, m->t, moved, energies);
    return energies[KINETIC];
}

void lag_account_rise(LagRun *run)
{
    const int n = run->model->n;
    const double *rates = run->scale.largest + n;
    int is_risen = 0;
    for (int i = 0; i < n; ++i)
        is_risen |= rates[i] > RISEN * run->risen[i];
    if (!is_risen)
        return;
    memcpy(run->risen, rates, (size_t)n * sizeof *rates);
    double energies[3] = {0, 0, 0};
    lag_energies(run, run->motion.t, run->motion.y, energies);
    run->risen_energy = lag_max(lag_max(energy_of_rates(run, run->motion.t, run->motion.y), run->risen_energy), energies[KINETIC]);
    run->blurred_energy = lag_max(fabs(blurred_energy(run) - energies[KINETIC]), run->blurred_energy);
}

/* The miss that the tolerance explains, and rounding, of energies of this size: each step may add a part of it. */
static double explained_of(const LagRun *run, double steps, double size, double doubt)
{
    const double tolerance = run->settings.tolerance, base = run->model->n_power > 0 ? POWERS : BASE;
    const double by_steps = tolerance * (base + EACH * steps), rounding = ROUNDINGS * DBL_EPSILON * (1 + steps);
    const double excused = lag_min(DOUBTS * doubt, EXCUSED * tolerance * size);
    return lag_min((by_steps + rounding) * size + excused, lag_max(MOST, FEW * tolerance) * size);
}

static double explained(const LagRun *run)
{
    const LagStatistics *s = &run->statistics;
    return explained_of(run, (double)s->steps, lag_max(s->energy_scale, s->energy_stored), run->motion.doubt);
}

/* Whether such a miss is more than what explains it. */
static int is_unexplained(LagRun *run, double t, const double *y, double miss)
{
    if (miss > explained(run))
        run->statistics.energy_stored = lag_max(energy_of_rates(run, t, y), run->statistics.energy_stored);
    const double left = miss - explained(run);
    if (left <= 0)
        return 0;
    if (left > DOUBTS * run->blurred_energy && left > NOISES * rounding_of(run, t, y) && left > NOISES * rounding_of_loads(run, t, y))
        return 1;
    run->statistics.energy_rounding = lag_max(miss, run->statistics.energy_rounding);
    return 0;
}

/* The account is open from the first row on at which the largest miss is more than what explains it, unless that comes to do so. */
static void judge(LagRun *run, double t, const double *y)
{
    LagStatistics *s = &run->statistics;
    const int is_open = is_unexplained(run, t, y, s->energy_residual);
    if (is_open && !s->energy_is_open)
        s->energy_open = t;
    s->energy_is_open = is_open;
}

static double residual_of(const LagRun *run, const double *y, double total)
{
    const double *quadratures = y + 2 * run->model->n;
    const double given = run->model->n_power == 2 ? quadratures[1] - quadratures[0] : run->given_energy;
    return total - run->start_energy - given;
}

void lag_account_start(LagRun *run)
{
    const double before = run->statistics.energy_stored;
    run->given_energy = run->missed_energy = 0;
    run->start_energy = look(run).total;
    if (may_jump(run->model)) {
        run->start_energy = limit_of(run, run->motion.t, run->motion.y, aside(run), 0);
        run->jumps_seen = run->motion.t + 3 * aside(run);
    }
    if (run->model->n_power == 0 || run->model->n_switches + run->model->n_held > 0) /* else it is what lag_account_weigh asks for */
        run->statistics.energy_stored = before;
}

int lag_account_misses(LagRun *run)
{
    double energies[3] = {0};
    const LagMotion *m = &run->motion;
    lag_energies(run, m->t, m->y, energies);
    return is_unexplained(run, m->t, m->y, fabs(residual_of(run, m->y, total_of_row(run, m->t, m->y, energies[TOTAL]))));
}

void lag_account_note(LagRun *run, double t, const double *y, double *entries)
{
    LagStatistics *statistics = &run->statistics;
    const double *quadratures = y + 2 * run->model->n;
    const int kept = run->model->n_power == 2;
    entries[DISSIPATED] = kept ? quadratures[0] : 0;
    entries[WORK] = kept ? quadratures[1] : run->given_energy;
    const double residual = residual_of(run, y, total_of_row(run, t, y, entries[TOTAL]));
    statistics->energy_residual = lag_max(fabs(residual), statistics->energy_residual);
    for (int i = 0; i < LAG_ACCOUNT_SIZE; ++i)
        statistics->energy_scale = lag_max(fabs(entries[i]), statistics->energy_scale);
    for (int i = KINETIC; i <= TOTAL; ++i)
        statistics->energy_stored = lag_max(fabs(entries[i]), statistics->energy_stored);
    statistics->energy_risen = lag_max(entries[TOTAL] - run->start_energy, statistics->energy_risen);
    statistics->energy_given = lag_max(entries[WORK] - entries[DISSIPATED], statistics->energy_given);
    judge(run, t, y);
}

/* The miss between two states by which steps are made stricter, unless energies become so large that it is little. */
static double most_missed(const LagRun *run, double steps, double size)
{
    return size * (DRIFT * run->settings.tolerance + STEP_ROUNDING * steps);
}

double lag_account_between(const LagRun *like, const double *first, const double *last, const double *quadratures, double steps,
                           int is_short)
{
    const int kept = like->model->n_power == 2;
    const double given = kept ? quadratures[1] - quadratures[0] : 0, missed = fabs(last[TOTAL] - first[TOTAL] - given);
    double size = kept ? lag_max(fabs(quadratures[0]), fabs(quadratures[1])) : 0;
    for (int i = KINETIC; i <= TOTAL; ++i)
        size = lag_max(size, lag_max(fabs(first[i]), fabs(last[i])));
    const double most = is_short ? explained_of(like, steps, size, 0) : most_missed(like, steps, size);
    return !(missed <= most) ? NAN : size > 0 ? missed / size : 0;
}

/* By what the unit of errors of quadratures is larger than the tolerance of all energy. */
static double looseness(const LagRun *run) { return run->methods.table->weighs_work ? 1 : LOOSE; }

/* The energies that are behind the present unit, which another method may have loosened. */
static double seen_energy(const LagMotion *m) { return m->looseness > 0 ? m->energy / m->looseness : m->energy; }

/* Makes steps stricter that have missed too much of the energies. */
static void keep(LagRun *run, double total)
{
    const LagStatistics *s = &run->statistics;
    LagScale *scale = &run->scale;
    const double size = lag_max(s->energy_scale, s->energy_stored), residual = residual_of(run, run->motion.y, total);
    const double most = most_missed(run, (double)s->steps, size);
    const double strictest = lag_max(STRICTEST * scale->asked, lag_scale_caution(0));
    if (!run->methods.table->attempt || run->model->n_switches > 0) /* whose ties are as sharp as the tolerance */
        return;
    if (fabs(residual - run->missed_energy) > most) {
        run->missed_energy = residual;
        scale->tolerance = lag_max(STRICTER * scale->tolerance, lag_min(strictest, scale->tolerance));
    } else if (scale->tolerance < scale->asked && lag_max(fabs(residual), fabs(run->missed_energy)) < LITTLE * most)
        scale->tolerance = scale->asked;
}

void lag_account_glance(LagRun *run)
{
    const Seen now = look(run);
    if (run->carried_energy > 0)
        run->carried_energy = lag_max(energy_of_rates(run, run->motion.t, run->motion.y), run->carried_energy);
    const double seen = run->motion.looseness * lag_max(run->carried_energy, now.largest);
    keep(run, now.total);
    if (run->motion.energy > 0)
        run->motion.energy = lag_max(run->motion.energy, seen);
}

int lag_account_may_carry(const LagModel *model)
{
    const int is_still = model->is_steady && model->n_inputs == 0; /* nothing is moved in time */
    return model->n_power > 0 && model->n_delays == 0 && model->carries_in_time && !is_still;
}

/* The kinetic energy that prescribed motion will give to what it carries in the segment that begins, where there is none yet, or none left
 * by what moves against it. */
static void foresee(LagRun *run)
{
    LagStatistics *s = &run->statistics;
    const double t = run->motion.t, end = lag_min(run->segment_end, run->settings.t_stop), rest = isfinite(end) ? end - t : 1;
    const double seen = lag_account_may_carry(run->model) ? lag_max(s->energy_scale, s->energy_stored) : INFINITY;
    if (seen == INFINITY || (run->started && seen > run->carried_energy))
        return;
    double carried = 0;
    for (size_t place = 0; place < sizeof PLACES / sizeof *PLACES; ++place) {
        double energies[3] = {0, 0, 0};
        lag_energies(run, t + PLACES[place] * rest, run->motion.y, energies);
        if (isfinite(energies[KINETIC])) /* not of springs, which what they push would have left by then */
            carried = lag_max(energies[KINETIC], carried);
    }
    if (carried > 0 && lag_max(look(run).largest, seen) < NOTHING * carried) {
        run->carried_energy = carried;
        s->energy_stored = lag_max(carried, s->energy_stored);
    }
}

double lag_account_unit(const LagRun *run)
{
    return run->settings.tolerance * lag_max(run->statistics.energy_scale, run->carried_energy);
}

void lag_account_weigh(LagRun *run)
{
    LagMotion *motion = &run->motion;
    const LagStatistics *statistics = &run->statistics;
    const int counts = run->model->n_power > 0, slides = counts && run->sliding.count > 0;
    const int weighs = run->methods.table->weighs_work && !slides;
    double energy = weighs ? seen_energy(motion) : lag_max(statistics->energy_scale, statistics->energy_stored);
    if (slides || energy == 0)
        energy = counts ? lag_max(look(run).largest, energy) : 0;
    if (counts && energy == 0)
        energy = run->carried_energy;
    motion->looseness = slides ? 1 : looseness(run);
    motion->energy = counts ? motion->looseness * energy : 0;
    motion->strength = slides ? run->sliding.energy : 0;
}

void lag_account_begin(LagRun *run)
{
    run->motion.work_error = run->motion.work_is_rough = 0;
    foresee(run);
    lag_account_weigh(run);
}

double lag_account_count(LagMotion *m, double h, double error)
{
    const int is_again = m->work_error > 1 && m->work_time == m->t && h < m->work_step;
    const double shorter = h / m->work_step;
    if (is_again && m->work_is_rough < ROUGH)
        m->work_is_rough = error > shorter * shorter * m->work_error ? m->work_is_rough + 1 : 0;
    m->work_error = error;
    m->work_step = h;
    m->work_time = m->t;
    return m->work_is_rough < ROUGH ? error : 0;
}

static void give(LagRun *run, double jump)
{
    if (run->model->n_power == 2)
        run->motion.y[2 * run->model->n + 1] += jump;
    else
        run->given_energy += jump;
}

void lag_account_open(LagRun *run) { run->energy_before = look(run).total; }

void lag_account_close(LagRun *run) { give(run, look(run).total - run->energy_before); }

void lag_account_come(LagRun *run) { run->energy_before = total_before(run, look(run).total); }

void lag_account_leave(LagRun *run)
{
    const LagMotion *m = &run->motion;
    const double d = aside(run), total = look(run).total;
    give(run, (run->jumps_in_time ? limit_of(run, m->t, m->y, d, 0) : total) - run->energy_before);
    run->jumps_seen = m->t + 3 * d;
}
