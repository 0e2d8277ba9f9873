"""Who is stable and who is not, by judges that can be told what they should say; and Table II in small."""

import pickle

import numpy as np
import pytest
from joblib import parallel_config
from scipy.spatial import ConvexHull

from skillfold.experiments import nao_balance, nao_balance_rows
from skillfold.experiments.nao_balance import LOWER, UPPER, Counts
from skillfold.experiments.nao_floor import CLEAR, STEPS, around, led_out
from skillfold.experiments.nao_poses import Asked, Optimiser
from skillfold.experiments.nao_stability import (
    SPEED,
    Verdict,
    count,
    judge_motion,
    judge_pose,
    lasting,
    support_margin,
)
from skillfold.experiments.rows import Settings
from skillfold.manifold.skill import SkillManifold
from skillfold.robots.shapes import Box

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
FOOT = np.array([0.03, -0.1, 0.05])


@pytest.fixture(scope="module", autouse=True)
def in_one_process():
    """What starts others takes longer than so few trials."""
    with parallel_config(backend="sequential"):
        yield


@pytest.fixture(scope="module")
def optimiser():
    return Optimiser("left")


@pytest.fixture(scope="module")
def pose(optimiser):
    return optimiser.optimise(optimiser.over_foot(FOOT)).pose


@pytest.fixture(scope="module")
def tables():
    def fit(demos, **options):
        return SkillManifold.fit(demos, dim=3, kernels=10, ridge=1e-5, **options)

    return nao_balance.run(Settings(0, fit=fit), Counts((60,), 3, 2))


def test_margin_is_the_distance_from_the_nearest_edge_whichever_way_round():
    points = np.array([[0.5, 0.5], [0.9, 0.5], [1.2, 0.5], [0.5, -0.1]])
    for corners in (SQUARE, SQUARE[::-1]):
        np.testing.assert_allclose(support_margin(points, corners), [0.5, 0.1, -0.2, -0.1])


def test_margin_tells_inside_as_a_convex_hull_does(optimiser):
    points = np.random.default_rng(0).uniform(-0.06, 0.1, (300, 2))
    planes = ConvexHull(optimiser.polygon).equations
    inside = (points @ planes[:, :2].T + planes[:, 2] < 0).all(1)
    np.testing.assert_array_equal(support_margin(points, optimiser.polygon) > 0, inside)
    assert 10 < inside.sum() < 290


@pytest.mark.parametrize("pedestal", [True, False])
def test_an_optimal_pose_stands(optimiser, pose, pedestal):
    verdict = judge_pose(optimiser, pose, pedestal)
    assert verdict.stable
    assert not verdict.collides
    assert 0.005 < verdict.margin < 0.02
    assert 0.0 < verdict.leaning < 0.1


def test_a_pelvis_far_off_the_foot_falls_by_both(optimiser):
    off = optimiser.optimise(Asked(FOOT, optimiser.centre + np.array([-0.1, 0.0]))).pose
    verdict = judge_pose(optimiser, off)
    assert (verdict.balanced, verdict.upright) == (False, False)


def test_a_foot_in_the_floor_is_propped_there_and_not_on_a_pedestal(optimiser):
    """A robot that tips onto its free foot stays up only where there is ground for it."""
    tipping = optimiser.optimise(Asked(np.array([0.0, -0.1, 0.0]), optimiser.centre + np.array([0.0, -0.045]))).pose
    flat, high = (judge_pose(optimiser, tipping, pedestal) for pedestal in (False, True))
    assert not high.balanced
    assert flat.upright
    assert not high.upright


def test_a_motion_is_as_stable_as_its_worst_state(optimiser, pose):
    off = optimiser.optimise(Asked(FOOT, optimiser.centre + np.array([-0.1, 0.0]))).pose
    there = judge_motion(optimiser, np.stack([pose, off]))
    away = judge_motion(optimiser, np.stack([pose, off, pose]))
    assert there.margin < 0
    assert away.margin == pytest.approx(there.margin)
    assert judge_pose(optimiser, pose).margin > 0


