"""Table I on skills that are always right: what the protocol does to them, and to the naive planner."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skillfold.baselines.quintic import Quintic
from skillfold.experiments import pushed_motions, table_one, three_link, tray
from skillfold.experiments.bench import GROUPS
from skillfold.experiments.rows import Settings
from skillfold.experiments.three_link import WEIGHTED_REACHING

TRIALS = 5


class _Right:
    """Plans over true optimal poses; projects to the optimal pose where the tool is."""

    def __init__(self, samples):
        self.dim = samples.shape[1] // 2
        self.arm = samples.shape[1] == 3

    def truth(self, states):
        if self.arm:
            return three_link.followed(three_link.forward(states), WEIGHTED_REACHING)
        return tray.optimum(tray.positions(states), tray.PAPER_WEIGHT)

    def project(self, state, near):
        found = self.truth(state[None])[0]
        return found if np.isfinite(found).all() else near

    def plan(self, start, goal):
        line = start + np.linspace(0, 1, 30)[:, None] * (goal - start)
        return SimpleNamespace(path=SimpleNamespace(states=self.truth(line)), success=True)


@pytest.fixture(scope="module")
def halves():
    return table_one.table(Settings(0, fit=_Right), TRIALS)


@pytest.fixture(scope="module", params=[0, 1], ids=["3-link", "KUKA"])
def half(halves, request):
    return halves[request.param]


def test_motions_go_from_start_to_goal(half):
    for runs in half.runs:
        for states in runs.motions.values():
            assert states.shape == (TRIALS, pushed_motions.STEPS, half.task.ends.shape[-1])
            np.testing.assert_allclose(states[:, 0], half.task.ends[:, 0], atol=1e-9)
            np.testing.assert_allclose(states[:, -1], half.task.ends[:, 1], atol=1e-9)


def test_naive_motions_are_quintics(half):
    times = np.linspace(0, 1, pushed_motions.STEPS)
    for (start, goal), states in zip(half.task.ends, half.runs[0].motions["naive"], strict=True):
        np.testing.assert_allclose(states, Quintic.between(start, goal).position(times), atol=1e-9)
    for (_, goal), states in zip(half.task.ends, half.runs[1].motions["naive"], strict=True):
        again = Quintic.between(states[25], goal, 0.75).position(times[25:] - 0.25)
        np.testing.assert_allclose(states[25:], again, atol=1e-9)


def test_every_method_is_pushed_alike(half):
    alone = half.runs[0].motions
    for runs in half.runs[1:]:
        np.testing.assert_allclose(np.linalg.norm(runs.pushes, axis=1), runs.push)
        for method, states in runs.motions.items():
            np.testing.assert_array_equal(states[:, :25], alone[method][:, :25])
            np.testing.assert_allclose(states[:, 25] - alone[method][:, 25], runs.pushes, atol=1e-12)


def test_a_right_skill_is_back_at_once_and_the_naive_planner_never(half):
    back = 9  # the first looked at after a tenth of the time
    for runs in half.runs[1:]:
        excess = {method: np.nanmean(values[:, back:], axis=1) for method, values in runs.excess.items()}
        assert (excess["manifold"] < 1e-3 * excess["naive"]).all()
        assert (excess["manifold"] <= excess["unhurried"] + 1e-12).all()
    assert min(np.nanmin(values) for runs in half.runs for values in runs.excess.values()) > -1e-9


def test_a_right_skill_meets_every_target_but_where_ends_are_few(half):
    rows = table_one.rows(half)
    assert len(rows) == len({row.name for row in rows})
    excess = [row for row in rows if "excess" in row.name]
    assert len(excess) == 2
    assert all(row.met for row in excess)
    assert all(row.paper for row in rows if row not in excess)
    assert all("lower in" in row.note for row in rows if row not in excess)


def test_mean_costs_are_means_of_costs(half):
    runs = half.runs[1]
    for cost in half.task.costs.values():
        for method, means in runs.costs(cost).items():
            np.testing.assert_allclose(means[2], cost(runs.motions[method][2]).mean())


def test_failed_plans_are_counted_and_told():
    class Wrong(_Right):
        def plan(self, start, goal):
            return SimpleNamespace(**{**vars(super().plan(start, goal)), "success": False})

    rng = np.random.default_rng(0)
    task = table_one.three_link_task(Settings(0, fit=Wrong), rng, 2)
    half = table_one.Half(task, tuple(pushed_motions.run(task, push, rng) for push in (0.0, 0.5)))
    assert [runs.failed for runs in half.runs] == [2, 4]
    assert "4 plans failed" in table_one.rows(half)[1].note


def test_ends_that_a_skill_moves_are_told(half):
    told = [row.note for row in table_one.rows(half)]
    assert not any("moved" in note for note in told)
    runs = half.runs[0]
    motions = {**runs.motions, "manifold": runs.motions["manifold"].copy()}
    motions["manifold"][1, 0] += 0.3 * np.eye(half.task.ends.shape[-1])[0]
    moved = table_one.Half(half.task, (replace(runs, motions=motions), *half.runs[1:]))
    note = table_one.rows(moved)[0].note
    assert "ends of 1 lay off its surface and were moved, by 0.3 rad at most" in note


def test_the_table_is_a_group_of_the_benchmark():
    assert table_one.measure in GROUPS["control"]


def test_followed_poses_are_those_of_the_branch_above():
    x = np.linspace(-0.8, 0.8, 9)
    above = np.column_stack([x, np.full(9, 0.01)])
    below = above * [1, -1]
    np.testing.assert_array_equal(
        three_link.followed(above, WEIGHTED_REACHING), three_link.optimal(above, WEIGHTED_REACHING)
    )
    poses = three_link.followed(below, WEIGHTED_REACHING)
    assert three_link.kkt_residual(poses, below, WEIGHTED_REACHING).max() < 1e-9
    assert np.abs(poses - three_link.followed(above, WEIGHTED_REACHING)).max() < 0.2
    assert (
        WEIGHTED_REACHING.cost(poses) > WEIGHTED_REACHING.cost(three_link.optimal(below, WEIGHTED_REACHING))
    ).all()
