/* A saved state: header, vital signs, vectors, and the run's snapshot when there is a run. Written out it is these bytes, with
 * a sum over them: bytes of another model, another build or with a fault are refused. */
#include <stdlib.h>
#include <string.h>

#include "fmi/instance.h"

#include "run/snapshot.h"

typedef struct {
    uint64_t sum, token; /* hashes: of the bytes after this one, and of the model's token */
    uint64_t kind, vectors, run; /* run: bytes of the run's snapshot, 0: none */
} Header;

struct LagSaved {
    LagSaved *next; /* of the instance's states */
    size_t size;
    unsigned char *bytes;
};

/* FNV-1a. */
static uint64_t hash(const unsigned char *bytes, size_t size)
{
    uint64_t value = 14695981039346656037u;
    for (size_t i = 0; i < size; ++i)
        value = (value ^ bytes[i]) * 1099511628211u;
    return value;
}

static uint64_t token_of(const LagInstance *s) { return hash((const unsigned char *)s->fmu->token, strlen(s->fmu->token)); }

static LagSaved *reserve(LagInstance *s, size_t size)
{
    LagSaved *saved = malloc(sizeof *saved);
    unsigned char *bytes = malloc(size);
    if (saved && bytes) {
        saved->size = size;
        saved->bytes = bytes;
        saved->next = s->states;
        s->states = saved;
        return saved;
    }
    free(saved);
    free(bytes);
    return NULL;
}

static void seal(LagSaved *saved)
{
    const uint64_t sum = hash(saved->bytes + sizeof sum, saved->size - sizeof sum);
    memcpy(saved->bytes, &sum, sizeof sum);
}

LagAnswer lag_instance_save(LagInstance *s, LagSaved **saved)
{
    const size_t vectors = s->saved_size * sizeof *s->memory, run = s->run ? lag_snapshot_size(s->run) : 0;
    const Header header = {0, token_of(s), (uint64_t)s->kind, s->saved_size, run};
    const size_t size = sizeof header + sizeof s->vital + vectors + run;
    LagSaved *result = lag_saved_is_known(s, *saved) ? *saved : NULL;
    if (result && result->size != size) {
        lag_saved_free(s, result);
        result = NULL;
    }
    if (!result)
        result = reserve(s, size);
    *saved = result;
    if (!result)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no memory is left");
    unsigned char *place = result->bytes;
    memcpy(place, &header, sizeof header);
    memcpy(place += sizeof header, &s->vital, sizeof s->vital);
    memcpy(place += sizeof s->vital, s->memory, vectors);
    if (run > 0)
        lag_snapshot_take(s->run, place + vectors);
    return LAG_ANSWER_OK;
}

/* A run to take over the one that was saved. */
static int prepare_run(LagInstance *s, const LagVital *vital, size_t run)
{
    if (run == 0) {
        lag_run_free(s->run);
        s->run = NULL;
        return 1;
    }
    if (s->run)
        return 1;
    const LagVital own = s->vital;
    s->vital = *vital;
    const LagAnswer answer = lag_instance_enter_initialization(s);
    s->vital = own;
    return answer == LAG_ANSWER_OK;
}

LagAnswer lag_instance_restore(LagInstance *s, const LagSaved *saved)
{
    Header header;
    LagVital vital;
    const size_t vectors = s->saved_size * sizeof *s->memory;
    if (!lag_saved_is_known(s, saved))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "there is no such state to restore");
    memcpy(&header, saved->bytes, sizeof header);
    if (header.token != token_of(s) || header.kind != (uint64_t)s->kind || header.vectors != s->saved_size
        || saved->size != sizeof header + sizeof vital + vectors + header.run)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the state belongs to another model or kind of instance");
    const unsigned char *place = saved->bytes + sizeof header;
    memcpy(&vital, place, sizeof vital);
    place += sizeof vital;
    if (!prepare_run(s, &vital, (size_t)header.run)
        || (header.run > 0 && lag_snapshot_restore(s->run, place + vectors, (size_t)header.run) != LAG_OK))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "the state cannot be restored");
    s->vital = vital;
    memcpy(s->memory, place, vectors);
    return LAG_ANSWER_OK;
}

int lag_saved_is_known(const LagInstance *s, const LagSaved *saved)
{
    const LagSaved *state = s->states;
    while (state && state != saved)
        state = state->next;
    return state != NULL;
}

void lag_saved_free(LagInstance *s, LagSaved *saved)
{
    LagSaved **link = &s->states;
    while (*link && *link != saved)
        link = &(*link)->next;
    if (!*link)
        return;
    *link = saved->next;
    free(saved->bytes);
    free(saved);
}

size_t lag_saved_size(const LagSaved *saved) { return saved->size; }

void lag_saved_write(const LagSaved *saved, unsigned char *bytes)
{
    LagSaved copy = {NULL, saved->size, bytes};
    memcpy(bytes, saved->bytes, saved->size);
    seal(&copy);
}

LagAnswer lag_saved_read(LagInstance *s, const unsigned char *bytes, size_t size, LagSaved **saved)
{
    uint64_t sum;
    if (!bytes || size < sizeof(Header) + sizeof s->vital)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "these bytes are no state");
    memcpy(&sum, bytes, sizeof sum);
    if (sum != hash(bytes + sizeof sum, size - sizeof sum))
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "these bytes are no state, or have changed since");
    LagSaved *result = reserve(s, size);
    if (!result)
        return lag_instance_log(s, LAG_ANSWER_ERROR, LAG_ERROR_CATEGORY, "no memory is left");
    memcpy(result->bytes, bytes, size);
    lag_saved_free(s, *saved); /* when it is one of ours: it may be used anew */
    *saved = result;
    return LAG_ANSWER_OK;
}
