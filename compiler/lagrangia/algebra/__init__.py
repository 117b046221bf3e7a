"""Numbers that are formulas: scalars, duals, the algebras of CasADi and SymPy, normal forms, small linear algebra.

Here belongs: what sums, products, sines, norms and their derivatives are, whatever they stand for.
Not here: frames, names of coordinates, text of models.
"""
