#include "account.h"

#include <math.h>

#include "evaluate.h"
#include "extremes.h"

enum { KINETIC, POTENTIAL, TOTAL, DISSIPATED, WORK };

/* At the present time, and takes notice of its parts. */
static double total(LagRun *run)
{
    LagStatistics *statistics = &run->statistics;
    double energies[3] = {0, 0, 0};
    lag_energies(run, run->motion.t, run->motion.y, energies);
    for (int i = KINETIC; i <= TOTAL; ++i)
        if (isfinite(energies[i]))
            statistics->energy_stored = lag_max(fabs(energies[i]), statistics->energy_stored);
    return energies[TOTAL];
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

void lag_account_glance(LagRun *run) { total(run); }

void lag_account_weigh(LagRun *run)
{
    const int counts = run->sliding.count > 0 && run->model->n_power > 0;
    if (counts)
        lag_account_glance(run);
    run->motion.energy = counts ? lag_max(run->statistics.energy_scale, run->statistics.energy_stored) : 0;
    run->motion.strength = counts ? run->sliding.energy : 0;
}

void lag_account_open(LagRun *run) { run->energy_before = total(run); }

void lag_account_close(LagRun *run)
{
    const double jump = total(run) - run->energy_before;
    if (run->model->n_power == 2)
        run->motion.y[2 * run->model->n + 1] += jump;
    else
        run->given_energy += jump;
}
