/* An FMU whose scene is a file: what compiler/lagrangia/fmu/stored.py wrote for this library.
 *
 * The whole is read into one piece of memory and opened there (image.h). Every instance has its own: libraries of several FMUs,
 * and instances in several threads, share nothing.
 */
#include "fmi/image.h"
#include "fmi/opening.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char FILE_NAME[] = "/scene.tape";
enum { LONGEST_PATH = 4096 };

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
    const LagFmu *fmu = NULL;
    const char *wrong = lag_image_open(bytes, size, &fmu);
    if (wrong) {
        snprintf(why, room, "%.600s %s", path, wrong);
        free(bytes);
        return NULL;
    }
    *memory = bytes;
    return fmu;
}
