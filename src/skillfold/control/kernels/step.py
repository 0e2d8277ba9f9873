"""One step of the controller in three calls: `sort` the sample, `find_foot` of one that is used, `answer` it.

`t` is a table (see `tables`). What a step remembers lies in it too: one table per controller. They are three because
each function that contains another compiles it once more, and what finds the foot is large.
"""

import math

import numpy as np

from skillfold.control.kernels.law import across, bound, eased, feedback, restrain
from skillfold.control.kernels.reference import evaluate
from skillfold.jit import function_at, njit
from skillfold.manifold.kernels.newton import descend
from skillfold.manifold.kernels.projection import gap
from skillfold.manifold.kernels.scratch import evaluate as evaluate_surface
from skillfold.manifold.kernels.scratch import make_scratch
from skillfold.manifold.kernels.small import copy
from skillfold.manifold.kernels.tabled import KEPT, SCALE, encode
from skillfold.tables import Indices, address, indices, matrix, reals_at, vector

# The first slots are those of a model (`tabled`).
NUMBERS = 17  # longest step of a projection; how far out and in how much doubt the surface is believed
KNOTS = 18  # (3 n, D) of the reference
Q, QD = 19, 20  # (D,) the sample
GOOD, LAST, SEEN = 21, 22, 41  # (D,) the last one that was used, the last of all, the last believed
REFERENCE = 23  # (3, D) position, velocity, acceleration that it asks for
FOOT = 24  # (D,) of the last usable sample
ACCELERATION, TORQUE = 25, 26  # (D,) the answer
GAINS = 27  # of `feedback`, then ω of a hold
VELOCITY, RISE, REACTION, LOWER, UPPER, EFFORT = range(28, 34)  # (D,) limits, all finite
TURNING = 34  # (D,) whether full turns change nothing
MEMORY = 35  # see below
FUNCTIONS = 36  # addresses of inverse dynamics and clearance; 0 is none
DYNAMICS, OBSTACLES = 37, 38  # their arguments
NOTHING = 39  # (0,)
WORK = 40  # (8, D)
BASIS = 42  # (d, E) tangents at the foot
EASE = 43  # (D,) acceleration of a reference that gives way
SLOTS = 44

# What is remembered.
PHASE, RATE, SLOPE, BRAKE = 0, 1, 2, 3  # of the reference: phase [s], its rate, how that changes, how fast it may
STEP, DURATION = 4, 5  # seconds
SCAN, SWEEP, BLOCKED, HORIZON, KEEP = 6, 7, 8, 9, 10  # knot next to look at; phases [s]; clearance that blocks
CLEARANCE, DISTANCE, DEVIATION = 11, 12, 13  # of the last usable sample
STRANGE, LEAP, FASTEST = 14, 15, 16  # samples refused in a row; what may lie between two; velocity of no robot
INTERVAL = 17  # seconds between the last two samples
CELLS = 18

PATIENCE = 20.0  # samples that agree with each other are believed after all
LOOKS = 3  # knots looked at in a step
TOLERANCE, STEPS = 1e-7, 8.0  # of the foot, inner; it was near the last one
SLACK = 1e-4  # squared inner distance by which a foot may be farther than the last one
YIELD = 10.0  # 1/s, at which a reference that gives way comes to the foot
LARGE = 1e9  # stands for no limit

USED, HELD, STILL = 0, 1, 2  # a sample is used; it is, to hold still; it is not usable

_row, _table = np.empty(0), np.empty(0, np.int64)
inverse_at = function_at(0.0, _row, _row, _row, _table, _row)
clearance_at = function_at(0.0, _row, _row, _table)


@njit
def usable(t: Indices, elapsed: float) -> bool:
    """Whether the sample can be where the robot is: finite, and near the last one that was believed.

    Samples that agree with each other long enough are believed though they are far off.
    """
    q, qd, seen, last = vector(t, Q), vector(t, QD), vector(t, SEEN), vector(t, LAST)
    reference, turning, memory = matrix(t, REFERENCE), vector(t, TURNING), vector(t, MEMORY)
    near, steady, total = True, True, 0.0
    for c in range(q.size):
        if turning[c] > 0.0:
            q[c] -= 2.0 * math.pi * np.round((q[c] - reference[0, c]) / (2.0 * math.pi))
        leap = memory[LEAP] + 2.0 * abs(qd[c]) * max(elapsed, memory[INTERVAL])
        near &= abs(q[c] - seen[c]) <= leap
        steady &= abs(q[c] - last[c]) <= leap
        total += abs(q[c]) if abs(qd[c]) < memory[FASTEST] else math.inf
    if not total < LARGE:
        memory[STRANGE] = 0.0
        return False
    memory[STRANGE] = memory[STRANGE] + 1.0 if steady and not near else 0.0
    believed = near or memory[STRANGE] > PATIENCE
    for c in range(q.size):
        last[c] = q[c]
        if believed:
            seen[c] = q[c]
    return believed


