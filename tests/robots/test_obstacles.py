"""Clearance: against analytic cases, plain MuJoCo, finite differences and dense sampling."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import skillfold as sf
from robots import scenes
from skillfold.errors import InputError, SceneError
from skillfold.jit import njit
from skillfold.robots import distances, shape_distances
from skillfold.robots.bounds import travel
from skillfold.robots.obstacles import Obstacles

LAWS = settings(max_examples=25, deadline=None)
NAMES = st.sampled_from(["jaco", "lwr4", "nao", "planar_arm"])
TURNED = np.array([np.cos(0.3), 0, 0, np.sin(0.3)])


def plain(obstacles, q):
    """Smallest distance over all pairs and points, by MuJoCo's Python interface: the twin of the compiled loops."""
    layout, robot = obstacles._layout, obstacles.robot
    model = layout.merged.model
    data, segment = mujoco.MjData(model), np.zeros(6)
    data.qpos[: len(layout.joints.rest)] = layout.joints.rest
    data.qpos[layout.joints.addresses] = robot.couple(q)
    for name, place in layout.merged.mocaps.items():
        pose = obstacles.scene[name].at(obstacles.time)
        data.mocap_pos[place], data.mocap_quat[place] = pose[:3], pose[3:]
    mujoco.mj_kinematics(model, data)
    found = [mujoco.mj_geomDistance(model, data, int(a), int(b), 100.0, segment) for a, b in layout.pairs]
    for shape in obstacles.scene:
        if isinstance(shape, sf.PointCloud):
            proxy = layout.merged.shapes[shape.name]
            turned = np.empty(9)
            mujoco.mju_quat2Mat(turned, shape.at(obstacles.time)[3:])
            for point in shape.points:
                data.geom_xpos[proxy] = shape.at(obstacles.time)[:3] + turned.reshape(3, 3) @ point
                found += [mujoco.mj_geomDistance(model, data, int(g), proxy, 100.0, segment) for g in layout.moving]
    return min(found, default=np.inf)


# The planar arm stretched along x is a capsule of radius 0.015 from the origin to (1, 0, 0).
ANALYTIC = [
    (sf.Sphere(center=(0.5, 0.4, 0), radius=0.1), 0.3),
    (sf.Sphere(center=(1.3, 0.4, 0), radius=0.1), 0.4),
    (sf.Box(pose=(0.5, 0.4, 0), size=(0.2, 0.3, 0.1)), 0.25),
    (sf.Box(pose=(0.5, 0.4, 0, *TURNED), size=(0.2, 0.2, 0.2)), 0.4 - 0.1 * (np.cos(0.6) + np.sin(0.6))),
    (sf.Box(pose=(1.2, 0, 0), size=(0.2, 2, 2)), 0.1),
    (sf.Cylinder(pose=(0.5, 0.4, 0), radius=0.1, length=0.5), 0.3),
    (sf.Cylinder(pose=(0.5, 0, 0.4), radius=0.1, length=0.5), 0.15),
    (sf.Capsule(pose=(0.5, 0, 0.4), radius=0.1, length=0.2), 0.2),
    (sf.Mesh([(x, y, z) for x in (0.4, 0.6) for y in (0.3, 0.5) for z in (-0.1, 0.1)]), 0.3),
    (sf.Mesh([(0, 0, 0), (0, 0.1, 0.1), (0, 0.1, -0.1), (-0.1, 0.1, 0)], pose=(0.5, 0.2, 0)), 0.2),
    (sf.PointCloud([(0.5, 0.4, 0), (0.2, 0, 0.3), (2, 2, 2)], 0.05), 0.25),
    (sf.PointCloud([(0.1, 0, 0)], 0.05, pose=(0.5, 0.3, 0, *TURNED)), np.hypot(0, 0.3 + 0.1 * np.sin(0.6)) - 0.05),
]


