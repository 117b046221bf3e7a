/* What a call can answer, and where a run came to grief. */
#ifndef LAG_STATUS_H
#define LAG_STATUS_H

#include <stdint.h>

typedef enum {
    LAG_OK,
    LAG_PAUSED,         /* the wall time granted is over: call again to go on */
    LAG_STEP_TOO_SMALL, /* no step is small enough here: a singularity, or motion faster than time can resolve */
    LAG_NOT_FINITE,     /* the first evaluation of a segment is not finite */
    LAG_INITIAL_FAILED, /* the initial equations cannot be satisfied */
    LAG_TOO_MANY_STEPS, /* settings.max_steps */
    LAG_TIME_PASSED,    /* a row was asked for that lies before what is still known */
    LAG_PAST_STOP,      /* a row was asked for that lies after t_stop */
    LAG_NOT_STARTED,
    LAG_BAD_SETTINGS,
    LAG_BAD_INPUTS, /* input times are not ascending or not finite */
    LAG_OUT_OF_MEMORY,
    LAG_EVENTS_GO_ON, /* events that reset rates bring each other about without end */
    LAG_NO_IMPULSE,   /* contacts and their friction have neither forces nor impulses that go together; rate: turns nothing back */
    LAG_CONSTRAINTS_OPEN, /* a row cannot be brought back to its constraints: by how much of the motion one is open */
    LAG_NO_PROGRESS,      /* steps are so short that the rest would take so many */
    LAG_WANTS_JACOBIAN,   /* implicit steps are to go on, and model.jacobian_waits: run it again where it is there */
    LAG_TABLE_ENDED,      /* a table is asked for what lies beyond its ends: which one */
    LAG_INPUT_JUMPS,      /* the input of this index moves places, and jumps by so much */
    LAG_TURNED_OFF,       /* at a singular position rates became others, as of another way of moving that meets there */
    LAG_BAD_INTERVAL,     /* between the instants of the sampler of this index */
    LAG_BAD_DELAY,        /* the delay of this index is not positive, or was to change while something is on its way */
    LAG_ASSERTED,         /* the guard of this index does not hold */
    LAG_ENDED             /* the same: it ends the run, as it was meant to */
} LagStatus;

typedef struct {
    int32_t status; /* LagStatus */
    int32_t index;  /* coordinate, acceleration, initial equation, input, sampler, delay or guard; -1: none */
    int32_t rate;   /* 1: the rate of the coordinate, 0: its position */
    double time;
    double value; /* residual of the initial equation, or what the status says */
} LagFailure;

#endif