def test_motions_last_as_their_fastest_joint_asks(pose):
    moved = pose.copy()
    moved[2] += 0.3
    assert lasting(np.stack([pose, moved, pose])) == pytest.approx(0.6 / SPEED)


def test_obstacles_stand_in_the_dynamics(optimiser, pose):
    box = Box(pose=(FOOT[0], FOOT[1], 0.06), size=(0.05, 0.05, 0.12), name="under the foot")
    assert judge_pose(optimiser, pose).upright
    assert not judge_motion(optimiser, pose[None], scene=[box]).upright


def test_counts_add_up():
    verdicts = [Verdict(0.01, 0.0, 0.1), Verdict(0.01, 0.0, -0.1), Verdict(-0.01, 0.0, 0.1), Verdict(0.01, 1.0, -0.1)]
    found = count(verdicts)
    assert (found.total, found.stable, found.balanced, found.upright, found.colliding, found.both) == (
        4,
        2,
        3,
        3,
        2,
        1,
    )
    assert "2 collide with themselves (1 of these among the stable)" in found.note


def test_poses_are_drawn_from_the_papers_box_and_the_same_for_a_seed(optimiser):
    drawn, again = (nao_balance.balancing(optimiser, 5, np.random.default_rng(3), Settings(3)) for _ in range(2))
    feet = optimiser.robot.forward(drawn.poses, optimiser.robot.swing)[:, :3]
    assert len(feet) == 5
    assert ((feet > LOWER - 0.004) & (feet < UPPER + 0.004)).all()
    np.testing.assert_array_equal(drawn.poses, again.poses)
    assert ((drawn.missed >= LOWER) & (drawn.missed <= UPPER)).all()
    assert not any(optimiser.optimise(optimiser.over_foot(foot)).reached for foot in drawn.missed[:3])


def test_a_trial_is_what_it_says(tables, optimiser):
    (table,) = tables
    assert len(table.demonstrations) == 60
    for before, trial in zip(table.trials, table.trials[1:], strict=False):
        np.testing.assert_array_equal(trial.projected, table.skill.project(trial.state))
        np.testing.assert_allclose(trial.plan.path.states[-1], trial.projected, atol=0.2)
        np.testing.assert_allclose(trial.plan.path.states[0], before.projected, atol=0.2)
        feet = [optimiser.robot.forward(q, optimiser.robot.swing)[:3] for q in (trial.projected, trial.best.pose)]
        assert trial.best.cost < 1.0
        np.testing.assert_allclose(*feet, atol=0.01)
        assert trial.error == pytest.approx(np.linalg.norm(trial.projected - trial.best.pose) / np.sqrt(12))


def test_poses_along_a_geodesic_are_held_one_by_one(tables, optimiser):
    """Each from standing still: first and last here are where the ways begin and end."""
    for before, trial in zip(tables[0].trials, tables[0].trials[1:], strict=False):
        assert len(trial.held) == 2
        for q, found in ((before.projected, trial.held[0]), (trial.projected, trial.held[1])):
            alone = judge_pose(optimiser, q, True), judge_pose(optimiser, q)
            assert [verdict.stable for verdict in found] == [verdict.stable for verdict in alone]


def test_a_foot_in_the_floor_is_led_out_along_the_manifold(tables, optimiser):
    skill, obstacles = tables[0].skill, around(optimiser)
    poses = tables[0].demonstrations
    low = poses[optimiser.robot.forward(poses, optimiser.robot.swing)[:, 2].argmin()]
    assert obstacles.clearance(low) < CLEAR
    led = led_out(skill, obstacles, low)
    assert obstacles.clearance(led) >= CLEAR
    assert skill.distance(led) < 1e-6
    assert np.linalg.norm(led - low) < 0.5
    np.testing.assert_array_equal(led_out(skill, obstacles, led), led)