@pytest.mark.parametrize(("shape", "wanted"), ANALYTIC)
def test_clearance_of_a_stretched_arm_is_what_geometry_says(planar, shape, wanted):
    obstacles = planar.obstacles([shape], self_collision=False)
    assert obstacles.clearance(np.zeros(3)) == pytest.approx(wanted - 0.015, abs=2e-6)
    near = obstacles.closest(np.zeros(3))
    assert near.clearance == pytest.approx(wanted - 0.015, abs=2e-6)
    assert np.linalg.norm(near.points[1] - near.points[0]) == pytest.approx(near.clearance, abs=2e-6)
    assert near.second == obstacles.scene.names[0]
    assert near.first.startswith("link")


def test_overlap_is_negative(planar):
    obstacles = planar.obstacles([sf.Sphere(center=(0.5, 0.05, 0), radius=0.1)], self_collision=False)
    assert obstacles.clearance(np.zeros(3)) == pytest.approx(0.05 - 0.115)


def test_empty_space_is_endless(lwr4):
    empty = lwr4.obstacles([], self_collision=False)
    assert empty.clearance(lwr4.home) == np.inf
    np.testing.assert_array_equal(empty.clearance_gradient(lwr4.home), 0)
    assert empty.edge_clear(lwr4.home, lwr4.home + 1, margin=5)
    assert empty.closest(lwr4.home).first == "nothing"
    assert empty.n_pairs == 0


@given(name=NAMES, seed=st.integers(0, 999))
@LAWS
def test_clearance_is_plain_mujocos(robots, name, seed):
    robot = robots[name]
    obstacles = robot.obstacles(scenes.one_of_each(seed, count=1))
    for q in robot.sample(3, seed):
        clearance, wanted = obstacles.clearance(q), plain(obstacles, q)
        if wanted > 0:
            assert clearance == pytest.approx(wanted, abs=1e-6)
        else:
            # Of deep overlaps MuJoCo's distance is not the smallest way out: which pair wins is no matter.
            assert wanted - 1e-6 <= clearance < 0


def test_clearance_of_many_points_and_moving_things_is_plain_mujocos(lwr4):
    cloud = sf.PointCloud(np.random.default_rng(0).uniform(-0.3, 0.3, (400, 3)), 0.01, (0.5, 0, 0.5))
    motion = sf.Motion([0, 2], [[-0.5, 0, 0.5, 1, 0, 0, 0], [-0.5, 0.6, 0.5, *TURNED]])
    box = sf.Box(pose=(-0.5, 0, 0.5), size=(0.1, 0.2, 0.3), motion=motion)
    obstacles = lwr4.obstacles([cloud, box])
    for moment in (None, 0.5, 1.7, 9.0):
        now = obstacles.at(moment)
        for q in lwr4.sample(5, 3):
            assert now.clearance(q) == pytest.approx(plain(now, q), abs=1e-6)


@given(name=NAMES, seed=st.integers(0, 999))
@LAWS
def test_gradients_are_derivatives(robots, name, seed):
    """Where one pair is nearest on either side, and nothing touches: elsewhere clearance has kinks."""
    robot, h = robots[name], 1e-6
    obstacles = robot.obstacles(scenes.boxes(6, seed))
    for q in scenes.clear_poses(robot, obstacles, 3, seed):
        steps = h * np.eye(robot.dof)
        ahead, behind, here = obstacles.clearance(q + steps), obstacles.clearance(q - steps), obstacles.clearance(q)
        slope, bend = (ahead - behind) / (2 * h), (ahead - 2 * here + behind) / h
        smooth = np.abs(bend) < 1e-3
        gradient = obstacles.clearance_gradient(q)
        np.testing.assert_allclose(gradient[smooth], slope[smooth], atol=2e-3)
        assert smooth.mean() > 0.5


