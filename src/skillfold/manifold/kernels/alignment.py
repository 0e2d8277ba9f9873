"""The tangent field at edges against the edges' steps: the corrected equation 6, edge by edge."""

from typing import Any

import numpy as np

from skillfold.jit import njit

Array = np.ndarray[Any, np.dtype[np.float64]]


@njit
def align_steps(field: Array, steps: Array, ridge: float, eps: Array, misfit: Array) -> None:
    """ε = (H'H + λI)⁻¹ H'Δ into `eps` (E, d) and Hε − Δ into `misfit` (E, D).

    Args:
        field: (E, d, D), H at each edge, a column of it a row here.
        steps: (E, D).
        ridge: λ.
        eps, misfit: written.
    """
    E, d, D = field.shape
    gram = np.empty((d, d))
    for e in range(E):
        for a in range(d):
            for b in range(a + 1):
                s = ridge if a == b else 0.0
                for c in range(D):
                    s += field[e, a, c] * field[e, b, c]
                for i in range(b):
                    s -= gram[a, i] * gram[b, i]
                gram[a, b] = np.sqrt(max(s, 1e-300)) if a == b else s / gram[b, b]
            s = 0.0
            for c in range(D):
                s += field[e, a, c] * steps[e, c]
            for b in range(a):
                s -= gram[a, b] * eps[e, b]
            eps[e, a] = s / gram[a, a]
        for a in range(d - 1, -1, -1):
            for b in range(a + 1, d):
                eps[e, a] -= gram[b, a] * eps[e, b]
            eps[e, a] /= gram[a, a]
        for c in range(D):
            s = -steps[e, c]
            for a in range(d):
                s += field[e, a, c] * eps[e, a]
            misfit[e, c] = s
