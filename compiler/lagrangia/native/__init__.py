"""From functions as data to machine code: tapes, C text written from them, C compilers, built libraries.

Here belongs: what a tape is, its C in all kinds of arithmetic, the compilers of this machine and what they have built.
Not here: how a tape is made (room compile), CasADi, SymPy, Lark.
"""
