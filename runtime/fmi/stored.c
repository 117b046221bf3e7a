/* An FMU whose scene is a file: what compiler/lagrangia/fmu/stored.py wrote for this library, as it lies in memory.
 *
 * Behind the head lie structures and vectors as C has them; where one points to another stands the distance of that one from
 * the beginning of the file. So the whole is read into one piece of memory, checked, and all pointers are set. Every instance has
 * its own: libraries of several FMUs, and instances in several threads, share nothing.
 */
#include "fmi/opening.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if !defined(LAG_BUILD)
#define LAG_BUILD "unknown"
#endif

static const char FILE_NAME[] = "/scene.tape";
enum { LONGEST_PATH = 4096, BUILD_SIZE = 64 };

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

static int digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The path of a URI file:/..., file:///... or file://localhost/..., its escapes decoded; of Windows without the first slash. What is
 * no URI is a path. 0: it is too long. */
static int path_of(const char *resources, char *path)
{
    const int is_uri = strncmp(resources, "file:", 5) == 0;
    const char *from = is_uri ? resources + 5 : resources;
    if (is_uri && from[0] == '/' && from[1] == '/') {
        const char *root = strchr(from + 2, '/');
        from = root ? root : from + 2;
    }
    if (is_uri && from[0] == '/' && from[1] && (from[2] == ':' || from[2] == '|'))
        ++from;
    size_t used = 0;
    while (*from && used < LONGEST_PATH) {
        const int high = is_uri && from[0] == '%' ? digit(from[1]) : -1, low = high >= 0 ? digit(from[2]) : -1;
        path[used++] = (char)(low >= 0 ? 16 * high + low : *from);
        from += low >= 0 ? 3 : 1;
    }
    while (used > 1 && (path[used - 1] == '/' || path[used - 1] == '\\'))
        --used;
    if (used + sizeof FILE_NAME > LONGEST_PATH)
        return 0;
    memcpy(path + used, FILE_NAME, sizeof FILE_NAME);
    return 1;
}

/* The whole file, and its size; NULL when it cannot be read. */
static unsigned char *read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    unsigned char *bytes = NULL;
    const long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    if (end > 0 && fseek(file, 0, SEEK_SET) == 0 && (bytes = malloc((size_t)end)) != NULL
        && fread(bytes, 1, (size_t)end, file) != (size_t)end) {
        free(bytes);
        bytes = NULL;
    }
    fclose(file);
    *size = bytes ? (size_t)end : 0;
    return bytes;
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
        uint64_t place, distance;
        memcpy(&place, bytes + head->pointers + 8 * k, 8);
        if (place % 8 != 0 || place > head->pointers - 8)
            return 0;
        memcpy(&distance, bytes + place, 8);
        if (distance >= size)
            return 0;
        const void *target = bytes + distance;
        memcpy(bytes + place, &target, sizeof target);
    }
    return 1;
}

const LagFmu *lag_fmu_open(const char *resources, void **memory, char *why, size_t room)
{
    char path[LONGEST_PATH + 1];
    if (!resources || !*resources || !path_of(resources, path)) {
        snprintf(why, room, "the importer has to tell the folder of the FMU's resources: the scene is in it");
        return NULL;
    }
    size_t size = 0;
    unsigned char *bytes = read_file(path, &size);
    if (!bytes) {
        snprintf(why, room, "%.600s, which holds the scene, cannot be read", path);
        return NULL;
    }
    Head head;
    const char *wrong = size < sizeof head + sizeof(LagFmu) ? "is damaged" : NULL;
    if (!wrong) {
        memcpy(&head, bytes, sizeof head);
        wrong = fault(&head, bytes, size);
    }
    if (!wrong && !set_pointers(&head, bytes, size))
        wrong = "is damaged";
    if (wrong) {
        snprintf(why, room, "%.600s %s", path, wrong);
        free(bytes);
        return NULL;
    }
    *memory = bytes;
    return (const LagFmu *)(const void *)(bytes + head.root);
}
