/* Layout of the bytes: Header, the run's struct, its vectors, its table of inputs, what is on its way to be read late; of each island
 * the number of its bytes, and these. */
#include "run/snapshot.h"

#include <stdlib.h>
#include <string.h>

#include "state/state.h"
#include "state/stepper.h"

typedef struct {
    uint64_t struct_size, memory_size, table_size, history_size; /* bytes, doubles each */
    uint64_t run, memory; /* addresses the saved run had */
} Header;

enum { WORD = sizeof(uint64_t) };
/* Code and constants of one library lie no farther apart, nor does what is in a model that was read from a file. */
static const uint64_t REACH = (uint64_t)1 << 30;
/* Where memory begins within that of 0 (executables at fixed addresses have it so), numbers of a fresh run lie below this. */
static const uint64_t LOWEST = (uint64_t)1 << 24;

static uint64_t address(const void *pointer) { return (uint64_t)(uintptr_t)pointer; }

static uint64_t table_size(const LagRun *run) { return (uint64_t)run->inputs.rows * (1 + (uint64_t)run->inputs.n); }

size_t lag_snapshot_size(const LagRun *run)
{
    const size_t tables = (size_t)table_size(run) + lag_history_size(&run->history);
    size_t islands = 0;
    for (int k = 0; k < run->methods.islands.count; ++k)
        islands += WORD + lag_snapshot_size(run->methods.islands.runs[k]);
    return sizeof(Header) + sizeof *run + (run->memory_size + tables) * sizeof(double) + islands;
}

static unsigned char *append(unsigned char *place, const void *from, size_t size)
{
    if (size > 0)
        memcpy(place, from, size);
    return place + size;
}

void lag_snapshot_take(const LagRun *run, unsigned char *bytes)
{
    const Header header = {sizeof *run, run->memory_size, table_size(run), lag_history_size(&run->history), address(run),
                           address(run->memory)};
    const size_t rows = (size_t)run->inputs.rows;
    unsigned char *place = append(bytes, &header, sizeof header);
    place = append(place, run, sizeof *run);
    place = append(place, run->memory, run->memory_size * sizeof(double));
    place = append(place, run->inputs.times, rows * sizeof(double));
    place = append(place, run->inputs.values, rows * (size_t)run->inputs.n * sizeof(double));
    lag_history_save(&run->history, place);
    place += lag_history_size(&run->history) * sizeof(double);
    for (int k = 0; k < run->methods.islands.count; ++k) {
        const LagRun *island = run->methods.islands.runs[k];
        const uint64_t size = lag_snapshot_size(island);
        place = append(place, &size, sizeof size);
        lag_snapshot_take(island, place);
        place += size;
    }
}

static uint64_t read_word(const void *base, size_t k)
{
    uint64_t word;
    memcpy(&word, (const unsigned char *)base + k * WORD, WORD);
    return word;
}

static int is_near(uint64_t word, const void *place)
{
    const uint64_t there = address(place);
    return word >= LOWEST && (word > there ? word - there : there - word) < REACH;
}

/* A word of the saved struct in the terms of `run`; first and second are runs just made. */
static uint64_t moved(const Header *header, const LagRun *run, const LagRun *first, const LagRun *second, uint64_t saved, size_t k)
{
    const uint64_t fresh = read_word(first, k);
    if (fresh == read_word(second, k)) /* of constants and code: where they are in this process */
        return is_near(fresh, run->model) || is_near(fresh, &REACH) ? fresh : saved;
    if (saved - header->memory <= header->memory_size * sizeof(double))
        return address(run->memory) + (saved - header->memory);
    if (saved - header->run < header->struct_size)
        return address(run) + (saved - header->run);
    return saved;
}

static int relocate(const Header *header, const LagRun *run, const LagRun *saved_struct, LagRun *result)
{
    LagRun *first = lag_run_new(run->model, &saved_struct->settings), *second = lag_run_new(run->model, &saved_struct->settings);
    const int made = first && second;
    for (size_t k = 0; made && k < sizeof *run / WORD; ++k) {
        const uint64_t word = moved(header, run, first, second, read_word(saved_struct, k), k);
        memcpy((unsigned char *)result + k * WORD, &word, WORD);
    }
    lag_run_free(first);
    lag_run_free(second);
    return made;
}

