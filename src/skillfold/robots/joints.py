"""The joints of a compiled model: which of MuJoCo's positions q tells, their limits, which follow others."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from skillfold.errors import RobotError
from skillfold.robots import kinematics as kin
from skillfold.robots.engine import mujoco
from skillfold.robots.motors import torque_limits
from skillfold.robots.poses import HERE
from skillfold.spaces import StateSpace
from skillfold.tables import Array, Indices, Table, table_of

Flags = np.ndarray[Any, np.dtype[np.bool_]]

_FREE, _BALL = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL
_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE
WIDEST = 1e4  # radians or metres: limits farther apart are a way to write that there are none
_PLACES = (
    "body_pos",
    "body_quat",
    "body_mass",
    "body_inertia",
    "geom_pos",
    "geom_size",
    "jnt_pos",
    "qpos0",
    "key_qpos",
)


class Limits(NamedTuple):
    """Joint limits, infinite where there are none; `numpy.asarray` makes it (2, dof)."""

    lower: Array
    upper: Array


@dataclass(frozen=True)
class Joints:
    """What q (dof,) means to a model.

    Attributes:
        names: of the joints.
        numbers, addresses: (dof,) MuJoCo's number of each and its place in qpos.
        columns, offsets, ratios: (dof,) each joint stands at offset + ratio · q[column]; ratio 0 where it is held.
        slides: (dof,) whether it is prismatic.
        limits: of each.
        velocity, acceleration, torque: (dof,) largest values, infinite where unknown.
        base: place of the floating base's pose in qpos; None where the base is fixed.
        rest: (nq,) qpos of what q does not tell, the base at the origin.
        home: (dof,) positions of the home pose.
    """

    names: tuple[str, ...]
    numbers: Indices
    addresses: Indices
    columns: Indices
    offsets: Array
    ratios: Array
    slides: Flags
    limits: Limits
    velocity: Array
    acceleration: Array
    torque: Array
    base: int | None
    rest: Array
    home: Array

    @property
    def dof(self) -> int:
        """Number of joint positions."""
        return len(self.names)

    def space(self) -> StateSpace:
        """Coordinates of q: prismatic joints are lengths, hinges angles, continuous where they have no limits."""
        finite = np.isfinite(self.limits.lower) & np.isfinite(self.limits.upper)
        kinds = ["linear" if s else "angle" if f else "continuous" for s, f in zip(self.slides, finite, strict=True)]
        return StateSpace(tuple(kinds), tuple(self.limits.lower.tolist()), tuple(self.limits.upper.tolist()))


def read_joints(model: Any, source: str, speeds: dict[str, float]) -> Joints:
    """The joints of a robot's model.

    Raises:
        RobotError: no joints, ball joints, or a joint that follows another in no straight line.
    """
    kinds = model.jnt_type
    balls = [_name(model, i) for i in range(model.njnt) if kinds[i] == _BALL]
    if balls:
        raise RobotError(f"{source}: ball joints ({', '.join(balls)}); expected hinges, slides and one free base.")
    numbers = np.setdiff1d(np.flatnonzero(kinds != _FREE), loose_joints(model))
    if not len(numbers):
        raise RobotError(f"{source}: no joints that move; expected hinges or slides.")
    names = tuple(_name(model, i) for i in numbers)
    columns, offsets, ratios = _couplings(model, numbers, source)
    _check_finite(model, source)
    limited = model.jnt_limited[numbers].astype(bool) & (np.ptp(model.jnt_range[numbers], axis=1) < WIDEST)
    lower = np.where(limited, model.jnt_range[numbers, 0], -math.inf)
    upper = np.where(limited, model.jnt_range[numbers, 1], math.inf)
    addresses = model.jnt_qposadr[numbers].astype(np.int64)
    base = _base(model, numbers)
    start = _start(model)
    rest = start.copy()
    if base is not None:
        rest[base : base + 7] = HERE
    home = np.clip(start[addresses], lower, upper)
    home = np.clip(offsets + ratios * home[columns], lower, upper)
    velocity = _numeric(model, "velocity_limits", len(numbers), source)
    velocity = np.minimum(velocity, [speeds.get(name, math.inf) for name in names])
    return Joints(
        names,
        numbers,
        addresses,
        columns,
        offsets,
        ratios,
        kinds[numbers] == _SLIDE,
        Limits(lower, upper),
        velocity,
        _numeric(model, "acceleration_limits", len(numbers), source),
        torque_limits(model, numbers),
        base,
        rest,
        home,
    )


def machine_of(model: Any, joints: Joints, base: Array | None = None) -> Table:
    """Table for the compiled loops over poses, with a `MjData` of its own.

    Args:
        model: the robot's, or one that holds the robot first and more after it.
        joints: of the robot.
        base: (7,) pose of a floating base; None is the origin.
    """
    data = mujoco.MjData(model)
    return table_of(pose_slots(model, data, joints, base), kin.SLOTS, model, data)


def pose_slots(model: Any, data: Any, joints: Joints, base: Array | None) -> dict[int, Any]:
    """What the loops over poses need, by slot."""
    rest = np.concatenate([joints.rest, data.qpos[len(joints.rest) :]])
    if base is not None and joints.base is not None:
        rest[joints.base : joints.base + 7] = base
    return {
        kin.MODEL: np.array([model._address]),
        kin.DATA: np.array([data._address]),
        kin.QPOS: data.qpos,
        kin.REST: rest,
        kin.PLACES: joints.addresses,
        kin.COLUMNS: joints.columns,
        kin.OFFSETS: joints.offsets,
        kin.RATIOS: joints.ratios,
        kin.JOINTS: joints.numbers,
        kin.SLIDES: joints.slides,
        kin.MOVES: moves_of(model, joints),
        kin.XANCHOR: data.xanchor,
        kin.XAXIS: data.xaxis,
        kin.XPOS: data.xpos,
        kin.XQUAT: data.xquat,
        kin.XIPOS: data.xipos,
        kin.MASSES: np.where(robot_bodies(model, joints), model.body_mass, 0.0),
    }


def moves_of(model: Any, joints: Joints) -> Flags:
    """(n_bodies, dof) whether joint k moves the body; one that is held moves none."""
    moves = np.zeros((model.nbody, joints.dof), bool)
    column = {int(number): k for k, number in enumerate(joints.numbers) if joints.ratios[k] != 0.0}
    for body in range(1, model.nbody):
        moves[body] = moves[model.body_parentid[body]]
        first = model.body_jntadr[body]
        for number in range(first, first + model.body_jntnum[body]):
            if number in column:
                moves[body, column[number]] = True
    return moves


def loose_joints(model: Any) -> Indices:
    """Joints of things that lie about, such as the lid of a box: what carries them is free, and not the robot.

    Where something with joints stands fast, the robot does, else it is what has the most joints.
    """
    numbers = np.flatnonzero(model.jnt_type != _FREE)
    roots = model.body_rootid[model.jnt_bodyid[numbers]]
    first = model.body_jntadr[roots]
    free = (first >= 0) & (model.jnt_type[np.maximum(first, 0)] == _FREE)
    if free.all() and len(numbers):
        free = roots != np.bincount(roots).argmax()
    return numbers[free].astype(np.int64)


def loose_notes(model: Any) -> tuple[str, ...]:
    """What a user should know of them."""
    names = [_name(model, int(number)) for number in loose_joints(model)]
    return (f"Not joints of the robot, as what carries them is loose: {', '.join(names)}.",) if names else ()


def robot_bodies(model: Any, joints: Joints) -> Flags:
    """(n_bodies,) whether a body is of the robot: not loose, nor moved from outside."""
    mine = np.ones(model.nbody, bool)
    for body in range(1, model.nbody):
        number = model.body_jntadr[body]
        loose = number >= 0 and model.jnt_type[number] == _FREE and model.jnt_qposadr[number] != joints.base
        mine[body] = mine[model.body_parentid[body]] and not loose and model.body_mocapid[body] < 0
    return mine


def _check_finite(model: Any, source: str) -> None:
    """MuJoCo warns of numbers that are none, and takes them."""
    wrong = [name for name in _PLACES if not np.isfinite(getattr(model, name)).all()]
    wrong += ["jnt_range"] if np.isnan(model.jnt_range).any() else []
    if wrong:
        raise RobotError(f"{source}: numbers that are not finite ({', '.join(wrong)} of MuJoCo's model).")


def _name(model: Any, joint: int) -> str:
    return model.joint(int(joint)).name or f"joint_{joint}"


def _base(model: Any, numbers: Indices) -> int | None:
    """Place in qpos of the free joint that carries the first joint, if any does."""
    body = model.jnt_bodyid[numbers[0]]
    root = model.body_rootid[body]
    number = model.body_jntadr[root]
    return int(model.jnt_qposadr[number]) if number >= 0 and model.jnt_type[number] == _FREE else None


def _start(model: Any) -> Array:
    for key in range(model.nkey):
        if model.key(key).name == "home":
            return model.key_qpos[key].copy()
    return (model.key_qpos[0] if model.nkey else model.qpos0).copy()


def _couplings(model: Any, numbers: Indices, source: str) -> tuple[Indices, Array, Array]:
    columns, offsets = np.arange(len(numbers)), np.zeros(len(numbers))
    ratios = np.ones(len(numbers))
    place = {int(number): k for k, number in enumerate(numbers)}
    for i in range(model.neq):
        follower, leader = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        loose = follower not in place or (leader >= 0 and leader not in place)
        if model.eq_type[i] != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[i] or loose:
            continue
        constant, slope, *curved = model.eq_data[i, :5]
        k, zero = place[follower], model.qpos0[model.jnt_qposadr[[follower, leader]]]
        if leader < 0:  # held where it is
            columns[k], ratios[k], offsets[k] = k, 0.0, zero[0] + constant
            continue
        if any(curved):
            names = f"{_name(model, follower)} follows {_name(model, leader)}"
            raise RobotError(f"{source}: joint {names} along a curve; expected a straight line (polycoef a b 0 0 0).")
        # MuJoCo counts both from where they stand in qpos0.
        columns[k], ratios[k] = place[leader], slope
        offsets[k] = zero[0] + constant - slope * zero[1]
    return _resolved(columns, offsets, ratios, source, [_name(model, i) for i in numbers])


def _resolved(
    columns: Indices, offsets: Array, ratios: Array, source: str, names: list[str]
) -> tuple[Indices, Array, Array]:
    """Followers of followers follow the first leader, and are held where it is."""
    direct = columns
    for _ in names:
        lead = columns[columns]
        if (lead == columns).all() and (direct[columns] == columns).all():
            led = columns != np.arange(len(columns))
            return columns, offsets + np.where(led, ratios * offsets[columns], 0.0), ratios * ratios[columns]
        offsets = offsets + ratios * np.where(lead != columns, offsets[columns], 0.0)
        ratios = ratios * np.where(lead != columns, ratios[columns], 1.0)
        columns = lead
    raise RobotError(f"{source}: joints that follow each other in a circle; joints: {', '.join(names)}.")


def _numeric(model: Any, name: str, dof: int, source: str) -> Array:
    """Limits that a model keeps among its custom numbers."""
    for i in range(model.nnumeric):
        if model.numeric(i).name == name:
            values = np.array(model.numeric(i).data, float)
            if len(values) != dof or not (values > 0).all():
                raise RobotError(f"{source}: custom numeric {name}; expected {dof} positive numbers, one a joint.")
            return values
    return np.full(dof, math.inf)
