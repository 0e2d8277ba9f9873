"""The step of the controller, part by part, against NumPy."""

import numpy as np
import pytest

import skillfold as sf
from control import twins
from skillfold.control.kernels import step

BALL = sf.Sphere(center=(0.9, 0.4, 0.0), radius=0.05)


@pytest.fixture
def controller(make, planar):
    return make(obstacles=planar.obstacles([BALL]))


@pytest.fixture
def arrays(controller):
    return controller._table.arrays


@pytest.fixture
def sample(controller, arrays, plan):
    """A state beside the path, the phase in its middle, everything up to date."""
    arrays[step.MEMORY][step.PHASE] = 0.4 * controller.reference.duration
    q = controller.reference.at(arrays[step.MEMORY][step.PHASE])[0] + [0.03, -0.02, 0.01]
    for slot in (step.Q, step.GOOD, step.LAST, step.SEEN):
        arrays[slot][:] = q
    arrays[step.QD][:] = [0.3, -0.2, 0.1]
    step.advance(controller._entries, 0.0, 1.0)
    arrays[step.FOOT][:] = arrays[step.REFERENCE][0]
    return q


def test_usable(controller, arrays, sample):
    t, q, qd = controller._entries, arrays[step.Q], arrays[step.QD]
    assert step.usable(t, 0.001)
    for bad in (np.nan, np.inf, -np.inf, 1e300, sample[0] + 3.0):
        q[0] = bad
        assert not step.usable(t, 0.001)
    q[0] = sample[0]
    for bad in (np.nan, np.inf, 1e6):
        qd[1] = bad
        assert not step.usable(t, 0.001)
    qd[1] = 0.0
    assert step.usable(t, 0.001)


def test_usable_believes_samples_that_agree(controller, arrays, sample):
    arrays[step.Q][:] = sample + 1.0
    answers = [step.usable(controller._entries, 0.001) for _ in range(30)]
    assert answers == sorted(answers) and not answers[10] and answers[-1]


def test_usable_takes_off_full_turns(controller, arrays, sample):
    arrays[step.TURNING][1] = 1.0
    arrays[step.Q][1] = sample[1] - 4 * np.pi
    assert step.usable(controller._entries, 0.001)
    assert np.allclose(arrays[step.Q], sample)


def test_advance(controller, arrays):
    memory, t = arrays[step.MEMORY], controller._entries
    phase, rate, slope, brake = 0.0, 1.0, 0.0, memory[step.BRAKE]
    for target in [1.0] * 50 + [0.0] * 150 + [0.6] * 100:
        step.advance(t, 0.002, target)
        slope += 0.002 * (brake**2 * (target - rate) - 2 * brake * slope)
        rate = np.clip(rate + 0.002 * slope, 0, 1)
        phase += 0.002 * rate
        x, v, a = controller.reference.at(phase)
        assert np.allclose(memory[[step.PHASE, step.RATE, step.SLOPE]], [phase, rate, slope])
        assert np.allclose(arrays[step.REFERENCE], [x, rate * v, rate**2 * a + slope * v])


def test_give_way(controller, arrays, sample, planar):
    t, reference = controller._entries, arrays[step.REFERENCE]
    arrays[step.FOOT][:] = sample + 0.05
    x, v = reference[0].copy(), reference[1].copy()
    for _ in range(1500):
        step.give_way(t, 0.001)
        rise = twins.bound(10 * (10 * (sample + 0.05 - x) - 2 * v), planar.acceleration_limits)
        after = np.clip(v + 0.001 * rise, -planar.velocity_limits, planar.velocity_limits)
        x, v = x + 0.0005 * (v + after), after
        assert np.allclose(reference, [x, v, rise])
    assert np.allclose(reference[0], sample + 0.05, atol=1e-3)


def test_find_foot(controller, arrays, sample, skill):
    step.find_foot(controller._entries)
    foot, basis = arrays[step.FOOT], arrays[step.BASIS]
    assert np.allclose(foot, skill.project(sample, near=sample), atol=1e-6)
    tangents, kept = skill.tangent(foot), skill.model.kept
    off = np.eye(3) - tangents @ tangents.T
    assert np.allclose(twins.tangent_projector(kept, basis), off, atol=1e-5)


def test_a_foot_does_not_run_away(controller, arrays, sample, skill):
    for away in ([2.0, -3.0, 4.0], [-5.0, 5.0, 1.0], [0.0, 9.0, 0.0]):
        before = arrays[step.FOOT].copy()
        arrays[step.Q][:] = sample + away
        step.find_foot(controller._entries)
        foot, q = arrays[step.FOOT], arrays[step.Q]
        assert np.linalg.norm(foot - q) <= np.linalg.norm(before - q) + 0.02
        assert skill.inside(foot) < 6.0


@pytest.mark.parametrize("elapsed", [0.001, 0.04])
def test_track(controller, arrays, sample, skill, elapsed):
    step.find_foot(controller._entries)
    arrays[step.MEMORY][step.INTERVAL] = elapsed
    step.track(controller._entries)
    foot, (x, v, a) = skill.project(sample, near=sample), arrays[step.REFERENCE]
    tangents = skill.tangent(foot)
    off = np.eye(3) - tangents @ tangents.T
    along, rest = foot - x, arrays[step.QD] - v
    speeds = off @ arrays[step.QD], rest - off @ rest
    wanted = twins.feedback(arrays[step.GAINS], sample - foot, along - off @ along, *speeds, 1.0 / elapsed)
    assert np.allclose(arrays[step.ACCELERATION], twins.bound(wanted, arrays[step.REACTION]) + a, atol=1e-3)
    memory = arrays[step.MEMORY]
    assert memory[step.DISTANCE] == pytest.approx(np.linalg.norm(sample - foot), abs=1e-6)
    assert memory[step.DEVIATION] == pytest.approx(np.linalg.norm(along - off @ along), abs=1e-6)