def test_what_runs_through_a_box_is_not_clear_of_it():
    """MuJoCo's own distance of thin capsules deep in a box may be positive."""
    robot, rng = sf.Robot.load("planar_arm"), np.random.default_rng(0)
    for q in robot.sample(300, 1):
        heading = np.cumsum(q)
        joints = np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]) / 3, axis=0)
        share = rng.uniform(0.1, 0.9)
        inside = np.append(joints[1] + share * (joints[2] - joints[1]), 0.0)
        size = rng.uniform(0.02, 0.4, 3)
        turn = Rotation.random(rng=rng).as_quat(scalar_first=True)
        box = sf.Box(pose=[*(inside + rng.uniform(-0.4, 0.4, 3) * size * 0.3), *turn], size=size)
        obstacles = robot.obstacles([box], self_collision=False)
        assert obstacles.clearance(q) < 0.0
        assert np.isfinite(obstacles.clearance_gradient(q)).all()
        assert not obstacles.edge_clear(q, q + 1e-3)


def test_gradients_to_a_sphere_are_exact(lwr4):
    """Capsules and spheres have closed forms: no iteration blurs the difference."""
    obstacles, h = lwr4.obstacles([sf.Sphere(center=(0.5, 0.1, 0.7), radius=0.1)], self_collision=False), 1e-6
    for q in lwr4.sample(20, 5):
        steps = h * np.eye(7)
        slope = (obstacles.clearance(q + steps) - obstacles.clearance(q - steps)) / (2 * h)
        np.testing.assert_allclose(obstacles.clearance_gradient(q), slope, atol=1e-8)


def test_a_follower_moves_what_its_leader_asks(nao):
    obstacles, h = nao.obstacles([sf.Sphere(center=(0.1, -0.05, -0.35), radius=0.03)]), 1e-6
    follower = nao.names.index("RHipYawPitch")
    for q in scenes.clear_poses(nao, obstacles, 5):
        gradient = obstacles.clearance_gradient(q)
        assert gradient[follower] == 0
        steps = h * np.eye(24)
        slope = (obstacles.clearance(q + steps) - obstacles.clearance(q - steps)) / (2 * h)
        np.testing.assert_allclose(gradient, slope, atol=1e-3)


def test_all_pairs_within_reach(lwr4):
    obstacles = lwr4.obstacles(scenes.one_of_each(4))
    q = scenes.clear_poses(lwr4, obstacles, 30)
    for one in q:
        near, gradients = obstacles.within(one, 0.2)
        assert gradients.shape == (len(near), 7)
        assert (near < 0.2).all()
        clearance = obstacles.clearance(one)
        if clearance < 0.2:
            least = near.argmin()
            assert near[least] == pytest.approx(clearance, abs=1e-6)
            np.testing.assert_allclose(gradients[least], obstacles.clearance_gradient(one), atol=1e-3)
    assert max(len(obstacles.within(one, 0.2)[0]) for one in q) > 3


def test_joint_limits_count_where_they_are_asked_to(lwr4):
    free = lwr4.obstacles([], self_collision=False, limits=True)
    q = lwr4.home
    q[3] = lwr4.limits.upper[3] - 0.05
    assert free.clearance(q) == pytest.approx(0.05)
    np.testing.assert_array_equal(free.clearance_gradient(q), -np.eye(7)[3])
    assert free.closest(q)[1:3] == ("joint4", "upper limit")
    q[3] = lwr4.limits.upper[3] + 0.1
    assert free.clearance(q) == pytest.approx(-0.1)
    assert not free.edge_clear(lwr4.home, q)
    assert free.edge_clear(lwr4.home, lwr4.home + 0.1, margin=0.1)
    assert lwr4.obstacles([], self_collision=False).edge_clear(lwr4.home, q)


