"""The route that whole demonstrations take between given ends, and through via points.

This goes beyond paper 000, which plans shortest paths on the manifold: people who show a motion take no
shortest path, and how they go depends on where they start and end. So the route is interpolated between
whole demonstrations at phases where they are alike (`route_phases`), each counting for more the more alike its own
ends are (`route_models`). Ends that lie part-way are first located on the demonstrations, which are then cut there
(`route_location`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from skillfold.errors import InputError, SkillFileError
from skillfold.manifold.route_location import Location, locate, locate_between, squared_spread
from skillfold.manifold.route_models import ALIKE, IntArray, RouteModel, choose, for_whole, predict
from skillfold.manifold.route_phases import at_phases, by_arc_length, registered
from skillfold.motion import Array

FEWEST_PHASES = 9


@dataclass(frozen=True)
class RouteAnswer:
    """A route between asked ends.

    Attributes:
        states: (points, D); the ends are the asked ones to the bit, and each via point is one of the rows.
        spread: (points,), standard deviation of the distance (over all coordinates, in state units) to the
            way a demonstration would take; 0 at the ends and via points.
        start_phase, goal_phase: where on the demonstrations the ends lie, in [0, 1] of their length; 0 and 1
            for a whole motion.
        reversed: the goal lies before the start, and the demonstrations are travelled backwards.
        supported: distance of the asked ends from the nearest demonstrated state at that phase, in units of
            the distance between neighbouring demonstrations: about 1 is usual, 3 far.
    """

    states: Array
    spread: Array
    start_phase: float
    goal_phase: float
    reversed: bool
    supported: float


@dataclass(frozen=True)
class Route:
    """Demonstrations read at common phases, and what was learnt from them.

    Attributes:
        curves: (n, n_phases, D), demonstrations read at common phases, centred, of unit rms radius.
        centre: (D,), in state units.
        scale: rms distance of the states from the centre, in state units.
        squared_spread: (n_phases,), between neighbouring curves.
        model: how a route depends on its ends.
    """

    curves: Array
    centre: Array
    scale: float
    squared_spread: Array
    model: RouteModel

    @staticmethod
    def fit(recordings: Sequence[Array], n_phases: int = 101) -> "Route | None":
        """Learn from whole demonstrations.

        Args:
            recordings: each (n_steps, D), of any length; angles unwrapped, quaternions sign-consistent.
            n_phases: at which they are read, 9 or more.

        Returns:
            None when there are fewer than two.
        """
        if n_phases < FEWEST_PHASES:
            raise InputError(f"n_phases: expected {FEWEST_PHASES} or more, got {n_phases}.")
        if len(recordings) < 2:
            return None
        centre = np.mean([np.mean(recording, axis=0) for recording in recordings], axis=0)
        raw = np.stack([by_arc_length(recording - centre, n_phases) for recording in recordings])
        scale = float(np.sqrt((raw**2).sum(axis=2).mean()))
        # What is left of one state repeated at a large offset is rounding, and no shape.
        if scale <= 1e-14 * np.abs(centre).max():
            raw, scale = np.zeros_like(raw), 1.0
        curves = raw / scale
        model = choose(curves)
        curves = registered(curves) if model in ALIKE else curves
        return Route(curves, centre, scale, squared_spread(curves), model)

    def between(self, start: Array, goal: Array, points: int = 50, via: Array | None = None) -> RouteAnswer:
        """The route from `start` to `goal`.

        Args:
            start, goal: (D,), anywhere; part-way on the demonstrations too.
            points: of the path, equally spaced in phase between given states.
            via: (m, D), states to pass through, in this order.

        Raises:
            InputError: where shapes do not fit, a number is not finite, or the points are too few.
        """
        exact = self._given(start, goal, via, points)
        asked = (exact - self.centre) / self.scale
        place = locate(self.curves, self.squared_spread, asked)
        ends_only = len(asked) == 2
        given = np.array([0.0, 1.0]) if ends_only else self._via_phases(place, asked)
        nodes = node_rows(given, points)
        shares = np.interp(np.arange(points), nodes, given)
        model = for_whole(self.model) if ends_only and place.whole else self.model
        route, errors = predict(model, self._cut(place, shares), nodes, asked)
        spread = np.sqrt((errors**2).sum(axis=2).mean(axis=0))
        states = route * self.scale + self.centre
        states[nodes] = exact
        first, last = (1.0 - place.phases if place.reversed else place.phases).tolist()
        return RouteAnswer(states, spread * self.scale, first, last, place.reversed, place.supported)

    def leg_by_leg(self, states: Array, counts: Sequence[int]) -> RouteAnswer:
        """Routes from each of the states (m, D) to the next, of so many states each, one after the other.

        They need not lie in the order of the demonstrations: some legs may go backwards. Phases are those of the
        first and the last state; `reversed` is whether all legs are.
        """
        legs = [self.between(a, b, n) for a, b, n in zip(states[:-1], states[1:], counts, strict=True)]
        first, *others = legs
        return RouteAnswer(
            np.vstack([first.states, *(leg.states[1:] for leg in others)]),
            np.concatenate([first.spread, *(leg.spread[1:] for leg in others)]),
            first.start_phase,
            legs[-1].goal_phase,
            all(leg.reversed for leg in legs),
            max(leg.supported for leg in legs),
        )

    def stretches(self, ends: Array) -> Array:
        """The demonstrations between ends (2, D), at equal shares of the stretch; as `curves`, and in its units."""
        place = locate(self.curves, self.squared_spread, ends)
        return self._cut(place, np.linspace(0.0, 1.0, self.curves.shape[1]))

    def _given(self, start: Array, goal: Array, via: Array | None, points: int) -> Array:
        """Start, via points and goal, checked: (m, D)."""
        n_dims = self.centre.size
        rows: list[tuple[str, Any]] = [("start", start)]
        rows += [(f"via[{i}]", state) for i, state in enumerate([] if via is None else via)]
        rows += [("goal", goal)]
        for name, state in rows:
            if np.shape(state) != (n_dims,) or not np.isfinite(state).all():
                raise InputError(f"{name}: expected {n_dims} finite numbers, got {state!r}.")
        most = min(points, self.curves.shape[1])
        if len(rows) > most:
            raise InputError(f"{len(rows)} given states, of which a path of {points} points can hold {most}.")
        return np.array([state for _, state in rows], dtype=np.float64)

    def _via_phases(self, place: Location, asked: Array) -> Array:
        """Where on the stretch between the ends the asked states lie: (m,), from 0 to 1."""
        last = self.curves.shape[1] - 1
        stretch = self._cut(place, np.linspace(0.0, 1.0, last + 1))
        route, errors = predict(self.model, stretch, np.array([0, last]), asked[[0, -1]])
        return locate_between(stretch, route, errors, asked)

    def _cut(self, place: Location, shares: Array) -> Array:
        """The demonstrations between the located ends, read at shares (points,) of that stretch."""
        curves = self.curves[:, ::-1] if place.reversed else self.curves
        first, last = place.own[:, :1], place.own[:, 1:]
        return at_phases(curves, first + shares * (last - first))

    def arrays(self) -> dict[str, Array]:
        """Everything as plain arrays, for an NPZ."""
        return {
            "curves": self.curves,
            "centre": self.centre,
            "scale": np.array(self.scale),
            "squared_spread": self.squared_spread,
            "model": np.array(astuple(self.model), dtype=np.float64),
        }

    @staticmethod
    def from_arrays(arrays: Mapping[str, Array]) -> "Route":
        """Back from `arrays()`, to the bit.

        Raises:
            SkillFileError: where an array is missing, misshapen, no float64 or not finite.
        """
        names = ("curves", "centre", "scale", "squared_spread", "model")
        found = [np.asarray(arrays.get(name)) for name in names]
        curves, centre, scale, spread, model = found
        shapes = [curves.shape[-1:], (), curves.shape[1:2], (len(astuple(RouteModel())),)]
        if [a.shape for a in found[1:]] != shapes or curves.ndim != 3 or not curves.size:
            raise SkillFileError(f"route: shapes {[a.shape for a in found]} do not belong together.")
        if len(curves) < 2 or curves.shape[1] < FEWEST_PHASES or any(a.dtype != np.float64 for a in found):
            raise SkillFileError(
                f"route: expected two curves at {FEWEST_PHASES} phases or more, all float64; found {curves.shape}, "
                f"{', '.join(str(a.dtype) for a in found)}."
            )
        learnt, kriged, *numbers = model.tolist()
        # Of the model, kernel weights may be zero; reach, nugget and ridge may not.
        if not all(np.isfinite(a).all() for a in found) or min(scale, spread.min(), *numbers[2:]) <= 0.0:
            raise SkillFileError("route: a number is not finite, or a scale not positive.")
        return Route(curves, centre, float(scale), spread, RouteModel(bool(learnt), bool(kriged), *numbers))


def node_rows(phases: Array, points: int) -> IntArray:
    """Rows of a path, evenly spread in phase, that stand for the given phases: (m,), strictly increasing."""
    even = (phases - phases[0]) / (phases[-1] - phases[0]) * (points - 1)
    order = np.arange(len(phases))
    rows = np.maximum.accumulate(np.rint(even).astype(np.intp) - order) + order
    return np.minimum(rows, points - len(phases) + order)
