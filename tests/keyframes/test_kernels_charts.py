"""Chart coordinates against SciPy's rotation vectors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keyframes.envelopes import random_poses
from manifold.kernels import callable_of
from skillfold.keyframes.kernels import charts as _charts

charts = callable_of(_charts)


@pytest.mark.parametrize("sign", [1, -1])
def test_to_flat_and_back_to_full(sign):
    rng = np.random.default_rng(0)
    for pose, middle in zip(random_poses(50, rng), random_poses(50, rng)[:, 3:], strict=True):
        y, back = np.empty(6), np.empty(7)
        charts.to_flat(pose * np.repeat([1, sign], [3, 4]), middle, y)
        turn = Rotation.from_quat(middle, scalar_first=True).inv() * Rotation.from_quat(pose[3:], scalar_first=True)
        np.testing.assert_allclose(y, [*pose[:3], *turn.as_rotvec()], atol=1e-13)
        charts.to_full(y, middle, back)
        np.testing.assert_allclose(back * np.sign(back[3:] @ pose[3:]) ** [0, 0, 0, 1, 1, 1, 1], pose, atol=1e-14)


def test_flat_and_full_of_turns_that_hardly_turn():
    """No division by the length of a vector that has none."""
    poses, middle = np.zeros((5, 7)), np.array([1.0, 0.0, 0.0, 0.0])
    vectors = 10.0 ** -np.array([5.0, 8.0, 12.0, 16.0, 200.0])[:, None] * [1.0, -2.0, 0.5]
    poses[:, 3:] = Rotation.from_rotvec(vectors).as_quat(scalar_first=True)
    y, back = np.empty((5, 6)), np.empty((5, 7))
    charts.flat(poses, middle, y)
    np.testing.assert_allclose(y[:, 3:], vectors, rtol=1e-12, atol=1e-199)
    charts.full(y, middle, back)
    np.testing.assert_allclose(back, poses, rtol=1e-12, atol=1e-199)
