"""`KeyframeSkill`: what `fit` learns from a few keyframes, and every question a user may ask of it."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from os import PathLike
from typing import TYPE_CHECKING, Any
from warnings import warn

import numpy as np

from skillfold import archive
from skillfold.errors import InputError
from skillfold.keyframes.clusters import assigned, cluster
from skillfold.keyframes.envelope import HALF_TURN, INTERPOLATIONS, SoftEnvelope
from skillfold.keyframes.estimation import COVERAGE, FEWEST, estimate, read_coverage
from skillfold.keyframes.gaussians import PoseGaussian
from skillfold.keyframes.phase import Phase, phase_of
from skillfold.keyframes.recorded import read_keyframes
from skillfold.keyframes.storage import pack, unpack
from skillfold.recordings import shortened

if TYPE_CHECKING:
    from skillfold.motion import Plan
    from skillfold.robots.robot import Robot

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

SEEDS = 2**32 - 1
FAR = 30.0  # metres from the origin: no robot that stands there reaches as far


@dataclass(frozen=True, eq=False, repr=False)
class KeyframeSkill:
    """A skill of a few keyframes, ready to answer; made by `fit` or `load`.

    Attributes:
        gaussians: of the keyframes, in order.
        keyframes: by demonstration, (m, 7) poses it was learnt from.
        labels: by demonstration, (m,) the Gaussian of each keyframe, −1 for those that belong to none.
        names: of the demonstrations.
        coverage: how often a further keyframe falls within a block's gate.
        interpolation: of covariances in envelopes.
        selection: (number of Gaussians, logarithm of the evidence) of each number that fit tried.
        notes: what a user should know about the data; `fit` warns of it too.
    """

    gaussians: tuple[PoseGaussian, ...]
    keyframes: tuple[Array, ...]
    labels: tuple[Indices, ...]
    names: tuple[str, ...]
    coverage: float = COVERAGE
    interpolation: str = "linear"
    selection: tuple[tuple[int, float], ...] = ()
    notes: tuple[str, ...] = ()

    @classmethod
    def fit(
        cls,
        keyframes: Any,
        n_keyframes: int | None = None,
        coverage: float = COVERAGE,
        interpolation: str = "linear",
        seed: int = 0,
        *,
        extract: bool = False,
        gripper: str | None = None,
    ) -> "KeyframeSkill":
        """Learn the ordered Gaussians of a skill (section II-A).

        Keyframes that a demonstration leaves out, and extra ones that belong to no Gaussian, are allowed.

        Args:
            keyframes: poses x, y, z [m], qw, qx, qy, qz: a list of arrays (m, 7), one for each demonstration, in
                order; an array (n_demos, m, 7); `Demonstrations` with those coordinates; or a file or folder of
                them, as `Demonstrations.load` reads it.
            n_keyframes: number of Gaussians; left out, that of the highest evidence.
            coverage: share of further keyframes that the gates hold, in each block; 0.5 to 0.999.
            interpolation: of covariances between Gaussians, "linear" or "bures".
            seed: of k-means; the same seed gives the same bits.
            extract: take keyframes from full recordings: at rests, sharp turns and both ends.
            gripper: take them where this column of full recordings says that the gripper opens or closes.

        Raises:
            InputError: says what was given and what was expected.
        """
        demos, names = read_keyframes(keyframes, extract, gripper)
        return _learnt(demos, names, n_keyframes, coverage, interpolation, seed)

    def refined(
        self,
        keyframes: Any,
        n_keyframes: int | None = None,
        seed: int = 0,
        *,
        extract: bool = False,
        gripper: str | None = None,
    ) -> "KeyframeSkill":
        """The skill learnt from its own keyframes and those of further demonstrations, as `fit` takes them.

        Arguments and errors as in `fit`; coverage and interpolation are its own.
        """
        more, names = read_keyframes(keyframes, extract, gripper)
        names = tuple(_another(name, self.names) for name in names)
        demos = self.keyframes + more
        return _learnt(demos, self.names + names, n_keyframes, self.coverage, self.interpolation, seed)

    def __repr__(self) -> str:
        counts = [int(gaussian.count) for gaussian in self.gaussians]
        spread = [np.sqrt(np.trace(g.covariance[b : b + 3, b : b + 3]) / 3) for b in (0, 3) for g in self.gaussians]
        metres, radians = np.split(np.array(spread), 2)
        return (
            f"KeyframeSkill({len(self.gaussians)} Gaussians of {_span(counts)} keyframes, {len(self.keyframes)} "
            f"demonstrations, {self.extras} extra keyframes, gates hold {100 * self.coverage:g} %, spread "
            f"{_span(metres)} m and {_span(radians)} rad)"
        )

    @property
    def n_keyframes(self) -> int:
        """K, the number of Gaussians."""
        return len(self.gaussians)

    @property
    def extras(self) -> int:
        """How many keyframes belong to no Gaussian."""
        return sum(int((labels < 0).sum()) for labels in self.labels)

    @cached_property
    def envelopes(self) -> tuple[SoftEnvelope, ...]:
        """The soft-envelopes between consecutive Gaussians, not reduced (section II-B.2).

        Raises:
            InputError: rotations half a turn apart.
        """
        return tuple(SoftEnvelope.between(a, b, self.interpolation) for a, b in pairwise(self.gaussians))

    def envelope(self, i: int, alpha: float = 100.0) -> SoftEnvelope:
        """The soft-envelope from Gaussian i to i + 1, reduced to `alpha` percent (section II-B.3).

        Raises:
            InputError: no such pair, or its rotations are half a turn apart.
        """
        if isinstance(i, bool) or not isinstance(i, int | np.integer) or not 0 <= i < len(self.gaussians) - 1:
            raise InputError(f"envelope {shortened(i)}: there are {len(self.gaussians) - 1}, counted from 0.")
        return self.envelopes[i].reduced(alpha)

    def phase(self, pose: Any, start_at: int | None = None) -> Phase:
        """Which pair of Gaussians a motion from a pose (7,) of the tool begins with; see `phase_of`.

        Raises:
            InputError: no pose, no such pair, or none at all.
        """
        return phase_of(self.gaussians, self.envelopes, pose, start_at)

    def assign(self, keyframes: Any) -> Indices:
        """The Gaussian of each keyframe (m,) of a further demonstration (m, 7), in order; −1 for none."""
        (demo,), _ = read_keyframes([keyframes])
        return assigned(self.keyframes, self.labels, demo, len(self.gaussians))

    def plan(
        self,
        robot: "Robot",
        q_start: Any = None,
        scene: Any = None,
        alpha: float = 100.0,
        time_limit: float = 1.0,
        stop: str = "first",
        seed: int = 0,
        variant: str = "mended",
        *,
        start_at: int | None = None,
        until: int | None = None,
    ) -> "Plan":
        """A path of the robot's joints through the envelopes, clear of obstacles (section II-C).

        Args:
            robot: whose tool moves; what it holds counts.
            q_start: joint positions (dof,); None is the robot's home.
            scene: a `Scene`, a list of shapes, or `robot.obstacles(...)` made before.
            alpha: percent of the variance that a reduced envelope keeps; 100 is the full envelope.
            time_limit: seconds.
            stop: "first" ends with the first path; "time" makes it shorter until the time is up.
            seed: same seed, same path, unless a try runs out of time (the first has .3 of it) or `stop` is "time".
            variant: "mended", or "paper" for algorithms 3 to 5 as printed.
            start_at: the pair to start with; None tells it from the start's pose.
            until: the Gaussian to end at; None is the last.

        Raises:
            InputError: says what was given and what was expected. What cannot be planned is no error but a plan
                without success; see `skillfold.keyframes.planning.plan_skill`.
        """
        from skillfold.keyframes.planning import plan_skill

        asked = (q_start, scene, alpha, time_limit, stop, seed, variant)
        return plan_skill(self, robot, *asked, start_at=start_at, until=until)

    def replan(self, plan: "Plan", robot: "Robot", scene: Any, q: Any = None, **options: Any) -> "Plan":
        """The plan from joint positions q on, after obstacles moved: what is left of it if clear, else afresh.

        Arguments and `stats` as of `skillfold.keyframes.replanning.replan_skill`; `options` are those of `plan`.
        """
        from skillfold.keyframes.replanning import replan_skill

        return replan_skill(self, plan, robot, scene, q, **options)

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything to one sealed NPZ file, arrays and a JSON header; the same skill gives the same bytes.

        Raises:
            SkillFileError: the file cannot be written.
        """
        archive.write(path, *pack(self))

    @staticmethod
    def load(path: str | PathLike[str]) -> "KeyframeSkill":
        """Read a saved skill; every array is checked and nothing in the file is run.

        Raises:
            SkillFileError: the file is damaged, of another format, or no skill of keyframes.
        """
        return KeyframeSkill(**unpack(path))


