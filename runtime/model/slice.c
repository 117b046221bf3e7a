/* An instruction's operands are what was written last before it (M. Weiser, Program slicing, IEEE Trans. Software Eng. 10, 1984).
 * Sines and cosines that are computed together read all their angles first, and are as many as the slice has of them.
 */
#include "model/slice.h"

#include <stdlib.h>
#include <string.h>

enum { FIELDS = 4 };

void lag_slicer_layout(LagSlicer *s, const LagFunction *function, LagArena *arena)
{
    s->function = function;
    if (!lag_has_slices(function))
        return;
    const size_t count = (size_t)function->tape->n_instructions;
    size_t outputs = 0;
    for (int k = 0; k < function->n_out; ++k)
        outputs += (size_t)function->out_size[k];
    s->from = lag_take_ints(arena, 2 * count);
    s->output = lag_take_ints(arena, outputs);
    s->first = lag_take_ints(arena, (size_t)function->n_out);
    s->mark = lag_take_ints(arena, count);
    s->found = lag_take_ints(arena, count > function->n_work ? count : function->n_work);
}

static int is_sine(const int32_t *instruction) { return instruction[0] == LAG_OP_SIN || instruction[0] == LAG_OP_COS; }

/* How many instructions from this one on read their operands before any of them writes. */
static int together(const int32_t *instruction)
{
    if (!is_sine(instruction) || instruction[3] < 1)
        return 1;
    return instruction[3] < LAG_MOST_SINES ? instruction[3] : LAG_MOST_SINES;
}

static void read_operands(LagSlicer *s, const int *writer, int i)
{
    const int32_t *instruction = s->function->tape->code + FIELDS * i;
    const int32_t op = instruction[0];
    const int reads = op != LAG_OP_INPUT && op != LAG_OP_CONST, reads_both = reads && op != LAG_OP_OUTPUT && !is_sine(instruction);
    s->from[2 * i] = reads ? writer[instruction[2]] : -1;
    s->from[2 * i + 1] = reads_both ? writer[instruction[3]] : -1;
}

static void note_result(LagSlicer *s, int *writer, int i)
{
    const int32_t *instruction = s->function->tape->code + FIELDS * i;
    if (instruction[0] == LAG_OP_OUTPUT)
        s->output[s->first[instruction[1]] + instruction[3]] = i;
    else
        writer[instruction[1]] = i;
}

void lag_slicer_begin(LagSlicer *s)
{
    const LagTape *tape = s->function->tape;
    int *writer = s->found, outputs = 0;
    for (int k = 0; k < s->function->n_out; outputs += s->function->out_size[k++])
        s->first[k] = outputs;
    for (int k = 0; k < outputs; ++k)
        s->output[k] = -1;
    for (size_t i = 0; i < s->function->n_work; ++i)
        writer[i] = -1;
    memset(s->mark, 0, (size_t)tape->n_instructions * sizeof *s->mark);
    s->slices = 0;
    for (int32_t i = 0; i < tape->n_instructions;) {
        const int end = i + together(tape->code + FIELDS * i);
        for (int k = i; k < end; ++k)
            read_operands(s, writer, k);
        for (; i < end; ++i)
            note_result(s, writer, i);
    }
}

void lag_slice_layout(LagSlice *slice, const LagFunction *function, LagArena *arena)
{
    if (lag_has_slices(function))
        slice->code = lag_take_ints(arena, FIELDS * (size_t)function->tape->n_instructions);
}

void lag_slice_begin(LagSlicer *s, LagSlice *slice)
{
    slice->tape = *s->function->tape;
    slice->tape.code = slice->code;
    slice->tape.n_instructions = 0;
    ++s->slices;
}

static void take(LagSlicer *s, LagTape *slice, int i)
{
    if (i < 0 || s->mark[i] == s->slices)
        return;
    s->mark[i] = s->slices;
    s->found[slice->n_instructions++] = i;
}

void lag_slice_add(LagSlicer *s, LagSlice *slice, int output, int element)
{
    LagTape *tape = &slice->tape;
    int32_t next = tape->n_instructions;
    take(s, tape, s->output[s->first[output] + element]);
    for (; next < tape->n_instructions; ++next) {
        const int *from = s->from + 2 * s->found[next];
        take(s, tape, from[0]);
        take(s, tape, from[1]);
    }
}

static int by_number(const void *a, const void *b)
{
    const int i = *(const int *)a, j = *(const int *)b;
    return (i > j) - (i < j);
}

/* Whether two sines or cosines of the tape are computed together. */
static int are_together(const int32_t *code, int i, int j)
{
    const int32_t left = code[FIELDS * i + 3], later = code[FIELDS * j + 3];
    return is_sine(code + FIELDS * j) && later > 0 && left - later == j - i;
}

void lag_slice_end(LagSlicer *s, LagSlice *slice)
{
    const int32_t *code = s->function->tape->code;
    const int32_t count = slice->tape.n_instructions;
    qsort(s->found, (size_t)count, sizeof *s->found, by_number);
    for (int32_t k = count - 1; k >= 0; --k) {
        int32_t *to = slice->code + FIELDS * k;
        memcpy(to, code + FIELDS * s->found[k], FIELDS * sizeof *to);
        if (is_sine(to) && to[3] > 0)
            to[3] = k + 1 < count && are_together(code, s->found[k], s->found[k + 1]) ? to[FIELDS + 3] + 1 : 1;
    }
}