def test_look(controller, arrays, sample, planar):
    obstacles, memory = planar.obstacles([BALL]), arrays[step.MEMORY]
    path = controller.reference.knots[:, 0]
    clearances = obstacles.clearance(path)
    first = int(memory[step.PHASE] / controller.reference.step) + 1
    last = int(controller.reference.duration / controller.reference.step) + 1
    ahead = clearances[first : last + 1]
    memory[step.KEEP] = np.sort(ahead)[len(ahead) // 2]
    for _ in range(len(ahead)):
        step.look(controller._entries)
    wanted = (first + int(np.argmax(ahead < memory[step.KEEP]))) * controller.reference.step
    assert memory[step.BLOCKED] == pytest.approx(wanted)
    assert memory[step.CLEARANCE] == pytest.approx(obstacles.clearance(sample))
    memory[step.KEEP] = -1.0
    for _ in range(2 * len(ahead)):
        step.look(controller._entries)
    assert memory[step.BLOCKED] == np.inf


def test_respond(controller, arrays, sample, planar):
    arrays[step.ACCELERATION][:] = wanted = np.array([3.0, -4.0, 50.0])
    arrays[step.MEMORY][step.INTERVAL] = 0.001
    step.respond(controller._entries)
    limits = (arrays[slot] for slot in (step.LOWER, step.UPPER, step.VELOCITY, step.RISE, step.REACTION))
    bounded = twins.restrain(sample, arrays[step.QD], *limits, 0.001, wanted)
    torque = planar.dynamics().torque(sample, arrays[step.QD], bounded)
    assert np.allclose(arrays[step.ACCELERATION], bounded)
    assert np.allclose(arrays[step.TORQUE], np.clip(torque, -planar.torque_limits, planar.torque_limits))


def test_most_damping(controller, arrays):
    for interval, wanted in ((0.0, np.inf), (0.02, 50.0)):
        arrays[step.MEMORY][step.INTERVAL] = interval
        assert step.most_damping(controller._entries) == pytest.approx(wanted)


@pytest.mark.parametrize("interval", [0.001, 0.2])
def test_hold_still(controller, arrays, sample, interval):
    t, gain = controller._entries, arrays[step.GAINS][6]
    arrays[step.GOOD][:] = sample - 0.01
    arrays[step.MEMORY][step.INTERVAL] = interval
    step.hold_still(t, True)
    pull, calm = twins.eased(gain**2, 2 * gain, 1 / interval)
    wanted = -pull * 0.01 - calm * arrays[step.QD]
    assert np.allclose(arrays[step.ACCELERATION], twins.bound(wanted, arrays[step.RISE]))
    step.hold_still(t, False)
    assert np.array_equal(arrays[step.Q], arrays[step.GOOD]) and not arrays[step.ACCELERATION].any()


def test_sort(controller, arrays, sample):
    t = controller._entries
    arrays[step.GOOD][:] = sample + 0.1
    assert step.sort(t, 0.001, False, True) == step.USED
    assert np.array_equal(arrays[step.GOOD], sample)
    assert step.sort(t, 0.001, True, True) == step.HELD
    assert step.sort(t, 0.001, False, False) == step.STILL
    arrays[step.Q][0] = np.nan
    assert step.sort(t, 0.001, False, True) == step.STILL
    assert np.array_equal(arrays[step.GOOD], sample)


def test_sort_looks_for_the_foot_from_the_reference_after_a_leap(controller, arrays, sample):
    arrays[step.GOOD][:] = sample + 1.0
    assert step.sort(controller._entries, 0.001, False, True) == step.USED
    assert np.array_equal(arrays[step.FOOT], arrays[step.REFERENCE][0])


@pytest.mark.parametrize("target", [0.7, -1.0])
@pytest.mark.parametrize("kind", [step.USED, step.HELD, step.STILL])
def test_answer(controller, arrays, sample, kind, target):
    """As its parts one after the other, but for rounding: together they are optimised as one."""
    t, kept = controller._entries, [slot for slot, array in arrays.items() if array.dtype == float]
    before = {slot: arrays[slot].copy() for slot in kept}
    step.find_foot(t)
    step.answer(t, 0.002, target, kind)
    after = {slot: arrays[slot].copy() for slot in kept}
    for slot in kept:
        arrays[slot][...] = before[slot]
    step.find_foot(t)
    if target < 0:
        step.give_way(t, 0.002)
    else:
        step.advance(t, 0.002, target if kind == step.USED else 0.0)
    if kind == step.USED:
        step.track(t)
    else:
        step.hold_still(t, kind == step.HELD)
    step.respond(t)
    if kind == step.USED:
        step.look(t)
    for slot in kept:
        np.testing.assert_allclose(arrays[slot], after[slot], rtol=1e-11, atol=1e-12)
    assert np.isfinite(arrays[step.TORQUE]).all()
