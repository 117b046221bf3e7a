"""Pages that compute: a scene, its drawing and the C run time in WebAssembly, in one file.

Here belongs: building the run time for pages, what a page draws its strokes from, its controls and scripts.
Not here: what the words of a drawing look like on paper (draw/strokes.py), the C that a page calls (runtime/fmi/play.c).
"""
