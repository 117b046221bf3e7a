/* Lines of numbers in a text -> doubles. */
#ifndef LAG_READ_NUMBERS_H
#define LAG_READ_NUMBERS_H

#include <stdint.h>

#include "model/model.h"

/* Cells of `width` numbers a line, between delimiters; 0: between spaces and tabs. `decimal` is '.' or ','. Lines that are empty or
 * begin with # or % are none. `text` ends with 0. Returns the rows read, at most `most`; or -1 - k when line k, counted from 0, has
 * another number of cells, or something that is no finite number. */
LAG_API int64_t lag_read_numbers(const char *text, int delimiter, int decimal, int width, double *values, int64_t most);

#endif
