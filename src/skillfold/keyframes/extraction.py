"""Keyframes from full recordings: gripper events, or where the tool rests or turns sharply; always both ends."""

from typing import Any

import numpy as np

from skillfold.keyframes.charts import LENGTH

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

REST = 0.1  # share of the speed that nine tenths of the recording keep below: slower is rest
RESTING = 0.03  # share of the recording that a rest lasts at least
ALONG = 0.05  # share of the path on either side that directions are taken over
SHARP = np.cos(np.radians(60))  # cosine of the change of direction that makes a keyframe
NEAR = 0.05  # share of the path within which two keyframes are one
HYSTERESIS = 0.25  # of a gripper's range: it opens above the middle by as much, and closes below


def extract(poses: Array, times: Array | None = None, gripper: Array | None = None) -> Indices:
    """Rows of a recording (n, 7) that are its keyframes, in order.

    With a gripper: where it closes or opens, that is, crosses the middle of its range. Without: the slowest state of
    each rest (speed below a tenth of the fast part's, a radian as 0.15 m, for 3 % of the recording), and the sharpest
    state of each turn (60° or more). Keyframes within a twentieth of the path are merged; the ends always count.

    Args:
        poses: consistent along the recording; one state at least.
        times: (n,) seconds; left out, states are taken as evenly spaced in time.
        gripper: (n,) any signal that differs when the gripper is open and closed.
    """
    last = len(poses) - 1
    curve = developed(poses)
    along = np.concatenate([[0.0], np.linalg.norm(np.diff(curve, axis=0), axis=1).cumsum()])
    if last < 2 or along[-1] <= 0.0:
        return np.unique([0, last])
    found = [_rests(along, times), _turns(curve, along)] if gripper is None else [_events(gripper)]
    return _merged(np.sort(np.concatenate(found)), along)


def developed(poses: Array) -> Array:
    """Poses (n, 7) as a curve (n, 6) [m] whose steps are those of position and rotation, a radian as `LENGTH`."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_quat(poses[:, 3:], scalar_first=True)
    turned = (turns[1:] * turns[:-1].inv()).as_rotvec() if len(poses) > 1 else np.empty((0, 3))
    steps = np.hstack([np.diff(poses[:, :3], axis=0), LENGTH * turned])
    return np.vstack([np.zeros(6), steps.cumsum(0)])


def _rests(along: Array, times: Array | None) -> Indices:
    """The middle of each stretch that is slow for long enough; those at the ends are no rests on the way."""
    n = len(along)
    clock = np.arange(n) if times is None else times
    reach = max(1, round(RESTING * n / 2))
    before, after = np.maximum(np.arange(n) - reach, 0), np.minimum(np.arange(n) + reach, n - 1)
    speed = (along[after] - along[before]) / (clock[after] - clock[before])
    slow = np.concatenate([[False], speed < REST * np.quantile(speed, 0.9), [False]])
    starts, ends = np.flatnonzero(slow[1:] & ~slow[:-1]), np.flatnonzero(~slow[1:] & slow[:-1]) - 1
    return (starts + ends) // 2


def _turns(curve: Array, along: Array) -> Indices:
    """Where the direction before and the direction after differ most, if they differ by `SHARP`."""
    marks = np.linspace(0.0, along[-1], 1 + round(8 / ALONG))  # evenly along the path, whatever the speed
    even = np.column_stack([np.interp(marks, along, column) for column in curve.T])
    w = 8
    before, after = even[w:-w] - even[: -2 * w], even[2 * w :] - even[w:-w]
    lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    cosine = (before * after).sum(1) / np.maximum(lengths, 1e-300)
    sharp = [i for i in np.flatnonzero(cosine < SHARP) if cosine[i] <= cosine[max(i - w, 0) : i + w + 1].min()]
    return np.searchsorted(along, marks[np.array(sharp, np.int64) + w]).astype(np.int64)


def _events(gripper: Array) -> Indices:
    """First rows of the gripper's other state."""
    low, high = gripper.min(), gripper.max()
    if not high > low:
        return np.empty(0, np.int64)
    level = (gripper - low) / (high - low) - 0.5
    sure = np.flatnonzero(np.abs(level) >= HYSTERESIS)
    state = level[sure] > 0
    return sure[1:][state[1:] != state[:-1]]


def _merged(rows: Indices, along: Array) -> Indices:
    """Rows without those too near to the one before, or to an end."""
    near, last = NEAR * along[-1], len(along) - 1
    kept = [0]
    for row in rows:
        if along[row] - along[kept[-1]] > near and along[-1] - along[row] > near:
            kept.append(int(row))
    return np.array([*kept, last], np.int64)