@njit
def advance(t: Indices, elapsed: float, target: float) -> None:
    """Bring the rate toward `target` without a jolt, the phase on by it, and evaluate the reference."""
    memory, reference = vector(t, MEMORY), matrix(t, REFERENCE)
    brake = memory[BRAKE]
    memory[SLOPE] += elapsed * brake * (brake * (target - memory[RATE]) - 2.0 * memory[SLOPE])
    memory[RATE] = min(max(memory[RATE] + elapsed * memory[SLOPE], 0.0), 1.0)
    memory[PHASE] += elapsed * memory[RATE]
    rows = matrix(t, KNOTS)
    knots = reals_at(address(t, KNOTS), (rows.shape[0] // 3, 3, rows.shape[1]))
    evaluate(knots, memory[STEP], memory[PHASE], reference)
    rate, slope = memory[RATE], memory[SLOPE]
    for c in range(rows.shape[1]):
        reference[2, c] = rate * rate * reference[2, c] + slope * reference[1, c]
        reference[1, c] *= rate


@njit
def give_way(t: Indices, elapsed: float) -> None:
    """Let the reference leave its path and come to rest at the foot: an arm that is pushed along is not pulled back.

    It starts from where and how fast it was, so nothing jumps.
    """
    reference, foot, velocity = matrix(t, REFERENCE), vector(t, FOOT), vector(t, VELOCITY)
    rise = reference[2]
    for c in range(foot.size):
        rise[c] = YIELD * (YIELD * (foot[c] - reference[0, c]) - 2.0 * reference[1, c])
    bound(rise, vector(t, EASE))
    for c in range(foot.size):
        before = reference[1, c]
        reference[1, c] = min(max(before + elapsed * rise[c], -velocity[c]), velocity[c])
        reference[0, c] += 0.5 * elapsed * (before + reference[1, c])


@njit
def find_foot(t: Indices) -> None:
    """Move the foot to that of the sample, found from where it is, and find the tangents there."""
    q, foot, basis = vector(t, Q), vector(t, FOOT), matrix(t, BASIS)
    numbers, kept, scale = vector(t, NUMBERS), matrix(t, KEPT), vector(t, SCALE)[0]
    scratch = make_scratch(t, 1)
    E, d = kept.shape[1], scratch.bases.shape[1]
    state, point = encode(t, q.reshape(1, q.size)), encode(t, foot.reshape(1, foot.size))
    first, before = point.copy(), gap(state[0], point[0])
    descend(numbers[1], numbers[2], numbers[0], state, point, TOLERANCE, STEPS, scratch)
    if not gap(state[0], point[0]) <= before + SLACK:  # far off, it may run away; the last foot is nearer
        copy(first[0], point[0])
        evaluate_surface(point, scratch)
    for c in range(q.size):
        foot[c] = q[c]
        for e in range(E):
            foot[c] += scale * kept[c, e] * (point[0, e] - state[0, e])
    for a in range(d):
        for e in range(E):
            basis[a, e] = scratch.bases[0, a, e]


@njit
def most_damping(t: Indices) -> float:
    """2ζω [1/s] with which a velocity dies until the next sample, which will take as long as the last."""
    interval = vector(t, MEMORY)[INTERVAL]
    return 1.0 / interval if interval > 0.0 else math.inf


@njit
def track(t: Indices) -> None:
    """Acceleration toward the reference along the manifold, and toward the foot off it."""
    q, qd, foot, reference = vector(t, Q), vector(t, QD), vector(t, FOOT), matrix(t, REFERENCE)
    memory, work, kept, out = vector(t, MEMORY), matrix(t, WORK), matrix(t, KEPT), vector(t, ACCELERATION)
    basis = matrix(t, BASIS)
    off, along, off_speed, along_speed, rest = work[0], work[1], work[2], work[3], work[4]
    for c in range(q.size):
        off[c], along[c] = q[c] - foot[c], foot[c] - reference[0, c]
        along_speed[c] = qd[c] - reference[1, c]
    inner = work[5][: kept.shape[1]]
    across(kept, basis, along, inner, rest)
    across(kept, basis, qd, inner, off_speed)
    distance, deviation = 0.0, 0.0
    for c in range(q.size):
        along[c] -= rest[c]
        distance += off[c] ** 2
        deviation += along[c] ** 2
    across(kept, basis, along_speed, inner, rest)
    for c in range(q.size):
        along_speed[c] -= rest[c]
    memory[DISTANCE], memory[DEVIATION] = math.sqrt(distance), math.sqrt(deviation)
    feedback(vector(t, GAINS), off, along, off_speed, along_speed, most_damping(t), out)
    bound(out, vector(t, REACTION))
    for c in range(q.size):
        out[c] += reference[2, c]


@njit
def look(t: Indices) -> None:
    """Clearance of the sample, and of a few knots ahead; the phase of the first that is blocked."""
    memory, nothing, arguments = vector(t, MEMORY), vector(t, NOTHING), indices(t, OBSTACLES)
    rows, clearance = matrix(t, KNOTS), clearance_at(indices(t, FUNCTIONS)[1])
    memory[CLEARANCE] = clearance(vector(t, GOOD), nothing, arguments)
    step, end = memory[STEP], min(memory[PHASE] + memory[HORIZON], memory[DURATION] + memory[STEP])
    first, k = int(memory[PHASE] / step) + 1, int(memory[SCAN])
    for _ in range(LOOKS):
        k = max(k, first)
        if k * step > end:
            memory[BLOCKED], memory[SWEEP] = memory[SWEEP], math.inf
            k = first
        if clearance(rows[3 * min(k, rows.shape[0] // 3 - 1)], nothing, arguments) < memory[KEEP]:
            memory[SWEEP] = min(memory[SWEEP], k * step)
            memory[BLOCKED] = min(memory[BLOCKED], k * step)
        k += 1
    memory[SCAN] = k


@njit
def respond(t: Indices) -> None:
    """Bound the acceleration, and answer it with a torque (D,) within its limits; NaN without dynamics."""
    q, qd, out, torque = vector(t, Q), vector(t, QD), vector(t, ACCELERATION), vector(t, TORQUE)
    effort, where = vector(t, EFFORT), indices(t, FUNCTIONS)[0]
    ends, reaction, interval = (vector(t, LOWER), vector(t, UPPER)), vector(t, REACTION), vector(t, MEMORY)[INTERVAL]
    restrain(q, qd, *ends, vector(t, VELOCITY), vector(t, RISE), reaction, interval, out)
    if where == 0:
        torque[:] = math.nan
        return
    inverse = inverse_at(where)
    inverse(q, qd, out, indices(t, DYNAMICS), torque)
    for c in range(q.size):
        torque[c] = min(max(torque[c], -effort[c]), effort[c])


@njit
def hold_still(t: Indices, known: bool) -> None:
    """Acceleration back to the last good state, damped; none where not even the state is known."""
    q, qd, good, out = vector(t, Q), vector(t, QD), vector(t, GOOD), vector(t, ACCELERATION)
    stiff = vector(t, GAINS)[6]
    pull, calm = eased(stiff * stiff, 2.0 * stiff, most_damping(t))
    for c in range(q.size):
        if not known:
            q[c], qd[c] = good[c], 0.0
        out[c] = -pull * (q[c] - good[c]) - calm * qd[c]
    bound(out, vector(t, RISE))


@njit
def sort(t: Indices, elapsed: float, hold: bool, given: bool) -> int:
    """What a sample is good for: USED, HELD or STILL.

    Args:
        t: table.
        elapsed: seconds since the last step.
        hold: whether to hold still whatever the sample.
        given: whether there is a sample at all.
    """
    q, good, foot, reference = vector(t, Q), vector(t, GOOD), vector(t, FOOT), matrix(t, REFERENCE)
    known = given and usable(t, elapsed)
    if hold or not known:
        return HELD if known else STILL
    moved = 0.0
    for c in range(q.size):
        moved = max(moved, abs(q[c] - good[c]))
        good[c] = q[c]
    if moved > vector(t, MEMORY)[LEAP]:  # taken elsewhere: the last foot says nothing
        for c in range(q.size):
            foot[c] = reference[0, c]
    return USED


@njit
def answer(t: Indices, elapsed: float, target: float, kind: int) -> None:
    """Answer a sample of that kind.

    The phase goes on at `target`, and stops while the arm is held still; below zero, the reference gives way. The
    answer lies in ACCELERATION and TORQUE.
    """
    if target < 0.0:
        give_way(t, elapsed)
    else:
        advance(t, elapsed, target if kind == USED else 0.0)
    if kind == USED:
        track(t)
    else:
        hold_still(t, kind == HELD)
    respond(t)
    if kind == USED and indices(t, FUNCTIONS)[1] != 0:
        look(t)