/* The parts that belong to the run and not to its motion. */
static void keep_own(LagRun *result, const LagRun *run)
{
    const int rows = result->inputs.rows, left = result->inputs.left;
    result->model = run->model;
    result->memory = run->memory;
    result->block = run->block;
    result->inputs = run->inputs;
    result->inputs.rows = rows;
    result->inputs.left = left;
    result->motion.attitudes = run->motion.attitudes;
    result->scale.kind = run->scale.kind;
    result->retry.kept = run->retry.kept;
    result->retry.room = run->retry.room;
    result->retry.stop = run->retry.stop;
    result->retry.limit = run->retry.limit;
    result->methods.islands.runs = run->methods.islands.runs;
    result->methods.islands.count = run->methods.islands.count;
    result->history.pieces = run->history.pieces;
    result->history.marks = run->history.marks;
    result->history.first = run->history.first;
    result->history.capacity = run->history.capacity;
    result->history.mark_capacity = run->history.mark_capacity;
}

static LagStatus set_table(LagRun *run, const unsigned char *table, uint64_t count)
{
    const size_t rows = (size_t)count / (1 + (size_t)run->inputs.n);
    double *values = malloc((size_t)count * sizeof(double) + 1);
    LagStatus status = values ? LAG_OK : LAG_OUT_OF_MEMORY;
    if (status == LAG_OK && rows > 0) {
        memcpy(values, table, (size_t)count * sizeof(double));
        status = lag_inputs_set(&run->inputs, values, values + rows, (int)rows);
    }
    free(values);
    return status;
}

/* Numbers that the history of a saved struct had. */
static uint64_t saved_history(const LagRun *run, const LagRun *saved)
{
    LagHistory past = saved->history;
    past.n = run->history.n;
    return lag_history_size(&past);
}

/* Whether bytes are of this model and build, the run's own and those of its islands: `own` are the run's. */
static int fits(const LagRun *run, const unsigned char *bytes, size_t size, size_t *own)
{
    Header header;
    LagRun saved;
    if (size < sizeof header + sizeof saved)
        return 0;
    memcpy(&header, bytes, sizeof header);
    memcpy(&saved, bytes + sizeof header, sizeof saved);
    const size_t most = size / sizeof(double);
    if (header.struct_size != sizeof saved || header.memory_size != run->memory_size || header.table_size > most
        || header.history_size > most || header.history_size != saved_history(run, &saved)
        || header.table_size % (1 + (uint64_t)run->inputs.n) != 0)
        return 0;
    *own = sizeof header + sizeof saved + (run->memory_size + (size_t)(header.table_size + header.history_size)) * sizeof(double);
    size_t place = *own;
    for (int k = 0; k < run->methods.islands.count; ++k) {
        size_t inner;
        if (place > size || size - place < WORD)
            return 0;
        const uint64_t count = read_word(bytes + place, 0);
        place += WORD;
        if (count > size - place || !fits(run->methods.islands.runs[k], bytes + place, (size_t)count, &inner))
            return 0;
        place += (size_t)count;
    }
    return place == size;
}

static LagStatus restore_islands(LagRun *run, const unsigned char *place)
{
    LagStatus status = LAG_OK;
    for (int k = 0; k < run->methods.islands.count && status == LAG_OK; ++k) {
        const size_t count = (size_t)read_word(place, 0);
        status = lag_snapshot_restore(run->methods.islands.runs[k], place + WORD, count);
        place += WORD + count;
    }
    return status;
}

LagStatus lag_snapshot_restore(LagRun *run, const unsigned char *bytes, size_t size)
{
    Header header;
    LagRun saved, result;
    size_t own;
    if (!fits(run, bytes, size, &own))
        return LAG_BAD_SETTINGS;
    memcpy(&header, bytes, sizeof header);
    memcpy(&saved, bytes + sizeof header, sizeof saved);
    const unsigned char *vectors = bytes + sizeof header + sizeof saved;
    result = saved;
    if ((header.run != address(run) || header.memory != address(run->memory)) && !relocate(&header, run, &saved, &result))
        return LAG_OUT_OF_MEMORY;
    const unsigned char *table = vectors + run->memory_size * sizeof(double);
    LagStatus status = set_table(run, table, header.table_size);
    if (status == LAG_OK)
        status = restore_islands(run, bytes + own);
    if (status != LAG_OK)
        return status;
    if (header.history_size > 0 && !lag_history_load(&run->history, &saved.history, table + header.table_size * sizeof(double)))
        return LAG_OUT_OF_MEMORY;
    keep_own(&result, run);
    if (saved.methods.islands.inputs_version == saved.inputs.version)
        result.methods.islands.inputs_version = result.inputs.version;
    memcpy(run->memory, vectors, run->memory_size * sizeof(double));
    *run = result;
    lag_stepper_choose(run, saved.methods.solver);
    lag_retry_forget(run);
    return LAG_OK;
}
