"""From text to a flat model: grammar, names, units, classes, loops and conditions, and all that can be wrong with a text.

Here belongs: every step that needs no mechanics, each with the faults it tells by code, place and advice.
Not here: CasADi; graphs, constraints and energies of what the text says.
"""
