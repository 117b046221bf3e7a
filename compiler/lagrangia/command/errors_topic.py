"""The texts of `lag help errors` and `lag help warnings`."""

ERRORS = """\
error[L0203]: Spring has no parameter 'd', with file, line and caret, what was expected and what to do. Codes by phase:
L00xx files and command line   L01xx syntax   L02xx names, modifications, arrays   L03xx units and dimensions
L04xx component graph          L05xx energies, equations of motion                 L06xx values, initial conditions
L07xx command line             L08xx style: lag lint                               L09xx not supported yet
Exit codes: 0 done, 1 the run failed (what was computed is kept), 2 the input is wrong, 130 interrupted. A sweep fails where none
of its runs went well, or the energy account of one is open; single runs that fail are rows that say so, and leave it at 0.
Warnings have codes of their own: lag help warnings.
"""
_WARNINGS = """\
warning[L0224]: nothing reads the parameter 'd', with file, line and caret. What is meant is allowed by its code: in the model
annotation(allow = "L0224, L0741"), on the command line --allow L0224,L0741; --strict takes warnings for errors (exit code 2).
L08xx are told by lag lint alone. In Python, model.warnings; InputWarning for values that a run is asked for (L0708, L0709,
L0746, L0747, L0748), run.warnings for L0610, RunWarning for rows that are no motion of the scene (exit code 1 of the command),
which warnings.simplefilter("error", lagrangia.RunWarning) makes an error, and for the cache (L0742) a line on standard error.

"""
TOLD = {
    "L0224": "what is written has no effect",
    "L0237": "two events at one instant, whose order decides",
    "L0238": "an assertion of level warning does not hold when the scene is compiled",
    "L0239": "a condition changes for single instants alone, where something just reaches a level and turns back",
    "L0305": "Hz where rad/s is meant, or the other way about",
    "L0306": "a vector of two where space has three",
    "L0607": "a force between two places that are one at the start, where it has no direction",
    "L0608": "a start value without effect: time, or other coordinates, say where it begins",
    "L0609": "several starts fit an initial equation, or one only just",
    "L0610": "an assertion of level warning does not hold in a run",
    "L0708": "no value is given for an input",
    "L0709": "a table of inputs ends before the run does, or has more than two rows at one time",
    "L0740": "coefficients of small motion change with time, and are those of one moment",
    "L0741": "an export leaves something out",
    "L0742": "a cache folder that others may write to is not used",
    "L0743": "forces bend just where small motion is asked for",
    "L0744": "an energy jumps where a condition on positions changes",
    "L0745": "a scene is too large to look whether a kinetic energy of its own is positive",
    "L0746": "an inertia that no rigid body has",
    "L0747": "a parameter is given in vain, beside another one",
    "L0748": "a range does not meet its end",
    "L0749": "an environment variable that nothing reads, or that names nothing there is",
    "L0801": "nothing in the file uses a class",
    "L0802": "a name hides another one",
    "L0803": "a number with a unit stands in a formula without a name",
    "L0804": "a name is against the convention",
    "L0805": "a unit is spelled out that has a name",
    "L0806": "the text is not laid out as lag format does it",
}


def warnings_topic() -> str:
    """What each code of a warning is about, and what to do about it."""
    return _WARNINGS + "".join(f"{code}  {about}\n" for code, about in TOLD.items())
