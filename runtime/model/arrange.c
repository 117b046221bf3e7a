#include "model/arrange.h"

#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "model/numbering.h"
#include "model/tape.h"

enum { FEWEST_TOGETHER = 4 }; /* sines: the library takes less time for three */

typedef struct {
    int32_t first, second;
} Pair;

typedef struct {
    LagNumbering known; /* with what gives results among the rest */
    LagInstruction *ordered; /* operands by their places in the list */
    int32_t *held; /* what the places of the source hold */
    int32_t n_held;
    int32_t *level, *place, *number, *to_come, *list, *stack;
    Pair *pairs, *sines;
    int32_t n_ordered, n_sines;
} Arranged;

static void layout(Arranged *s, int32_t count, LagArena *arena)
{
    const size_t n = (size_t)count + 1;
    int32_t **const lists[] = {&s->level, &s->place, &s->number, &s->to_come, &s->list};
    lag_numbering_layout(&s->known, count, arena);
    s->ordered = (LagInstruction *)lag_take(arena, 2 * n);
    s->pairs = (Pair *)lag_take(arena, n);
    s->sines = (Pair *)lag_take(arena, n);
    s->held = lag_take_ints(arena, (size_t)s->n_held);
    s->stack = lag_take_ints(arena, 3 * n);
    for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i)
        *lists[i] = lag_take_ints(arena, n);
}

static int is_sine(int32_t op) { return op == LAG_OP_SIN || op == LAG_OP_COS; }

static int is_leaf(int32_t op) { return op == LAG_OP_INPUT || op == LAG_OP_CONST; }

/* -------- what is the same */

/* 0 for an operation that tapes lack. */
static int find_values(Arranged *s, const int32_t *read, int32_t count, const int32_t *kinds, int32_t n_kinds)
{
    for (int32_t k = 0; k < count; ++k, read += 4) {
        const int32_t kind = read[0] >= 0 && read[0] < n_kinds ? kinds[read[0]] : -1, op = kind & LAG_ARRANGE_OP;
        if (kind < 0)
            return 0;
        if (op == LAG_OP_OUTPUT) {
            s->known.found[s->known.count++] = (LagInstruction){op, read[1], s->held[read[2]], read[3]};
        } else if (op == LAG_OP_INPUT) {
            s->held[read[1]] = lag_number(&s->known, (LagInstruction){op, 0, read[2], read[3]}, 0, NULL);
        } else if (op == LAG_OP_CONST) {
            double number;
            memcpy(&number, read + 2, sizeof number);
            s->held[read[1]] = lag_number(&s->known, (LagInstruction){op, 0, 0, 0}, 0, &number);
        } else {
            const int32_t a = s->held[read[2]], b = kind & LAG_ARRANGE_BINARY ? s->held[read[3]] : a;
            s->held[read[1]] = lag_number(&s->known, (LagInstruction){op, 0, a, b}, kind & LAG_ARRANGE_COMMUTES, NULL);
        }
    }
    return 1;
}

/* -------- sines together */

/* How many sines lie one within another in each, with itself. */
static void find_levels(Arranged *s)
{
    for (int32_t k = 0; k < s->known.count; ++k) {
        const LagInstruction *i = &s->known.found[k];
        s->level[k] = 0;
        if (is_sine(i->op)) {
            s->level[k] = s->level[i->a] + 1;
        } else if (!is_leaf(i->op) && i->op != LAG_OP_OUTPUT) {
            s->level[k] = s->level[i->a] > s->level[i->b] ? s->level[i->a] : s->level[i->b];
        }
    }
}

static int ascending(const void *a, const void *b)
{
    const Pair *x = a, *y = b;
    if (x->first != y->first)
        return x->first < y->first ? -1 : 1;
    return x->second < y->second ? -1 : x->second > y->second;
}

static void add(Arranged *s, int32_t k)
{
    s->place[k] = s->n_ordered;
    s->list[s->n_ordered++] = k;
}

/* What has no place yet of all that these depend on, and they themselves, in their order. Uses up the list of those wanted. */
static void add_needed(Arranged *s, int32_t pending)
{
    int32_t n = 0;
    while (pending > 0) {
        const int32_t k = s->stack[--pending];
        if (s->place[k] != -1)
            continue;
        s->place[k] = -2; /* is among them */
        s->pairs[n++] = (Pair){0, k};
        const LagInstruction *i = &s->known.found[k];
        if (!is_leaf(i->op)) {
            if (s->place[i->a] == -1)
                s->stack[pending++] = i->a;
            if (i->b != i->a && s->place[i->b] == -1)
                s->stack[pending++] = i->b;
        }
    }
    qsort(s->pairs, (size_t)n, sizeof *s->pairs, ascending);
    for (int32_t i = 0; i < n; ++i)
        add(s, s->pairs[i].second);
}

