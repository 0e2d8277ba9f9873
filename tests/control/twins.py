"""Plain NumPy twins of the kernels of `skillfold.control.kernels`, written from their descriptions."""

import numpy as np
from numpy.polynomial import Polynomial


def quintic(start, end, duration):
    """The polynomial through positions, velocities, accelerations (3,) at both ends."""
    T = duration
    rows = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]]
    rows += [
        [T**k for k in range(6)],
        [k * T ** max(k - 1, 0) for k in range(6)],
        [k * (k - 1) * T ** max(k - 2, 0) for k in range(6)],
    ]
    return Polynomial(np.linalg.solve(np.array(rows, float), np.concatenate([start, end])))


def values(polynomial, time):
    """Value, first and second derivative."""
    return np.array([polynomial(time), polynomial.deriv(1)(time), polynomial.deriv(2)(time)])


def evaluate(knots, step, time):
    """(3, D) at a time, at rest beyond the ends."""
    time = min(max(time, 0.0), (len(knots) - 1) * step)
    k = min(int(time / step), len(knots) - 2)
    parts = [quintic(knots[k, :, c], knots[k + 1, :, c], step) for c in range(knots.shape[2])]
    return np.stack([values(part, time - k * step) for part in parts], axis=1)


def brake(state, duration, time):
    end = np.zeros_like(state)
    end[0] = state[0] + 0.5 * duration * state[1]
    parts = [quintic(state[:, c], end[:, c], duration) for c in range(state.shape[1])]
    return np.stack([values(part, time) for part in parts], axis=1)


def excess(state, velocity, acceleration):
    return max(np.abs(state[1] / velocity).max(), np.abs(state[2] / acceleration).max())


def mix(knots, step, state, duration, delay, k):
    """Product rule for (1 - w) · braking + w · reference, which begins later."""
    w = Polynomial([0, 0, 0, 10 / duration**3, -15 / duration**4, 6 / duration**5])
    w0, w1, w2 = values(w, k * step)
    new = knots[k - delay] if k >= delay else knots[0] * [[1], [0], [0]]
    old = brake(state, duration, k * step)
    gap = new - old
    return np.array(
        [
            old[0] + w0 * gap[0],
            old[1] + w0 * gap[1] + w1 * gap[0],
            old[2] + w0 * gap[2] + 2 * w1 * gap[1] + w2 * gap[0],
        ]
    )


def tangent_projector(kept, basis):
    """(D, D) onto what lies across the tangents."""
    inner = np.eye(kept.shape[1]) - basis.T @ basis
    return kept @ inner @ kept.T


def eased(pull, calm, most):
    """A spring with the same damping ratio, whose damping is no more than most."""
    ratio = calm / (2 * np.sqrt(pull))
    return ((min(calm, most) / (2 * ratio)) ** 2, min(calm, most))


def feedback(gains, off, along, off_speed, along_speed, most):
    pull = gains[2] * (1 + (gains[4] - 1) * min(np.linalg.norm(off) / gains[5], 1))
    (lead, drag), (pull, calm) = eased(*gains[:2], most), eased(pull, 2 * gains[3] * np.sqrt(pull), most)
    return -lead * along - drag * along_speed - pull * off - calm * off_speed


def bound(vector, limit):
    return vector * min(1.0, (limit / np.maximum(np.abs(vector), 1e-300)).min())


def restrain(q, qd, lower, upper, velocity, rise, reaction, interval, acceleration):
    quick = max(0.02, interval)
    top = np.minimum(velocity, np.sqrt(2 * rise * np.maximum(upper - q, 0)))
    bottom = -np.minimum(velocity, np.sqrt(2 * rise * np.maximum(q - lower, 0)))
    most, least = np.maximum((top - qd) / quick, -reaction), np.minimum((bottom - qd) / quick, reaction)
    return np.clip(np.minimum(np.maximum(acceleration, least), most), -reaction, reaction)
