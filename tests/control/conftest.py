"""A small skill over the planar arm, and controllers on it."""

import numpy as np
import pytest

import skillfold as sf
from skillfold.experiments.reaching import grid
from skillfold.experiments.three_link import REACHING, optimal

LATENCY = 0.03


@pytest.fixture(scope="session")
def planar():
    return sf.Robot.load("planar_arm")


@pytest.fixture(scope="session")
def poses():
    found = optimal(grid(), REACHING)
    return found[np.random.default_rng(0).choice(len(found), 100, replace=False)]


@pytest.fixture(scope="session")
def skill(poses):
    return sf.SkillManifold.fit(poses, dim=2, kernels=10, ridge=1e-5, jobs=1)


@pytest.fixture(scope="session")
def plan(skill):
    far = sorted(
        (skill.plan(a, b) for a, b in np.random.default_rng(2).permutation(skill.sample(20, 0)).reshape(10, 2, 3)),
        key=lambda plan: plan.length if plan.success else 0.0,
    )
    return far[-1]


@pytest.fixture
def make(skill, plan, planar):
    def made(**options):
        return sf.ReactiveController(skill, plan, **{"robot": planar, "latency": LATENCY} | options)

    return made
