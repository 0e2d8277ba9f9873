"""Plans around obstacles: checked once more by what is true, whatever the method; and what cannot be met is told."""

import numpy as np
import pytest

from manifold import clouds
from manifold.conftest import arm_poses, curves, fit
from robots import scenes
from skillfold import PointObstacles, Robot, Scene, SkillManifold, Sphere, StateSpace
from skillfold.errors import InputError
from skillfold.experiments.three_link import REACHING, forward, optimal
from skillfold.manifold import avoiding
from skillfold.manifold.aside import aside_of
from skillfold.manifold.terrain import Terrain

METHODS = [None, "geodesic", "springs", "hinge", "sampled"]
BENT = ["springs", "hinge", "sampled"]
FAR = PointObstacles([[5.0, 5.0, 5.0]], 0.4)


def unit(*x):
    return np.array(x) / np.linalg.norm(x)


@pytest.fixture(scope="module")
def ends(sphere):
    return sphere.project(np.array([unit(1, -0.8, 0.3), unit(1, 0.8, 0.3)]))


def disc(sphere, reach, offset=0.0):
    """A few points between the ends."""
    middle = unit(1, 0, 0.3 + offset)
    around = 0.1 * np.array([[0, 0, 0], [0, 0, 1], [0, 0, -1], [0, 1, 0], [0, -1, 0]])
    return PointObstacles(sphere.project(middle + around), reach)


def ring(sphere, centre):
    """Points all about a state."""
    u = np.cross(centre, [0, 0, 1.0]) / np.linalg.norm(np.cross(centre, [0, 0, 1.0]))
    angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)[:, None]
    return PointObstacles(
        sphere.project(centre + 0.45 * (np.cos(angles) * u + np.sin(angles) * np.cross(centre, u))), 0.3
    )


def dense(states, resolution, finer=5):
    """States along the chords, as many times closer than the check looks at."""
    steps = np.diff(states, axis=0)
    count = finer * int(np.ceil(np.linalg.norm(steps, axis=1).max() / resolution))
    shares = np.linspace(0, 1, count + 1)[:, None, None]
    return (states[:-1] + shares * steps).reshape(-1, states.shape[1])


def check_again(plan, obstacles, asked, off, tolerance):
    """`off` tells how far states are from what is true; chords sag by as much as what is round bends."""
    states = plan.path.states
    assert plan.success, plan.reason
    np.testing.assert_array_equal(states[[0, -1]], asked)
    between = dense(states, obstacles.resolution)
    assert obstacles.clearance(between).min() > 0.0
    assert plan.stats["check"].clearance >= obstacles.clearance(between).min()
    sag = np.linalg.norm(np.diff(states, axis=0), axis=1).max() ** 2 / 4
    assert off(between).max() <= tolerance + sag
    assert plan.length == pytest.approx(np.linalg.norm(np.diff(states, axis=0), axis=1).sum())
    assert np.linalg.norm(np.diff(states, axis=0), axis=1).max() < 1.5 * obstacles.resolution


def off_sphere(states):
    return np.abs(np.linalg.norm(states, axis=1) - 1.0)


@pytest.mark.parametrize("place", [[5.0, 5.0, 5.0], [0.0, 0.3, 0.0], [0.0, -0.5, 0.0]])
def test_among_obstacles_the_way_leads_along_the_edge_too(place):
    """Around a bay that nobody crossed, whether what stands there is far off, in the bay or ashore."""
    land = fit(clouds.bay(300, 1), 2)
    ends = np.array([[-0.8, 0.3, -0.072], [0.8, 0.3, 0.072]])
    plan = land.plan(*ends, obstacles=PointObstacles([place], 0.15))
    assert plan.success
    assert plan.stats["check"].outside < 1.8
    across = land.plan(*ends).stats["check"].outside
    assert across < 1.8
    assert ("held within the edge" in plan.reason) == (plan.stats["methods"] == ("geodesic",))


