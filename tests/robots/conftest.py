"""Robots that many tests ask."""

import pytest

import skillfold as sf


@pytest.fixture(scope="session")
def robots():
    return {name: sf.Robot.load(name) for name in ("jaco", "lwr4", "nao", "planar_arm")}


@pytest.fixture(scope="session")
def lwr4(robots):
    return robots["lwr4"]


@pytest.fixture(scope="session")
def nao(robots):
    return robots["nao"]


@pytest.fixture(scope="session")
def planar(robots):
    return robots["planar_arm"]
