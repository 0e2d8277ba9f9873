"""Sequences of keyframes laid along an ordered list of places, with gaps on both sides."""

from typing import Any

import numpy as np

from skillfold.jit import njit

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

EXTRA = -1  # label of a keyframe that belongs to no place


@njit
def lay_along(found: Array, missed: Array, extra: float, count: int, scores: Array, labels: Indices) -> None:
    """Most likely places (S, m) of the first `count` keyframes of a sequence, increasing, under S models at once.

    Args:
        found: (S, m, K) logarithm of the likelihood of each keyframe at each place.
        missed: (S, K) of a place that the sequence leaves out.
        extra: of a keyframe that belongs to no place.
        count: of keyframes.
        scores: (m + 1, K + 1), written over.
        labels: (S, m), filled in.
    """
    places = found.shape[2]
    for s in range(len(found)):
        for i in range(count + 1):
            for k in range(places + 1):
                best = 0.0 if i + k == 0 else -np.inf
                if i > 0:
                    best = max(best, scores[i - 1, k] + extra)
                if k > 0:
                    best = max(best, scores[i, k - 1] + missed[s, k - 1])
                if i > 0 and k > 0:
                    best = max(best, scores[i - 1, k - 1] + found[s, i - 1, k - 1])
                scores[i, k] = best
        i, k = count, places
        while i > 0:
            if scores[i, k] == scores[i - 1, k] + extra:
                i -= 1
                labels[s, i] = EXTRA
            elif k > 0 and scores[i, k] == scores[i, k - 1] + missed[s, k - 1]:
                k -= 1
            else:
                i, k = i - 1, k - 1
                labels[s, i] = k
