/* What is the same is found by a hash table with open addresses. */
#include "model/arrange.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "model/tape.h"

enum { FEWEST_TOGETHER = 4 }; /* sines: the library takes less time for three */

typedef struct {
    int32_t op, out, a, b;
} Instruction;

typedef struct {
    int32_t first, second;
} Pair;

typedef struct {
    int32_t count, n_constants, n_held, n_slots; /* n_slots is a power of 2 */
    Instruction *found, *ordered; /* operands by their places in the list */
    double *constants;
    int32_t *slots; /* 1 + places in `found`; 0 where there is none */
    int32_t *held;  /* what the places of the source hold */
    int32_t *level, *place, *number, *to_come, *list, *stack;
    Pair *pairs, *sines;
    int32_t n_ordered, n_sines;
} Arranged;

static void layout(Arranged *s, int32_t count, LagArena *arena)
{
    const size_t n = (size_t)count + 1;
    int32_t **const lists[] = {&s->level, &s->place, &s->number, &s->to_come, &s->list};
    s->found = (Instruction *)lag_take(arena, 2 * n);
    s->ordered = (Instruction *)lag_take(arena, 2 * n);
    s->pairs = (Pair *)lag_take(arena, n);
    s->sines = (Pair *)lag_take(arena, n);
    s->slots = lag_take_ints(arena, (size_t)s->n_slots);
    s->held = lag_take_ints(arena, (size_t)s->n_held);
    s->stack = lag_take_ints(arena, 3 * n);
    for (size_t i = 0; i < sizeof lists / sizeof *lists; ++i)
        *lists[i] = lag_take_ints(arena, n);
}

static int is_sine(int32_t op) { return op == LAG_OP_SIN || op == LAG_OP_COS; }

static int is_leaf(int32_t op) { return op == LAG_OP_INPUT || op == LAG_OP_CONST; }

/* -------- what is the same */

static int is_same(double x, double y) { return x == y && !signbit(x) == !signbit(y); }

static uint32_t mixed(uint32_t hash, uint32_t more) { return (hash ^ more) * 0x9e3779b1u ^ (hash >> 15); }

static uint32_t hash_of(const Instruction *i, const double *constant)
{
    uint32_t bits[2] = {(uint32_t)i->a, (uint32_t)i->b};
    if (constant)
        memcpy(bits, constant, sizeof bits);
    const uint32_t hash = mixed(mixed(mixed(17, (uint32_t)i->op), bits[0]), bits[1]);
    return hash ^ (hash >> 16);
}

/* The place of what is the same, which is added where there is none. `commutes`: operands may change places. */
static int32_t place_of(Arranged *s, Instruction made, int commutes, const double *constant)
{
    Instruction key = made;
    if (commutes && made.b < made.a) {
        key.a = made.b;
        key.b = made.a;
    }
    const uint32_t mask = (uint32_t)s->n_slots - 1;
    uint32_t slot = hash_of(&key, constant) & mask;
    for (; s->slots[slot]; slot = (slot + 1) & mask) {
        const Instruction *other = &s->found[s->slots[slot] - 1];
        const int is_alike = other->op == made.op && ((other->a == made.a && other->b == made.b)
                                                      || (commutes && other->a == made.b && other->b == made.a));
        if (constant ? other->op == made.op && is_same(s->constants[other->a], *constant) : is_alike)
            return s->slots[slot] - 1;
    }
    if (constant) {
        made.a = s->n_constants;
        s->constants[s->n_constants++] = *constant;
    }
    s->found[s->count] = made;
    s->slots[slot] = ++s->count;
    return s->count - 1;
}

/* 0 for an operation that tapes lack. */
static int find_values(Arranged *s, const int32_t *read, int32_t count, const int32_t *kinds, int32_t n_kinds)
{
    for (int32_t k = 0; k < count; ++k, read += 4) {
        const int32_t kind = read[0] >= 0 && read[0] < n_kinds ? kinds[read[0]] : -1, op = kind & LAG_ARRANGE_OP;
        if (kind < 0)
            return 0;
        if (op == LAG_OP_OUTPUT) {
            s->found[s->count++] = (Instruction){op, read[1], s->held[read[2]], read[3]};
        } else if (op == LAG_OP_INPUT) {
            s->held[read[1]] = place_of(s, (Instruction){op, 0, read[2], read[3]}, 0, NULL);
        } else if (op == LAG_OP_CONST) {
            double number;
            memcpy(&number, read + 2, sizeof number);
            s->held[read[1]] = place_of(s, (Instruction){op, 0, 0, 0}, 0, &number);
        } else {
            const int32_t a = s->held[read[2]], b = kind & LAG_ARRANGE_BINARY ? s->held[read[3]] : a;
            s->held[read[1]] = place_of(s, (Instruction){op, 0, a, b}, kind & LAG_ARRANGE_COMMUTES, NULL);
        }
    }
    return 1;
}

/* -------- sines together */

/* How many sines lie one within another in each, with itself. */
static void find_levels(Arranged *s)
{
    for (int32_t k = 0; k < s->count; ++k) {
        const Instruction *i = &s->found[k];
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
        const Instruction *i = &s->found[k];
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
    for (int32_t k = 0; k < s->count; ++k) {
        s->place[k] = s->number[k] = -1;
        if (is_sine(s->found[k].op))
            s->sines[s->n_sines++] = (Pair){s->level[k], k};
    }
    qsort(s->sines, (size_t)s->n_sines, sizeof *s->sines, ascending);
}

/* Those of one level: what they need, then sines and cosines of one angle after another. */
static void add_level(Arranged *s, const Pair *sines, int32_t count)
{
    int32_t angles = 0;
    for (int32_t i = 0; i < count; ++i) {
        const int32_t a = s->found[sines[i].second].a;
        if (s->number[a] == -1) {
            s->stack[angles] = a;
            s->number[a] = angles++;
        }
    }
    add_needed(s, angles);
    for (int32_t i = 0; i < count; ++i)
        s->pairs[i] = (Pair){s->number[s->found[sines[i].second].a], sines[i].second};
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
    for (int32_t k = 0; k < s->count; ++k)
        if (s->place[k] == -1)
            add(s, k);
    for (int32_t j = 0; j < s->count; ++j) {
        Instruction i = s->found[s->list[j]];
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
    for (int32_t k = 0; k < s->count; ++k)
        s->level[k] = 0;
    for (int32_t k = 0; k < s->count; ++k) {
        const Instruction *i = &s->ordered[k];
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
    for (int32_t k = 0; k < s->count; ++k, code += 4) {
        Instruction i = s->ordered[k];
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

static int32_t places_in(const int32_t *read, int32_t count)
{
    int32_t most = 0;
    for (int32_t k = 0; k < count; ++k)
        most = read[4 * k + 1] > most ? read[4 * k + 1] : most;
    return most + 1;
}

int lag_arrange(const int32_t *read, int32_t count, const int32_t *kinds, int32_t n_kinds, int32_t *code, double *constants,
                int32_t *sizes)
{
    Arranged s = {.n_held = places_in(read, count), .n_slots = 2, .constants = constants};
    while (s.n_slots < 2 * count)
        s.n_slots *= 2;
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
        sizes[0] = s.count;
        sizes[1] = s.n_constants;
        sizes[2] = put(&s, code);
    }
    free(block);
    return is_known ? LAG_ARRANGED : LAG_ARRANGE_UNKNOWN;
}
