"""The text of `lag help errors`."""

ERRORS = """\
error[L0203]: Spring has no parameter 'd', with file, line and caret, what was expected and what to do. Codes by phase:
L00xx files and command line   L01xx syntax   L02xx names, modifications, arrays   L03xx units and dimensions
L04xx component graph          L05xx energies, equations of motion                 L06xx values, initial conditions
L07xx command line             L09xx not supported yet
Exit codes: 0 done, 1 the run failed (what was computed is kept), 2 the input is wrong, 130 interrupted.
"""
