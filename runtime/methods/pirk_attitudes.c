#include "methods/pirk_attitudes.h"
#include "model/attitude_places.h"

void lag_pirk_find_detours(const LagMotion *m, const double *q, const double *v, double *detours, int stride)
{
    for (int i = 0; i < m->n_attitudes; ++i) {
        const int c = lag_attitude_place(m->attitudes, i);
        for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE) {
            LagWide s[3], w[3];
            for (int k = 0; k < 3; ++k) {
                s[k] = lag_wide_read(q + (c + k) * LAG_ABREAST + lane);
                w[k] = lag_wide_read(v + (c + k) * LAG_ABREAST + lane);
            }
            const LagWide bent = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) * LAG_WIDE_OF(-0.0625);
            const LagWide along = (s[0] * w[0] + s[1] * w[1] + s[2] * w[2]) * LAG_WIDE_OF(0.125), half = LAG_WIDE_OF(0.5);
            for (int k = 0; k < 3; ++k) {
                const int a = (k + 1) % 3, b = (k + 2) % 3;
                const LagWide detour = bent * w[k] + half * (s[a] * w[b] - s[b] * w[a]) + along * s[k];
                lag_wide_write(detours + (3 * i + k) * stride + lane, detour);
            }
        }
    }
}
