"""Places of paths and ends that are moved, against plain twins that move them the same way."""

import numpy as np
import pytest

from keyframes import planner_twins as twins
from keyframes.asked import asked
from skillfold.keyframes.grown import REACH, dense
from skillfold.keyframes.kernels import relaxing
from skillfold.keyframes.rrtstar import search


@pytest.fixture(scope="module")
def world():
    return asked()


@pytest.fixture(scope="module")
def path(world):
    found = search(world.question, world.start, world.leg.targets, 0.0, np.inf, True, 3)
    return dense(found.path, REACH)


def draws(count, dof, seed):
    rng = np.random.default_rng(seed)
    return (
        rng.random(count),
        rng.random(count),
        rng.choice([0.01, 0.05], (count, 1)) * rng.standard_normal((count, dof)),
    )


def holds_at(world, twin, q, last):
    """`holds_at` in plain code."""
    pose = world.robot.forward(q)
    fits = world.robot.space.contains(q, 0.0) and twin.is_inside(pose) and twin.is_clear(q)
    return bool(fits and (not last or twin.is_goal(pose)))


def relaxed(world, path, picks, pulls, moves, free):
    """`relax`, `propose`, `gap_to` and `edges_hold` in plain code."""
    path, twin = path.copy(), twins.Twin(world)
    length = lambda p: np.linalg.norm(np.diff(p, axis=0), axis=1).sum()  # noqa: E731
    for pick, pull, move in zip(picks, pulls, moves, strict=True):
        i = 1 + int(pick * (len(path) - 1 if free else len(path) - 2))
        last = i == len(path) - 1
        middle = 0.5 * (path[i - 1] + path[i - 1 if last else i + 1])
        moved = path.copy()
        moved[i] += pull * (middle - path[i]) + move
        if length(path) - length(moved) < relaxing.WORTH or not holds_at(world, twin, moved[i], last):
            continue
        edges = [(moved[i - 1], moved[i])] + ([] if last else [(moved[i], moved[i + 1])])
        if all(twin.seems_to_hold(a, b) and twin.edge_is_clear(a, b) for a, b in edges):
            path = moved
    return path


@pytest.mark.parametrize("free", [True, False])
def test_relax(world, path, free):
    picks, pulls, moves = draws(80, 6, 1)
    found = path.copy()
    gained = relaxing.relax(world.table, found, len(found), picks, pulls, moves, free)
    np.testing.assert_allclose(found, relaxed(world, path, picks, pulls, moves, free), atol=1e-9)
    before, after = (np.linalg.norm(np.diff(p, axis=0), axis=1).sum() for p in (path, found))
    assert gained == pytest.approx(before - after, abs=1e-9) and gained > 0.0
    assert free or (found[-1] == path[-1]).all()
    assert (found[0] == path[0]).all()
    assert world.leg.hold.contains(world.robot.forward(dense(found, 0.01))).all()
    assert world.obstacles.clearance(dense(found, 0.01)).min() > 0.0


def test_a_path_of_one_edge_between_fixed_ends_stays(world, path):
    found = path[:2].copy()
    assert relaxing.relax(world.table, found, 2, *draws(10, 6, 2), False) == 0.0
    assert (found == path[:2]).all()


def test_approach(world, path):
    _, pulls, moves = draws(60, 6, 4)
    states, twin = np.stack([path[-1], path[-1]]), twins.Twin(world)
    expected = path[-1].copy()
    for pull, move in zip(pulls, moves, strict=True):
        q = expected + pull * (world.start - expected) + move
        nearer = np.linalg.norm(q - world.start) < np.linalg.norm(expected - world.start)
        if nearer and holds_at(world, twin, q, True):
            expected = q
    relaxing.approach(world.table, world.start, states, pulls, moves)
    np.testing.assert_allclose(states, [expected, expected], atol=1e-9)
    assert np.linalg.norm(expected - world.start) < np.linalg.norm(path[-1] - world.start)
