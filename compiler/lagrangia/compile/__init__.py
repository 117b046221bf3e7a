"""All phases in their order, and what comes out of them: functions, instructions, tapes, the scene as data.

Here belongs: pipeline.py, the page on which the whole compiler is seen; hoisting; dumps of phases; functions for NumPy.
Not here: formulas of mechanics, uses of a compiled scene.
"""
