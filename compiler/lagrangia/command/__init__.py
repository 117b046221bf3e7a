"""The command `lag`: a module a subcommand, its options, its words, its exit codes.

Here belongs: what is read from the command line and printed on it; help topics; exports of scenes.
Not here: formulas, and anything that Python users could want without a command line.
"""
