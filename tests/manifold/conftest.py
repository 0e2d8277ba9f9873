"""Skills fitted once for all tests of the manifold family, and one of them saved."""

import numpy as np
import pytest

from manifold import clouds
from manifold.laws import KINDS, Skills
from skillfold import SkillManifold
from skillfold.experiments.reaching import grid
from skillfold.experiments.three_link import REACHING, optimal


def fit(demos, dim, kernels=10, **options):
    """A quick fit: nothing but the local surfaces is chosen by cross-validation."""
    return SkillManifold.fit(demos, dim=dim, kernels=kernels, ridge=1e-5, jobs=1, **options)


def arm_poses(count, seed):
    """Optimal poses of section V-A's three-link arm."""
    poses = optimal(grid(), REACHING)
    return poses[np.random.default_rng(seed).choice(len(poses), count, replace=False)]


def curves(count=6, steps=60):
    """Recordings that differ in their ends and their shape."""
    t = np.linspace(0, 1, steps)
    return [np.column_stack([t, np.sin(2 * t) + 0.05 * i * (1 - t), 0.1 * i * t + t**2]) for i in range(count)]


@pytest.fixture(scope="session")
def sphere():
    return fit(clouds.draw_sphere(250, np.random.default_rng(0)), 2, 20)


@pytest.fixture(scope="session")
def arm():
    return fit(arm_poses(100, 0), 2)


@pytest.fixture(scope="session")
def cylinder():
    """Circle × line × line: two of four directions are free."""
    return fit(clouds.cylinder(2)(500, np.random.default_rng(1))[0], 3)


@pytest.fixture(scope="session")
def recorded():
    return fit(curves(), 1, 6)


@pytest.fixture(scope="session")
def creased():
    """Two smooth halves that meet at an angle, without noise."""
    return fit(clouds.crease(100, np.random.default_rng(1)), 2, 20)


@pytest.fixture(scope="session")
def skills(sphere, arm, cylinder, recorded):
    return Skills(zip(KINDS, (sphere, arm, cylinder, recorded), strict=True))


@pytest.fixture(params=KINDS)
def skill(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def saved(recorded, tmp_path):
    path = tmp_path / "skill.npz"
    recorded.save(path)
    return path
