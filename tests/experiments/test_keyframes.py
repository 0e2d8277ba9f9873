"""The keyframes bench on very little: what it measures is what it says, and wrong paths are seen."""

import importlib.util

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from skillfold.errors import InputError, MissingExtraError
from skillfold.experiments import keyframe_judge as judging
from skillfold.experiments import keyframe_motions, keyframe_moving, keyframe_narrow, keyframe_peers, keyframe_runs
from skillfold.experiments.bench import GROUPS
from skillfold.experiments.keyframe_ompl import SPACES, EnvelopePeer
from skillfold.experiments.keyframe_tasks import tasks
from skillfold.experiments.keyframes import Counts, measure
from skillfold.experiments.rows import Settings
from skillfold.robots.world import World

SETTINGS = Settings(11)
INSTALLED = importlib.util.find_spec("ompl") is not None


@pytest.fixture(scope="module")
def learnt():
    return keyframe_runs.learn(tasks()[1], 0, SETTINGS)


@pytest.fixture(scope="module")
def answer(learnt):
    return keyframe_runs.ask(learnt, learnt.start(0), 100.0, 0, time_limit=10.0)


@pytest.fixture(scope="module")
def world(learnt):
    return World(learnt.task.robot, learnt.task.scene)


def test_a_plan_is_judged_good_and_one_through_the_can_is_not(learnt, answer, world):
    assert answer.plan.success
    seen = keyframe_runs.judged(answer, learnt, world).verdict
    assert seen is not None and seen.outside == seen.touching == seen.beyond == 0 and seen.excess <= 0.0
    ends = np.asarray(answer.plan.path.states)[[0, -1]]
    middle = ends.mean(axis=0)
    middle[2] += 0.35
    wrong = judging.judge(learnt.task.robot, world, learnt.envelope, np.array([ends[0], middle, ends[1]]))
    assert wrong.outside > 0 and wrong.excess > 0.0


def test_the_straight_way_touches_the_can(learnt, world):
    """Through a pose whose held thing is inside the can."""
    from skillfold.experiments.keyframe_tasks import DOWN
    from skillfold.robots.reaching import reach

    task = learnt.task
    inside = reach(task.robot, [*task.obstacle.pose[:3], *DOWN], task.robot.obstacles(task.shown))
    assert world.touching(inside) == len(inside) > 0
    lower = task.robot.limits.lower
    beyond = np.where(np.isfinite(lower), lower - 0.1, 0.0)[None]
    assert judging.judge(task.robot, world, learnt.envelope, np.repeat(beyond, 2, axis=0)).beyond > 0


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from([100.0, 85.0]))
def test_the_judge_and_the_envelope_agree(learnt, seed, alpha):
    """Two ways to the same distance, unless the judge has seen enough to call a pose inside."""
    envelope = learnt.envelope if alpha == 100.0 else learnt.envelope.reduced(alpha)
    rng = np.random.default_rng(seed)
    poses = envelope.sample(20, seed)
    poses[:, :3] += 0.05 * rng.standard_normal((20, 3))
    squares, mine = envelope.membership(poses)[0], judging.least_squares(envelope, poses)
    outside = mine > 1.0
    assert np.allclose(mine[outside], squares[outside], rtol=1e-6)
    assert (squares[~outside] <= 1.0 + 1e-9).all()


def test_the_chart_is_scipys(learnt):
    poses = learnt.envelope.sample(30, 1)
    y = judging.in_chart(learnt.envelope.chart.middle, poses)
    assert np.allclose(y, learnt.envelope.chart.to_chart(poses), atol=1e-12)
    again = Rotation.from_quat(learnt.envelope.chart.middle, scalar_first=True) * Rotation.from_rotvec(y[:, 3:])
    assert np.allclose(np.abs((again.as_quat(scalar_first=True) * poses[:, 3:]).sum(axis=1)), 1.0)


