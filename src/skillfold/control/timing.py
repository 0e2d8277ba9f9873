"""Paths in time: the shortest smooth motion along a path that keeps limits of velocity and acceleration."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from skillfold.control.kernels.reference import evaluate, overrun
from skillfold.errors import InputError
from skillfold.manifold.inputs import amount, read_numbers
from skillfold.motion import Array, Path, Trajectory

STEP = 0.02  # seconds between knots
MARGIN = 0.95  # share of the limits that is used
SPEED, RISE = 1.0, 4.0  # limits of coordinates without any, in units per s and s²
GRID = 400  # places along the path at which the limits are looked at
EASING = 0.2  # seconds over which changes of acceleration are spread
TAIL = 2.0  # seconds of rest that are kept after the end, for what is spliced to a short path
SLOWER = 10  # times that a law is slowed at most where its motion breaks limits between knots
SEEN = 0.998  # share of the limits that it may be seen to take there: in between it takes a little more
SHORTEST, LONGEST = 1e-3, 1e4  # seconds of a motion: longer is a slip of units, and would not fit into memory
STILL = 1e-9  # a path no longer than this stays where it is

Spline = Callable[..., Array]


@dataclass(frozen=True)
class Reference:
    """A motion in time, for compiled loops and for people.

    Attributes:
        knots: (n, 3, D) positions, velocities and accelerations at even times from 0 on, at rest from `duration` on.
        step: seconds between them.
        duration: of the motion [s].
        names: of the coordinates, or empty.
        pace: share of the speed that limits allow: below 1 where a longer duration was asked for.
    """

    knots: Array
    step: float
    duration: float
    names: tuple[str, ...] = ()
    pace: float = 1.0

    def at(self, time: float) -> Array:
        """Position, velocity and acceleration (3, D) at a time [s]."""
        out = np.empty(self.knots.shape[1:])
        evaluate(self.knots, self.step, float(time), out)
        return out

    def trajectory(self, rate: float = 100.0) -> Trajectory:
        """Timed states, `rate` a second and the last one at the end."""
        times = np.linspace(0.0, self.duration, max(2, int(np.ceil(self.duration * rate)) + 1))
        return Trajectory(times, np.array([self.at(time)[0] for time in times]), self.names)


def time_path(
    path: Path | Array,
    velocity: Any = None,
    acceleration: Any = None,
    duration: float | None = None,
    speed: float = 0.0,
    margin: float = MARGIN,
) -> Reference:
    """A smooth motion along a path that ends at rest: a spline through its states by arc length, and a law of time.

    Args:
        path: states (n, D), one at least.
        velocity, acceleration: limits (D,) per s and s²; where missing or infinite, 1 and 4.
        duration: seconds it shall take; left out, about the shortest.
        speed: at the start, along the path [1/s], or the nearest that the limits allow.
        margin: share of the limits that is used.

    Raises:
        InputError: no states, limits that are not positive, a duration too short for them.
    """
    states = read_numbers(path.states if isinstance(path, Path) else path, "path", "(n, D)")
    names = path.names if isinstance(path, Path) else ()
    if states.ndim != 2 or not states.size or not np.isfinite(states).all():
        raise InputError(f"path of shape {states.shape}; expected finite states (n, D).")
    margin, speed = amount("margin", margin, 1.0), amount("speed", speed, zero=True)
    v = margin * _limit(velocity, states.shape[1], SPEED, "velocity")
    a = margin * _limit(acceleration, states.shape[1], RISE, "acceleration")
    curve, length = _curve(states)
    if length <= STILL:
        return _resting(states[-1], 0.0 if duration is None else _seconds(duration), names)
    times, place = _law(curve, length, v, a, speed)
    shortest, reference = _slowed(curve, times, place, v, a, margin, names)
    if duration is None:
        return reference
    stretch = _seconds(duration) / times[-1]
    if stretch < shortest * (1 - 1e-6):
        raise InputError(
            f"duration {duration:g} s; the limits of velocity and acceleration need {shortest * times[-1]:.3g} s."
        )
    return replace(_baked(curve, times * stretch, place, names), pace=min(shortest / stretch, 1.0))


def follow(trajectory: Trajectory) -> Reference:
    """A timed motion as a reference, smooth between its states; it ends at rest.

    Raises:
        InputError: no trajectory, fewer than six states, a duration that no motion has.
    """
    if not isinstance(trajectory, Trajectory):
        raise InputError(f"follow: {type(trajectory).__name__}; expected a Trajectory.")
    times, states = trajectory.times - trajectory.times[0], trajectory.states
    if len(times) < 6:
        raise InputError(f"trajectory of {len(times)} states; expected six or more.")
    duration = float(times[-1])
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(f"trajectory of {duration:g} s; expected {SHORTEST:g} to {LONGEST:g} s.")
    curve = make_interp_spline(times, states, k=5)
    moments = np.linspace(0.0, duration, max(int(np.ceil(duration / STEP)), 4) + 1)
    knots = np.stack([curve(moments), curve(moments, 1), curve(moments, 2)], axis=1)
    return _with_rest(knots, float(moments[1]), duration, trajectory.names)


def _limit(values: Any, n_dims: int, missing: float, name: str) -> Array:
    given = np.full(n_dims, np.inf) if values is None else read_numbers(values, f"{name} limits", f"({n_dims},)")
    if given.shape != (n_dims,) or not (given > 0).all():
        raise InputError(f"{name} limits {values}; expected {n_dims} positive numbers.")
    return np.where(np.isfinite(given), given, missing)


def _seconds(duration: Any) -> float:
    if not (isinstance(duration, int | float | np.number) and 0 < duration <= LONGEST):
        raise InputError(f"duration {duration!r}; expected seconds, above zero and {LONGEST:g} at most.")
    return float(duration)


def _curve(states: Array) -> tuple[Spline, float]:
    """Spline through the states by the distance along them, and the whole distance."""
    steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
    keep = np.concatenate([[True], steps > 1e-6 * max(steps.sum(), STILL)])
    kept = states[keep]
    kept[-1] = states[-1]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(kept, axis=0), axis=1))])
    if along[-1] <= STILL:
        return lambda s, nu=0: np.zeros((len(s), states.shape[1])), 0.0
    if len(kept) < 4:  # too few for a cubic
        even = np.linspace(0.0, along[-1], 7)
        kept = np.column_stack([np.interp(even, along, column) for column in kept.T])
        along = even
    return make_interp_spline(along, kept, k=3), float(along[-1])


def _law(curve: Spline, length: float, v: Array, a: Array, speed: float) -> tuple[Array, Array]:
    """Times, and places along the path at them; even times.

    As fast as the limits let it along the path, then speeds averaged over a moment: acceleration is continuous and
    starts and ends at zero. The average begins with a piece at the first speed, so that much of the way is left out.
    """
    peak = float((v / np.maximum(np.abs(curve(np.linspace(0, length, GRID), 1)), 1e-12)).min(1).max())
    ease = min(EASING, 0.5 * length / peak)
    s = np.linspace(0.0, length, GRID)
    u = _fastest(s, curve(s, 1), curve(s, 2), v, a, speed)
    if u[0] > 0:
        s = np.linspace(0.5 * ease * u[0], length, GRID)
        u = _fastest(s, curve(s, 1), curve(s, 2), v, a, u[0])
    moments = np.concatenate([[0.0], np.cumsum(2 * np.diff(s) / np.maximum(u[1:] + u[:-1], 1e-9))])
    if not moments[-1] <= LONGEST:
        raise InputError(
            f"path of length {length:.3g}: within the limits of velocity and acceleration it takes "
            f"{moments[-1]:.3g} s; expected {LONGEST:g} at most. Are the units right?"
        )
    tick = min(0.2 * STEP, moments[-1] / GRID)
    window = np.hanning(max(round(ease / tick), 2) + 2)[1:-1]
    ticks = np.arange(int(np.ceil(moments[-1] / tick)) + 2) * tick
    speeds = np.concatenate([np.full(len(window), u[0]), np.interp(ticks, moments, u), np.zeros(len(window))])
    smooth = np.convolve(speeds, window / window.sum(), "valid")
    smooth[0], smooth[-1] = u[0], 0.0
    place = np.concatenate([[0.0], np.cumsum(0.5 * tick * (smooth[1:] + smooth[:-1]))])
    times = np.asarray(np.arange(len(place)) * tick, np.float64)
    return times, np.asarray(place * (length / place[-1]), np.float64)


def _fastest(s: Array, slope: Array, bend: Array, v: Array, a: Array, speed: float) -> Array:
    """Speeds along the path (n,): limits at each place, braking seen from the end, speeding up from the start."""
    slope_size = np.maximum(np.abs(slope), 1e-12)
    top = (v / slope_size).min(1)
    # A third of what there is for the bend leaves most of it for speeding up and braking.
    top = np.minimum(top, np.sqrt((0.35 * a / np.maximum(np.abs(bend), 1e-12)).min(1)))
    rise = ((a - np.abs(bend) * top[:, None] ** 2) / slope_size).min(1)
    square = top**2
    square[0], square[-1] = min(square[0], speed**2), 0.0
    steps = 2 * np.diff(s)
    for i in range(len(s) - 2, -1, -1):
        square[i] = min(square[i], square[i + 1] + steps[i] * rise[i])
    for i in range(len(s) - 1):
        square[i + 1] = min(square[i + 1], square[i] + steps[i] * rise[i])
    return np.sqrt(square)


def _slowed(
    curve: Spline, times: Array, place: Array, v: Array, a: Array, margin: float, names: tuple[str, ...]
) -> tuple[float, Reference]:
    """By how much the law is slowed to keep a share of the limits, and the motion, which keeps these everywhere.

    Between its knots it is not quite the law's: rarely, where accelerations change at once, that takes more time.
    """
    stretch = _stretch(curve, times, place, v, a)
    reference = _baked(curve, times * stretch, place, names)
    for _ in range(SLOWER):
        share = overrun(reference.knots, reference.step, v / margin, a / margin, np.empty((3, v.size)))
        if share <= SEEN:
            break
        stretch *= share / SEEN
        reference = _baked(curve, times * stretch, place, names)
    return stretch, reference


def _stretch(curve: Spline, times: Array, place: Array, v: Array, a: Array) -> float:
    """By how much the law must be slowed so that the motion keeps the limits everywhere; at most a little faster."""
    motion = _along(curve, times, place, times)
    fast = (np.abs(motion[:, 1]) / v).max()
    hard = np.sqrt((np.abs(motion[:, 2]) / a).max())
    return float(max(fast, hard, 1e-3))


def _along(curve: Spline, times: Array, place: Array, moments: Array) -> Array:
    """Knots (n, 3, D) of the motion at moments (n,)."""
    law = make_interp_spline(times, place, k=5, bc_type=_ends(times, place))
    s = np.clip(law(moments), 0.0, place[-1])
    u, rise = law(moments, 1)[:, None], law(moments, 2)[:, None]
    slope = curve(s, 1)
    return np.stack([curve(s), slope * u, curve(s, 2) * u**2 + slope * rise], axis=1)


def _ends(times: Array, place: Array) -> Any:
    """First and second derivatives of the law at both ends."""
    first = (place[1] - place[0]) / (times[1] - times[0])
    return [(1, first), (2, 0.0)], [(1, 0.0), (2, 0.0)]


def _baked(curve: Spline, times: Array, place: Array, names: tuple[str, ...]) -> Reference:
    """The motion at even knots, and its rest."""
    duration = float(times[-1])
    count = max(int(np.ceil(duration / STEP)), 4)
    moments = np.linspace(0.0, duration, count + 1)
    return _with_rest(_along(curve, times, place, moments), duration / count, duration, names)


def _with_rest(knots: Array, step: float, duration: float, names: tuple[str, ...]) -> Reference:
    """The knots of a motion, and its rest."""
    knots[-1, 1:] = 0.0
    tail = np.repeat(knots[-1:], int(np.ceil(TAIL / step)), axis=0)
    return Reference(np.ascontiguousarray(np.concatenate([knots, tail])), step, duration, names)


def _resting(state: Array, duration: float, names: tuple[str, ...]) -> Reference:
    """No motion at all."""
    knots = np.zeros((max(int(np.ceil((duration + TAIL) / STEP)), 2), 3, len(state)))
    knots[:, 0] = state
    return Reference(knots, STEP, duration, names)