@given(name=NAMES, seed=st.integers(0, 999), length=st.floats(0.01, 1.0), margin=st.sampled_from([0.0, 0.01, 0.05]))
@LAWS
def test_clear_edges_are_clear_all_along(robots, name, seed, length, margin):
    robot, rng = robots[name], np.random.default_rng(seed)
    obstacles = robot.obstacles(scenes.one_of_each(seed, count=1))
    a = scenes.clear_poses(robot, obstacles, 10, seed)
    b = a + length * rng.normal(size=a.shape) / np.sqrt(robot.dof)
    clear = obstacles.edge_clear(a, b, margin)
    shares = np.linspace(0, 1, 200)[:, None, None]
    least = obstacles.clearance(a + shares * (b - a)).min(axis=0)
    assert (least[clear] >= margin - 2e-6).all()
    # And it is not called blocked without cause: only within a hair of the margin.
    assert clear[least > margin + 5e-3].all()


def test_an_edge_through_a_thin_wall_is_blocked(planar):
    """Both ends are clear, and so is any coarse sampling between them."""
    wall = planar.obstacles([sf.Box(pose=(0.7, 0, 0), size=(0.1, 1e-3, 0.1))])
    a, b = np.array([-0.4, 0, 0]), np.array([0.4, 0, 0])
    assert wall.clearance(np.stack([a, b])).min() > 0.1
    assert not wall.edge_clear(a, b)
    assert 0.4 < wall.edge_advance(a, b) < 0.5
    assert wall.edge_clear(a, a - 0.3)


def test_an_edge_without_end_is_given_up(planar):
    far = np.array([1e16, 0.0, 0.0])
    assert not planar.obstacles([sf.Sphere(center=(1.2, 0, 0), radius=0.1)]).edge_clear(planar.home, far)


def test_edges_broadcast(planar):
    obstacles = planar.obstacles([sf.Sphere(center=(0.5, 0.5, 0), radius=0.1)])
    ends = planar.sample(6).reshape(2, 3, 3)
    clear = obstacles.edge_clear(np.zeros(3), ends)
    assert clear.shape == (2, 3)
    for i in range(2):
        for j in range(3):
            assert obstacles.edge_clear(np.zeros(3), ends[i, j]) == clear[i, j]


@given(name=NAMES, seed=st.integers(0, 999))
@LAWS
def test_no_point_of_a_shape_moves_faster_than_its_bound(robots, name, seed):
    robot, h = robots[name], 1e-5
    model, joints = robot.model, robot.joints
    bound, data, rng = travel(model, joints), mujoco.MjData(model), np.random.default_rng(seed)

    def places(q, g, local):
        data.qpos[: len(joints.rest)] = joints.rest
        data.qpos[joints.addresses] = q
        mujoco.mj_kinematics(model, data)
        return data.geom_xpos[g] + data.geom_xmat[g].reshape(3, 3) @ local

    q = robot.sample(1, seed)[0]
    for g in rng.integers(0, model.ngeom, 5):
        # A point of the shape: along the z axis of a capsule or cylinder, anywhere in a box or sphere.
        size, kind = model.geom_size[g], model.geom_type[g]
        way = scenes.quaternion(rng)[1:]
        way = way / np.linalg.norm(way)
        long = kind in (mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_CYLINDER)
        local = rng.choice([-1, 1], 3) * size if kind == mujoco.mjtGeom.mjGEOM_BOX else size[0] * way
        if long:
            local = size[0] * np.array([way[0], way[1], 0]) + [0, 0, rng.choice([-1, 1]) * size[1]]
        for k in range(robot.dof):
            step = h * np.eye(robot.dof)[k]
            speed = np.linalg.norm(places(q + step, g, local) - places(q - step, g, local)) / (2 * h)
            assert speed <= bound[g, k] + 1e-8


def test_obstacles_along_their_motions(planar):
    motion = sf.Motion([1, 2], [[0.5, 0.4, 0], [0.5, 0.8, 0]])
    ball = sf.Sphere(center=(0.5, 0.6, 0), radius=0.1, motion=motion)
    obstacles = planar.obstacles([ball], self_collision=False)
    q = np.zeros(3)
    for moment, wanted in [(None, 0.5), (0, 0.3), (1, 0.3), (1.5, 0.5), (2, 0.7), (99, 0.7)]:
        assert obstacles.at(moment).clearance(q) == pytest.approx(wanted - 0.015)
    assert obstacles.clearance(q) == pytest.approx(0.485)
    assert "at 1.5 s" in repr(obstacles.at(1.5))


