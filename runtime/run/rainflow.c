#include "run/rainflow.h"

#include <math.h>
#include <stdlib.h>

enum { FIRST_ROOM = 64 };

void lag_rainflow_start(LagRainflow *flow, double slope, double size, int keeps_cycles)
{
    flow->n_turns = flow->n_cycles = 0;
    flow->damage = 0;
    flow->slope = slope;
    flow->size = size;
    flow->keeps_cycles = keeps_cycles;
    flow->has_failed = 0;
}

void lag_rainflow_free(LagRainflow *flow)
{
    free(flow->turns);
    free(flow->cycles);
}

/* Room for one more; answers whether there is. */
static int grow(LagRainflow *flow, void **place, size_t *room, size_t used, size_t width)
{
    if (used < *room)
        return 1;
    const size_t wanted = *room ? 2 * *room : FIRST_ROOM;
    void *larger = realloc(*place, wanted * width);
    if (!larger) {
        flow->has_failed = 1;
        return 0;
    }
    *place = larger;
    *room = wanted;
    return 1;
}

static void count(LagRainflow *flow, double a, double b, double cycles)
{
    const double range = fabs(b - a);
    flow->damage += cycles * pow(range / flow->size, flow->slope);
    void *place = flow->cycles;
    if (!flow->keeps_cycles || !grow(flow, &place, &flow->room_cycles, flow->n_cycles, sizeof *flow->cycles))
        return;
    flow->cycles = place;
    const LagCycle cycle = {range, (a + b) / 2, cycles};
    flow->cycles[flow->n_cycles++] = cycle;
}

/* With the last turn in its place: cycles that it closes. */
static void close_cycles(LagRainflow *flow)
{
    double *y = flow->turns;
    while (flow->n_turns >= 3) {
        const size_t n = flow->n_turns;
        if (fabs(y[n - 1] - y[n - 2]) < fabs(y[n - 2] - y[n - 3]))
            return;
        if (n == 3) { /* from the starting point on: it closes no more */
            count(flow, y[0], y[1], 0.5);
            y[0] = y[1];
            y[1] = y[2];
            flow->n_turns = 2;
        } else {
            count(flow, y[n - 3], y[n - 2], 1);
            y[n - 3] = y[n - 1];
            flow->n_turns = n - 2;
        }
    }
}

static void push(LagRainflow *flow, double y)
{
    void *place = flow->turns;
    if (!grow(flow, &place, &flow->room, flow->n_turns, sizeof *flow->turns))
        return;
    flow->turns = place;
    flow->turns[flow->n_turns++] = y;
}

void lag_rainflow_add(LagRainflow *flow, double y)
{
    const size_t n = flow->n_turns;
    if (flow->has_failed || !isfinite(y) || (n > 0 && y == flow->turns[n - 1]))
        return;
    if (n >= 2 && (y > flow->turns[n - 1]) == (flow->turns[n - 1] > flow->turns[n - 2])) {
        flow->turns[n - 1] = y; /* it goes on the same way */
        return;
    }
    if (n >= 3)
        close_cycles(flow); /* the last one has turned */
    push(flow, y);
}

void lag_rainflow_end(LagRainflow *flow)
{
    close_cycles(flow);
    for (size_t i = 1; i < flow->n_turns; ++i)
        count(flow, flow->turns[i - 1], flow->turns[i], 0.5);
    flow->n_turns = 0;
}
