"""Steps, with skills that are always the same: straight lines in joint space through what they are asked."""

from types import SimpleNamespace

import numpy as np
import pytest
from joblib import parallel_config

from skillfold.errors import SkillfoldError
from skillfold.experiments import nao_around, nao_stepping, nao_steps, nao_walk
from skillfold.experiments.nao_stability import support_margin
from skillfold.experiments.nao_stepping import Counts
from skillfold.experiments.nao_steps import AHEAD, APEX, ASIDE, POINTS, Skills, Step, Stepper, same_pace
from skillfold.experiments.rows import Settings
from skillfold.robots.shapes import Box, Sphere
from skillfold.robots.standing import SIDES


class Straight:
    """Straight from state to state; past obstacles by a detour that it was told of."""

    dim = 3

    def __init__(self, detour=None):
        self.detour = detour

    def plan(self, start, goal, via=None, obstacles=None):
        between = self.detour if obstacles is not None and self.detour is not None else via
        corners = np.stack([start, *(() if between is None else between), goal])
        places = np.linspace(0, len(corners) - 1, 31)
        states = np.stack([np.interp(places, np.arange(len(corners)), column) for column in corners.T], axis=1)
        return SimpleNamespace(path=SimpleNamespace(states=states), success=True)


@pytest.fixture(scope="module", autouse=True)
def in_one_process():
    """What starts others takes longer than so few trials."""
    with parallel_config(backend="sequential"):
        yield


@pytest.fixture(scope="module")
def step():
    return Step("left", np.array([-0.08, -0.09]), np.array([0.07, -0.1]), 0.04)


@pytest.fixture(scope="module")
def example(step):
    return Stepper("left").example(step)


@pytest.fixture(scope="module")
def stepping():
    return nao_stepping.run(Settings(0, fit=lambda demos, **options: Straight()), Counts(2, 2, 2, 2))


def long_step():
    """A long step's poses on the floor, raised, and high above its middle."""
    stepper = Stepper("left")
    poses = [
        stepper.pose(stepper.optimiser.over_foot(np.array([x, -0.09, z])))
        for z, places in ((0.0, (-0.1, 0.1)), (0.02, (-0.1, 0.1)), (0.055, (-0.06, 0.06)))
        for x in places
    ]
    return np.array(poses).reshape(3, 2, -1)


def test_a_swing_is_a_sinusoid_over_a_straight_line(step, example):
    robot = Stepper("left").optimiser.robot
    feet = robot.forward(example.swing, robot.swing)[:, :3]
    shares = np.linspace(0, 1, POINTS)
    line = step.start + shares[:, None] * (step.goal - step.start)
    np.testing.assert_allclose(feet[:, :2], line, atol=1e-3)
    np.testing.assert_allclose(feet[:, 2], 0.04 * np.sin(np.pi * shares), atol=1e-3)


def test_a_shift_keeps_both_feet_and_brings_the_pelvis_over_the_other(step, example):
    stepper = Stepper("left")
    robot = stepper.optimiser.robot
    feet, pelvis = robot.forward(example.shift, robot.swing)[:, :3], robot.forward(example.shift, "Torso")[:, :2]
    np.testing.assert_allclose(feet, np.tile([*step.goal, 0.0], (POINTS, 1)), atol=1e-3)
    np.testing.assert_allclose(pelvis[0], [0.02, 0.0044], atol=1e-3)
    np.testing.assert_allclose(pelvis[-1], step.goal + np.array([0.02, -0.0044]), atol=1e-3)
    np.testing.assert_allclose(example.shift[0], example.swing[-1], atol=1e-3)


def test_the_other_foot_goes_on_where_this_one_ends(step, example):
    """The end of the shift is the optimal pose to begin the next swing with."""
    other = Stepper("right")
    begun = other.pose(other.swinging(Step("right", -step.goal, step.goal, 0.03), 0.0))
    np.testing.assert_allclose(Stepper("left").onward(example.shift[-1]), begun, atol=2e-3)


def test_both_soles_hold_what_lies_between_them(step):
    soles = Stepper("left").soles(step)
    between = np.array([[0.02, 0.0], step.goal + np.array([0.02, 0.0]), step.goal / 2 + [0.02, 0.0]])
    assert (support_margin(between, soles) > 0.01).all()
    assert (support_margin(np.array([[0.02, 0.06], [0.2, -0.1]]), soles) < 0).all()


def test_steps_are_drawn_within_their_ranges():
    rng = np.random.default_rng(0)
    for side in SIDES:
        drawn = [nao_steps.draw(side, rng) for _ in range(50)]
        places = np.array([place for step in drawn for place in (step.start, step.goal)])
        aside = places[:, 1] * (-1 if side == "left" else 1)
        assert AHEAD[0] <= places[:, 0].min() < 0 < places[:, 0].max() <= AHEAD[1]
        assert (aside >= ASIDE[0]).all()
        assert (aside <= ASIDE[1]).all()
        assert all(APEX[0] <= step.apex <= APEX[1] for step in drawn)


def test_what_is_out_of_reach_is_no_example():
    assert Stepper("left").example(Step("left", np.array([-0.1, -0.1]), np.array([0.1, -0.3]), 0.03)) is None


