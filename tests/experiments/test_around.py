"""Plans around obstacles: what is counted as good is so by distances and kinematics of this file's own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from skillfold.experiments import around, around_arm, around_peers, around_tray, bench, three_link, tray
from skillfold.experiments.ompl_peer import PeerPlan
from skillfold.experiments.oracle import finely
from skillfold.experiments.rows import Settings
from skillfold.manifold.skill import SkillManifold


def quick(demos):
    return SkillManifold.fit(demos, kernels=20, dim=demos.shape[1] // 2 if demos.shape[1] > 3 else 2)


@pytest.fixture(scope="module")
def settings():
    return Settings(3, fit=quick)


@pytest.fixture(scope="module")
def skill(settings):
    return around_arm.learn(settings, np.random.default_rng(0))


@pytest.fixture(scope="module", params=around_arm.KINDS, ids=lambda kind: kind.name)
def answers(request, skill):
    cases = around_arm.make_cases(skill, request.param, 3, np.random.default_rng(1))
    return around_arm.ask(skill, cases)


@pytest.fixture(scope="module")
def boxes(settings):
    task = around_tray.prepare(settings, 2, 1)
    return task, around_tray.run(task, settings)


def told(answer, states, success=True):
    """The same answer with another path."""
    path = SimpleNamespace(states=states)
    return around_arm.answer(Says(success, path), answer.case)


class Says:
    """A skill that answers with a path whatever it is asked."""

    def __init__(self, success, path):
        self.success, self.path = success, path

    def plan(self, start, goal, **options):
        length = float(np.linalg.norm(np.diff(self.path.states, axis=0), axis=1).sum())
        stats = {"methods": ("told",), "seconds_to_first": 0.0}
        return SimpleNamespace(success=self.success, path=self.path, length=length, stats=stats)


def test_finer_paths_are_the_same_paths():
    path = np.cumsum(np.random.default_rng(0).standard_normal((20, 3)), axis=0)
    fine = finely(path, 0.01)
    assert np.linalg.norm(np.diff(fine, axis=0), axis=1).max() <= 0.01 + 1e-12
    assert cdist(path, fine).min(axis=1).max() < 1e-12
    np.testing.assert_array_equal(fine[[0, -1]], path[[0, -1]])
    lengths = [np.linalg.norm(np.diff(states, axis=0), axis=1).sum() for states in (path, fine)]
    assert lengths[0] == pytest.approx(lengths[1])


def test_plans_around_patches_are_clear_and_optimal(answers):
    for answer in answers:
        assert answer.good
        states = answer.plan.path.states
        share = np.linspace(0.0, 1.0, 40)[:, None, None]
        between = (states[:-1] + share * np.diff(states, axis=0)).reshape(-1, 3)
        nearest = cdist(between, answer.case.points).min()
        assert nearest > 0.5 * answer.case.reach
        assert nearest / answer.case.reach == pytest.approx(answer.clearance, abs=0.01)
        np.testing.assert_allclose(states[[0, -1]], [answer.case.start, answer.case.goal])
        best = three_link.followed(three_link.forward(states), three_link.WEIGHTED_REACHING)
        assert np.sqrt(np.mean((states - best) ** 2)) == pytest.approx(answer.rmse)
        assert answer.rmse < 0.02


def test_what_says_success_is_not_believed(answers):
    for answer in answers:
        case = answer.case
        assert told(answer, case.oracle).good
        assert not told(answer, case.oracle, success=False).good
        through = told(answer, np.stack([case.start, case.goal]))
        assert not through.good
        lifted = told(answer, case.oracle + 0.1)
        assert lifted.rmse > 0.02
        assert not lifted.good


def test_rows_tell_what_went_wrong(answers):
    walls = [told(answer, np.vstack([answer.case.start, answer.case.points[:1]])) for answer in answers]
    failed = [told(answer, answer.case.oracle, success=False) for answer in answers]
    lifted = [told(answer, answer.case.oracle + 0.1) for answer in answers]
    kinds = [kind.name for kind in around_arm.KINDS]
    rows = around_arm.rows(dict(zip([("", kind) for kind in kinds], (failed, lifted, walls), strict=True)))
    assert [row.measured for row in rows[:4]] == [0.0, 0.0, 0.0, 3]
    assert "3 say that they failed" in rows[0].note
    assert "on the manifold" in rows[1].name
    assert "3 say success but come too near" in rows[2].note
    assert not any(row.met for row in rows[:4])


def test_the_paths_of_local_methods_are_judged_alike(skill):
    cases = around_arm.make_cases(skill, around_arm.KINDS[0], 2, np.random.default_rng(2))
    for method in around_arm.LOCAL:
        for answer in around_arm.ask(skill, cases, method):
            assert answer.good <= answer.plan.success
    assert not any(answer.good for answer in around_arm.ask(skill, cases, "geodesic"))


def test_plans_past_boxes_are_clear_and_level(boxes):
    for run in boxes[1]:
        for answer in run.answers:
            assert answer.valid
            fine = finely(answer.plan.path.states, 0.004)
            assert tray.arm().obstacles(answer.case.scene).clearance(fine).min() > 0.0
            assert tray.tilt(fine).max() < 0.02
            x, y = tray.arm().forward(fine)[:, 4:6].T
            np.testing.assert_allclose(np.cos(tray.tilt(fine)), 1 - 2 * (x * x + y * y), atol=1e-9)
            lower, upper = tray.arm().limits
            assert ((fine >= lower - 1e-9) & (fine <= upper + 1e-9)).all()


def test_paths_through_boxes_tilted_or_beyond_limits_are_not_valid(boxes):
    case = boxes[0].past[0]

    def judged(states):
        return around_tray.answer(Says(True, SimpleNamespace(states=states)), case)

    assert judged(case.oracle).valid
    straight = tray.levelled(finely(np.stack([case.start, case.goal]), 0.02), tray.LEVEL_WEIGHT)
    assert not judged(straight).clearance > 0.0
    tilted = case.oracle + 0.1 * np.eye(7)[5]
    assert judged(tilted).tilts.max() > 0.02
    beyond = case.oracle + np.linspace(0.0, 4.0, len(case.oracle))[:, None] * np.eye(7)[6]
    assert not judged(beyond).within
    assert not any(judged(states).valid for states in (straight, tilted, beyond))


def test_rows_of_boxes(boxes):
    rows = around_tray.rows(*boxes)
    assert len({row.name for row in rows}) == len(rows) == 3 + 1 + 4 + 1
    assert all(row.measured is not None and np.isfinite(row.measured) for row in rows)
    assert [row.measured for row in rows[:3]] == [1.0] * 3
    demonstrated = np.concatenate([tray.tilt(poses) for poses in boxes[0].demonstrations.values()])
    assert rows[3].target == pytest.approx(np.quantile(demonstrated, 0.95))


def test_ratios_with_ompl(boxes):
    ours = [replace(answer, seconds=0.01) for answer in boxes[1][0].answers]
    for answer in ours:
        answer.plan.stats["seconds_to_first"] = 0.002
    slow = [PeerPlan("atlas", True, 0.006, 0.04, a.case.oracle) for a in ours]
    slow[-1] = replace(slow[-1], solved=False)
    races = [around_peers.Race(a, {"atlas": plan}) for a, plan in zip(ours, slow, strict=True)]
    first, whole, solved, length = around_peers.compare(races, "atlas")
    assert first.measured == pytest.approx(3.0)
    assert whole.measured == pytest.approx(4.0)
    assert (solved.measured, solved.target, solved.met) == (1.0, 0.5, True)
    assert "1 are valid" in solved.note
    assert length.measured == pytest.approx(ours[0].plan.length / ours[0].case.length)


def test_without_ompl_every_row_says_so(boxes, monkeypatch):
    def missing(*_):
        raise around_peers.MissingExtraError("OMPL is not installed: pip install 'skillfold[peers]'.")

    monkeypatch.setattr(around_peers, "OmplPeer", missing)
    rows = around_peers.rows(boxes[0].skills[400], boxes[0].past, Settings(0))
    assert len({row.name for row in rows}) == len(rows) == 8
    assert all(row.measured is None and row.met is None and "peers" in row.note for row in rows)


def test_the_group_measures_all(settings, monkeypatch):
    monkeypatch.setitem(bench.GROUPS, "around", (lambda given: around.measure(replace(given, fit=quick), counts),))
    counts = around.Counts(around_arm.Counts(1, (1, 1, 1), 1), 1, 1, 1)
    shares = []
    report = bench.run(["around"], seed=5, progress=lambda label, share: shares.append(share))
    assert len({row.name for row in report.rows}) == len(report.rows) == 4 + 2 + 9 + 9 + 8
    assert shares == sorted(shares)
