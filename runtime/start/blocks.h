/* Equations of start values solved one block after another. */
#ifndef LAG_BLOCKS_H
#define LAG_BLOCKS_H

#include "base/arena.h"
#include "start/newton.h"

typedef struct {
    int count;
    int *block;    /* n_initial: of an equation, -1: not looked at */
    int *owner;    /* 2 n: the block that moves a value, -1: none */
    int *open;     /* n_initial: of how many values that nobody owns an equation speaks */
    int *moved;    /* n_initial: whether it speaks of any that may move */
    int *first;    /* 2 n + 1: equations[first[j]] .. equations[first[j + 1] - 1] speak of value j, where it may move */
    int *equations;
    double *scale; /* 2 n: those of newton.h, while a block moves */
} LagBlocks;

void lag_blocks_layout(LagBlocks *blocks, const LagModel *model, LagArena *arena);

/* Finds the blocks of the equations that are looked at, of the values that may move. Returns their number. */
int lag_blocks_find(LagBlocks *blocks, const LagNewton *newton);

/* Measures and solves the blocks found last, each by its own values, the others where they are, at last all together. Returns -1,
 * or an equation of the first block that fails. */
int lag_blocks_solve(LagBlocks *blocks, LagNewton *newton, const double *p, const int *fixed, int way, int most_iterations,
                     int most_pushes, double *x, double *work);

#endif
