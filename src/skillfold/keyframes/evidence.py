"""How likely keyframes are to share a place, whatever its mean and covariance: both integrated out.

Positions and rotations each follow a Gaussian whose mean may lie anywhere among all keyframes and whose covariance
has an inverse Wishart prior, so weak that three keyframes outweigh it. Then the probability of a further keyframe is
a Student t density, that of all keyframes of a place a ratio of determinants, and both need only sums over keyframes.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.special import gammaln

from skillfold.keyframes.charts import LENGTH

Array = np.ndarray[Any, np.dtype[np.float64]]

SUMS = 29  # of each keyframe: 1, its position, products of positions (9), products of quaternion components (16)
FREEDOM = 5.0  # of the inverse Wishart prior
SPREAD = 0.18  # prior standard deviation of a place, as a share of the spread of all keyframes
LEAST = np.array([[LENGTH], [1.0]])  # [m], [rad]: keyframes may lie anywhere in a box with sides of this at least
HITS, MISSES = 6.0, 1.5  # Beta prior of the share of demonstrations that show a keyframe
EXTRAS = 0.2  # prior number of extra keyframes in a row, at any place of a sequence


@dataclass(frozen=True)
class Places:
    """What sums over keyframes tell of places (S, K).

    Attributes:
        count: (S, K) keyframes.
        centre: (S, K, 3) mean positions.
        turn: (S, K, 4, 3) what takes a quaternion to its rotation from the mean, 2 sin(θ/2) along the axis.
        scatter: (S, K, 2, 3, 3) prior and squared differences from the mean, of positions and rotations.
    """

    count: Array
    centre: Array
    turn: Array
    scatter: Array


@dataclass(frozen=True)
class Prior:
    """What all keyframes together tell of one place.

    Attributes:
        volume: logarithm of the volume that positions and rotations spread over.
        spread: (2,) prior standard deviations [m], [rad].
    """

    volume: float
    spread: Array

    @classmethod
    def of(cls, sums: Array) -> Self:
        """From the sums (29,) over all keyframes."""
        whole = _places(sums[None, None], np.zeros(2))
        variances = np.linalg.eigvalsh(whole.scatter[0, 0] / max(sums[0], 1.0))
        sides = np.maximum(np.sqrt(12 * np.maximum(variances, 0.0)), LEAST)  # of the box that varies as they do
        volume = np.log(sides).sum(1)
        spread = SPREAD * np.exp(volume / 3) / np.sqrt(12)
        return cls(float(volume[0] + min(volume[1], np.log(8 * np.pi**2))), spread)

    def places(self, sums: Array) -> Places:
        """Places from sums (S, K, 29)."""
        return _places(sums, FREEDOM * self.spread**2)

    def further(self, places: Places, positions: Array, turns: Array) -> Array:
        """Logarithm (S, m, K) of the density of further keyframes at places, positions (m, 3), quaternions (m, 4)."""
        moved = positions[:, None] - places.centre[:, None]
        turned = np.einsum("mi,skij->smkj", turns, places.turn)
        values = sum(_student(places, block, v) for block, v in enumerate((moved, turned)))
        return np.where(places.count[:, None] > 0, values, -self.volume)

    def evidence(self, places: Places) -> Array:
        """Logarithm (S,) of the density of all keyframes of the places."""
        count = np.maximum(places.count, 1)
        freedom = FREEDOM + count - 1
        determinants = np.linalg.slogdet(places.scatter)[1].sum(-1)
        prior = 3 * np.log(FREEDOM * self.spread**2).sum()
        values = 0.5 * FREEDOM * prior - 0.5 * freedom * determinants - 3 * np.log(count)
        halves = 0.5 * np.arange(3)  # of the multivariate gamma functions
        values += 2 * (gammaln(0.5 * freedom[..., None] - halves) - gammaln(0.5 * FREEDOM - halves)).sum(-1)
        values -= 3 * (count - 1) * np.log(np.pi) + self.volume
        return np.where(places.count > 0, values, 0.0).sum(-1)

    @property
    def extra(self) -> float:
        """Logarithm of the density of a keyframe that belongs to no place."""
        return float(np.log(EXTRAS)) - self.volume


def sums_of(positions: Array, turns: Array) -> Array:
    """What is summed over keyframes: (n, 29)."""
    count = len(positions)
    products = [(v[:, :, None] * v[:, None]).reshape(count, -1) for v in (positions, turns)]
    return np.hstack([np.ones((count, 1)), positions, *products])


def shown(hits: Any, demonstrations: int) -> Array:
    """Logarithm (...,) of the probability of which demonstrations show a place, `hits` of them."""
    total = gammaln(HITS + MISSES) - gammaln(HITS + MISSES + demonstrations)
    some = gammaln(HITS + hits) + gammaln(MISSES + demonstrations - hits)
    return total + some - gammaln(HITS) - gammaln(MISSES)


def next_shown(hits: Array, demonstrations: int) -> tuple[Array, Array]:
    """Logarithms of the probability that a further demonstration shows a place, and that it does not."""
    hits = np.minimum(hits, demonstrations)  # a start may give a place more keyframes than there are demonstrations
    total = HITS + MISSES + demonstrations
    return np.log((HITS + hits) / total), np.log((MISSES + demonstrations - hits) / total)


def _places(sums: Array, prior: Array) -> Places:
    count = np.maximum(sums[..., :1], 1)
    centre = sums[..., 1:4] / count
    products = sums[..., 4:13].reshape(*sums.shape[:-1], 3, 3)
    moved = products - count[..., None] * centre[..., :, None] * centre[..., None, :]
    quaternions = sums[..., 13:].reshape(*sums.shape[:-1], 4, 4)
    turn = _from_mean(np.linalg.eigh(quaternions)[1][..., -1])
    turned = turn.swapaxes(-1, -2) @ quaternions @ turn
    scatter = np.stack([moved, turned], axis=-3) + prior[:, None, None] * np.eye(3)
    return Places(sums[..., 0], centre, turn, scatter)


def _from_mean(mean: Array) -> Array:
    """(..., 4, 3) such that 2 × vector part of mean⁻¹ q is q times it: sign and wrap drop out of its squares."""
    w, x, y, z = np.moveaxis(mean, -1, 0)
    columns = [[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]]
    return 2 * np.stack([np.stack(column, -1) for column in columns], -1)


def _student(places: Places, block: int, differences: Array) -> Array:
    """Logarithm (S, m, K) of the density of a further difference (S, m, K, 3) in a block."""
    count = np.maximum(places.count, 1)[:, None]
    freedom = FREEDOM + count - 3
    scatter = places.scatter[:, :, block]
    inverse, determinant = np.linalg.inv(scatter), np.linalg.slogdet(scatter)[1][:, None]
    squares = np.einsum("smki,skij,smkj->smk", differences, inverse, differences) * count / (count + 1)
    constant = gammaln(0.5 * freedom + 1.5) - gammaln(0.5 * freedom) - 1.5 * np.log(np.pi * (count + 1) / count)
    return constant - 0.5 * determinant - 0.5 * (freedom + 3) * np.log1p(squares)
