"""Motions in time, and the loop that holds a robot to its skill (paper 000, sections IV-C and IV-D).

D coordinates of a state, d dimensions of the manifold. A `Reference` is a path in time, known at evenly spaced
knots; its phase [s] is how far along it the robot should be, its rate how fast the phase goes on (1 as timed, 0
stopped). The foot of a state is its projection onto the manifold. Positions q, velocities qd and accelerations qdd
are (D,).
"""
