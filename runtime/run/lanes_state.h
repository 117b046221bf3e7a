/* What lanes consist of. Private to run_lanes.c and lane_runs.c. */
#ifndef LAG_LANES_STATE_H
#define LAG_LANES_STATE_H

#include "methods/wide_conditions.h"
#include "methods/wide_explicit.h"
#include "methods/wide_roots.h"
#include "methods/wide_taylor.h"
#include "run/bare_runs.h"
#include "run/run_lanes.h"

struct LagRunLanes {
    LagBatch *batch;
    void *block;
    const LagWideMethod *method;
    LagWideSteps *steps;
    LagWideTaylor taylor;
    LagWideExplicit explicit;
    LagWideRoots roots;
    LagWideConditions conditions;
    LagBareRuns bare;
    int is_bare; /* runs that begin there are such ones */
    int starts_again; /* runs start as lag_run_start_again does, where it serves */
    int may_turn;  /* others go on where stability rules */
    int are_shared; /* inputs */
    int is_guarded; /* each step is looked at */
    int is_loop;    /* each step is told to its run */
    int has_events; /* runs leave their lanes for events, and come back */
    int opened;    /* lanes whose follower and run are there */
    LagFollower follower[LAG_ABREAST];
    int64_t job[LAG_ABREAST]; /* the run in each lane; -1: none */
    int busy;                 /* how many there are */
    double due[LAG_ABREAST];  /* when something is to be looked at */
    double glance[LAG_ABREAST]; /* after so many steps, too */
    int64_t look[LAG_ABREAST];
    double came[LAG_ABREAST]; /* how many steps the run had made when it came into the lane */
    int in_vain[LAG_ABREAST]; /* how often in a row it left soon, where there are events */
    int begins[LAG_ABREAST];  /* it has just come, and waits to be settled with others */
    int64_t next, runs;  /* of the present call: the run to be started next, and how many there are */
    uint8_t *done;       /* of each run */
    int64_t counts[LAG_LANES_COUNTS];
};

static inline LagRun *lag_lanes_run(const LagRunLanes *s, int lane) { return s->follower[lane].run; }

#endif