def test_targets_of_the_robots_own_file_stay_where_they_are(tmp_path):
    """Mocap bodies, as controllers aim at: those of the scene come after them."""
    file, arm = (
        tmp_path / "aiming.xml",
        "<body><joint axis='0 0 1'/><geom type='box' size='.1 .1 .1' pos='1 0 0'/></body>",
    )
    targets = "".join(f"<body mocap='true' pos='0 0 {z}'><geom size='.05'/></body>" for z in (2, 3))
    file.write_text(f"<mujoco><worldbody>{targets}{arm}</worldbody></mujoco>")
    motion = sf.Motion([0, 1], [[1, 0.5, 0], [1, 0.7, 0]])
    ball = sf.Sphere(center=(1, 0.4, 0), radius=0.1, name="ball", motion=motion)
    obstacles = sf.Robot.load(file).obstacles([ball])
    for moment, wanted in [(None, 0.2), (0, 0.3), (1, 0.5)]:
        assert obstacles.at(moment).clearance([0]) == pytest.approx(wanted)
    compiled = obstacles.compiled()
    obstacles.place(compiled, 1.0)
    assert compiled.clearance(np.zeros(1), np.empty(0), compiled.arguments) == pytest.approx(0.5)
    assert obstacles.move("ball", (1, 0.9, 0)).clearance([0]) == pytest.approx(0.7)


@pytest.mark.parametrize("movable", [(), ("ball", "dust")])
def test_move_puts_an_obstacle_elsewhere_and_leaves_the_old_one(planar, movable):
    ball = sf.Sphere(center=(0.5, 0.6, 0), radius=0.1, name="ball")
    dust = sf.PointCloud([(0, 0, 0)], 0.1, (0.5, -2.0, 0), name="dust")
    obstacles = planar.obstacles([ball, dust], movable=movable, self_collision=False)
    q = np.zeros(3)
    moved = obstacles.move("ball", (0.5, 0.3, 0))
    assert moved.clearance(q) == pytest.approx(0.185)
    assert obstacles.clearance(q) == pytest.approx(0.485)
    assert moved.move("ball", (0.5, 0.9, 0, *TURNED)).clearance(q) == pytest.approx(0.785)
    assert moved.move("dust", (0.5, 0.2, 0)).clearance(q) == pytest.approx(0.085)
    assert moved.clearance(q) == pytest.approx(0.185)


def test_for_what_is_movable_no_model_is_made_anew(lwr4, monkeypatch):
    obstacles = lwr4.obstacles(scenes.boxes(10), movable=("box_0",))
    monkeypatch.setattr(Obstacles, "build", lambda *_: pytest.fail("made anew"))
    for i in range(3):
        obstacles.move("box_0", (0.5, 0.01 * i, 0.5)).clearance(lwr4.home)
    with pytest.raises(pytest.fail.Exception, match="made anew"):
        obstacles.move("box_1", (0.5, 0.0, 0.5))


