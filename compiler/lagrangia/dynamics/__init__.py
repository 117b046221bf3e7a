"""From energies to motion: M, h, accelerations by each way to solve for them, impacts, friction, reactions, rest, freedom.

Here belongs: Lagrange's equations in formulas, what happens at events, positions at which forces balance.
Not here: compiled functions, C; studies of a whole scene for people.
"""
