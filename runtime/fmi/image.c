/* Where one structure of the image points to another stands, in as many bytes as a pointer has, the distance of that one from the
 * beginning of the image; all such places are listed at its end. */
#include "fmi/image.h"

#include <stdint.h>
#include <string.h>

#if !defined(LAG_BUILD)
#define LAG_BUILD "unknown"
#endif

enum { BUILD_SIZE = 64 };

typedef struct {
    char magic[8], build[BUILD_SIZE];
    uint64_t size, checksum;            /* of the file, of all behind the head */
    uint64_t fmu_size, model_size;      /* sizeof LagFmu, LagModel */
    uint64_t root;                      /* of the LagFmu */
    uint64_t n_pointers, pointers;      /* places that hold distances, and where they are listed */
} Head;

/* Adler-32 (RFC 1950). */
static uint64_t checksum(const unsigned char *bytes, size_t size)
{
    uint64_t sum = 1, sums = 0;
    for (size_t i = 0; i < size; ++i) {
        sum = (sum + bytes[i]) % 65521;
        sums = (sums + sum) % 65521;
    }
    return sums << 16 | sum;
}

/* NULL when it belongs to this library as a whole, else what is wrong. */
static const char *fault(const Head *head, const unsigned char *bytes, size_t size)
{
    if (memcmp(head->magic, "LAGFMU\0\1", sizeof head->magic) != 0)
        return "is no scene of Lagrangia";
    if (strncmp(head->build, LAG_BUILD, BUILD_SIZE) != 0 || head->fmu_size != sizeof(LagFmu) || head->model_size != sizeof(LagModel))
        return "was written for the library of another version";
    if (head->size != size || size % 8 != 0 || head->checksum != checksum(bytes + sizeof *head, size - sizeof *head))
        return "is damaged";
    return NULL;
}

/* 0 when a place, or what it points to, is not in the file. */
static int set_pointers(const Head *head, unsigned char *bytes, size_t size)
{
    if (head->root % 8 != 0 || head->root > size - sizeof(LagFmu) || head->pointers % 8 != 0 || head->pointers > size
        || head->n_pointers > (size - head->pointers) / 8)
        return 0;
    for (uint64_t k = 0; k < head->n_pointers; ++k) {
        uint64_t place;
        uintptr_t distance;
        memcpy(&place, bytes + head->pointers + 8 * k, 8);
        if (place % sizeof distance != 0 || place > head->pointers - sizeof distance)
            return 0;
        memcpy(&distance, bytes + place, sizeof distance);
        if (distance >= size)
            return 0;
        const void *target = bytes + distance;
        memcpy(bytes + place, &target, sizeof target);
    }
    return 1;
}

const char *lag_image_open(unsigned char *bytes, size_t size, const LagFmu **fmu)
{
    Head head;
    if (size < sizeof head + sizeof(LagFmu))
        return "is damaged";
    memcpy(&head, bytes, sizeof head);
    const char *wrong = fault(&head, bytes, size);
    if (wrong)
        return wrong;
    if (!set_pointers(&head, bytes, size))
        return "is damaged";
    *fmu = (const LagFmu *)(const void *)(bytes + head.root);
    return NULL;
}
