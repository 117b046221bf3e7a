"""This product beside its peers: problems, references, times and errors, tables and pictures of them.

Here belongs: what `lag bench` measures, through lagrangia.Model as a user would.
Not here: anything that users of scenes need.
"""
