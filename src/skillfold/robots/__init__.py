"""Robots, scenes and the clearance between them, over one MuJoCo model.

q (dof,) joint positions [rad, m] in the order of `Robot.names`; poses (x, y, z, qw, qx, qy, qz); clearance is the
smallest signed distance [m] over pairs of shapes, negative where they overlap. K joints of the model, of which some
may follow others; P pairs of shapes. MuJoCo stays in this room.
"""