def test_bad_questions_say_what_is_wrong(lwr4):
    obstacles = lwr4.obstacles(scenes.boxes(2))
    with pytest.raises(InputError, match="joint 2 of state 0 is nan"):
        obstacles.clearance([0, 0, np.nan, 0, 0, 0, 0])
    with pytest.raises(InputError, match=r"shape \(3,\)"):
        obstacles.edge_clear(np.zeros(3), np.zeros(3))
    with pytest.raises(InputError, match="do not go together"):
        obstacles.edge_clear(np.zeros((2, 7)), np.zeros((3, 7)))
    with pytest.raises(InputError, match="margin -1"):
        obstacles.edge_clear(lwr4.home, lwr4.home, -1)
    with pytest.raises(InputError, match="margin 'wide'"):
        obstacles.edge_clear(lwr4.home, lwr4.home, "wide")
    with pytest.raises(InputError, match="reach nan"):
        obstacles.within(lwr4.home, np.nan)
    for movable in (3, None, "box_0"):
        with pytest.raises(InputError, match="list of names"):
            lwr4.obstacles([], movable=movable)
    with pytest.raises(InputError, match=r"within: .* expected \(7,\)"):
        obstacles.within(np.zeros((2, 7)), 0.1)
    with pytest.raises(InputError, match="time nan"):
        obstacles.at(np.nan)
    with pytest.raises(SceneError, match="no obstacle 'table'; there are box_0, box_1"):
        obstacles.move("table", (0, 0, 0))
    with pytest.raises(SceneError, match="no obstacle 'x'"):
        lwr4.obstacles([], movable=("x",))
    with pytest.raises(SceneError, match="obstacle 0 is a str"):
        lwr4.obstacles(["box"])
    with pytest.raises(InputError, match="base is fixed"):
        lwr4.obstacles([], base=(0, 0, 0))


def test_a_free_base_carries_the_robot_among_obstacles(nao):
    ball = sf.Sphere(center=(1.5, 0, 0.35), radius=0.1)
    here = nao.obstacles([ball], self_collision=False, base=(1.0, 0, 0.35))
    there = nao.obstacles([sf.Sphere(center=(0.5, 0, 0), radius=0.1)], self_collision=False)
    q = nao.sample(20)
    np.testing.assert_allclose(here.clearance(q), there.clearance(q), atol=1e-9)
    assert nao.obstacles([sf.Sphere(center=(0, 0, 0.05), radius=0.02)]).clearance(nao.home) < 0


def test_what_a_fixed_base_stands_on_does_not_count(lwr4):
    table = sf.Box(pose=(0, 0, -0.05), size=(2, 2, 0.1))
    assert lwr4.obstacles([table]).clearance(lwr4.home) > 0


@njit
def looped(states, clearance, arguments, out):
    """A loop as planners have them: it knows nothing of robots."""
    gradient = np.zeros(states.shape[1])
    for i in range(len(states)):
        out[i] = clearance(states[i], gradient, arguments)
    return gradient


@njit
def inner(q, near, gradients, edge, within, arguments):
    return within(q, 0.3, near, gradients, arguments), edge(q, q + 0.2, 0.0, arguments)


def test_compiled_loops_take_obstacles_as_arguments(robots):
    for name in ("lwr4", "planar_arm"):
        robot = robots[name]
        obstacles = robot.obstacles(scenes.boxes(5))
        compiled, q, out = obstacles.compiled(), robot.sample(50), np.empty(50)
        gradient = looped(q, compiled.clearance, compiled.arguments, out)
        np.testing.assert_array_equal(out, obstacles.clearance(q))
        np.testing.assert_array_equal(gradient, obstacles.clearance_gradient(q[-1]))
        near, gradients = np.empty(compiled.capacity), np.empty((compiled.capacity, robot.dof))
        count, advance = inner(q[0], near, gradients, compiled.edge, compiled.within, compiled.arguments)
        np.testing.assert_array_equal(near[:count], obstacles.within(q[0], 0.3)[0])
        assert advance == obstacles.edge_advance(q[0], q[0] + 0.2)
        # What is not finite is clear of nothing, and ends.
        bad = np.full((1, robot.dof), np.nan)
        looped(bad, compiled.clearance, compiled.arguments, out)
        assert np.isnan(out[0])
        assert inner(bad[0], near, gradients, compiled.edge, compiled.within, compiled.arguments)[1] == 0
    # One compiled form serves both robots.
    assert len(looped.signatures) == 1


