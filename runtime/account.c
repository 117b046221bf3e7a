#include "account.h"

#include <math.h>

#include "evaluate.h"
#include "extremes.h"

enum { KINETIC, POTENTIAL, TOTAL, DISSIPATED, WORK };

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

void lag_account_note(LagRun *run, const double *y, double *entries)
{
    LagStatistics *statistics = &run->statistics;
    const double *quadratures = y + 2 * run->model->n;
    const int kept = run->model->n_power == 2;
    entries[DISSIPATED] = kept ? quadratures[0] : 0;
    entries[WORK] = kept ? quadratures[1] : run->given_energy;
    const double residual = entries[TOTAL] - run->start_energy + entries[DISSIPATED] - entries[WORK];
    statistics->energy_residual = lag_max(fabs(residual), statistics->energy_residual);
    for (int i = 0; i < LAG_ACCOUNT_SIZE; ++i)
        statistics->energy_scale = lag_max(fabs(entries[i]), statistics->energy_scale);
    for (int i = KINETIC; i <= TOTAL; ++i)
        statistics->energy_stored = lag_max(fabs(entries[i]), statistics->energy_stored);
    statistics->energy_risen = lag_max(entries[TOTAL] - run->start_energy, statistics->energy_risen);
    statistics->energy_given = lag_max(entries[WORK] - entries[DISSIPATED], statistics->energy_given);
}

void lag_account_glance(LagRun *run)
{
    const Seen seen = look(run);
    if (run->motion.energy > 0)
        run->motion.energy = lag_max(run->motion.energy, seen.largest);
}

void lag_account_weigh(LagRun *run)
{
    LagMotion *motion = &run->motion;
    const LagStatistics *statistics = &run->statistics;
    const int counts = run->model->n_power > 0, slides = counts && run->sliding.count > 0;
    const int weighs = counts && run->methods.table->weighs_work;
    double energy = weighs ? motion->energy : 0;
    if (slides || (weighs && energy == 0))
        energy = look(run).largest;
    if (slides)
        energy = lag_max(statistics->energy_scale, statistics->energy_stored);
    motion->energy = energy;
    motion->strength = slides ? run->sliding.energy : 0;
}

void lag_account_open(LagRun *run) { run->energy_before = look(run).total; }

void lag_account_close(LagRun *run)
{
    const double jump = look(run).total - run->energy_before;
    if (run->model->n_power == 2)
        run->motion.y[2 * run->model->n + 1] += jump;
    else
        run->given_energy += jump;
}
