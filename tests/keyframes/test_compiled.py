"""Any constraint in a compiled loop: its own functions, or calls back into Python that cannot bring it down."""

import threading

import numpy as np
import pytest

from keyframes.envelopes import near, random_gaussian, random_poses
from skillfold.errors import InputError
from skillfold.jit import njit
from skillfold.keyframes.compiled import SLACK, compiled_constraint, raise_error
from skillfold.keyframes.envelope import SoftEnvelope
from skillfold.keyframes.hand_written import AxisUpright, PlaneConstraint, TaskSpaceRegion


@njit
def loop(excess, project, poses, arguments, excesses, again, out):
    for i in range(len(poses)):
        excesses[i] = excess(poses[i], arguments)
        again[i] = project(poses[i], out[i], arguments)


def run(constraint, poses):
    compiled = constraint if isinstance(constraint, tuple) else compiled_constraint(constraint)
    excesses, again, out = np.empty(len(poses)), np.empty(len(poses)), np.empty_like(poses)
    loop(compiled.excess, compiled.project, poses, compiled.arguments, excesses, again, out)
    return excesses, again, out


class Shelf:
    """A user's own: below a height."""

    def distance(self, poses):
        return np.maximum(np.asarray(poses)[..., 2] - 0.1, 0)

    def project(self, poses):
        poses = np.array(poses)
        poses[..., 2] = np.minimum(poses[..., 2], 0.1)
        return poses


def constraints():
    rng = np.random.default_rng(0)
    gaussian = random_gaussian(rng)
    envelope = SoftEnvelope.between(gaussian, random_gaussian(rng))
    region = TaskSpaceRegion((0, 0, 0, 1, 0, 0, 0), [-0.1] * 6, [0.1] * 6)
    hand_written = [AxisUpright(), PlaneConstraint((0, 0, 0.1)), region, Shelf()]
    return [gaussian, envelope, envelope.reduced(70), envelope.slice(1.0), *hand_written]


def test_one_loop_serves_all_and_agrees_with_python():
    rng = np.random.default_rng(1)
    for constraint in constraints():
        poses = random_poses(30, rng, 0.1)
        if isinstance(constraint, SoftEnvelope):
            poses = np.concatenate([poses, near(constraint, 30, rng, 0.02)])
        excesses, again, out = run(constraint, poses)
        np.testing.assert_allclose(again, excesses, atol=1e-12)
        np.testing.assert_array_equal(excesses <= 0, constraint.distance(poses) == 0)
        np.testing.assert_allclose(out, constraint.project(poses), atol=1e-12)
    assert len(loop.signatures) == 1


class Broken(Shelf):
    """As often as users' code is."""

    def __init__(self, answer):
        self.answer = answer

    def distance(self, poses):
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer


@pytest.mark.parametrize(
    ("answer", "kind"),
    [
        (ZeroDivisionError("no way"), ZeroDivisionError),
        (KeyboardInterrupt(), KeyboardInterrupt),
        (np.array([np.nan]), InputError),
        ("far", InputError),
        (0.0, InputError),
        (np.zeros(3), InputError),
        (np.zeros((1, 1)), InputError),
        (np.zeros(1, complex), InputError),
        ([[0.0], [0.0, 1.0]], InputError),
        (None, InputError),
    ],
)
def test_what_goes_wrong_in_python_counts_as_outside_and_is_raised_afterwards(answer, kind):
    compiled = compiled_constraint(Broken(answer))
    pose = np.array([[0, 0, 0.2, 1.0, 0, 0, 0]])
    excesses, again, out = run(compiled, pose)
    assert (excesses[0], again[0]) == (np.inf, np.inf)
    np.testing.assert_array_equal(out, pose)
    with pytest.raises(kind):
        raise_error(compiled)
    raise_error(compiled)


@pytest.mark.parametrize("answer", [np.zeros(6), np.full(7, np.nan), "there", None])
def test_projections_that_are_no_poses_are_raised(answer):
    shelf = Shelf()
    shelf.project = lambda poses: answer
    compiled = compiled_constraint(shelf)
    pose = np.array([[0, 0, 0.2, 1.0, 0, 0, 0]])
    excesses, again, out = run(compiled, pose)
    assert excesses[0] == pytest.approx(0.1 - SLACK)
    assert again[0] == np.inf
    np.testing.assert_array_equal(out, pose)
    with pytest.raises(InputError, match="projection"):
        raise_error(compiled)


def test_calls_from_other_threads():
    poses, found = random_poses(200, np.random.default_rng(2)), {}
    compiled = compiled_constraint(Shelf())
    threads = [threading.Thread(target=lambda i=i: found.update({i: run(compiled, poses)[0]})) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for excesses in found.values():
        np.testing.assert_allclose(excesses, Shelf().distance(poses) - SLACK)
    assert len(found) == 4


@pytest.mark.parametrize("given", [None, 3, "upright", object(), type("Half", (), {"distance": lambda self, p: 0})()])
def test_what_is_no_constraint_is_refused(given):
    with pytest.raises(InputError, match=r"constraint: .* has no .*project; expected"):
        compiled_constraint(given)
