/* Up to 19 digits are one whole number; where it and the power of ten are doubles without rounding, so is what one operation makes
 * of them (W.D. Clinger, How to read floating point numbers accurately, 1990). The C library reads the few others.
 */
#include "model/read_numbers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_DIGITS = 19, MOST_EXACT = 22, LONGEST = 400 };
static const uint64_t LARGEST_EXACT = UINT64_C(1) << 53;
static const double POWERS[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17,
                                1e18, 1e19, 1e20, 1e21, 1e22};

static int is_digit(char c) { return c >= '0' && c <= '9'; }

/* What is left to the C library, which wants a point. Returns the end, or NULL. */
static const char *read_slowly(const char *begin, const char *end, int decimal, double *value)
{
    char copy[LONGEST + 1];
    const size_t size = (size_t)(end - begin);
    if (size > LONGEST)
        return NULL;
    memcpy(copy, begin, size);
    copy[size] = 0;
    char *comma = strchr(copy, decimal), *stop;
    if (comma)
        *comma = '.';
    *value = strtod(copy, &stop);
    return *stop == 0 && isfinite(*value) ? end : NULL;
}

/* The number that begins here; returns where it ends, or NULL. */
static const char *read_number(const char *text, int decimal, double *value)
{
    const char *at = text;
    const int is_negative = *at == '-';
    uint64_t digits = 0;
    int count = 0, any = 0, exponent = 0, power = 0;
    at += *at == '-' || *at == '+';
    for (int is_behind = 0;; ++at) {
        if (*at == decimal && !is_behind) {
            is_behind = 1;
            continue;
        }
        if (!is_digit(*at))
            break;
        any = 1;
        if (count < MOST_DIGITS) {
            digits = 10 * digits + (uint64_t)(*at - '0');
            count += digits > 0;
            exponent -= is_behind;
        } else {
            count = LONGEST; /* too many for this */
        }
    }
    if (!any)
        return NULL;
    if (*at == 'e' || *at == 'E') {
        const char *sign = at + 1;
        at = sign + (*sign == '-' || *sign == '+');
        if (!is_digit(*at))
            return NULL;
        for (; is_digit(*at); ++at)
            power = power < LONGEST ? 10 * power + (*at - '0') : power;
        exponent += *sign == '-' ? -power : power;
    }
    if (count > MOST_DIGITS || digits > LARGEST_EXACT || exponent > MOST_EXACT || exponent < -MOST_EXACT)
        return digits == 0 && count <= MOST_DIGITS ? (*value = is_negative ? -0.0 : 0.0, at) : read_slowly(text, at, decimal, value);
    const double whole = (double)digits, size = exponent < 0 ? whole / POWERS[-exponent] : whole * POWERS[exponent];
    *value = is_negative ? -size : size;
    return at;
}

static const char *over_spaces(const char *at, int delimiter)
{
    while (*at == ' ' || *at == '\r' || (*at == '\t' && delimiter != '\t'))
        ++at;
    return at;
}

/* Reads a line; returns where it ends, or NULL. */
static const char *read_line(const char *at, int delimiter, int decimal, int width, double *values)
{
    for (int k = 0; k < width; ++k) {
        at = read_number(over_spaces(at, delimiter), decimal, values + k);
        if (!at)
            return NULL;
        const char *behind = over_spaces(at, delimiter);
        if (k + 1 < width && delimiter ? *behind != delimiter : k + 1 < width && behind == at)
            return NULL;
        at = k + 1 < width && delimiter ? behind + 1 : behind;
    }
    return *at == '\n' || *at == 0 ? at : NULL;
}

int64_t lag_read_numbers(const char *text, int delimiter, int decimal, int width, double *values, int64_t most)
{
    int64_t rows = 0;
    for (int64_t line = 0; *text && rows < most; ++line) {
        const char *at = over_spaces(text, delimiter);
        if (*at == '#' || *at == '%')
            while (*at && *at != '\n')
                ++at;
        else if (*at && *at != '\n') {
            at = read_line(at, delimiter, decimal, width, values + rows * width);
            if (!at)
                return -1 - line;
            ++rows;
        }
        text = at + (*at == '\n');
    }
    return rows;
}
