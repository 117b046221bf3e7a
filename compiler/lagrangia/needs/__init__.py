"""What a scene may leave out, and shorter ways: linear equations, islands, loads in time, what depends on what.

Here belongs: each property that lets a run be cheaper, how it is proved, and the table of them that `lag explain` prints.
Not here: how what is left is run.
"""