def test_same_pace_compares_at_shares_of_the_way():
    poses = np.linspace(0, 1, 5)[:, None] ** 2 * np.ones(12)
    np.testing.assert_allclose(same_pace(np.linspace(0, 1, 40)[:, None] * np.ones(12), poses), 0.0, atol=1e-12)
    np.testing.assert_allclose(same_pace(poses + 0.1, poses), 0.1)


def test_errors_of_optimal_states_are_none(step, example):
    stepper = Stepper("left")
    robot = stepper.optimiser.robot

    def asked(q):
        return stepper.optimiser.over_foot(robot.forward(q, robot.swing)[:3])

    assert stepper.errors(example.swing, asked, 3).shape == (3,)
    assert stepper.errors(example.swing, asked, 3).max() < 1e-4
    assert stepper.errors(example.swing + 0.02, asked, 3).min() > 5e-3


def test_a_detour_is_clear_and_the_straight_way_is_not():
    standing, raised, high = long_step()
    edge = Box(pose=(0.027, -0.09, 0.0125), size=(0.01, 0.08, 0.025), name="edge")
    case = nao_around.Case("left", edge, standing, raised, raised)
    over, through = (nao_around.ask(Skills(Straight(detour), Straight(), []), case) for detour in (high, None))
    assert over.clear
    assert over.as_asked
    assert over.verdict.stable
    assert not through.clear
    shares = [row.measured for row in nao_around.rows([over, through])]
    assert shares == [0.5, 0.5, 1.0]


def test_a_plan_that_says_it_failed_is_not_clear():
    standing, raised, high = long_step()
    case = nao_around.Case("left", Sphere(center=(0.5, 0.5, 0.1), radius=0.01, name="ball"), standing, raised, raised)
    answer = nao_around.ask(Skills(Straight(high), Straight(), []), case)
    assert answer.clear
    answer.plan.success = False
    assert not answer.clear


def test_cases_are_blocked_and_fair(stepping):
    assert len(stepping.around) == 2
    for answer in stepping.around:
        case = answer.case
        robot = Stepper(case.side).optimiser.robot
        there = robot.obstacles([case.obstacle])
        assert there.clearance(case.blocked).min() < nao_around.ASKED
        assert there.clearance(case.standing).min() > nao_around.ASKED
        assert not answer.clear  # a straight line is what is blocked


def test_a_walk_goes_on_from_foot_to_foot(stepping):
    walk = stepping.walk
    assert [step.side for step in walk.steps] == ["left", "right"]
    np.testing.assert_array_equal(walk.steps[1].start, -walk.steps[0].goal)
    np.testing.assert_allclose(walk.feet[2], walk.steps[0].goal + walk.steps[1].goal)
    jumps = np.abs(np.diff(walk.whole, axis=0)).max(1)
    assert jumps.max() < 0.1  # rad: no pose is skipped
    row = nao_walk.row(walk)
    assert row.measured == 1.0
    assert row.met
    assert walk.leaning[0] < 0.15


def test_a_walk_with_both_legs_stiff_and_tilted_falls(stepping):
    """The judge of walks knows a fall."""
    side = Stepper("left")
    states = np.tile(stepping.skills["left"].examples[0].swing[0], (2, 1))
    states[1, side.optimiser.robot.names.index("LAnklePitch")] += 0.5
    first = stepping.walk
    fallen = nao_walk.played(first.steps, first.feet, first.plans, [(side, states)])
    assert not fallen.up
    assert nao_walk.row(fallen).measured == 0.0


def test_no_step_in_reach_is_an_error(stepping, monkeypatch):
    monkeypatch.setattr(nao_walk, "TRIES", 2)
    skills = stepping.skills["left"]
    with pytest.raises(SkillfoldError, match="within reach"):
        nao_walk.planned(skills, Stepper("left"), None, np.array([0.0, -0.6]), np.random.default_rng(0))


def test_rows_tell_what_the_trials_found(stepping):
    rows = {row.name: row for row in nao_stepping.rows(stepping)}
    assert len(rows) == 10
    error = rows["Nao's new steps: RMSE to the optimum at each state's own foot and pelvis"]
    whole = [np.sqrt(np.mean(np.square(trial.errors))) for trial in stepping.trials]
    assert error.measured == pytest.approx(np.mean(whole))
    assert (error.target, error.paper) == (0.05, "0.1")
    name = "Nao's new steps: plan, times faster than optimisation"
    assert rows[f"{name} with analytic derivatives"].target == 1000
    assert (rows[f"{name} by finite differences"].target, rows[f"{name} by finite differences"].paper) == (None, "30")
    states = np.mean([sum(len(plan.path.states) for plan in trial.plans) for trial in stepping.trials])
    alike = rows[f"{name} by finite differences of as many poses as the plans have states"]
    assert alike.measured == pytest.approx(rows[f"{name} by finite differences"].measured * states / 20)
    assert rows["Nao's steps past a ball or an edge: clear"].measured == 0.0
    assert rows["Nao's new steps: stable by both judges"].measured == 1.0
