"""Where things are: the graph of frames, spanning trees and cut joints, poses, velocities. Only this room knows the dimension.

Here belongs: kinds of joints and their edges, evaluation of expressions at positions, kinematics.
Not here: masses, forces, energies; how constraints are solved.
"""
