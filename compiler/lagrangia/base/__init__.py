"""What everybody may lean on: faults and where they are, folders, kept results, files, checked values.

Here belongs: diagnostics with their place, the cache and its safety, files that are written whole or not at all, checks of what
a person gives, spelling for terminals, the version.
Not here: anything that knows what mechanics is.
"""
