"""Samples that coincide: given twice, moved apart by rounding, or alike in all but a free direction."""

import numpy as np
import pytest

from manifold.conftest import curves, fit
from skillfold.errors import DisconnectedError
from skillfold.manifold.free import split_directions
from skillfold.manifold.samples import crowds, distinct, read_samples, side_by_side, told_apart
from skillfold.spaces import StateSpace


def bent(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Places on a sheet that bends along x alone, on a grid; (len(x) * len(y), 3)."""
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.column_stack([places, 0.2 * np.sin(3.0 * places[:, 0])])


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("columns", [8, 30])
def test_on_a_grid_that_bends_one_way_plans_are_what_they_are_elsewhere(columns, turned):
    """Without the other direction whole rows of it coincide: counted each, they would predict each other exactly."""
    grid = bent(np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, 40))
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0] if turned else np.eye(3)
    skill = fit(grid @ turn, 2)
    plan = skill.plan(grid[0] @ turn, grid[-1] @ turn)
    assert skill.model.free.shape[1] == 1
    assert plan.success, plan.reason
    states = plan.path.states @ turn.T
    off = np.abs(states[:, 2] - 0.2 * np.sin(3.0 * states[:, 0]))
    assert off.max() < max(3.0 * skill.noise, 1e-4)
    # A held-out residual that tells how far: nothing is predicted by its own twin.
    assert skill.noise > 0.1 * off.max()


def test_nothing_is_free_where_too_few_would_be_left():
    grid = bent(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 40))
    assert split_directions(grid, None, 2, 0)[0].free.shape[1] == 0


def test_what_rounding_has_moved_apart_is_the_same():
    states = np.random.default_rng(0).normal(size=(50, 4))
    again = states * (1.0 + 1e-15)
    np.testing.assert_array_equal(distinct(np.vstack([states, again, states[::-1]])), np.arange(50))
    np.testing.assert_array_equal(distinct(np.vstack([states, states + 1e-6])), np.arange(100))
    np.testing.assert_array_equal(distinct(np.zeros((3, 2))), [0])


def test_what_rounding_has_moved_into_another_cell_is_the_same():
    """Of so many even steps, every other one is on the edge of a cell."""
    states = np.outer(np.linspace(0.0, 1.0, 1025), [1.0, 2.0, -4.0])
    again = [states + 1e-13 * np.random.default_rng(i).normal(size=states.shape) for i in range(5)]
    np.testing.assert_array_equal(distinct(np.vstack([states, *again])), np.arange(1025))


def test_of_a_recording_given_twice_nothing_is_left():
    curve = curves()[0]
    once, twice = read_samples([curve], None), read_samples([curve, curve * (1.0 + 1e-15)], None)
    assert twice.groups is None
    np.testing.assert_array_equal(once.states, twice.states)


def test_of_one_given_again_so_little_is_left_that_it_does_not_count():
    curve = curves()[0]
    moved = curve.copy()
    moved[30] += 1e-6
    once, twice = read_samples([curve], None), read_samples([curve, moved], None)
    assert twice.groups is None
    np.testing.assert_array_equal(once.states, twice.states)


def _bowl(count, times, tremble):
    """Places on z = 0.3 (x² + y²), so many samples at each; (count * times, 3)."""
    rng = np.random.default_rng(3)
    places = rng.uniform(-1.0, 1.0, (count, 2))
    held = np.repeat(np.column_stack([places, 0.3 * (places**2).sum(1)]), times, axis=0)
    return held + tremble * rng.normal(size=held.shape)


@pytest.mark.parametrize(("times", "tremble"), [(2, 1e-8), (4, 1e-4), (15, 1e-6)])
def test_poses_that_were_held_are_left_out_as_one(times, tremble):
    """Else their samples would predict each other: neither noise nor how far apart places are would be known."""
    held = _bowl(200, times, tremble)
    skill = fit(held, 2)
    assert skill.noise > 0.9 * max(tremble, 1e-6)
    for i, j in np.random.default_rng(0).choice(len(held), (4, 2)):
        plan = skill.plan(held[i], held[j])
        assert plan.success, plan.reason
        x, y, z = plan.path.states.T
        assert np.abs(z - 0.3 * (x**2 + y**2)).max() < max(5.0 * skill.tolerance, 1e-3)


@pytest.mark.parametrize("tremble", [1e-8, 1e-5])
def test_a_motion_repeated_in_the_same_steps_is_left_out_place_by_place(tremble):
    rng = np.random.default_rng(0)
    curve = curves()[0]
    once = fit([curve, curve], 1)
    skill = fit([curve + tremble * rng.normal(size=curve.shape) for _ in range(5)], 1)
    assert 0.5 < skill.residual / once.residual < 2.0
    for route in (None, "geodesic"):
        plan = skill.plan(curve[5], curve[-9], route=route)
        assert plan.success, plan.reason
        assert once.distance(plan.path.states).max() < 10.0 * once.tolerance


def test_a_few_large_parts_are_no_crowds():
    parts = [_bowl(150, 1, 0.0) + 200.0 * i for i in range(4)]
    assert crowds(np.vstack(parts)) is None
    assert crowds(_bowl(300, 1, 0.0)) is None
    assert crowds(np.eye(2)) is None


def test_poses_that_were_held_fall_apart_where_the_poses_do():
    rng = np.random.default_rng(2)
    place = np.sort(rng.uniform(0.0, 1.0, 40))
    curve = np.repeat(np.column_stack([place, place**2, np.sin(place)]), 11, axis=0)
    held = curve + 1e-7 * rng.normal(size=curve.shape)
    assert fit(held, 1).tolerance < 1e-3
    with pytest.raises(DisconnectedError, match=r"2 parts: 40 samples; 40 samples\. The widest gap"):
        fit(np.vstack([held, held + 30.0]), 1)


def test_what_is_left_keeps_its_recording():
    states = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    left, groups = told_apart(states, np.array([0, 0, 1, 1]))
    np.testing.assert_array_equal(left, states[[0, 1, 3]])
    np.testing.assert_array_equal(groups, [0, 0, 1])


def test_a_slip_of_units_is_told():
    """A row in millimetres among metres, in a cloud and in a recording."""
    states = np.random.default_rng(0).normal(size=(100, 3))
    states[17] *= 1e4
    (told,) = read_samples(states, None).notes
    assert "row 17" in told
    assert "times as far as is usual: a slip?" in told
    slipped = [curve.copy() for curve in curves()[:3]]
    slipped[1][7] *= 1e4
    assert any("Demonstration 1, row 7" in note for note in read_samples(slipped, None).notes)
    assert read_samples(curves()[:3], None).notes == ()


def test_angles_of_samples_without_order_are_written_in_one_turn():
    """From one row to the next they may go more than half a turn either way, which says nothing of turns."""
    rng = np.random.default_rng(0)
    angles = rng.uniform(-2.9, 2.9, (300, 1))
    states = np.hstack([angles + 2.0, np.sin(angles)])
    space = StateSpace.continuous(1) + StateSpace.linear(1)
    found = read_samples(space.wrap(states), space).states
    np.testing.assert_allclose(found - found[0], states - states[0], atol=1e-12)
    skill = fit(space.wrap(states), 1, space=space)
    plan = skill.plan(*space.wrap(states[[angles.argmin(), angles.argmax()]]))
    assert plan.success, plan.reason
    np.testing.assert_allclose(plan.path.states[:, 1], np.sin(plan.path.states[:, 0] - 2.0), atol=1e-4)


def test_quaternions_of_samples_without_order_have_the_sign_that_is_near_to_most():
    rng = np.random.default_rng(0)
    half = rng.uniform(-1.1, 1.1, 200)
    turns = np.column_stack([np.cos(half), 0.6 * np.sin(half), 0.8 * np.sin(half), 0.0 * half])
    turns[0] = [1.0, 0.0, 0.0, 0.0]
    flipped = turns * np.append(1.0, rng.choice([-1.0, 1.0], 199))[:, None]
    np.testing.assert_array_equal(side_by_side(flipped, StateSpace.quaternion()), turns)


def test_states_that_are_near_each_other_stay_as_they_are_written():
    rng = np.random.default_rng(0)
    states = np.hstack([40.0 + rng.uniform(-1.0, 1.0, (50, 2)), -np.eye(4)[0] + 0.1 * rng.normal(size=(50, 4))])
    space = StateSpace.continuous(2) + StateSpace.quaternion()
    np.testing.assert_array_equal(side_by_side(states, space), states)


class Table:
    """As other libraries have them: no sequence, no NumPy array, but it can be one."""

    ndim = 2

    def __array__(self, dtype=None, copy=None):
        return np.random.default_rng(0).normal(size=(30, 3))


def test_a_table_of_another_library_is_a_cloud_as_an_array_is():
    assert read_samples(Table(), None).groups is None  # pyright: ignore[reportArgumentType]
    assert read_samples(Table(), None).recordings == ()  # pyright: ignore[reportArgumentType]


def test_arrays_on_their_side_are_told():
    lying = [x.T for x in curves(3, 60)]
    assert any("Is x.T meant?" in note for note in read_samples(lying, None).notes)
    assert not any("x.T" in note for note in read_samples(curves(3, 60), None).notes)