def _learnt(
    demos: tuple[Array, ...],
    names: tuple[str, ...],
    n_keyframes: int | None,
    coverage: float,
    interpolation: str,
    seed: int,
) -> KeyframeSkill:
    coverage = read_coverage(coverage)
    if not isinstance(interpolation, str) or interpolation not in INTERPOLATIONS:
        raise InputError(f"interpolation={shortened(interpolation)}; possible: {', '.join(INTERPOLATIONS)}.")
    _whole("seed", seed, 0, SEEDS)
    if len(demos) < 2:
        raise InputError("keyframes: one demonstration; expected two at least, for how they differ is the skill.")
    if n_keyframes is not None:
        _whole("n_keyframes", n_keyframes, 1, max(map(len, demos)))
    found = cluster(demos, n_keyframes, seed)
    groups = [
        np.concatenate([demo[labels == k] for demo, labels in zip(demos, found.labels, strict=True)])
        for k in range(found.chosen)
    ]
    if not all(map(len, groups)):
        filled = sum(1 for group in groups if len(group))
        raise InputError(f"n_keyframes={n_keyframes}: the keyframes lie in {filled} places; expected no more.")
    gaussians = tuple(estimate(group, coverage) for group in groups)
    notes = (*_few(gaussians), *_far(gaussians), *_half_turns(gaussians))
    for note in notes:
        warn(note, stacklevel=3)
    return KeyframeSkill(gaussians, demos, found.labels, names, coverage, interpolation, found.table, notes)


