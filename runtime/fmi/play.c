/* What a page calls: a scene in motion, in WebAssembly. The page is its only importer: numbers go through vectors that lie here.
 *
 * Steps are those of Co-Simulation, so that moments at which the page looks are rows inside the steps of the run and change
 * nothing; what it sets between two of them cuts the run there.
 */
#include "fmi/play.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fmi/image.h"
#include "fmi/instance.h"
#include "fmi/opening.h"

#include "events/sampling.h"

#include "model/attitude_places.h"
#include "model/function.h"
#include "state/state.h"

enum { LONGEST_MESSAGE = 1000, MOST_EVENTS = 1000 };

/* The scene of a page: stored.py's `Played`. */
typedef struct {
    LagFmu fmu;
    LagFunction drawing; /* t, q, v, u and held values, p -> numbers of which the page draws its strokes */
} LagPlayed;

struct LagPlayer {
    LagInstance *instance;
    char message[LONGEST_MESSAGE];
    double *values;  /* of all variables with numbers, by reference */
    double *drawing; /* of the drawing, then its work */
    double *given;   /* inputs, references of attitudes, held values */
    unsigned int *references;
    size_t n_values;
    double *inputs; /* times[rows], then rows of all inputs; NULL: they are held */
    int rows;
    double events[1 + MOST_EVENTS]; /* how many, and their times */
};

const LagFmu *lag_fmu_open(const char *resources, void **memory, char *why, size_t room)
{
    const LagFmu *fmu = NULL;
    unsigned char *bytes = (unsigned char *)(uintptr_t)resources; /* there are no files: this is the image, and the instance's own */
    uint64_t size = 0;
    memcpy(&size, bytes + LAG_IMAGE_SIZE_AT, sizeof size);
    const char *wrong = lag_image_open(bytes, (size_t)size, &fmu);
    *memory = bytes;
    if (wrong && room > strlen(wrong))
        memcpy(why, wrong, strlen(wrong) + 1);
    return wrong ? NULL : fmu;
}

static void hear(const LagInstance *instance, LagAnswer answer, const char *category, const char *message)
{
    LagPlayer *player = instance->wrapper;
    (void)answer, (void)category;
    strncpy(player->message, message, LONGEST_MESSAGE - 1);
}

unsigned char *lag_play_room(size_t size)
{
    return malloc(size);
}

static const LagPlayed *played(const LagPlayer *player)
{
    return (const LagPlayed *)(const void *)player->instance->fmu;
}

static size_t drawing_size(const LagPlayer *player)
{
    const LagFunction *drawing = &played(player)->drawing;
    return lag_present(drawing) ? (size_t)drawing->out_size[0] : 0;
}

