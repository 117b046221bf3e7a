/* A scene that a page plays: play.c. Answers are those of LagAnswer; after one that is not 0 the message says why. */
#ifndef LAG_FMI_PLAY_H
#define LAG_FMI_PLAY_H

#include <stddef.h>

#include "model/model.h"

#define LAG_PLAY_TOKEN "page"
enum { LAG_IMAGE_SIZE_AT = 72 }; /* where the head of an image says how long it is */

typedef struct LagPlayer LagPlayer;

unsigned char *lag_play_room(size_t size);
/* The image becomes the player's. */
LagPlayer *lag_play_new(unsigned char *image);
const char *lag_play_message(LagPlayer *player);

/* Order of calls: reset, set of what is not as declared, begin; then steps, with inputs and parameters set between them. The digits
 * are those of a run to `stop`; steps may go on behind it. */
int lag_play_reset(LagPlayer *player);
int lag_play_set(LagPlayer *player, unsigned int reference, double value);
/* Inputs over time, linear between rows and held outside: times[rows], then rows of all inputs; the table stays the caller's, for good. An
 * input that is set is held. */
int lag_play_inputs(LagPlayer *player, double *table, int rows);
int lag_play_begin(LagPlayer *player, double tolerance, double stop);
int lag_play_step(LagPlayer *player, double h);

/* All numbers by value reference, up to the parameters; NULL when there are none. */
const double *lag_play_values(LagPlayer *player);
/* How many events there were since the last call, and their times, until the next step. */
const double *lag_play_events(LagPlayer *player);
/* The numbers of the drawing, at other positions where some are given. */
const double *lag_play_drawing(LagPlayer *player, const double *q);

#endif