def _few(gaussians: tuple[PoseGaussian, ...]) -> list[str]:
    return [
        f"Gaussian {i} was learnt from {int(g.count)} keyframes: its gates are those of {FEWEST}, and hold less than "
        "they promise."
        for i, g in enumerate(gaussians)
        if g.count < FEWEST
    ]


def _far(gaussians: tuple[PoseGaussian, ...]) -> list[str]:
    """Keyframes in millimetres, most likely."""
    away = max(float(np.linalg.norm(g.mean[:3])) for g in gaussians)
    return [] if away < FAR else [f"Keyframes lie up to {away:.3g} m from the origin; positions are in metres."]


def _half_turns(gaussians: tuple[PoseGaussian, ...]) -> list[str]:
    limit = np.cos(0.5 * HALF_TURN)
    return [
        f"Gaussians {i} and {i + 1} are about half a turn apart, which leaves open which way to turn: no envelope."
        for i, (a, b) in enumerate(pairwise(gaussians))
        if abs(float(a.mean[3:] @ b.mean[3:])) < limit
    ]


def _another(name: str, taken: tuple[str, ...]) -> str:
    """The name, or where it is taken, with the first number that makes it another."""
    candidates = (name if i == 0 else f"{name}+{i}" for i in range(len(taken) + 1))
    return next(candidate for candidate in candidates if candidate not in taken)


def _whole(name: str, value: Any, low: int, high: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not low <= value <= high:
        raise InputError(f"{name}={shortened(value)}; expected a whole number from {low} to {high}.")


def _span(values: Any) -> str:
    low, high = min(values), max(values)
    return f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g}–{high:.3g}"
