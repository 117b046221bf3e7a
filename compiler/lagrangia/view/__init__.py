"""Results to be looked at: trajectories with their columns and energies, curves, the mechanism as lines.

Here belongs: tables, files and pictures of one run.
Not here: solving; pictures of studies (study/pictures.py) and of FMUs (fmu/pictures.py).
"""
