"""The library, and packages of people's own, as pages to be read: a static site without a server.

Here belongs: what a page tells of a class, its formulas as written, scenes that show one component, HTML, the search.
Not here: what is drawn and how (draw), derived equations (paper); how the files are asked for (command).
"""
