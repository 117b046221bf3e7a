"""Models for the run time, written in C by hand: what the compiler would make, without the compiler."""

import re

from lagrangia.base.folders import data_folder
from lagrangia.native.build import build
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Model, Run, Settings, Status

FOLDER = data_folder("runtime")
OSCILLATOR = "a[0] = -q[0];"

FUNCTION = """
static int {name}(const double *const *in, double *const *out, double *work)
{{
    (void)in, (void)out, (void)work;
    {body}
    return 0;
}}
"""
STATE = """const double t = *in[0], *q = in[1], *v = in[2], *u = in[3], *d = in[4], *c = in[5];
    (void)t, (void)q, (void)v, (void)u, (void)d, (void)c;"""
HEADS = {
    "rhs": STATE + "double *a = out[0], *power = out[1];(void)power;",
    "outputs": "const double t = *in[0], *q = in[1], *a = in[3], *d = in[6];(void)t,(void)q,(void)a,(void)d;double *y = out[0];",
    "energies": STATE + "double *E = out[0];",
    "start": "const double *p = in[0];(void)p;double *q = out[0], *v = out[1];(void)q,(void)v;",
    "modes": "const double t = *in[0], *p = in[1];(void)t,(void)p;double *d = out[0];",
    "events": "double *a = out[0], *b = out[1];",
    "initial": "const double *q = in[0], *v = in[1];(void)q,(void)v;double *g = out[0], *J = out[1];",  # row by row
    "parameters": "const double *given = in[0], *mask = in[1];double *p = out[0];",
    "place": "const double t = *in[0], *q = in[1];(void)t,(void)q;double *dq = out[0];",
    "steer": "const double *q = in[1], *v = in[2];(void)q,(void)v;double *dv = out[0];",
    "residual": STATE + "double *phi = out[0], *rate = out[1];",
    "jacobian": "const double *q = in[1], *v = in[2];(void)q,(void)v;",
    "hoist": "const double *p = in[0];double *c = out[0];",
}


def compiled(n: int, *, kinds: list[int] | None = None, event_kind: str = "0", numbers: str = "", **functions: str) -> Model:
    """A model from the bodies of its C functions; names of inputs and outputs as in HEADS."""
    bodies = {"start": "", **functions}
    text = '#include <math.h>\n#include "model/model.h"\n'
    text += "".join(FUNCTION.format(name=name, body=HEADS[name] + body) for name, body in bodies.items())
    kind = ", ".join(map(str, kinds or [1] * n)) or "0"
    text += f"static const int kind[] = {{{kind}}}, fixed[{2 * n + 1}], event_kind[] = {{{event_kind}}};\n"
    equations = int(found[1]) if (found := re.search(r"\.n_initial = (\d+)", numbers)) else 0
    slopes = [*range(0, 2 * n * equations + 1, 2 * n), *range(2 * n)] + [*range(2 * n)] * max(0, equations - 1)
    text += f"static const int slopes[] = {{{', '.join(map(str, slopes))}}};\n"
    fields = "".join(f", .{name} = {{.code = {name}}}" for name in bodies)
    text += "LAG_API const LagModel lag_model = {.coordinate_kind = kind, .fixed = fixed, .event_kind = event_kind,\n"
    text += "    .initial_pattern = slopes,\n"
    text += f"    .n = {n}{numbers}{fields}}};\n"
    return Model.from_library(build("case", text, include=[FOLDER]))


def started(runtime: Runtime, model: Model, q: list[float], v: list[float], **settings: float) -> Run:
    run = runtime.run(model, Settings(**settings))
    assert run.set_parameters() is Status.OK
    assert run.start(q, v) is Status.OK
    return run
