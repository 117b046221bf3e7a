/* A hash table with open addresses. */
#include "model/numbering.h"

#include <math.h>
#include <string.h>

void lag_numbering_layout(LagNumbering *s, int32_t count, LagArena *arena)
{
    s->n_slots = 2;
    while (s->n_slots < 2 * count)
        s->n_slots *= 2;
    s->found = (LagInstruction *)lag_take(arena, 2 * ((size_t)count + 1));
    s->slots = lag_take_ints(arena, (size_t)s->n_slots);
}

static int is_same(double x, double y) { return x == y && !signbit(x) == !signbit(y); }

static uint32_t mixed(uint32_t hash, uint32_t more) { return (hash ^ more) * 0x9e3779b1u ^ (hash >> 15); }

static uint32_t hash_of(const LagInstruction *i, const double *constant)
{
    uint32_t bits[2] = {(uint32_t)i->a, (uint32_t)i->b};
    if (constant)
        memcpy(bits, constant, sizeof bits);
    const uint32_t hash = mixed(mixed(mixed(17, (uint32_t)i->op), bits[0]), bits[1]);
    return hash ^ (hash >> 16);
}

int32_t lag_number(LagNumbering *s, LagInstruction made, int commutes, const double *constant)
{
    LagInstruction key = made;
    if (commutes && made.b < made.a) {
        key.a = made.b;
        key.b = made.a;
    }
    const uint32_t mask = (uint32_t)s->n_slots - 1;
    uint32_t slot = hash_of(&key, constant) & mask;
    for (; s->slots[slot]; slot = (slot + 1) & mask) {
        const LagInstruction *other = &s->found[s->slots[slot] - 1];
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

int32_t lag_count_places(const int32_t *read, int32_t count)
{
    int32_t most = 0;
    for (int32_t k = 0; k < count; ++k)
        most = read[4 * k + 1] > most ? read[4 * k + 1] : most;
    return most + 1;
}