def test_what_goes_off_the_axis_along_a_direction():
    axis, aside = np.array([2.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    way = np.array([[0.0, 0, 0], [0.3, 0.4, 0], [0.6, 0.4, 0.3], [0.9, -5, 0]])
    along, across, share = keyframe_motions.off_axis(way, axis, aside)
    assert (along, across, share) == pytest.approx((0.4, 0.3, 4 / 7))
    assert keyframe_motions.off_axis(way[:1], axis, aside) == (0.0, 0.0, 0.0)
    tilted = keyframe_motions.off_axis(way, axis, np.array([1.0, 1.0, 0.0]))
    assert tilted == pytest.approx((along, across, share))


def test_cost_after_a_while():
    costs = [(0.02, 3.0), (0.08, 2.0), (1.5, 1.0)]
    assert keyframe_motions.cost_at(costs, 0.1) == 2.0
    assert keyframe_motions.cost_at(costs, 0.01) == 3.0
    assert keyframe_motions.cost_at(costs, 3.0) == 1.0


def test_a_slot_leaves_the_share_that_is_asked_for(learnt):
    at = keyframe_narrow.middle_of(learnt.task, learnt.envelope, np.random.default_rng(0), 60)
    made = keyframe_narrow.narrow(at, np.random.default_rng(1), 0.2)
    assert made.free == pytest.approx(0.2, abs=0.05)
    assert at.free(keyframe_narrow.walled(at, 0.0, 0.0)) < made.free < at.free(learnt.task.shown)
    places = learnt.task.robot.forward(at.postures)[:, :3] - at.middle
    along = np.cross([0.0, 0.0, 1.0], at.across)
    assert np.abs(places @ along).max() < 1e-4, "its poses lie in the wall's plane"


def test_a_box_comes_into_the_way_but_not_into_the_arm(learnt, answer):
    box = keyframe_moving.coming(learnt, answer.plan, np.random.default_rng(2))
    assert box is not None
    obstacles = learnt.task.robot.obstacles([box], self_collision=False)
    states = np.asarray(answer.plan.path.states)
    assert obstacles.at(100.0).clearance(states).min() < 0 < obstacles.at(0.0).clearance(states[0])
    half = keyframe_moving.at(states, 0.5 * answer.plan.path.length)
    assert np.array_equal(keyframe_moving.at(states, 1e9), states[-1]) and half.shape == (6,)


def test_contacts_of_an_arm_that_does_not_look_are_seen(learnt, answer, monkeypatch):
    """Driven on blindly, the arm runs into the box."""
    box = keyframe_moving.coming(learnt, answer.plan, np.random.default_rng(2))
    assert box is not None
    assert keyframe_moving.drive(learnt, answer.plan, box, 0).touched == 0
    monkeypatch.setattr(keyframe_moving._Drive, "_look", lambda self, pose: None)
    assert keyframe_moving.drive(learnt, answer.plan, box, 0).touched > 0


def test_the_distance_ompl_is_given_is_the_envelopes_and_its_gradient_right(learnt):
    if not INSTALLED:
        pytest.skip("needs OMPL")
    task = learnt.task
    start = learnt.start(3)
    peer = EnvelopePeer(task.robot, task.clear[1], learnt.envelope, start, start[None], SPACES[1])
    assert peer.distance(start)[0] == 0.0
    q = start + 0.3
    distance, gradient = peer.distance(q)
    assert distance == pytest.approx(learnt.envelope.distance(task.robot.forward(q)), abs=1e-3)
    steps = [peer.distance(q + 1e-6 * e)[0] - peer.distance(q - 1e-6 * e)[0] for e in np.eye(6)]
    assert np.allclose(gradient, np.array(steps) / 2e-6, atol=0.01)


@pytest.mark.parametrize("space", SPACES)
def test_ompl_beside_ours(learnt, space):
    if not INSTALLED:
        with pytest.raises(MissingExtraError, match="peers"):
            keyframe_peers.race(learnt, 0, space, SETTINGS)
        rows = keyframe_peers.rows([learnt], 1, SETTINGS)
        assert len(rows) == 4 and all(row.measured is None and "peers" in row.note for row in rows)
        return
    rows = keyframe_peers.compare([keyframe_peers.race(learnt, 0, space, SETTINGS, 0.3)], space)
    assert all(row.measured is not None for row in rows)


def test_an_unknown_space_is_told(learnt):
    with pytest.raises(InputError, match="rejection, projected"):
        EnvelopePeer(learnt.task.robot, learnt.task.clear[1], learnt.envelope, np.zeros(6), np.zeros((1, 6)), "free")


def test_the_group_measures_all_that_it_promises(monkeypatch):
    monkeypatch.setattr(keyframe_narrow, "POSES", 20)
    monkeypatch.setattr(keyframe_peers, "SECONDS", 0.1)
    one = {name: 1 for name in Counts.__dataclass_fields__ if name != "late"}
    rows = measure(SETTINGS, Counts(**one, late=0.2))
    assert len({row.name for row in rows}) == len(rows) == 22
    assert all(row.measured is None or np.isfinite(row.measured) for row in rows)
    assert "keyframes" in GROUPS
    by_name = {row.name: row for row in rows}
    for name in (
        "path poses inside the (reduced) envelope",
        "paths that touch something",
        "same seed, same path bits",
    ):
        assert by_name[name].met, name
