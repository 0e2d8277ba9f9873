"""Numerical optimisation of one pose after another: what the learnt manifold saves (paper 000, Section V)."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize

from skillfold.motion import Array

Function = Callable[[Array], Array]


def optimise_poses(
    positions: Array,
    first: Array,
    cost: Function,
    gradient: Function,
    forward: Function,
    jacobian: Function,
) -> tuple[Array, float]:
    """Minimise cost(q) subject to forward(q) = position at each position, warm-started from its neighbour.

    SciPy's SLSQP with analytic derivatives and its default tolerance.

    Args:
        positions: (n, m) task positions along a path.
        first: (D,) pose to start the first optimisation from.
        cost, gradient: the scalar cost of a pose (D,) and its gradient (D,).
        forward, jacobian: task position (m,) of a pose and its derivative (m, D).

    Returns:
        The poses (n, D) and the share of the optimisations that report success.
    """
    poses, succeeded, q = [], 0, first
    for position in positions:
        reaches = {"type": "eq", "fun": _offset(forward, position), "jac": jacobian}
        result = minimize(cost, q, jac=gradient, constraints=[reaches], method="SLSQP")
        q = np.asarray(result.x, float)
        poses.append(q)
        succeeded += bool(result.success)
    return np.array(poses), succeeded / len(positions)


def _offset(forward: Function, position: Array) -> Function:
    return lambda q: forward(q) - position