def test_terrain_holds_only_paths_whose_chords_keep_to_the_surface():
    """On a spiral: along one winding, and across to the next, where both ends of the chord are on it."""
    turn = np.linspace(0.0, 4.0 * np.pi, 400)
    spiral = (0.5 + 0.05 * turn)[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    skill = fit(spiral, 1)
    obstacles = PointObstacles([[9.0, 9.0]], 0.1)
    land = Terrain.between(skill.model, skill.space, obstacles, spiral[[0, -1]], 0.02)
    along, across = spiral[:60], np.vstack([spiral[:30], spiral[229:260]])
    assert land.holds(land.coordinates(skill.project(along)))
    assert not land.holds(land.coordinates(skill.project(across)))


@pytest.mark.parametrize("reach", [0.1, 0.4])
@pytest.mark.parametrize("method", METHODS)
def test_around_a_disc_on_a_sphere(sphere, ends, method, reach):
    obstacles = disc(sphere, reach)
    plan = sphere.plan(*ends, method=method, obstacles=obstacles)
    if method == "geodesic" or (method == "springs" and reach == 0.1):
        assert not plan.success  # the shortest path; and springs are caught between points that are thin
        assert "is not clear: obstacle point" in plan.reason
        return
    check_again(plan, obstacles, ends, off_sphere, 2e-3)
    assert plan.stats["methods"] == (method or "sampled",)
    assert plan.route == "geodesic"
    assert plan.converged
    assert plan.stats["check"].clearance > 0.9 * obstacles.margin
    assert "blocked by obstacle point" in plan.reason
    angle = np.arccos(ends[0] @ ends[1])
    assert angle < plan.length < 1.4 * angle


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_gives_the_same_bits(sphere, ends, method):
    first, again = (sphere.plan(*ends, method=method, obstacles=disc(sphere, 0.4), seed=3) for _ in range(2))
    np.testing.assert_array_equal(first.path.states, again.path.states)
    assert (first.reason, first.iterations) == (again.reason, again.iterations)


def test_another_seed_samples_other_states(sphere, ends):
    obstacles = ring(sphere, ends[1])
    gap = PointObstacles(obstacles.points[6:], 0.3)
    plans = [sphere.plan(*ends, method="sampled", obstacles=gap, seed=seed) for seed in range(4)]
    assert len({plan.iterations for plan in plans}) > 1
    for plan in plans:
        check_again(plan, gap, ends, off_sphere, 2e-3)


@pytest.mark.parametrize("method", METHODS)
def test_a_free_geodesic_stays_the_geodesic(sphere, ends, method):
    alone = sphere.plan(*ends)
    plan = sphere.plan(*ends, method=method, obstacles=FAR)
    assert plan.success
    assert plan.length == pytest.approx(alone.length, rel=1e-3)
    assert "blocked" not in plan.reason
    normal = np.cross(*ends) / np.linalg.norm(np.cross(*ends))
    assert np.abs(plan.path.states @ normal).max() < 0.02
    assert plan.stats["methods"] == ("geodesic",)


@pytest.mark.parametrize("method", METHODS)
def test_ends_in_an_obstacle_are_named(sphere, ends, method):
    middle = unit(1, 0, 0.3)
    for at, name in [(ends[0], "start"), (ends[1], "goal"), (sphere.project(middle), "via 0")]:
        plan = sphere.plan(*ends, via=[middle], method=method, obstacles=PointObstacles([[9, 9, 9], at], 0.1))
        assert not plan.success
        assert plan.reason == f"The {name} is not clear: obstacle point 1, -0.05."
        np.testing.assert_array_equal(plan.path.states[[0, -1]], ends)


@pytest.mark.parametrize("method", METHODS)
def test_a_goal_that_is_fenced_in_fails_and_says_why(sphere, ends, method):
    obstacles = ring(sphere, ends[1])
    assert obstacles.clearance(ends).min() > 0.0
    plan = sphere.plan(*ends, method=method, obstacles=obstacles)
    assert not plan.success
    assert "is not clear: obstacle point" in plan.reason
    assert np.isfinite(plan.path.states).all()
    if method in (None, "sampled"):
        assert "sampling found no way around" in plan.reason
        assert plan.iterations >= 2000
        assert plan.stats["methods"] == ("none",)


@pytest.mark.parametrize("points", [None, 90])
def test_via_points_are_passed_around_obstacles(sphere, ends, points):
    obstacles, via = disc(sphere, 0.4), sphere.project(np.array([unit(1, -0.4, 0.9), unit(1, 0.4, 0.9)]))
    plan = sphere.plan(*ends, points, via=via, obstacles=obstacles)
    states = plan.path.states
    assert plan.success, plan.reason
    assert points is None or len(states) == points
    rows = [int(np.flatnonzero((states == v).all(1))[0]) for v in (ends[0], *via, ends[1])]
    assert rows == sorted(rows)
    assert (rows[0], rows[-1]) == (0, len(states) - 1)
    assert len(plan.stats["methods"]) == 3
    assert obstacles.clearance(dense(states, obstacles.resolution)).min() > 0.0
    assert off_sphere(states).max() < 2e-3


@pytest.mark.parametrize("points", [60, 700])
def test_as_many_states_as_are_asked_for(sphere, ends, points):
    obstacles = disc(sphere, 0.4)
    plan = sphere.plan(*ends, points, obstacles=obstacles)
    assert plan.success, plan.reason
    assert len(plan.path.states) == points
    assert obstacles.clearance(dense(plan.path.states, obstacles.resolution)).min() > 0.0
    assert off_sphere(plan.path.states).max() < 2e-3


@pytest.mark.parametrize("reach", [0.1, 0.4, 0.6])
@pytest.mark.parametrize("points", [3, 4, 5, 8])
def test_where_few_states_are_asked_for_their_chords_are_looked_at(sphere, ends, points, reach):
    obstacles = disc(sphere, reach, 0.03)
    plan = sphere.plan(*ends, points, obstacles=obstacles)
    least = obstacles.clearance(dense(plan.path.states, obstacles.resolution)).min()
    assert len(plan.path.states) == points
    assert plan.stats["check"].clearance == pytest.approx(least, abs=0.02 * reach)
    assert not plan.success or least > 0.0
    assert plan.success or least <= 0.0 or "off the manifold" in plan.reason


@pytest.mark.parametrize("method", METHODS)
def test_a_plan_that_stays_where_it_is(sphere, ends, method):
    plan = sphere.plan(ends[0], ends[0], method=method, obstacles=disc(sphere, 0.4))
    assert plan.success, plan.reason
    assert plan.length < 1e-5


def test_ends_off_the_manifold_are_projected_first(sphere, ends):
    obstacles = disc(sphere, 0.4)
    plan = sphere.plan(1.1 * ends[0], ends[1], obstacles=obstacles)
    assert plan.start_moved == pytest.approx(0.1, abs=1e-2)
    assert "start moved" in plan.reason
    check_again(plan, obstacles, [sphere.project(1.1 * ends[0]), ends[1]], off_sphere, 2e-3)
    # Off it this end would be clear, on it it is not.
    at = PointObstacles([sphere.project(1.1 * ends[0])], 0.15)
    assert "The start is not clear" in sphere.plan(1.1 * ends[0], ends[1], obstacles=at).reason


def test_a_tiny_reach_does_not_ask_for_millions_of_states(sphere, ends):
    plan = sphere.plan(*ends, obstacles=PointObstacles([[5.0, 5.0, 5.0]], 1e-9))
    assert plan.success, plan.reason
    assert 10_000 < len(plan.path.states) <= 20_001


def test_the_best_of_the_arm_s_poses_are_kept(arm):
    """Truth is not the model's: along the path poses stay optimal for where the tool is."""
    (start,), (goal,) = arm_poses(1, 1), arm_poses(1, 2)
    middle = arm.plan(start, goal).path.states[25]
    obstacles = PointObstacles([middle], 0.3)

    def off(states):
        return np.linalg.norm(states - optimal(forward(states), REACHING), axis=1)

    for method in (None, *BENT):
        plan = arm.plan(start, goal, method=method, obstacles=obstacles)
        check_again(plan, obstacles, [start, goal], off, 3e-3)


@pytest.mark.parametrize("method", [None, *BENT])
def test_limits_of_coordinates_are_kept_or_told(method):
    """The shortest path goes over a limit at the top of a sphere; nothing else is in the way."""
    x = clouds.draw_sphere(600, np.random.default_rng(0))
    space = StateSpace.linear(3, -2.0, [2.0, 2.0, 0.985])
    skill = fit(x[x[:, 2] < 0.98], 2, space=space)
    plan = skill.plan([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8], obstacles=FAR, method=method)
    assert "blocked by the limits of coordinate 2" in plan.reason
    if method == "springs":  # they know of obstacles alone
        assert not plan.success
        assert "breaks the limits" in plan.reason
        return
    assert plan.success, plan.reason
    between = dense(plan.path.states, FAR.resolution)
    assert between[:, 2].max() <= 0.985
    assert off_sphere(between).max() < 3e-3


@pytest.mark.parametrize("method", METHODS)
def test_free_directions_are_a_way_around(cylinder, method):
    """An obstacle at a state of the shortest path itself; the truth is a circle of two coordinates."""
    model = cylinder.model
    start, goal = cylinder.sample(2, seed=1)
    obstacles = PointObstacles([cylinder.plan(start, goal).path.states[25]], 0.5)
    plan = cylinder.plan(start, goal, method=method, obstacles=obstacles)
    if method == "geodesic":
        assert not plan.success
        return

    def off(states):
        centre = model.anchors.mean(0)
        circle = np.linalg.svd(model.anchors - centre, full_matrices=False)[2]
        radii = np.linalg.norm((model.encode(states) - centre) @ circle.T, axis=1)
        return np.abs(model.scale * radii - 1.0)

    check_again(plan, obstacles, [start, goal], off, 0.1)  # circles' centres are known from samples
    assert cylinder.distance(plan.path.states).max() <= cylinder.tolerance * 1.01
    free = (plan.path.states - model.centre) @ model.free
    straight = free[0] + np.linspace(0, 1, len(free))[:, None] * (free[-1] - free[0])
    assert np.abs(free - straight).max() > 0.05


# Recordings


def test_a_demonstrated_route_is_pushed_aside_and_elsewhere_keeps_its_way(recorded):
    curve = curves()[2]
    alone = recorded.plan(curve[0], curve[-1])
    obstacles = PointObstacles([alone.path.states[50] + [0.0, 0.0, 0.01]], 0.06)
    plan = recorded.plan(curve[0], curve[-1], obstacles=obstacles)
    assert plan.success, plan.reason
    assert (plan.route, len(plan.path.states)) == ("demonstrated", 101)
    assert "aside" in plan.reason
    assert obstacles.clearance(dense(plan.path.states, obstacles.resolution)).min() > 0.0
    moved = np.linalg.norm(plan.path.states - alone.path.states, axis=1)
    np.testing.assert_array_equal(plan.path.states[[0, -1]], curve[[0, -1]])
    assert 0.03 < moved.max() < 0.1
    assert moved.argmax() == pytest.approx(50, abs=2)
    assert moved[[*range(20), *range(80, 101)]].max() < 2e-3


@pytest.mark.parametrize("points", [101, 500, 1000])
def test_a_route_is_pushed_aside_with_any_number_of_states(points):
    """Many states so close together do not come to rest by themselves."""
    t = np.linspace(0, 1, points)[:, None]
    path = np.hstack([np.sin(2 * t), 0.5 * t**2, t])
    middle = np.array([np.sin(1.0), 0.125, 0.5])
    obstacles = PointObstacles(middle + 0.03 * np.random.default_rng(4).standard_normal((6, 3)), 0.2)
    aside = aside_of(path, path[[0, -1]], obstacles)
    assert obstacles.clearance(aside).min() > 0.98 * obstacles.margin
    np.testing.assert_array_equal(aside[[0, -1]], path[[0, -1]])


def test_a_demonstrated_route_that_is_free_stays_to_the_bit(recorded):
    curve = curves()[1]
    alone, plan = recorded.plan(curve[0], curve[-1]), recorded.plan(curve[0], curve[-1], obstacles=FAR)
    np.testing.assert_array_equal(plan.path.states, alone.path.states)
    assert plan.reason == alone.reason


def test_via_points_of_a_demonstrated_route_stay(recorded):
    curve = curves()[2]
    alone = recorded.plan(curve[0], curve[-1])
    via = alone.path.states[[40, 60]]
    obstacles = PointObstacles([alone.path.states[50] + [0.0, 0.0, 0.01]], 0.04)
    plan = recorded.plan(curve[0], curve[-1], via=via, obstacles=obstacles)
    assert plan.success, plan.reason
    for state in via:
        assert (plan.path.states == state).all(1).any()


def test_a_demonstrated_route_comes_nearer_than_the_margin_where_nothing_else_is_found(recorded):
    """From a start that is within it: to keep it at once the path would leave the manifold, or jump."""
    curve = curves()[2]
    obstacles = PointObstacles([curve[0] + [0.0, 0.0, -0.19]], 0.34)
    plan = recorded.plan(curve[0], curve[-1], obstacles=obstacles)
    assert plan.success, plan.reason
    assert "of the margin" in plan.reason
    assert 0.0 < obstacles.clearance(dense(plan.path.states, obstacles.resolution)).min() < obstacles.margin


def test_a_demonstrated_route_that_cannot_give_way_fails(recorded):
    """Far aside is off the manifold."""
    curve = curves()[2]
    middle = recorded.plan(curve[0], curve[-1]).path.states[50]
    plan = recorded.plan(curve[0], curve[-1], obstacles=PointObstacles([middle], 1.0))
    assert not plan.success
    assert "off the manifold" in plan.reason


@pytest.mark.parametrize(("end", "name"), [(0, "start"), (-1, "goal")])
def test_ends_of_a_demonstrated_route_in_an_obstacle_are_named(recorded, end, name):
    curve = curves()[2]
    plan = recorded.plan(curve[0], curve[-1], obstacles=PointObstacles([curve[end]], 0.1))
    assert not plan.success
    assert plan.route == "demonstrated"
    assert plan.reason == f"The {name} is not clear: obstacle point 0, -0.05."


def test_where_the_demonstrated_way_is_closed_the_manifold_may_leave_another():
    """Recordings that cover a sheet: what is too wide to be pushed past is gone around."""
    t = np.linspace(0, 1, 22)
    sheet = fit([np.column_stack([t, y + 0 * t, 0.2 * np.sin(3 * t)]) for y in np.linspace(0, 1, 21)], 2, 10)
    start, goal = np.array([0.0, 0.5, 0.0]), np.array([1.0, 0.5, 0.2 * np.sin(3.0)])
    wall = np.array([(0.5, y, z) for y in np.linspace(0.25, 1.3, 25) for z in np.linspace(-1.2, 1.6, 40)])
    obstacles = PointObstacles(wall, 0.16)
    plan = sheet.plan(start, goal, obstacles=obstacles)
    assert sheet.plan(start, goal).route == "demonstrated"
    assert plan.route == "geodesic"

    def off(states):
        return np.abs(states[:, 2] - 0.2 * np.sin(3 * states[:, 0]))

    check_again(plan, obstacles, [start, goal], off, 1e-3)


# Robots


def test_a_plan_with_success_does_not_say_that_there_is_no_way():
    """Recordings that spread make a rough surface, on which the shortest path does not settle and trees find none."""
    t = np.linspace(0.0, 1.0, 80)
    ways = [np.column_stack([t, 0.3 * np.sin(3.0 * t) + 0.05 * i]) for i in range(5)]
    skill = SkillManifold.fit(ways, 1, 10, 1e-6, jobs=1)
    plan = skill.plan(ways[0][0], ways[0][-1], obstacles=PointObstacles([[5.0, 9.0]], 0.2), route="geodesic")
    assert plan.success == ("no way" not in plan.reason)


def test_an_earlier_path_that_is_bent_is_not_called_the_shortest(sphere, ends):
    earlier = sphere.plan(*ends, obstacles=disc(sphere, 0.3)).path.states
    again = sphere.plan(*ends, obstacles=disc(sphere, 0.32), near=earlier)
    assert again.success and again.stats["methods"] == ("renewed",)
    assert "earlier path, bent" in again.reason and "Shortest" not in again.reason


@pytest.fixture(scope="module")
def planar():
    return Robot.load("planar_arm")


@pytest.mark.parametrize("method", [None, "hinge", "sampled"])
def test_a_robot_among_shapes(arm, planar, method):
    """The arm that the skill was learnt from, past a ball where its tool would go."""
    (start,), (goal,) = arm_poses(2, 1)[1:], arm_poses(2, 2)[1:]
    tool = planar.forward(arm.plan(start, goal).path.states[25])[:3]
    scene = Scene([Sphere(center=tool, radius=0.05), *scenes.boxes(2).moved("box_0", (0.0, 3.0, 0.0))])
    obstacles = planar.obstacles(scene, self_collision=False)
    plan = arm.plan(start, goal, method=method, obstacles=obstacles)
    assert obstacles.clearance(np.stack([start, goal])).min() > 0.0
    assert plan.success, plan.reason
    states = plan.path.states
    np.testing.assert_array_equal(states[[0, -1]], [start, goal])
    assert obstacles.clearance(dense(states, obstacles.resolution)).min() > 0.0
    assert obstacles.edge_clear(states[:-1], states[1:]).all()
    assert np.linalg.norm(states - optimal(forward(states), REACHING), axis=1).max() < 3e-3
    assert "blocked by link" in plan.reason
    assert (states > planar.limits.lower).all()
    assert (states < planar.limits.upper).all()


def test_a_robot_that_touches_or_is_beyond_its_limits_does_not_start(arm, planar):
    (start,), (goal,) = arm_poses(1, 1), arm_poses(1, 2)
    tool = planar.forward(goal)[:3]
    touched = planar.obstacles([Sphere(center=tool, radius=0.05)], self_collision=False)
    plan = arm.plan(start, goal, obstacles=touched)
    assert plan.reason.startswith("The goal is not clear: link")
    assert "to sphere_0" in plan.reason

    class Narrow:
        """The same obstacles for a robot with less room."""

        margin, resolution = 0.02, 0.01
        bounds = np.full(3, -9.0), np.array([9.0, start[1] - 0.25, 9.0])

        def __init__(self, inside):
            self.clearance, self.nearest, self.compiled = inside.clearance, inside.nearest, inside.compiled

    plan = arm.plan(start, start, obstacles=Narrow(planar.obstacles([], self_collision=False)))
    assert not plan.success
    assert plan.reason == "The start breaks the limits of coordinate 1 by 0.25."


# Bad input


class Halfway:
    """Knows how far, and no more."""

    margin, resolution, bounds = 0.1, 0.1, (np.zeros(3), np.ones(3))

    def clearance(self, q):
        return np.ones(np.shape(q)[:-1])

    def compiled(self):
        return None


NONSENSE = [3, "wall", np.zeros((4, 3)), [[0.0, 0.0, 0.0]], PointObstacles, Halfway(), lambda q: 1.0, object()]


@pytest.mark.parametrize("obstacles", NONSENSE, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("kind", ["sphere", "recorded"])
def test_obstacles_that_are_none(skills, kind, obstacles):
    start, goal = skills[kind].sample(2)
    with pytest.raises(InputError, match=r"obstacles=.*PointObstacles\(points, reach\) or robot.obstacles\(scene\)"):
        skills[kind].plan(start, goal, obstacles=obstacles)


@pytest.mark.parametrize("D", [1, 2, 4])
def test_obstacles_of_another_dimension(sphere, ends, D):
    with pytest.raises(InputError, match=f"obstacles are for states of {D} coordinates, the skill has 3"):
        sphere.plan(*ends, obstacles=PointObstacles(np.zeros((2, D)), 0.1))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"method": "fast"}, "method='fast'.*geodesic, springs, hinge, sampled"),
        ({"method": "leaf"}, "method='leaf'.*geodesic, springs, hinge, sampled"),
        ({"method": 3}, "method=3"),
        ({"seed": -1}, "seed=-1"),
        ({"seed": 1.5}, "seed=1.5"),
        ({"seed": None}, "seed=None"),
        ({"points": 2}, "points=2"),
        ({"points": 0}, "points=0"),
        ({"points": 10.0}, "points=10.0"),
        ({"via": np.zeros((1, 2))}, "3"),
        ({"route": "demonstrated"}, "two or more whole recordings"),
    ],
    ids=str,
)
def test_options_that_cannot_be(sphere, ends, options, says):
    with pytest.raises(InputError, match=says):
        sphere.plan(*ends, obstacles=FAR, **options)


