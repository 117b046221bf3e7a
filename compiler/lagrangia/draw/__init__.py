"""Scenes to be looked at: drawing sections in numbers, laid out, as strokes and labels, as SVG, pictures and pages that move.

Here belongs: what the words of a drawing section look like, where loose parts stand, files of pictures of a mechanism.
Not here: what the words take (language/figures.py), solving, curves (view/curves.py).
"""