LagPlayer *lag_play_new(unsigned char *image)
{
    LagPlayer *player = calloc(1, sizeof *player);
    const LagBirth birth = {LAG_CO_SIMULATION, "page", LAG_PLAY_TOKEN, (const char *)image, 0, 0};
    if (!player)
        return NULL;
    player->instance = lag_instance_new(&birth, hear, player);
    if (!player->instance)
        return player;
    const LagFmu *fmu = player->instance->fmu;
    for (int group = 0; group <= LAG_GROUP_PARAMETER; ++group)
        player->n_values += (size_t)lag_fmu_count(fmu, group);
    player->values = calloc(player->n_values + 1, sizeof *player->values);
    player->references = calloc(player->n_values + 1, sizeof *player->references);
    player->given = calloc((size_t)(fmu->model->n_inputs + 4 * fmu->model->n_attitudes + fmu->model->n_held) + 1, sizeof *player->given);
    player->drawing = calloc(drawing_size(player) + played(player)->drawing.n_work + 1, sizeof *player->drawing);
    for (size_t i = 0; player->references && i < player->n_values; ++i)
        player->references[i] = (unsigned int)i;
    if (!player->values || !player->references || !player->drawing || !player->given)
        lag_instance_log(player->instance, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no memory is left");
    return player;
}

const char *lag_play_message(LagPlayer *player)
{
    return player->message;
}

int lag_play_reset(LagPlayer *player)
{
    player->message[0] = 0;
    return (int)lag_instance_reset(player->instance);
}

int lag_play_inputs(LagPlayer *player, double *table, int rows)
{
    for (int i = 1; i < rows; ++i)
        if (!(table[i] >= table[i - 1]))
            return (int)lag_instance_log(player->instance, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "times of inputs fall");
    player->inputs = table;
    player->rows = rows;
    return (int)LAG_ANSWER_OK;
}

/* What they are now, for all that is asked of the present. */
static void show_inputs(LagPlayer *player)
{
    LagInstance *s = player->instance;
    const int n = s->model->n_inputs, rows = player->rows;
    const double t = s->vital.t, *times = player->inputs;
    int k = 0;
    while (k + 1 < rows && times[k + 1] <= t)
        ++k;
    for (int i = 0; i < n && rows > 0; ++i) {
        const double *here = times + rows + (size_t)k * (size_t)n + i;
        const int is_between = k + 1 < rows && t > times[k];
        s->u[i] = is_between ? *here + (here[n] - *here) * (t - times[k]) / (times[k + 1] - times[k]) : *here;
    }
}

int lag_play_set(LagPlayer *player, unsigned int reference, double value)
{
    LagInstance *s = player->instance;
    int index = 0;
    const int n = s->model->n_inputs, group = lag_instance_locate(s->fmu, reference, &index);
    double *column = group == LAG_GROUP_INPUT && player->rows > 0 ? player->inputs + player->rows + index : NULL;
    for (int i = 0; column && i < player->rows; ++i)
        column[(size_t)i * (size_t)n] = value;
    const LagAnswer answer = lag_instance_set(s, &reference, 1, &value, 1);
    s->vital.inputs_changed |= column != NULL;
    return (int)answer;
}

int lag_play_begin(LagPlayer *player, double tolerance, double stop)
{
    LagInstance *s = player->instance;
    LagAnswer answer = lag_instance_setup(s, 1, tolerance, s->fmu->start, stop > s->fmu->start, stop);
    s->foreseen = (LagForeseen){player->rows, player->inputs, player->inputs ? player->inputs + player->rows : NULL};
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_enter_initialization(s);
    if (answer == LAG_ANSWER_OK)
        answer = lag_instance_exit_initialization(s);
    if (s->run)
        lag_run_log_events(s->run, player->events + 1, MOST_EVENTS);
    show_inputs(player);
    return (int)answer;
}

int lag_play_step(LagPlayer *player, double h)
{
    LagInstance *s = player->instance;
    LagVital *vital = &s->vital;
    const double end = vital->t + h;
    LagStepResult result;
    LagAnswer answer = LAG_ANSWER_OK;
    if (vital->has_stop && end > vital->stop) { /* a run would end there: this one goes on */
        if (vital->stop > vital->t)
            answer = lag_instance_step(s, vital->t, vital->stop - vital->t, &result);
        vital->has_stop = 0;
    }
    if (answer <= LAG_ANSWER_WARNING && end > vital->t)
        answer = lag_instance_step(s, vital->t, end - vital->t, &result);
    show_inputs(player);
    return (int)(answer <= LAG_ANSWER_WARNING && vital->is_over ? LAG_ANSWER_DISCARD : answer);
}

const double *lag_play_values(LagPlayer *player)
{
    const LagAnswer answer = lag_instance_get(player->instance, player->references, player->n_values, player->values, player->n_values);
    return answer == LAG_ANSWER_OK ? player->values : NULL;
}

const double *lag_play_events(LagPlayer *player)
{
    LagRun *run = player->instance->run;
    player->events[0] = run ? lag_run_logged(run) : 0;
    if (run)
        lag_run_log_events(run, player->events + 1, MOST_EVENTS);
    return player->events;
}

static void give(LagPlayer *player)
{
    const LagInstance *s = player->instance;
    const LagModel *m = s->model;
    for (int i = 0; i < m->n_inputs; ++i)
        player->given[i] = s->u[i];
    double *held = player->given + m->n_inputs;
    for (int i = 0; i < 4 * m->n_attitudes; ++i)
        *held++ = s->run->d[lag_attitude_mode(m->attitudes, i / 4) + i % 4];
    for (int i = 0; i < m->n_held; ++i)
        *held++ = s->run->d[lag_held_mode(m, i)];
}

const double *lag_play_drawing(LagPlayer *player, const double *q)
{
    LagInstance *s = player->instance;
    if (!s->run)
        return NULL;
    const double *x = lag_instance_plain(s, s->x);
    const double *in[] = {&s->vital.t, q ? q : x, x + s->model->n, player->given, lag_run_parameters(s->run)};
    double *out[] = {player->drawing};
    give(player);
    if (lag_call(&played(player)->drawing, in, out, player->drawing + drawing_size(player)) != 0)
        return NULL;
    return player->drawing;
}
