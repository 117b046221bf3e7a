/* Coefficients of the pair 5(4) with dense output of order 4.
 *
 * Ch. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption, Computers &
 * Mathematics with Applications 62 (2011) 770-775. Stages count from 0 here. Row sums, order conditions and those of the
 * dense output are checked in test_explicit.py.
 */
#ifndef LAG_TSIT5_TABLEAU_H
#define LAG_TSIT5_TABLEAU_H

#include "methods/explicit.h"

enum { LAG_TSIT5_STAGES = 6, LAG_TSIT5_DENSE_ROWS = 1 };

/* c: stage i is at t + c[i] h. */
static const double lag_tsit5_node[LAG_TSIT5_STAGES + 1] = {0.0, 0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0};

/* A: stage i is at y + h sum of weight * k[column]. Row 6 = b: the new point. */
static const LagTableauRow lag_tsit5_stage[LAG_TSIT5_STAGES + 1] = {
    {0, {0}, {0.0}},
    {1, {0},
     {0.161}},
    {2, {0, 1},
     {-0.008480655492356989, 0.335480655492357}},
    {3, {0, 1, 2},
     {2.8971530571054935, -6.359448489975075, 4.3622954328695815}},
    {4, {0, 1, 2, 3},
     {5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525}},
    {5, {0, 1, 2, 3, 4},
     {5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383}},
    {6, {0, 1, 2, 3, 4, 5},
     {0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774}}};

/* b - b^ of the embedded formula of order 4, which uses the slope at the end. */
static const LagTableauRow lag_tsit5_error =
    {7, {0, 1, 2, 3, 4, 5, 6},
     {-0.0017800110522257771, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629, 0.5823571654525552,
      -0.45808210592918697, 0.015151515151515152}};

/* d: the uppermost coefficient of the interpolation polynomial. */
static const LagTableauRow lag_tsit5_dense[LAG_TSIT5_DENSE_ROWS] = {
    {7, {0, 1, 2, 3, 4, 5, 6},
     {-1.0530884977290216, 0.1017, 2.490627285651253, -16.548102889244902, 47.37952196281928, -34.87065786149661, 2.5}}};

#endif
