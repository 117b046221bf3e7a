#include "numbers/heap.h"

void lag_heap_layout(LagHeap *s, size_t items, LagArena *arena)
{
    s->key = lag_take(arena, items);
    s->item = lag_take_ints(arena, items);
    s->place = lag_take_ints(arena, items);
}

static int is_before(const LagHeap *s, int a, int b) { return s->key[a] < s->key[b] || (s->key[a] == s->key[b] && a < b); }

static void set(LagHeap *s, int place, int item)
{
    s->item[place] = item;
    s->place[item] = place;
}

static void rise(LagHeap *s, int item)
{
    int place = s->place[item];
    for (; place > 0 && is_before(s, item, s->item[(place - 1) / 2]); place = (place - 1) / 2)
        set(s, place, s->item[(place - 1) / 2]);
    set(s, place, item);
}

static void sink(LagHeap *s, int item)
{
    int place = s->place[item];
    for (int next = 2 * place + 1; next < s->size; next = 2 * place + 1) {
        if (next + 1 < s->size && is_before(s, s->item[next + 1], s->item[next]))
            ++next;
        if (!is_before(s, s->item[next], item))
            break;
        set(s, place, s->item[next]);
        place = next;
    }
    set(s, place, item);
}

void lag_heap_fill(LagHeap *s, int items)
{
    s->size = items;
    for (int k = 0; k < items; ++k)
        set(s, k, k);
    for (int k = items / 2 - 1; k >= 0; --k)
        sink(s, s->item[k]);
}

void lag_heap_put(LagHeap *s, int item)
{
    set(s, s->size++, item);
    rise(s, item);
}

void lag_heap_take(LagHeap *s, int item)
{
    const int last = s->item[--s->size], place = s->place[item];
    if (last == item)
        return;
    set(s, place, last);
    lag_heap_update(s, last);
}

void lag_heap_update(LagHeap *s, int item)
{
    rise(s, item);
    sink(s, item);
}