def test_what_cannot_be_led_out_is_no_endless_search(tables, optimiser):
    class Blocked:
        asked = 0

        def clearance(self, q):
            self.asked += 1
            return -1.0

        def clearance_gradient(self, q):
            return np.zeros(12)

    blocked, q = Blocked(), tables[0].trials[0].projected
    np.testing.assert_allclose(led_out(tables[0].skill, blocked, q), q, atol=1e-9)
    assert blocked.asked == STEPS


def test_with_the_floor_known_plans_lead_from_one_led_state_to_the_next(tables, optimiser):
    obstacles = around(optimiser)
    for before, trial in zip(tables[0].trials, tables[0].trials[1:], strict=False):
        assert trial.floor.clear == (obstacles.clearance(trial.floor.pose) >= CLEAR)
        if trial.floor.plan.success:
            np.testing.assert_allclose(trial.floor.plan.path.states[0], before.floor.pose, atol=0.2)
            assert obstacles.clearance(trial.floor.plan.path.states).min() > 0.0


def test_trials_and_what_they_are_given_go_to_other_processes_and_back(tables, optimiser):
    things = optimiser, tables[0].skill, tables[0].trials[0]
    again, skill, back = (pickle.loads(pickle.dumps(thing)) for thing in things)
    trial = tables[0].trials[0]
    np.testing.assert_array_equal(skill.project(trial.state), trial.projected)
    asked = again.over_foot(again.robot.forward(trial.projected, again.robot.swing)[:3])
    np.testing.assert_array_equal(again.optimise(asked).pose, trial.best.pose)
    np.testing.assert_array_equal(back.plan.path.states, trial.plan.path.states)
    assert back.floor.verdicts == trial.floor.verdicts


def test_finite_differences_cost_more_and_come_to_the_same(tables):
    for trial in tables[0].trials:
        assert trial.by_differences.evaluations > 5 * trial.best.evaluations
        assert trial.by_differences.cost == pytest.approx(trial.best.cost, abs=1e-4)


def test_rows_stand_beside_the_papers(tables):
    rows = {row.name: row for row in nao_balance_rows.rows(tables)}
    assert len(rows) == 4 + 14
    assert sum("stable" in name for name in rows) == 10
    error = rows["Nao on one leg, 60 poses: RMSE of projections to the optimum"]
    assert error.measured == pytest.approx(np.mean([trial.error for trial in tables[0].trials]))
    assert (error.target, error.paper) == (0.01, "0.01")
    name = "Nao on one leg, 60 poses: projection, times faster than optimisation of a pose"
    faster, analytic = (rows[f"{name} {how}"] for how in ("by finite differences", "with analytic derivatives"))
    assert (faster.target, faster.paper) == (None, "22")
    assert (analytic.target, analytic.paper) == (1000.0, "")
    seconds = [(trial.seconds.differencing, trial.seconds.optimising) for trial in tables[0].trials]
    assert faster.measured / analytic.measured == pytest.approx(np.divide(*np.median(seconds, axis=0)))
    whole = next(row for name, row in rows.items() if name.endswith("of as many poses as it has states"))
    single = rows[
        "Nao on one leg, 60 poses: geodesic, times faster than optimisation of a pose by finite differences"
    ]
    assert whole.measured == pytest.approx(single.measured * len(tables[0].trials[0].plan.path.states))
    projected = rows["Nao on one leg, 60 poses: projected states stable by both judges on a pedestal"]
    assert projected.target == 3  # 47 of 50, of three
    assert projected.measured == sum(trial.verdicts[0][0].stable for trial in tables[0].trials)
    poses = rows["Nao on one leg, 60 poses: poses of geodesics stable by both judges on flat ground"]
    assert poses.target == 6  # 46 of 50, of two poses of each of three
    assert poses.measured == sum(pair[1].stable for trial in tables[0].trials for pair in trial.held)