def test_threads_give_the_same_answers(lwr4):
    obstacles = lwr4.obstacles(scenes.one_of_each(1), movable=("box_0",))
    q = lwr4.sample(1500, 2)
    wanted = obstacles.clearance(q), obstacles.clearance_gradient(q), obstacles.edge_clear(q[:200], q[1:201])

    def ask(i):
        # Others move things meanwhile.
        obstacles.move("box_0", (0.1 * i, 0, 0.4)).clearance(q[:50])
        return obstacles.clearance(q), obstacles.clearance_gradient(q), obstacles.edge_clear(q[:200], q[1:201])

    with ThreadPoolExecutor(4) as pool:
        for answers in pool.map(ask, range(8)):
            for answer, right in zip(answers, wanted, strict=True):
                np.testing.assert_array_equal(answer, right)


def test_moved_copies_share_data_without_mixing(lwr4):
    obstacles = lwr4.obstacles(scenes.boxes(3), movable=("box_0", "box_1"))
    one, two = obstacles.move("box_0", (0.4, 0, 0.6)), obstacles.move("box_1", (0.3, 0.2, 0.7))
    q = lwr4.sample(30)
    first = one.clearance(q), two.clearance(q)
    np.testing.assert_array_equal(one.clearance(q), first[0])
    np.testing.assert_array_equal(two.clearance(q), first[1])
    assert (first[0] != first[1]).any()


def test_pickled_obstacles_answer_alike(lwr4):
    obstacles = lwr4.obstacles(scenes.one_of_each(1), limits=True).at(3.0)
    again = pickle.loads(pickle.dumps(obstacles))
    q = lwr4.sample(30)
    np.testing.assert_array_equal(again.clearance(q), obstacles.clearance(q))
    assert again.time == 3.0


def test_slots_of_the_tables_are_different():
    named = vars(shape_distances) | vars(distances)
    slots = [v for name, v in named.items() if name.isupper() and name != "SLOTS" and isinstance(v, int)]
    assert sorted(slots) == list(range(distances.kin.SLOTS, distances.SLOTS))


def test_what_planners_ask_besides(planar):
    """Margin, resolution, limits, and the nearest pair in words."""
    obstacles = planar.obstacles([sf.Sphere(center=(0.5, 0.4, 0), radius=0.1, name="lamp")], self_collision=False)
    assert obstacles.margin == 0.02
    assert planar.obstacles(margin=0.1).margin == 0.1
    assert 0.0 < obstacles.resolution <= 0.02
    for limit, wanted in zip(obstacles.bounds, planar.limits, strict=True):
        np.testing.assert_array_equal(limit, wanted)
    assert obstacles.nearest(np.zeros(3)) == "link2 to lamp"
    near = obstacles.closest(np.zeros(3))
    assert obstacles.nearest(np.zeros(3)) == f"{near.first} to {near.second}"
    assert planar.obstacles(self_collision=False).nearest(np.zeros(3)) == "nothing to nothing"


def test_the_margin_goes_along(planar):
    """Into copies, and through a file."""
    motion = sf.Motion([0, 2], [[0.5, 0.4, 0.0, 1, 0, 0, 0], [0.5, 0.8, 0.0, 1, 0, 0, 0]])
    obstacles = planar.obstacles([sf.Sphere(center=(0.5, 0.4, 0), radius=0.1, motion=motion)], margin=0.07)
    for other in (
        obstacles.at(1.0),
        obstacles.move("sphere_0", (0.1, 0.5, 0)),
        pickle.loads(pickle.dumps(obstacles)),
    ):
        assert other.margin == 0.07


@pytest.mark.parametrize("margin", [0, -0.1, np.nan, np.inf, "wide", None, [0.1]])
def test_margins_that_are_none(planar, margin):
    with pytest.raises(InputError, match="margin"):
        planar.obstacles(margin=margin)


@pytest.mark.parametrize("q", [np.zeros((2, 3)), np.zeros(2), [np.nan, 0, 0], "home", None])
def test_the_nearest_is_asked_for_one_pose(planar, q):
    with pytest.raises(InputError):
        planar.obstacles().nearest(q)
