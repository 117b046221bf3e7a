"""A compiled scene moves: the C run time by ctypes, the scene as data, engines, solvers, one run from start to stop.

Here belongs: structures that mirror those of runtime/, the choice between machine code and tapes, rows of results as they come.
Not here: CasADi, SymPy and Lark, for a kept scene runs without them; tables and pictures of results (room view).
"""
