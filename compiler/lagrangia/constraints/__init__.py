"""What must hold: rows of positions and rates, parameters, start values, assembly, independent coordinates.

Here belongs: which equations there are and which repeat others, positions that fulfil them, singular positions.
Not here: mass, forces and multipliers.
"""
