"""Things in a robot's hand: what keeps clear, what it weighs, and what cannot be held."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import skillfold as sf
from skillfold.errors import InputError, SceneError
from skillfold.robots.poses import compose, place_points
from skillfold.robots.world import World

CHERRY = sf.Sphere(center=(0.0, 0.0, 0.05), radius=0.01, name="cherry")
STICK = sf.Capsule(pose=(0.0, 0.0, 0.2), radius=0.01, length=0.3, name="stick")


@pytest.fixture(scope="module")
def jaco(robots):
    return robots["jaco"]


@pytest.fixture(scope="module")
def holding(jaco):
    return jaco.holding(CHERRY)


def test_a_held_thing_keeps_clear_of_the_scene(jaco, holding):
    q = jaco.home
    above = place_points(jaco.forward(q), np.array([0.0, 0.0, 0.08]))
    ball = [sf.Sphere(center=above, radius=0.005, name="ball")]
    obstacles = holding.obstacles(ball, self_collision=False)
    assert obstacles.clearance(q) == pytest.approx(0.03 - 0.015, abs=1e-6)
    assert obstacles.nearest(q) == "held: cherry to ball"
    assert jaco.obstacles(ball, self_collision=False).clearance(q) > 0.02


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000))
def test_its_surface_is_where_the_tool_carries_it(robots, seed):
    """Of a box turned in the hand: the distance of a far ball is that from the box's nearest point."""
    rng = np.random.default_rng(seed)
    turned = rng.standard_normal(4)
    pose = np.concatenate([[0.02, -0.03, 0.3], turned / np.linalg.norm(turned)])
    size = rng.uniform(0.02, 0.1, 3)
    robot = robots["jaco"].holding(sf.Box(pose, size))
    q = robot.sample(1, seed)[0]
    box = compose(robots["jaco"].forward(q), pose)
    corner = place_points(box, size / 2)
    far = place_points(box, size / 2 + 0.03)
    ball = [sf.Sphere(center=far, radius=0.001)]
    found = robot.obstacles(ball, self_collision=False).clearance(q)
    others = robots["jaco"].obstacles(ball, self_collision=False).clearance(q)
    assert found == pytest.approx(min(np.linalg.norm(far - corner) - 0.001, others), abs=1e-5)


def test_it_keeps_clear_of_the_robot_but_not_of_the_hand(jaco):
    near = jaco.holding(sf.Sphere(center=(0.0, 0.0, 0.0), radius=0.02))
    assert near.self_clearance(jaco.home) == pytest.approx(jaco.self_clearance(jaco.home), abs=1e-9)
    long = jaco.holding(STICK)
    states = jaco.sample(200, 1)
    own, held = jaco.self_clearance(states), long.self_clearance(states)
    assert (held <= own + 1e-9).all() and (held < own - 0.01).any()
    q = states[(own - held).argmax()]
    assert "held: stick" in long.obstacles().nearest(q)


def test_dynamics_know_the_mass(jaco):
    q, still = jaco.home, np.zeros(6)
    holding = jaco.holding([CHERRY], mass=0.7)
    assert np.allclose(holding.dynamics().bias(q, still), jaco.dynamics(0.7, CHERRY.center).bias(q, still))


def test_mass_is_shared_by_volume(jaco):
    small = sf.Box((0.0, 0.0, 0.1), (0.1, 0.1, 0.1))
    large = sf.Box((0.0, 0.2, 0.1), (0.2, 0.1, 0.1))
    holding, q, still = jaco.holding([small, large], 0.3), jaco.home, np.zeros(6)
    middle = (0.0, 0.2 * 2 / 3, 0.1)
    assert np.allclose(holding.dynamics().bias(q, still), jaco.dynamics(0.3, middle).bias(q, still))


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (sf.Cylinder((0, 0, 0.1), 0.02, 0.1), np.pi * 4e-4 * 0.1),
        (sf.Capsule((0, 0, 0.1), 0.02, 0.1), np.pi * 4e-4 * (0.1 + 0.08 / 3)),
        (sf.Sphere((0, 0, 0.1), 0.02), 4 / 3 * np.pi * 8e-6),
    ],
)
def test_volumes(jaco, shape, volume):
    cube = sf.Box((0, 0, 0.3), (0.05, 0.05, 0.05))
    model = jaco.holding([shape, cube], 1.0).model
    mass = model.body("held").mass[0]
    middle = model.body("held").ipos[2]
    share = volume / (volume + 0.05**3)
    assert mass == pytest.approx(1.0) and middle == pytest.approx(0.1 * share + 0.3 * (1 - share))


def test_it_can_be_sent_to_other_processes_with_all_it_holds(jaco, holding):
    again = pickle.loads(pickle.dumps(holding.holding(STICK, 0.2)))
    states = jaco.sample(20, 3)
    assert np.array_equal(again.self_clearance(states), holding.holding(STICK, 0.2).self_clearance(states))
    assert again.tool == jaco.tool and np.array_equal(again.forward(states), jaco.forward(states))
    assert again.names == jaco.names and np.array_equal(again.home, jaco.home)


def test_the_robot_itself_is_as_it_was(jaco, holding):
    assert "held" not in jaco.frames and "held" in holding.frames


def test_two_things_of_one_name_may_be_held_one_after_the_other(jaco):
    both = jaco.holding(CHERRY).holding(sf.Sphere((0.1, 0, 0.05), 0.01, name="cherry"))
    assert {"held", "held_1"} <= set(both.frames)


def test_robots_without_a_tool_frame_keep_theirs(robots):
    nao = robots["nao"]
    assert nao.holding(CHERRY).tool == nao.tool


def test_in_a_world_the_held_thing_touches(jaco, holding):
    place = place_points(jaco.forward(jaco.home), np.array([0.0, 0.0, 0.065]))
    world = World(holding, [sf.Sphere(center=place, radius=0.007, name="ball")])
    world.reset(jaco.home)
    assert {"held: cherry", "ball"} in [set(pair) for pair in world.contacts()]


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan, np.inf, "1", None, True])
def test_masses_that_make_no_sense_are_told(jaco, mass):
    with pytest.raises(InputError, match="kilograms"):
        jaco.holding(CHERRY, mass)


@pytest.mark.parametrize(
    "shapes",
    [
        [],
        None,
        3,
        "box",
        [CHERRY, CHERRY],
        sf.PointCloud([[0, 0, 0]], 0.01),
        sf.Mesh([[0, 0, 0], [0, 0, 1], [0, 1, 0], [1, 0, 0]]),
        [sf.Sphere((0, 0, 0), 0.1, motion=sf.Motion([0.0], [[0.0, 0.0, 0.0]]))],
    ],
)
def test_what_cannot_be_held_is_told(jaco, shapes):
    with pytest.raises(SceneError):
        jaco.holding(shapes)


@pytest.mark.parametrize("tray", [None, "tray", CHERRY])
def test_what_is_no_tray_is_told(jaco, tray):
    with pytest.raises(InputError, match="expected a Tray"):
        jaco.with_tray(tray)


def test_two_trays_are_one_too_many(jaco):
    with pytest.raises(InputError, match="carries a tray already"):
        jaco.with_tray(sf.Tray()).with_tray(sf.Tray())


@pytest.mark.parametrize(
    "wrong",
    [{"size": "big"}, {"size": None}, {"size": (1, 2)}, {"tumblers": 1.5}, {"height": "high"}, {"mass": [1, 2]}],
)
def test_trays_that_make_no_sense_are_told(wrong):
    with pytest.raises(InputError):
        sf.Tray(**wrong)
