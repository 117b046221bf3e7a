/* A scene as it lies in memory: the structures and vectors of a LagFmu behind a head, as compiler/lagrangia/fmu/stored.py writes
 * them for this version of the run time and this size of pointers. */
#ifndef LAG_FMI_IMAGE_H
#define LAG_FMI_IMAGE_H

#include <stddef.h>

#include "fmi/fmu.h"

/* Checks the image and sets its pointers, once. NULL, or what is wrong with it: "is damaged". */
const char *lag_image_open(unsigned char *bytes, size_t size, const LagFmu **fmu);

#endif