@pytest.mark.parametrize("method", ["springs", "hinge", "sampled", "geodesic"])
def test_ways_around_need_something_to_go_around(sphere, ends, method):
    with pytest.raises(InputError, match=f"method='{method}'.*anchored, leaf"):
        sphere.plan(*ends, method=method)


def test_ends_far_from_all_that_was_shown_are_data(sphere, ends):
    for method in METHODS:
        plan = sphere.plan(ends[0] + 100.0, ends[1] - 100.0, method=method, obstacles=disc(sphere, 0.4))
        assert np.isfinite(plan.path.states).all()
        assert "moved" in plan.reason or not plan.success
    for supported in (True, False):
        story = avoiding._story([], np.zeros(2), supported, True)
        assert ("an end lies far from the demonstrations" in story) != supported


@pytest.mark.parametrize("torn", [np.nan, np.inf, 1e200])
def test_springs_that_tear_the_path_apart_leave_the_shortest(sphere, ends, monkeypatch, torn):
    def tearing(table, chart, barrier, path, *how):
        path[1:-1] *= torn
        return 2000, torn

    monkeypatch.setattr("skillfold.manifold.springs.relax_springs", tearing)
    plan = sphere.plan(*ends, obstacles=disc(sphere, 0.4), method="springs")
    assert not plan.success
    assert not plan.converged
    assert "not clear" in plan.reason


