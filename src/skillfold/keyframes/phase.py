"""Where in a skill a pose is: which pair of consecutive Gaussians a motion from there belongs to."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skillfold.errors import InputError
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.gaussians import PoseGaussian


@dataclass(frozen=True)
class Phase:
    """Where a motion begins.

    Attributes:
        pair: index i of the parent: from Gaussian i to i + 1. At the last Gaussian, where nothing is left to do, the
            index of that.
        done: whether nothing is left to do.
        outside: how far [m] the pose lies outside the pair's envelope; 0 inside.
        told: the same in words.
    """

    pair: int
    done: bool
    outside: float
    told: str


def phase_of(
    gaussians: Sequence[PoseGaussian],
    envelopes: Sequence[SoftEnvelope],
    pose: Any,
    start_at: int | None = None,
) -> Phase:
    """The pair to start with from a pose (7,).

    Inside the gates of Gaussian i it is the pair (i, i + 1), in an envelope alone that envelope's, else the nearest
    envelope's (in metres, a radian as 0.15 m); where several hold, the earliest, which leaves out nothing of the
    skill. The paper's rule, the nearest centre and the nearer of its neighbours (section II-B.1), goes backwards as
    often as not.

    Args:
        gaussians, envelopes: of the skill, in order.
        pose: (7,) of the tool.
        start_at: the pair, whatever the pose.

    Raises:
        InputError: no such pair, or none at all: a single Gaussian, and the pose outside.
    """
    last = len(gaussians) - 1
    if start_at is not None:
        return _chosen(envelopes, pose, start_at)
    inside = [i for i, gaussian in enumerate(gaussians) if bool(gaussian.contains(pose))]
    if inside and inside[0] == last:
        return Phase(last, True, 0.0, f"inside the last Gaussian ({last}): nothing is left to do")
    if inside:
        return Phase(inside[0], False, 0.0, f"inside Gaussian {inside[0]}")
    _some(envelopes)
    outside = np.array([float(envelope.distance(pose)) for envelope in envelopes])
    pair = int(outside.argmin())
    return Phase(pair, False, float(outside[pair]), _place(pair, float(outside[pair])))


def _chosen(envelopes: Sequence[SoftEnvelope], pose: Any, start_at: Any) -> Phase:
    _some(envelopes)
    whole = isinstance(start_at, int | np.integer) and not isinstance(start_at, bool)
    pair = int(start_at) if whole else -1
    if not 0 <= pair < len(envelopes):
        raise InputError(f"start_at={start_at!r:.40}; expected a pair from 0 to {len(envelopes) - 1}.")
    outside = float(envelopes[pair].distance(pose))
    return Phase(pair, False, outside, _place(pair, outside))


def _some(envelopes: Sequence[SoftEnvelope]) -> None:
    if not envelopes:
        raise InputError("The skill has one keyframe, and no pair to start with; expected two keyframes at least.")


def _place(pair: int, outside: float) -> str:
    if outside == 0.0:
        return f"inside the envelope of pair {pair}, from Gaussian {pair} to {pair + 1}"
    return f"{outside:.2g} m outside every gate; nearest is pair {pair}, from Gaussian {pair} to {pair + 1}"
