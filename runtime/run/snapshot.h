/* A run's whole state as bytes, to come back to: afterwards it goes on as it went on then, bit for bit.
 *
 * All pointers inside a run are set when it is made and only change places among themselves afterwards (vectors are swapped,
 * never allocated). So the words that hold addresses are those in which two runs just made differ; in a copy they are moved
 * to the memory of the run that takes it over, in this process or in another one.
 */
#ifndef LAG_SNAPSHOT_H
#define LAG_SNAPSHOT_H

#include "run/run.h"

/* Bytes; it may grow with the table of inputs only. */
LAG_API size_t lag_snapshot_size(const LagRun *run);
LAG_API void lag_snapshot_take(const LagRun *run, unsigned char *bytes);

/* `run` has the same model as the one that was saved. Returns LAG_OK, LAG_OUT_OF_MEMORY or, for bytes of another model or
 * build, LAG_BAD_SETTINGS; then the run stays as it was. */
LAG_API LagStatus lag_snapshot_restore(LagRun *run, const unsigned char *bytes, size_t size);

#endif
