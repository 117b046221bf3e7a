"""Questions to a scene: equilibria, small motion, modes, responses, sweeps, what is needed, CasADi's solvers.

Here belongs: numbers that answer a question about a scene as a whole, with their text and pictures.
Not here: SymPy; words and options of commands (room command).
"""
