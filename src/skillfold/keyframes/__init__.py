"""Keyframe skills (Tao, Akgun, Thomaz and Billard): pose Gaussians, Soft-Envelope, PCTC-RRT*.

Notation, as in paper 002 where it has a sign: μ_p, Σ_p and μ_c, Σ_c mean and covariance of the parent and the child
Gaussian; s from 0 to 1 the place along the axis from parent to child; N_eig kept directions for α percent of the
variance; q joint positions; p a pose (7,) x, y, z, qw, qx, qy, qz; y its chart coordinates (6,), see `charts`.
"""
