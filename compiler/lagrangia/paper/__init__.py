"""Equations for people: derived by SymPy, named, laid out, and printed as text, LaTeX, MathML, HTML, Modelica, Python.

Here belongs: forms of the equations, notation, pages and the scripts that are exported for reading.
Not here: the way to a simulation, which never needs SymPy.
"""
