"""The C run time under the sanitizers of gcc and clang: all solvers, events, inputs, constraints, and no coordinates at all."""

from collections.abc import Callable
from pathlib import Path

import pytest

from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia import Model, load
from lagrangia.compile.dumps import dump
from lagrangia.native import wide_code as widecode
from lagrangia.native.build import find_compiler
from runtime.test_friction import BRAKED, STANDING
from runtime.test_rubs import BOX, SPINNING

pytestmark = [pytest.mark.slow, pytest.mark.skipif(find_compiler() is None, reason="no C compiler")]
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"

DRIVER = """
#include "run/run.h"
#include <math.h>
#include <stdlib.h>
static int rhs(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = -in[1][0] + in[3][0] + in[4][0]; out[1][0] = 0; out[1][1] = in[2][0]; return 0; }
static int start(const double *const *in, double *const *out, double *work)
{ (void)in; (void)work; out[0][0] = 1; out[1][0] = 0; return 0; }
static int events(const double *const *in, double *const *out, double *work)
{ (void)in; (void)work; out[0][0] = 0; out[1][0] = 1; return 0; }
static int modes(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = floor(in[0][0]); return 0; }
static int initial(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = in[0][0] * in[0][0] - 2; out[1][0] = 2 * in[0][0]; out[1][1] = 0; return 0; }
static const int kind[] = {3}, fixed[] = {0, 0}, slopes[] = {0, 2, 0, 1}, integer[] = {LAG_EVENT_INTEGER};
static const LagModel model = {.n = 1, .n_inputs = 1, .n_modes = 1, .n_events = 1, .n_initial = 1, .n_power = 2,
    .coordinate_kind = kind, .fixed = fixed, .initial_pattern = slopes, .event_kind = integer, .start = {.code = start},
    .initial = {.code = initial},
    .events = {.code = events}, .modes = {.code = modes}, .rhs = {.code = rhs}};
static int rod_rhs(const double *const *in, double *const *out, double *work)
{ const double *q = in[1], *v = in[2], l = v[0]*v[0] + v[1]*v[1] + q[1];
  (void)work; out[0][0] = -l*q[0]; out[0][1] = 1 - l*q[1]; out[2][0] = l; return 0; }
static int rod_place(const double *const *in, double *const *out, double *work)
{ const double *q = in[1], r2 = q[0]*q[0] + q[1]*q[1], phi = r2 - 1;
  (void)work; out[0][0] = -phi*q[0]/(2*r2); out[0][1] = -phi*q[1]/(2*r2); return 0; }
static int rod_steer(const double *const *in, double *const *out, double *work)
{ const double *q = in[1], *v = in[2], rate = q[0]*v[0] + q[1]*v[1], r2 = q[0]*q[0] + q[1]*q[1];
  (void)work; out[0][0] = -rate*q[0]/r2; out[0][1] = -rate*q[1]/r2; return 0; }
static int rod_residual(const double *const *in, double *const *out, double *work)
{ const double *q = in[1], *v = in[2];
  (void)work; out[0][0] = q[0]*q[0] + q[1]*q[1] - 1; out[1][0] = 2*(q[0]*v[0] + q[1]*v[1]); return 0; }
static int rod_start(const double *const *in, double *const *out, double *work)
{ (void)in; (void)work; out[0][0] = 0.6; out[0][1] = 0.8; out[1][0] = out[1][1] = 0; return 0; }
static const int rod_kind[] = {1, 1}, rod_fixed[] = {0, 0, 0, 0};
static int rod_jacobian(const double *const *in, double *const *out, double *work)
{ const double *q = in[1], *v = in[2], l = in[4][0];
  const double S0[7] = {1, q[0], 1, q[1], 0, 0, 0}, S1[7] = {0, 2*v[0], 0, 2*v[1], q[0], q[1], 0};
  const double S2[7] = {l, in[3][0], l, in[3][1], 0, 0, 0};
  (void)work; for (int i = 0; i < 7; ++i) { out[0][i] = S0[i]; out[1][i] = S1[i]; out[2][i] = S2[i]; } return 0; }
static const int rod_pattern[] = {0, 2, 4, 7, 0, 2, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1}; /* starts, rows, order, colours */
static const LagModel rod = {.n = 2, .n_entries = 7, .n_lower = LOWER, .n_upper = LOWER, .jacobian_pattern = rod_pattern,
    .jacobian = {.code = rod_jacobian}, .n_holonomic = 1, .n_multipliers = 1, .coordinate_kind = rod_kind,
    .fixed = rod_fixed, .start = {.code = rod_start}, .rhs = {.code = rod_rhs}, .place = {.code = rod_place},
    .steer = {.code = rod_steer}, .residual = {.code = rod_residual}};
static int held(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = *in[0]; return 0; }
static const LagModel still = {.n_outputs = 1, .coordinate_kind = rod_kind, .fixed = rod_fixed, .outputs = {.code = held}};
static int swing(const LagModel *rod, const LagSettings *settings, const double *times)
{
    double *rows = malloc(5 * (size_t)lag_run_row_width(rod) * sizeof *rows);
    LagRun *run = lag_run_new(rod, settings);
    int done = 0;
    const int failed = lag_run_start(run, NULL, NULL) != LAG_OK || lag_run_advance(run, times, 5, rows, &done, 0) != LAG_OK
        || lag_run_statistics(run)->constraint_residual > 1e-14;
    lag_run_free(run);
    free(rows);
    return failed;
}
int main(void)
{
    const LagSettings settings = {.t_stop = 10, .tolerance = 1e-9};
    const double times[] = {0, 0.5, 1, 7.3, 10}, corners[] = {2, 3, 3}, values[] = {0, 1, 2};
    double *rows = malloc(5 * (size_t)lag_run_row_width(&model) * sizeof *rows);
    LagRun *run = lag_run_new(&model, &settings);
    int done = 0;
    lag_run_set_parameters(run, NULL, NULL);
    lag_run_set_inputs(run, corners, values, 3);
    for (int i = 0; i < 2; ++i)
        if (lag_run_start(run, NULL, NULL) != LAG_OK || lag_run_advance(run, times, 5, rows, &done, 0) != LAG_OK || done != 5)
            return 1;
    lag_run_free(run);
    free(rows);
    const LagSettings implicit = {.t_stop = 10, .tolerance = 1e-9, .solver = LAG_SOLVER_IMPLICIT};
    return swing(&rod, &settings, times) || swing(&still, &settings, times) || swing(&rod, &implicit, times);
}
"""


