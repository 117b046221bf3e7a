"""Hostile importers: random calls with random arguments, under the sanitizers. An error is an answer; a crash is none."""

import os
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

from helpers.fmus import EXAMPLES, fmu_of
from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.base.folders import data_folder
from lagrangia.fmu.build import standard_headers
from lagrangia.native.build import find_compiler
from lagrangia.native.prebuilt import sources

SEQUENCES, CALLS = int(os.environ.get("LAGRANGIA_FUZZ", "1500")), 12  # LAGRANGIA_FUZZ=100000 takes two minutes
COMMON = """
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "HEADER"
#include "fmu.h"

static uint64_t seed = 88172645463325252u;
static unsigned pick(unsigned n)
{
    seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17; /* xorshift: G. Marsaglia, 2003 */
    return (unsigned)((seed >> 20) % n);
}
static double number(void)
{
    static const double odd[] = {0, -0.0, 1, -1, 1e-300, 1e300, 0.01, 0.5, 1e6, 1e7, -1e7};
    switch (pick(8)) {
    case 0: return NAN;
    case 1: return pick(2) ? INFINITY : -INFINITY;
    case 2: return odd[pick(sizeof odd / sizeof *odd)];
    default: return pick(2000) / 1000.0 - 1;
    }
}
static double step(void)
{
    static const double steps[] = {0, -1, 1e7, 0.01, 0.01, 0.1, 1e-9};
    return pick(9) == 0 ? NAN : steps[pick(7)];
}
enum { MOST = 6 };
static unsigned references[MOST];
static double values[64];
static size_t fill(void)
{
    const size_t count = pick(MOST);
    for (size_t i = 0; i < count; ++i) {
        references[i] = pick(10) ? pick(60) : pick(1000000000);
        values[i] = number();
    }
    return count;
}
static size_t size(void) { return pick(4) ? 2 * (size_t)lag_fmu.model->n : pick(9); }
static double time_now;
static long ended, failed;
static void note(int status) { failed += status > 1; ended += status == 0; }
"""
FMI2 = """
static void logger(fmi2ComponentEnvironment e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...)
{ (void)e, (void)s; if (!n || !c || !m || !*m) abort(); }
static void *saved[3];
static void sequence(void)
{
    fmi2CallbackFunctions callbacks = {pick(3) ? logger : NULL, calloc, free, NULL, NULL};
    const char *guid = pick(30) ? lag_fmu.token : pick(2) ? "other" : NULL;
    void *c = fmi2Instantiate(pick(30) ? "i" : NULL, pick(2) ? fmi2ModelExchange : fmi2CoSimulation, guid, pick(2) ? "file:///x" : NULL,
                              pick(20) ? &callbacks : NULL, 0, pick(2));
    time_now = 0;
    memset(saved, 0, sizeof saved);
    if (pick(3)) { /* most sequences go somewhere */
        note(fmi2SetupExperiment(c, 1, 1e-4, 0, 0, 0));
        note(fmi2EnterInitializationMode(c));
        note(fmi2ExitInitializationMode(c));
    }
    for (int i = 0; i < CALLS; ++i) {
        const size_t n = fill();
        const unsigned *r = pick(40) ? references : NULL;
        double *v = pick(40) ? values : NULL;
        int whole[MOST], flag = 0, other = 0;
        const char *texts[MOST];
        size_t bytes = 0;
        fmi2EventInfo info;
        void *which = saved[pick(3)];
        switch (pick(32)) {
        case 0: note(fmi2SetupExperiment(c, pick(2), number(), number(), pick(2), number())); break;
        case 1: note(fmi2EnterInitializationMode(c)); break;
        case 2: note(fmi2ExitInitializationMode(c)); break;
        case 3: note(fmi2Terminate(c)); break;
        case 4: note(fmi2Reset(c)); break;
        case 5: case 6: note(fmi2GetReal(c, r, n, v)); break;
        case 7: case 8: note(fmi2SetReal(c, r, n, v)); break;
        case 9: note(fmi2GetInteger(c, r, n, whole)); note(fmi2GetBoolean(c, r, n, pick(9) ? whole : NULL)); break;
        case 10: note(fmi2GetString(c, r, n, texts)); note(fmi2SetString(c, r, n, texts)); break;
        case 11: note(fmi2SetInteger(c, r, n, whole)); note(fmi2SetBoolean(c, r, n, whole)); break;
        case 12: note(fmi2GetFMUstate(c, pick(30) ? saved + pick(3) : NULL)); break;
        case 13: note(fmi2SetFMUstate(c, pick(20) ? which : (void *)values)); break;
        case 14: { const unsigned k = pick(3); void *copy = saved[k]; note(fmi2FreeFMUstate(c, saved + k)); note(fmi2FreeFMUstate(c, &copy)); break; }
        case 15:
            if (fmi2SerializedFMUstateSize(c, which, &bytes) == fmi2OK) {
                char *text = malloc(bytes);
                note(fmi2SerializeFMUstate(c, which, text, bytes - pick(2)));
                if (pick(2))
                    text[pick((unsigned)bytes)] ^= (char)(1 << pick(8));
                note(fmi2DeSerializeFMUstate(c, text, pick(5) ? bytes : pick((unsigned)bytes), saved + pick(3)));
                free(text);
            }
            break;
        case 16: note(fmi2GetDirectionalDerivative(c, r, n, r, pick((unsigned)n + 1), v, v)); break;
        case 17: note(fmi2EnterEventMode(c)); break;
        case 18: note(fmi2NewDiscreteStates(c, pick(30) ? &info : NULL)); break;
        case 19: note(fmi2EnterContinuousTimeMode(c)); break;
        case 20: note(fmi2CompletedIntegratorStep(c, 1, pick(30) ? &flag : NULL, &other)); break;
        case 21: note(fmi2SetTime(c, time_now += number())); break;
        case 22: note(fmi2SetContinuousStates(c, v, size())); break;
        case 23: note(fmi2GetDerivatives(c, v, size())); break;
        case 24: note(fmi2GetContinuousStates(c, v, size())); note(fmi2GetNominalsOfContinuousStates(c, v, size())); break;
        case 25: note(fmi2GetEventIndicators(c, v, pick(2))); note(fmi2SetDebugLogging(c, pick(2), 3, NULL)); break;
        case 26: note(fmi2SetRealInputDerivatives(c, r, n, whole, v)); note(fmi2GetRealOutputDerivatives(c, r, n, whole, v)); break;
        case 27: note(fmi2CancelStep(c)); note(fmi2GetStatus(c, fmi2DoStepStatus, NULL)); break;
        case 28: note(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, v)); note(fmi2GetBooleanStatus(c, fmi2Terminated, &flag)); break;
        default: { double now = 0, h = step();
            if (c && fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &now) == fmi2OK) time_now = now;
            note(fmi2DoStep(c, pick(20) ? time_now : number(), h, 1)); }
        }
    }
    fmi2FreeInstance(c);
}
"""  # noqa: E501
FMI3 = """
static void logger(fmi3InstanceEnvironment e, fmi3Status s, fmi3String c, fmi3String m) { (void)e, (void)s; if (!c || !m || !*m) abort(); }
static void update(fmi3InstanceEnvironment e, double t, bool set, bool get, bool done, bool may, bool *early, double *when)
{ (void)e, (void)set, (void)get, (void)done, (void)may; *early = pick(5) == 0; *when = t; }
static void *saved[3];
static void sequence(void)
{
    const char *token = pick(30) ? lag_fmu.token : pick(2) ? "other" : NULL, *name = pick(30) ? "i" : NULL;
    const fmi3LogMessageCallback log = pick(3) ? logger : NULL;
    void *c = pick(2) ? fmi3InstantiateModelExchange(name, token, NULL, 0, pick(2), NULL, log)
                      : fmi3InstantiateCoSimulation(name, token, NULL, 0, pick(2), pick(2), pick(2), NULL, 0, NULL, log, pick(2) ? update : NULL);
    time_now = 0;
    memset(saved, 0, sizeof saved);
    if (pick(3)) {
        note(fmi3EnterInitializationMode(c, 1, 1e-4, 0, 0, 0));
        note(fmi3ExitInitializationMode(c));
        if (pick(2)) note(fmi3EnterStepMode(c));
    }
    for (int i = 0; i < CALLS; ++i) {
        const size_t n = fill(), m = pick(20) ? n : pick(MOST);
        const unsigned *r = pick(40) ? references : NULL;
        double *v = pick(40) ? values : NULL, last = 0;
        int32_t whole[MOST] = {1, 1, 1, 1, 1, 1};
        bool flags[MOST], a, b, d, e;
        const char *texts[MOST];
        size_t bytes = 0, count;
        void *which = saved[pick(3)];
        switch (pick(32)) {
        case 0: note(fmi3EnterInitializationMode(c, pick(2), number(), number(), pick(2), number())); break;
        case 1: note(fmi3ExitInitializationMode(c)); break;
        case 2: note(fmi3Terminate(c)); break;
        case 3: note(fmi3Reset(c)); break;
        case 4: case 5: note(fmi3GetFloat64(c, r, n, v, m)); break;
        case 6: case 7: note(fmi3SetFloat64(c, r, n, v, m)); break;
        case 8: note(fmi3GetInt32(c, r, n, whole, m)); note(fmi3GetBoolean(c, r, n, pick(9) ? flags : NULL, m)); break;
        case 9: note(fmi3GetString(c, r, n, texts, m)); note(fmi3SetString(c, r, n, texts, m)); note(fmi3GetClock(c, r, n, flags)); break;
        case 10: note(fmi3GetUInt64(c, r, n, NULL, m)); note(fmi3SetInt8(c, r, n, NULL, m)); note(fmi3ActivateModelPartition(c, 0, 0)); break;
        case 11: note(fmi3GetFMUState(c, pick(30) ? saved + pick(3) : NULL)); break;
        case 12: note(fmi3SetFMUState(c, pick(20) ? which : (void *)values)); break;
        case 13: { const unsigned k = pick(3); void *copy = saved[k]; note(fmi3FreeFMUState(c, saved + k)); note(fmi3FreeFMUState(c, &copy)); break; }
        case 14:
            if (fmi3SerializedFMUStateSize(c, which, &bytes) == fmi3OK) {
                uint8_t *text = malloc(bytes);
                note(fmi3SerializeFMUState(c, which, text, bytes - pick(2)));
                if (pick(2))
                    text[pick((unsigned)bytes)] ^= (uint8_t)(1 << pick(8));
                note(fmi3DeserializeFMUState(c, text, pick(5) ? bytes : pick((unsigned)bytes), saved + pick(3)));
                free(text);
            }
            break;
        case 15: note(fmi3GetDirectionalDerivative(c, r, n, r, m, v, m, v, n)); break;
        case 16: note(fmi3GetAdjointDerivative(c, r, n, r, m, v, n, v, m)); break;
        case 17: note(fmi3EnterEventMode(c)); note(fmi3EvaluateDiscreteStates(c)); break;
        case 18: note(fmi3UpdateDiscreteStates(c, &a, &b, pick(30) ? &d : NULL, &e, &flags[0], &last)); break;
        case 19: note(fmi3EnterContinuousTimeMode(c)); break;
        case 20: note(fmi3CompletedIntegratorStep(c, 1, pick(30) ? &a : NULL, &b)); break;
        case 21: note(fmi3SetTime(c, time_now += number())); break;
        case 22: note(fmi3SetContinuousStates(c, v, size())); break;
        case 23: note(fmi3GetContinuousStateDerivatives(c, v, size())); break;
        case 24: note(fmi3GetContinuousStates(c, v, size())); note(fmi3GetNominalsOfContinuousStates(c, v, size())); break;
        case 25: note(fmi3GetEventIndicators(c, v, pick(2))); note(fmi3SetDebugLogging(c, pick(2), 3, NULL)); break;
        case 26: note(fmi3GetOutputDerivatives(c, r, n, pick(20) ? whole : NULL, v, m)); note(fmi3GetVariableDependencies(c, 1, &count, NULL, NULL, NULL, 0)); break;
        case 27: note(fmi3GetNumberOfContinuousStates(c, pick(2) ? &count : NULL)); note(fmi3EnterConfigurationMode(c)); note(fmi3ExitConfigurationMode(c)); break;
        case 28: note(fmi3EnterStepMode(c)); break;
        default:
            note(fmi3DoStep(c, pick(20) ? time_now : number(), step(), 1, &a, &b, pick(30) ? &d : NULL, &last));
            time_now = last;
        }
    }
    fmi3FreeInstance(c);
}
"""  # noqa: E501
MAIN = """
int main(void)
{
    for (long i = 0; i < SEQUENCES; ++i)
        sequence();
    printf("%ld %ld\\n", ended, failed);
    return 0;
}
"""


@pytest.mark.slow
@needs_sanitizers
@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(("example", "version"), [("quarter_car", "3"), ("four_bar", "2")])
def test_no_sequence_of_calls_crashes(example: str, version: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(fmu_of(EXAMPLES / f"{example}.lag", version)) as archive:
        archive.extractall(tmp_path)
    text = COMMON.replace("HEADER", f"fmi{version}Functions.h") + (FMI2 if version == "2" else FMI3) + MAIN
    known = {file.name for file in sources(data_folder("runtime"))}  # compiled for all that run under sanitizers
    own = sorted(file for file in (tmp_path / "sources").glob("*.c") if file.name not in known)
    flags = ["-DLAG_STATIC=1", "-DFMI3_OVERRIDE_FUNCTION_PREFIX=1", f"-DSEQUENCES={SEQUENCES}", f"-DCALLS={CALLS}",
             "-ffp-contract=off", f"-I{tmp_path / 'sources'}", f"-I{standard_headers()}"]
    printed = run_sanitized(tmp_path, {"driver.c": text}, own, flags)
    worked, refused = map(int, printed.split())
    assert worked > SEQUENCES and refused > SEQUENCES, "both happened often"