def test_demonstrations_that_differ_along_the_surface_leave_no_more_room_off_it():
    """They spread widely over the plane z = 0, and know it to a hair's breadth."""
    t, rng = np.linspace(0, 1, 60), np.random.default_rng(4)
    sways = rng.normal(0, 0.2, (8, 3)) @ np.sin(np.pi * np.arange(1, 4)[:, None] * t)
    wide = [np.column_stack([t, sway, 0 * t]) for sway in sways]
    skill = fit([states + rng.normal(0, 0.001, states.shape) for states in wide], 2)
    below = PointObstacles([[0.5, y, -0.06] for y in np.linspace(-0.1, 0.1, 5)], 0.2)
    plan = skill.plan([0.05, 0.0, 0.0], [0.95, 0.0, 0.0], obstacles=below)
    assert plan.success, plan.reason
    assert np.abs(plan.path.states[:, 2]).max() < 0.01
    assert below.clearance(dense(plan.path.states, below.resolution)).min() > 0.0
    # Not quite in the middle of the way, the same is passed along the plane, as the demonstrations go.
    beside = PointObstacles(below.points - [0.0, 0.12, 0.0], 0.2)
    plan = skill.plan([0.05, 0.0, 0.0], [0.95, 0.0, 0.0], obstacles=beside)
    assert plan.success and plan.route == "demonstrated", plan.reason
    assert np.abs(plan.path.states[:, 2]).max() < 0.01


