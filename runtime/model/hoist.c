#include "model/hoist.h"

#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "model/numbering.h"
#include "model/tape.h"

enum { NONE = -1 };

/* What a place of a program holds. It moves where there is neither a value nor a leaf. */
typedef struct {
    int32_t value; /* its number; NONE for leaves that nobody asked for yet, too */
    const int32_t *leaf; /* a constant, or a hoisted value that is there */
    int is_loaded;
} Held;

typedef struct {
    LagNumbering values; /* with what gives results among the rest: the program of hoisted values */
    double *constants; /* of these */
    Held *held;
    int32_t *slot; /* by the number of a value, its place among the hoisted ones, or NONE */
    int32_t *named; /* the first hoisted values, by their numbers */
    int32_t settled, n_hoisted, n_held;
    int32_t offset; /* of the parameters among the inputs that do not move */
    int32_t op_input, op_output; /* of the source */
    const int32_t *kinds;
    int32_t n_kinds;
    int32_t *end; /* of what is written */
} Hoisting;

static void layout(Hoisting *s, int32_t count, LagArena *arena)
{
    const size_t n = 2 * (size_t)count + 1;
    lag_numbering_layout(&s->values, 2 * count, arena);
    s->constants = lag_take(arena, n);
    s->held = (Held *)lag_take(arena, (sizeof *s->held / sizeof(double) + 1) * (size_t)s->n_held);
    s->slot = lag_take_ints(arena, n);
    s->named = lag_take_ints(arena, (size_t)s->settled + 1);
}

static void write(Hoisting *s, int32_t op, int32_t out, int32_t a, int32_t b)
{
    const int32_t made[] = {op, out, a, b};
    memcpy(s->end, made, sizeof made);
    s->end += 4;
}

static int kind_of(const Hoisting *s, int32_t op) { return op >= 0 && op < s->n_kinds ? s->kinds[op] : -1; }

static int32_t number(Hoisting *s, LagInstruction made, int commutes, const double *constant)
{
    const int32_t before = s->values.count, found = lag_number(&s->values, made, commutes, constant);
    if (found == before)
        s->slot[found] = NONE;
    return found;
}

/* The number of what a place holds; NONE for what moves. */
static int32_t value_at(Hoisting *s, int32_t place)
{
    Held *held = &s->held[place];
    if (held->value != NONE || !held->leaf)
        return held->value;
    const int32_t *leaf = held->leaf;
    if ((kind_of(s, leaf[0]) & LAG_ARRANGE_OP) == LAG_OP_CONST) {
        double constant;
        memcpy(&constant, leaf + 2, sizeof constant);
        held->value = number(s, (LagInstruction){leaf[0], 0, 0, 0}, 0, &constant);
    } else if (leaf[3] < s->offset) {
        held->value = s->named[leaf[3]];
    } else {
        held->value = number(s, (LagInstruction){leaf[0], 0, 0, leaf[3] - s->offset}, 0, NULL);
    }
    return held->value;
}

/* A value becomes a hoisted one, if it is none yet. */
static int32_t slot_of(Hoisting *s, int32_t value)
{
    if (s->slot[value] == NONE) {
        s->slot[value] = s->n_hoisted++;
        s->values.found[s->values.count++] = (LagInstruction){s->op_output, 0, value, s->slot[value]};
    }
    return s->slot[value];
}

/* Puts what a place holds there, for an instruction that moves. */
static void load(Hoisting *s, int32_t place, int32_t argument)
{
    Held *held = &s->held[place];
    if (held->is_loaded || (held->value == NONE && !held->leaf))
        return;
    held->is_loaded = 1;
    if (held->leaf && (kind_of(s, held->leaf[0]) & LAG_ARRANGE_OP) == LAG_OP_CONST)
        write(s, held->leaf[0], place, held->leaf[2], held->leaf[3]);
    else
        write(s, s->op_input, place, argument, slot_of(s, value_at(s, place)));
}

static void compute(Hoisting *s, const int32_t *i, int32_t kind, int32_t argument)
{
    const int is_binary = (kind & LAG_ARRANGE_BINARY) != 0;
    const int32_t a = value_at(s, i[2]), b = is_binary ? value_at(s, i[3]) : a;
    Held made = {NONE, NULL, 0};
    if (a != NONE && b != NONE) {
        made.value = number(s, (LagInstruction){i[0], 0, a, b}, kind & LAG_ARRANGE_COMMUTES, NULL);
    } else {
        load(s, i[2], argument);
        if (is_binary)
            load(s, i[3], argument);
        write(s, i[0], i[1], i[2], i[3]);
    }
    s->held[i[1]] = made;
}

