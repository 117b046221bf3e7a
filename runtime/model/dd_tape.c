/* The same meanings as in tape.c. */
#include "model/dd_tape.h"

enum { FIELDS = 4 };

static LagDD truth(int value) { return lag_dd(value); }

static LagDD fold_back(LagDD x) /* sqrt(1 - x^2) */
{
    return lag_dd_sqrt(lag_dd_mul(lag_dd_sub(lag_dd(1), x), lag_dd_add(lag_dd(1), x)));
}

static LagDD tangent(LagDD x)
{
    LagDD s, c;
    lag_dd_sin_cos(x, &s, &c);
    return lag_dd_div(s, c);
}

/* (exp(x) + sign exp(-x)) / 2 */
static LagDD hyperbolic(LagDD x, int sign)
{
    const LagDD up = lag_dd_exp(x), down = lag_dd_exp(lag_dd_neg(x));
    return lag_dd_scale(sign > 0 ? lag_dd_add(up, down) : lag_dd_sub(up, down), 0.5);
}

static LagDD sign_of(LagDD x) { return lag_dd(x.hi < 0 ? -1 : x.hi > 0 ? 1 : x.hi); }

static LagDD absolute(LagDD x) { return x.hi < 0 ? lag_dd_neg(x) : x; }

static LagDD relation(int32_t op, LagDD x, LagDD y)
{
    const int equal = x.hi == y.hi && x.lo == y.lo, less = lag_dd_less(x, y);
    switch (op) {
    case LAG_OP_LT: return truth(less);
    case LAG_OP_LE: return truth(less || equal);
    case LAG_OP_EQ: return truth(equal);
    case LAG_OP_NE: return truth(!equal);
    case LAG_OP_NOT: return truth(lag_dd_is_zero(x));
    case LAG_OP_AND: return truth(!lag_dd_is_zero(x) && !lag_dd_is_zero(y));
    case LAG_OP_OR: return truth(!lag_dd_is_zero(x) || !lag_dd_is_zero(y));
    case LAG_OP_FMIN: return less || isnan(y.hi) ? x : y;
    case LAG_OP_FMAX: return less || isnan(x.hi) ? y : x;
    default: return lag_dd(NAN);
    }
}

static LagDD rare(int32_t op, LagDD x, LagDD y)
{
    switch (op) {
    case LAG_OP_FABS: return absolute(x);
    case LAG_OP_SIGN: return sign_of(x);
    case LAG_OP_FLOOR: return lag_dd_floor(x);
    case LAG_OP_CEIL: return lag_dd_neg(lag_dd_floor(lag_dd_neg(x)));
    case LAG_OP_FMOD: return lag_dd(fmod(x.hi, y.hi));
    case LAG_OP_COPYSIGN: return signbit(y.hi) ? lag_dd_neg(absolute(x)) : absolute(x);
    case LAG_OP_SINH: return hyperbolic(x, -1);
    case LAG_OP_COSH: return hyperbolic(x, 1);
    case LAG_OP_TANH: return fabs(x.hi) < 300 ? lag_dd_div(hyperbolic(x, -1), hyperbolic(x, 1)) : sign_of(x);
    case LAG_OP_ASINH: return lag_dd(asinh(x.hi));
    case LAG_OP_ACOSH: return lag_dd(acosh(x.hi));
    case LAG_OP_ATANH: return lag_dd(atanh(x.hi));
    case LAG_OP_ERF: return lag_dd(erf(x.hi));
    default: return relation(op, x, y);
    }
}

static LagDD elementary(int32_t op, LagDD x, LagDD y)
{
    LagDD s, c;
    switch (op) {
    case LAG_OP_SQRT: return lag_dd_sqrt(x);
    case LAG_OP_SIN: lag_dd_sin_cos(x, &s, &c); return s;
    case LAG_OP_COS: lag_dd_sin_cos(x, &s, &c); return c;
    case LAG_OP_TAN: return tangent(x);
    case LAG_OP_ASIN: return lag_dd_atan2(x, fold_back(x));
    case LAG_OP_ACOS: return lag_dd_atan2(fold_back(x), x);
    case LAG_OP_ATAN: return lag_dd_atan2(x, lag_dd(1));
    case LAG_OP_ATAN2: return lag_dd_atan2(x, y);
    case LAG_OP_EXP: return lag_dd_exp(x);
    case LAG_OP_LOG: return lag_dd_log(x);
    case LAG_OP_POW:
    case LAG_OP_CONSTPOW: return lag_dd_pow(x, y);
    default: return rare(op, x, y);
    }
}

void lag_dd_tape_run(const LagTape *tape, const double *const *in, LagDD *const *out, LagDD *w)
{
    const int32_t *end = tape->code + FIELDS * tape->n_instructions;
    for (const int32_t *i = tape->code; i < end; i += FIELDS) {
        const int32_t o = i[1], a = i[2], b = i[3];
        switch (i[0]) {
        case LAG_OP_INPUT: w[o] = lag_dd(in[a][b]); break;
        case LAG_OP_OUTPUT: out[o][b] = w[a]; break;
        case LAG_OP_CONST: w[o] = lag_dd(tape->constants[a]); break;
        case LAG_OP_ASSIGN: w[o] = w[a]; break;
        case LAG_OP_ADD: w[o] = lag_dd_add(w[a], w[b]); break;
        case LAG_OP_SUB: w[o] = lag_dd_sub(w[a], w[b]); break;
        case LAG_OP_MUL: w[o] = lag_dd_mul(w[a], w[b]); break;
        case LAG_OP_DIV: w[o] = lag_dd_div(w[a], w[b]); break;
        case LAG_OP_NEG: w[o] = lag_dd_neg(w[a]); break;
        case LAG_OP_SQ: w[o] = lag_dd_mul(w[a], w[a]); break;
        case LAG_OP_TWICE: w[o] = lag_dd_scale(w[a], 2); break;
        case LAG_OP_INV: w[o] = lag_dd_div(lag_dd(1), w[a]); break;
        case LAG_OP_IF_ELSE_ZERO: w[o] = lag_dd_is_zero(w[a]) ? lag_dd(0) : w[b]; break;
        case LAG_OP_SIN:
        case LAG_OP_COS: w[o] = elementary(i[0], w[a], w[a]); break; /* b is a count */
        default: w[o] = elementary(i[0], w[a], w[b]); break;
        }
    }
}
