"""Where things are: the graph of frames, spanning trees and cut joints, poses, velocities. Only this room knows the dimension.

Here belongs: kinds of joints and their edges, evaluation of expressions at positions, kinematics; what a frame, a cut joint and a
body's inertia are in the plane (planar*.py).
Not here: forces, energies; how constraints are solved.
"""