/* The first program: the values that stay. */
static void name(Hoisting *s, const int32_t *i)
{
    if (i[3] >= s->settled)
        return;
    const int32_t value = s->named[i[3]] = value_at(s, i[2]);
    if (s->slot[value] == NONE)
        s->slot[value] = i[3];
    s->values.found[s->values.count++] = (LagInstruction){i[0], 0, value, i[3]};
}

/* 0 for an operation that tapes lack. */
static int pass(Hoisting *s, const int32_t *read, int32_t count, int32_t argument, int is_first)
{
    s->offset = is_first ? 0 : s->settled;
    for (int32_t k = 0; k < s->n_held; ++k)
        s->held[k] = (Held){NONE, NULL, 0};
    for (const int32_t *i = read; i < read + 4 * count; i += 4) {
        const int32_t kind = kind_of(s, i[0]), op = kind & LAG_ARRANGE_OP;
        if (kind < 0)
            return 0;
        if (op == LAG_OP_CONST || (op == LAG_OP_INPUT && i[2] == argument)) {
            s->held[i[1]] = (Held){NONE, i, 0};
        } else if (op == LAG_OP_INPUT) {
            s->held[i[1]] = (Held){NONE, NULL, 0};
            write(s, i[0], i[1], i[2], i[3]);
        } else if (op == LAG_OP_OUTPUT && is_first) {
            name(s, i);
        } else if (op == LAG_OP_OUTPUT) {
            load(s, i[2], argument);
            write(s, i[0], i[1], i[2], i[3]);
        } else {
            compute(s, i, kind, argument);
        }
    }
    return 1;
}

/* The program of hoisted values: each has a place of its own. */
static void write_hoisted(Hoisting *s)
{
    for (int32_t k = 0; k < s->values.count; ++k) {
        const LagInstruction *i = &s->values.found[k];
        if ((kind_of(s, i->op) & LAG_ARRANGE_OP) == LAG_OP_CONST) {
            int32_t bits[2];
            memcpy(bits, &s->constants[i->a], sizeof bits);
            write(s, i->op, k, bits[0], bits[1]);
        } else {
            write(s, i->op, i->op == s->op_output ? i->out : k, i->a, i->b);
        }
    }
}

static int32_t op_of(const int32_t *kinds, int32_t n_kinds, int32_t wanted)
{
    int32_t op = 0;
    while (op < n_kinds && (kinds[op] < 0 || (kinds[op] & LAG_ARRANGE_OP) != wanted))
        ++op;
    return op;
}

static int pass_all(Hoisting *s, const int32_t *read, const int32_t *counts, const int32_t *arguments, int32_t n_programs,
                    int32_t *sizes)
{
    for (int32_t k = 0; k < n_programs; ++k) {
        const int32_t *const begin = s->end;
        if (!pass(s, read, counts[k], arguments[k], k == 0))
            return 0;
        if (k > 0)
            *sizes++ = (int32_t)((s->end - begin) / 4);
        read += 4 * counts[k];
    }
    write_hoisted(s);
    sizes[0] = s->values.count;
    sizes[1] = s->n_hoisted;
    return 1;
}

int lag_hoist(const int32_t *read, const int32_t *counts, const int32_t *arguments, int32_t n_programs, int32_t settled,
              const int32_t *kinds, int32_t n_kinds, int32_t *written, int32_t *sizes)
{
    Hoisting s = {.settled = settled, .n_hoisted = settled, .kinds = kinds, .n_kinds = n_kinds, .end = written};
    int32_t count = 0;
    for (int32_t k = 0; k < n_programs; ++k)
        count += counts[k];
    s.n_held = lag_count_places(read, count);
    s.op_input = op_of(kinds, n_kinds, LAG_OP_INPUT);
    s.op_output = op_of(kinds, n_kinds, LAG_OP_OUTPUT);
    LagArena arena = {NULL, 0};
    layout(&s, count, &arena);
    double *block = calloc(arena.used + 1, sizeof *block);
    if (!block)
        return LAG_ARRANGE_NO_MEMORY;
    arena = (LagArena){block, 0};
    layout(&s, count, &arena);
    s.values.constants = s.constants;
    const int is_known = pass_all(&s, read, counts, arguments, n_programs, sizes);
    free(block);
    return is_known ? LAG_ARRANGED : LAG_ARRANGE_UNKNOWN;
}
