"""Worlds that can be stepped and looked at; obstacles that are put where they are."""

import pickle

import numpy as np
import pytest

import skillfold as sf
from skillfold.errors import InputError, RobotError
from skillfold.robots.poses import place_points
from skillfold.robots.world import World

PATH = sf.Motion([0.0, 1.0], [[0.6, 0.0, 0.5], [0.6, 0.5, 0.5]])
SHAPES = [
    sf.Box(pose=(0.6, 0.0, 0.1), size=(0.1, 0.1, 0.1), name="box"),
    sf.Sphere(center=(0.6, 0.0, 0.5), radius=0.05, motion=PATH, name="ball"),
    sf.PointCloud(points=[[0.3, 0.3, 0.3], [0.4, 0.3, 0.3]], radius=0.01, name="cloud"),
]


def test_moving_obstacles_are_put_where_they_are(lwr4):
    obstacles = lwr4.obstacles(SHAPES)
    assert obstacles.moves and not lwr4.obstacles(SHAPES[:1]).moves
    mine, q = obstacles.at(0.0), lwr4.home
    compiled = mine.compiled()
    for time in (0.0, 0.25, 0.8, 3.0):
        mine.place(compiled, time)
        assert mine.clearance(q) == pytest.approx(obstacles.at(time).clearance(q), abs=1e-12)


def test_a_world_holds_what_it_is_given(lwr4):
    world = World(lwr4, SHAPES, sf.Tray(tumblers=2))
    world.reset(lwr4.home)
    assert np.allclose(world.data.qpos[world.places], lwr4.home)
    assert world.tumblers().shape == (2, 7)
    world.move_obstacles(0.5)
    assert np.allclose(world.data.mocap_pos[0], [0.6, 0.25, 0.5])
    assert world.body("link3") == world.body(3)


def test_held_by_its_own_dynamics_an_arm_with_a_load_stays(lwr4):
    tray = sf.Tray(tumblers=0)
    world, q = World(lwr4, None, tray), lwr4.home
    world.reset(q)
    torque = lwr4.dynamics(*tray.load).bias(q, np.zeros(7))
    for _ in range(200):
        world.advance(torque)
    assert np.abs(world.data.qpos[world.places] - q).max() < 1e-3


def test_contacts_have_names(lwr4):
    tool = lwr4.forward(lwr4.home)[:3]
    world = World(lwr4, [sf.Sphere(center=tool, radius=0.05, name="ball")])
    world.reset(lwr4.home)
    assert any("ball" in pair for pair in world.contacts())
    away = World(lwr4, SHAPES[2:])
    away.reset(lwr4.home)
    assert away.contacts() == []


@pytest.mark.parametrize("body", ["elbow", 0, 8, True, None, 1.5])
def test_a_body_that_is_not_there_is_told(lwr4, body):
    with pytest.raises(InputError, match="possible: 1 to 7, base, link1"):
        World(lwr4).body(body)


def test_tumblers_stand_on_the_tray(lwr4):
    tray = sf.Tray(tumblers=4, height=0.05)
    pose = np.array([0.5, 0.1, 0.8, 1.0, 0, 0, 0])
    standing = tray.standing(pose)
    assert np.allclose(standing[:, 2], 0.8 + 0.05 + tray.length / 2)
    assert np.allclose(np.linalg.norm(standing[:, :2] - pose[:2], axis=1), tray.circle)
    mass, center = tray.load
    assert mass == pytest.approx(tray.mass + 4 * tray.tumbler_mass) and 0.05 < center[2] < 0.11


def test_with_a_tray_more_must_be_clear_and_the_load_is_known(lwr4):
    tray, q, still = sf.Tray(), lwr4.home, np.zeros(7)
    carrying = pickle.loads(pickle.dumps(lwr4.with_tray(tray)))
    tool = lwr4.forward(q)
    top = place_points(tool, np.array([0.0, 0.0, tray.height + tray.length + 0.03]))
    ball = [sf.Sphere(center=top, radius=0.01)]
    assert carrying.obstacles(ball, self_collision=False).clearance(q) == pytest.approx(0.02, abs=1e-4)
    assert lwr4.obstacles(ball, self_collision=False).clearance(q) > 0.1
    assert carrying.self_clearance(q) == pytest.approx(lwr4.self_clearance(q))
    assert np.allclose(carrying.dynamics().bias(q, still), lwr4.dynamics(*tray.load).bias(q, still))
    assert np.allclose(carrying.forward(q), tool) and carrying.names == lwr4.names


@pytest.mark.parametrize("wrong", [{"mass": 0.0}, {"size": (1, 1)}, {"radius": np.nan}, {"height": np.inf}])
def test_trays_that_make_no_sense_are_told(wrong):
    with pytest.raises(InputError, match="Tray"):
        sf.Tray(**wrong)


def test_pictures_where_they_can_be_drawn(lwr4):
    from skillfold.robots.rendering import pictures

    world = World(lwr4, SHAPES, sf.Tray(), visual=True)
    world.reset(lwr4.home)
    try:
        drawn = list(pictures(world, np.zeros(2), np.repeat(lwr4.home[None], 2, axis=0), np.zeros((2, 3, 7))))
    except RobotError as error:
        assert "MUJOCO_GL" in str(error)
        return
    assert drawn[0].shape == (480, 640, 3) and drawn[0].std() > 5