/* Sines by their levels, of each level in their order. */
static void collect_sines(Arranged *s)
{
    for (int32_t k = 0; k < s->known.count; ++k) {
        s->place[k] = s->number[k] = -1;
        if (is_sine(s->known.found[k].op))
            s->sines[s->n_sines++] = (Pair){s->level[k], k};
    }
    qsort(s->sines, (size_t)s->n_sines, sizeof *s->sines, ascending);
}

/* Those of one level: what they need, then sines and cosines of one angle after another. */
static void add_level(Arranged *s, const Pair *sines, int32_t count)
{
    int32_t angles = 0;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t a = s->known.found[sines[i].second].a;
        if (s->number[a] == -1) {
            s->stack[angles] = a;
            s->number[a] = angles++;
        }
    }
    add_needed(s, angles);
    for (int32_t i = 0; i < count; ++i)
        s->pairs[i] = (Pair){s->number[s->known.found[sines[i].second].a], sines[i].second};
    qsort(s->pairs, (size_t)count, sizeof *s->pairs, ascending);
    for (int32_t i = 0; i < count; ++i) {
        s->to_come[s->pairs[i].second] = count >= FEWEST_TOGETHER ? count - i : 0;
        add(s, s->pairs[i].second);
    }
}

/* The same in another order: what the sines of the first level need, then these, and so on; at last the rest. */
static void order(Arranged *s)
{
    find_levels(s);
    collect_sines(s);
    for (int32_t first = 0, next = 0; first < s->n_sines; first = next) {
        while (next < s->n_sines && s->sines[next].first == s->sines[first].first)
            ++next;
        add_level(s, s->sines + first, next - first);
    }
    for (int32_t k = 0; k < s->known.count; ++k)
        if (s->place[k] == -1)
            add(s, k);
    for (int32_t j = 0; j < s->known.count; ++j) {
        LagInstruction i = s->known.found[s->list[j]];
        if (!is_leaf(i.op)) {
            i.a = s->place[i.a];
            i.b = i.op == LAG_OP_OUTPUT ? i.b : is_sine(i.op) ? s->to_come[s->list[j]] : s->place[i.b];
        }
        s->ordered[j] = i;
    }
}

/* -------- places of w */

/* The last reader of each, in `level`. */
static void find_readers(Arranged *s)
{
    for (int32_t k = 0; k < s->known.count; ++k)
        s->level[k] = 0;
    for (int32_t k = 0; k < s->known.count; ++k) {
        const LagInstruction *i = &s->ordered[k];
        if (is_leaf(i->op))
            continue;
        s->level[i->a] = k;
        if (i->op != LAG_OP_OUTPUT && !is_sine(i->op))
            s->level[i->b] = k;
    }
}

/* A place is free for others after its last reader; returns the size of w. */
static int32_t put(Arranged *s, int32_t *code)
{
    int32_t n_free = 0, size = 0;
    find_readers(s);
    for (int32_t k = 0; k < s->known.count; ++k, code += 4) {
        LagInstruction i = s->ordered[k];
        const int32_t a = i.a, b = i.b, reads_two = !is_leaf(i.op) && i.op != LAG_OP_OUTPUT && !is_sine(i.op);
        if (!is_leaf(i.op))
            i.a = s->place[a];
        if (reads_two) {
            i.b = s->place[b];
            if (s->level[b] == k && a != b)
                s->stack[n_free++] = i.b;
        }
        if (!is_leaf(i.op) && s->level[a] == k)
            s->stack[n_free++] = i.a;
        if (i.op != LAG_OP_OUTPUT)
            i.out = n_free > 0 ? s->stack[--n_free] : size++;
        s->place[k] = i.out;
        code[0] = i.op;
        code[1] = i.out;
        code[2] = i.a;
        code[3] = i.b;
    }
    return size > 1 ? size : 1;
}

/* -------- all of it */

int lag_arrange(const int32_t *read, int32_t count, const int32_t *kinds, int32_t n_kinds, int32_t *code, double *constants,
                int32_t *sizes)
{
    Arranged s = {.n_held = lag_count_places(read, count), .known.constants = constants};
    LagArena arena = {NULL, 0};
    layout(&s, count, &arena);
    double *block = calloc(arena.used + 1, sizeof *block);
    if (!block)
        return LAG_ARRANGE_NO_MEMORY;
    arena = (LagArena){block, 0};
    layout(&s, count, &arena);
    const int is_known = find_values(&s, read, count, kinds, n_kinds);
    if (is_known) {
        order(&s);
        sizes[0] = s.known.count;
        sizes[1] = s.known.n_constants;
        sizes[2] = put(&s, code);
    }
    free(block);
    return is_known ? LAG_ARRANGED : LAG_ARRANGE_UNKNOWN;
}
