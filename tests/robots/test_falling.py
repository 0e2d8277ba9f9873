"""What stands, what falls, and who touches what."""

import numpy as np
import pytest

from skillfold.errors import InputError, RobotError
from skillfold.robots.falling import Falling
from skillfold.robots.rendering import View, snapshots
from skillfold.robots.robot import Robot
from skillfold.robots.shapes import Box, Sphere
from skillfold.robots.standing import base_of

UPRIGHT = np.array([0.0, 0.0, 0.32, 1.0, 0.0, 0.0, 0.0])
HIGH = np.array([0.0, 0.0, 1.32, 1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def nao():
    return Robot.load("nao")


@pytest.fixture(scope="module")
def floor(nao):
    return Falling(nao)


def standing(nao, q):
    return base_of(nao, q, "l_sole", (0.0, 0.05, 0.0))


def test_it_stands_on_both_feet_at_home(nao, floor):
    floor.reset(nao.home, standing(nao, nao.home))
    floor.hold(1.0)
    assert floor.leaning(UPRIGHT) < 0.02
    assert floor.touching() == {"LAnkleRollLink", "RAnkleRollLink"}
    assert floor.bumps() == set()
    np.testing.assert_allclose(floor.joints, nao.home, atol=0.03)


def test_it_falls_when_it_leans_too_far(nao, floor):
    q = nao.home
    q[[nao.names.index("LAnklePitch"), nao.names.index("RAnklePitch")]] += 0.6
    floor.reset(q, standing(nao, q))
    begun = floor.base
    floor.hold(1.0)
    assert floor.leaning(begun) > 0.5


def test_motors_are_no_stronger_than_published(nao, floor):
    q = nao.home
    far = nao.couple(q + 1.0)
    floor.reset(q, HIGH)
    floor.follow(np.stack([q, far]), 0.05)
    force = np.abs(floor.data.actuator_force)
    limits = [nao.torque_limits[nao.names.index(floor.model.actuator(i).name)] for i in range(floor.model.nu)]
    assert (force <= np.array(limits) + 1e-12).all()
    assert (force >= 0.99 * np.array(limits)).any()


def test_it_follows_from_rest_to_rest(nao, floor):
    q = nao.home
    bent = q.copy()
    for side in "LR":
        bent[[nao.names.index(side + name) for name in ("HipPitch", "KneePitch", "AnklePitch")]] += [-0.1, 0.2, -0.1]
    floor.reset(q, standing(nao, q))
    bases = floor.follow(np.stack([q, bent]), 1.0)
    assert bases.shape == (100, 7)
    floor.hold(0.5)
    np.testing.assert_allclose(floor.joints, bent, atol=0.03)
    assert floor.base[2] < bases[0, 2] - 0.005
    assert floor.leaning(UPRIGHT) < 0.03


def test_obstacles_stop_it_and_are_told(nao):
    wall = Box(pose=(0.0, 0.4, 0.02), size=(0.6, 0.6, 0.04), name="slab")
    among = Falling(nao, [wall])
    q = nao.home
    among.reset(q, base_of(nao, q, "l_sole", (0.0, 0.15, 0.03)))
    assert ("LAnkleRollLink", "slab") in among.bumps()


def test_bodies_pass_where_they_are_told_to(nao):
    q = nao.home
    passing = Falling(nao, passing=["RAnkleRollLink"])
    passing.reset(q, standing(nao, q))
    passing.hold(0.02)
    assert passing.touching() == {"LAnkleRollLink"}


def test_own_parts_stop_each_other_only_if_asked(nao):
    q = nao.home
    q[[nao.names.index("LHipRoll"), nao.names.index("RHipRoll")]] = [-0.37, 0.37]
    assert nao.self_clearance(q) < 0
    for own in (True, False):
        world = Falling(nao, own=own)
        world.reset(q, HIGH)
        assert bool(world.bumps()) is own


def test_a_fixed_base_cannot_fall():
    with pytest.raises(InputError, match="cannot fall"):
        Falling(Robot.load("lwr4"))


def test_snapshots_or_a_word_why_not(nao):
    shown = Falling(nao, visual=True)
    try:
        (picture,) = snapshots(shown, nao.home[None], UPRIGHT[None])
    except RobotError as error:
        assert "MUJOCO_GL" in str(error)
    else:
        assert picture.shape == (480, 640, 3)
        assert picture.std() > 5


def test_snapshots_show_bodies_and_obstacles_in_their_colours(nao):
    ball = Sphere(center=(0.3, 0.0, 0.2), radius=0.05, name="ball")
    paint = {"ball": (1.0, 0.0, 0.0), "RKneePitchLink": (0.0, 0.0, 1.0)}
    view = View((0.2, 0.0, 0.2), 0.8, 200.0, -10.0, (160, 120))
    seen = []
    for colors in (None, paint):
        try:
            (picture,) = snapshots(Falling(nao, [ball], visual=True), nao.home[None], UPRIGHT[None], view, colors)
        except RobotError as error:
            assert "MUJOCO_GL" in str(error)
            return
        assert picture.shape == (120, 160, 3)
        red, _, blue = (picture[..., i].astype(int) for i in range(3))
        seen.append([(red > blue + 80).sum(), (blue > red + 80).sum()])
    assert seen[0] == [0, 0]
    assert min(seen[1]) > 20