def poses_of_a_turn():
    """Recordings of poses that go along x and turn about z, a little aside of each other."""
    t = np.linspace(0, 1, 60)
    half = 0.6 * t
    turned = [np.cos(half), 0 * t, 0 * t, np.sin(half)]
    return [np.column_stack([t, aside + 0 * t, 0 * t, *turned]) for aside in np.linspace(-0.1, 0.1, 5)]


@pytest.fixture(scope="module")
def turn():
    return fit(poses_of_a_turn(), 2, space=StateSpace.pose())


@pytest.mark.parametrize("route", ["demonstrated", "geodesic"])
def test_points_written_with_the_other_sign_of_the_quaternion_are_the_same_points(turn, route):
    start, goal = poses_of_a_turn()[2][[0, -1]]
    point = poses_of_a_turn()[2][30:31]
    flipped = point * np.r_[np.ones(3), -np.ones(4)]
    one = turn.plan(start, goal, obstacles=PointObstacles(point, 0.05), route=route)
    other = turn.plan(start, goal, obstacles=PointObstacles(flipped, 0.05), route=route)
    assert one.success, one.reason
    assert np.linalg.norm(one.path.states - point, axis=1).min() > 0.025
    np.testing.assert_array_equal(other.path.states, one.path.states)


@pytest.mark.parametrize("which", ["start", "goal", "via 0"])
def test_quaternions_of_another_length_are_no_orientations(turn, which):
    start, goal = poses_of_a_turn()[2][[0, -1]]
    states = {"start": start, "via 0": poses_of_a_turn()[2][30], "goal": goal}
    states[which] = states[which] * np.r_[np.ones(3), np.full(4, 2.0)]
    with pytest.raises(InputError, match=f"{which}: quaternion .* of length 2; expected length 1"):
        turn.plan(states["start"], states["goal"], via=states["via 0"])