@needs_sanitizers
@pytest.mark.parametrize("elimination", ["dense", "sparse"])
def test_sanitizers_find_nothing(tmp_path: Path, elimination: str) -> None:
    run_sanitized(tmp_path, {"driver.c": DRIVER.replace("LOWER", "6" if elimination == "sparse" else "0")})


SCENE_DRIVER = """
#include "run/run.h"
#include <stdlib.h>
extern const LagModel lag_model;
int main(void)
{
    const int solvers[] = {LAG_SOLVER_AUTO, LAG_SOLVER_ERK, LAG_SOLVER_ERK5, LAG_SOLVER_ADAMS, LAG_SOLVER_IMPLICIT,
                           LAG_SOLVER_TAYLOR, LAG_SOLVER_PIRK};
    double times[61], *rows = malloc(61 * (size_t)lag_run_row_width(&lag_model) * sizeof *rows);
    for (int i = 0; i < 61; ++i)
        times[i] = i / 20.0;
    for (int i = 0; i < 14; ++i) {
        const LagSettings settings = {.t_stop = 3, .tolerance = i < 7 ? 1e-4 : 1e-8, .solver = solvers[i % 7]};
        if ((settings.solver == LAG_SOLVER_TAYLOR && lag_model.n_jets == 0) || (i >= 7 && i % 2 != FINE))
            continue;
        LagRun *run = lag_run_new(&lag_model, &settings);
        int done = 0;
        lag_run_set_parameters(run, NULL, NULL);
        if (lag_run_start(run, NULL, NULL) != LAG_OK || lag_run_advance(run, times, 61, rows, &done, 0) != LAG_OK || done != 61)
            return 1;
        lag_run_free(run);
    }
    free(rows);
    return 0;
}
"""


@needs_sanitizers
@pytest.mark.parametrize(("text", "fine"), [(BOX, 0), (SPINNING, 1), (BRAKED, 0), (STANDING, 1)],
                         ids=["box", "spinning", "braked", "standing"])
def test_they_find_nothing_where_things_strike_and_slide(tmp_path: Path, scene: Callable[[str], Model], text: str,
                                                         fine: int) -> None:
    """Whole scenes, by all solvers: impacts, friction that sticks, rubs and is torn off, stiff or not. At the finer tolerance,
    which takes most of the time, a scene is run by every other solver, and the next one by the others."""
    run_sanitized(tmp_path, {"driver.c": SCENE_DRIVER, "scene.c": dump(scene(text).compilation, "c")}, flags=[f"-DFINE={fine}"])


@needs_sanitizers
@pytest.mark.parametrize("longest", [10_000, 0], ids=["written", "tape"])
@pytest.mark.parametrize("name", ["chain", "slider_crank"])
def test_they_find_nothing_where_eight_states_are_evaluated_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str,
                                                                    longest: int) -> None:
    monkeypatch.setattr(widecode, "_LONGEST", longest)
    files = {"driver.c": SCENE_DRIVER, "scene.c": dump(load(EXAMPLES / f"{name}.lag").compilation, "c")}
    run_sanitized(tmp_path, files, flags=[f"-DFINE={int(longest == 0)}"])
