"""`SkillManifold`: what `fit` learns, and every question a user may ask of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any
from warnings import warn

import numpy as np

from skillfold import archive
from skillfold.clearance import Clearance
from skillfold.demonstrations import Demonstrations
from skillfold.manifold import inputs
from skillfold.manifold.answering import answer, read_plan
from skillfold.manifold.fitting import Options, fit_model
from skillfold.manifold.inputs import MANY, amount, choice, read_states, seed_of, together, whole
from skillfold.manifold.model import Model
from skillfold.manifold.projection import OnManifold, project_anchored, projected, tangents, within_limits
from skillfold.manifold.route import Route
from skillfold.manifold.samples import read_samples
from skillfold.manifold.sampling import sample_surface
from skillfold.manifold.shapes import Progress
from skillfold.manifold.storage import facts_of, pack, unpack
from skillfold.manifold.table import Selection
from skillfold.manifold.threads import libraries_alone
from skillfold.motion import Plan
from skillfold.spaces import StateSpace

Array = np.ndarray[Any, np.dtype[np.float64]]

METHODS = ("anchored", "leaf")
LEAF_RATE, LEAF_STEPS = 0.1, 1000  # of the printed projection; larger rates drift off the leaf


@dataclass(frozen=True, repr=False)
class SkillManifold:
    """A learnt skill manifold, ready to answer; made by `fit` or `load`.

    States are in the units of the demonstrations and in the order of `names`. Methods take one (D,) or a batch
    (..., D); angles that repeat may differ by full turns, quaternions by their sign. Lengths and tolerances are
    Euclidean: where units are mixed, scale the coordinates before fitting, so that 1 of each weighs the same.
    `distance` tells how far a state is off the constraint, `inside` how far from all that was demonstrated: above
    1 answers are extrapolated. What cannot be used is an `InputError` that says what was expected.

    Attributes:
        model: the arrays it consists of.
        route: how whole demonstrations go between their ends; None for samples without order.
        space: what the coordinates are.
        names: of the coordinates.
        selection: table of every choice that fit made.
        noise: standard deviation of the samples about the manifold, per normal direction.
        residual: rms distance of held-out samples from the manifold.
        ridge: λ of the tangent field.
        converged: whether training met its stop rule.
        n_samples: samples that were given.
        notes: what a user should know about the data; `fit` warns of it too.
    """

    model: Model
    route: Route | None
    space: StateSpace
    names: tuple[str, ...]
    selection: Selection
    noise: float
    residual: float
    ridge: float
    converged: bool
    n_samples: int
    notes: tuple[str, ...] = ()

    @classmethod
    def fit(
        cls,
        demos: Demonstrations | Array | Sequence[Array],
        dim: int | None = None,
        kernels: int | None = None,
        ridge: float | None = None,
        neighbors: int | None = None,
        seed: int = 0,
        *,
        space: StateSpace | None = None,
        jobs: int = -1,
        progress: Progress | None = None,
    ) -> "SkillManifold":
        """Learn the manifold that demonstrations lie on (section III).

        Args:
            demos: recordings (`Demonstrations`, a list of (n_steps, D) arrays, one array of three dimensions), or one
                (N, D) array of samples without time order.
            dim: d, free directions included; left out, from local spectra.
            kernels: K, radial basis functions of the tangent field; left out, by cross-validation.
            ridge: λ, for steps of unit rms; left out, by cross-validation.
            neighbors: of each sample in the graph to start with; grown until it is connected. Left out, 6 to 10.
            seed: the same seed gives the same bits.
            space: what the coordinates of plain arrays are; linear when left out.
            jobs: parallel workers of cross-validation, as in joblib.
            progress: called with a stage and its share done, 0 to 1.

        Raises:
            InputError: what was given cannot be used.
            DisconnectedError: the samples fall apart.
        """
        samples = read_samples(demos, space)
        options = Options(dim, kernels, ridge, neighbors, seed, jobs)
        options.check(*samples.states.shape)
        with libraries_alone():
            fitted = fit_model(
                samples.states,
                samples.groups,
                samples.space.quaternions,
                options,
                progress or (lambda stage, share: None),
            )
            route = Route.fit(samples.recordings)
        for note in samples.notes:
            warn(note, stacklevel=2)
        return cls(
            fitted.model,
            route,
            samples.space,
            samples.names,
            fitted.selection,
            fitted.noise,
            fitted.residual,
            fitted.ridge,
            fitted.field.converged,
            samples.count,
            samples.notes,
        )

    def __repr__(self) -> str:
        kind = " of recordings" if self.route else ""
        return (
            f"SkillManifold({self.dim} of {self.n_dims} dimensions, {self.kernels} kernels, "
            f"{self.n_samples} samples{kind}, residual {self.residual:.3g}, noise {self.noise:.3g})"
        )

    @property
    def dim(self) -> int:
        """d, the manifold's dimension."""
        return self.model.dim

    @property
    def n_dims(self) -> int:
        """D, the number of coordinates."""
        return self.model.n_dims

    @property
    def kernels(self) -> int:
        """K, radial basis functions of the tangent field."""
        return self.model.field.centres.shape[1]

    @property
    def tolerance(self) -> float:
        """95 % quantile of the distances of held-out samples: nearer states count as on the manifold."""
        return self.model.tolerance * self.model.scale

    def tangent(self, x: Any) -> Array:
        """Orthonormal basis H(x) of the tangent space at x (..., D), of the field alone as in print: (..., D, d)."""
        states, shape = self._states(x)
        return tangents(self.model, states).reshape(*shape, self.n_dims, self.dim)

    def project(
        self,
        x: Any,
        near: Any = None,
        method: str = "anchored",
        *,
        rate: float = LEAF_RATE,
        steps: int = LEAF_STEPS,
    ) -> Array:
        """Closest states on the manifold to x (..., D) (section IV-C1).

        Args:
            x: states.
            near: states to start from, such as those tracked before a push; the answer stays on their sheet. One
                for each of x, or one for all. Left out, the states themselves and their nearest anchors.
            method: "anchored", onto the modelled surface, within the limits of the coordinates; "leaf", the paper's
                iteration, whose answer lies on the field's leaf through `near` (else the nearest anchor) and so
                depends on it.
            rate, steps: α of the paper's iteration, 1 at most, and how often at most; for "leaf".
        """
        choice("method", method, METHODS)
        states, start = read_states(x, self.names), None
        if near is not None:
            states, start = together(states, read_states(near, self.names))
            start = self._rows(start)
        rate, steps = amount("rate", rate, 1.0), whole("steps", steps, 1, MANY)
        found = projected(self.model, self._rows(states), start, method, rate, steps)
        if method == "anchored":
            found = within_limits(self.model, found, self.space)
        return self.space.normalize(found).reshape(states.shape)

    def distance(self, x: Any) -> Any:
        """Distance of x (..., D) from the modelled surface, the paper's manifold metric (section IV-D); (...,)."""
        states, shape = self._states(x)
        return _scalar(OnManifold(self.model).distance(states), shape)

    def distance_gradient(self, x: Any) -> Array:
        """Gradient of `distance` at x (..., D): the unit vector away from the surface, zero on it; (..., D)."""
        states, shape = self._states(x)
        away = states - project_anchored(self.model, states)[0]
        length = np.linalg.norm(away, axis=1, keepdims=True)
        flat = length <= 1e-9 * self.model.scale
        return np.where(flat, 0.0, away / np.where(flat, 1.0, length)).reshape(*shape, self.n_dims)

    def contains(self, x: Any, tolerance: float | None = None) -> Any:
        """Whether x (..., D) lies within `tolerance` of the manifold; left out, `self.tolerance`; (...,)."""
        limit = self.tolerance if tolerance is None else amount("tolerance", tolerance, zero=True)
        return self.distance(x) <= limit

    def inside(self, x: Any) -> Any:
        """How far x (..., D) lies outside the demonstrations: 1 at the 95 % quantile of held-out samples; (...,)."""
        states, shape = self._states(x)
        return _scalar(OnManifold(self.model).inside(states), shape)

    def plan(
        self,
        start: Any,
        goal: Any,
        points: int | None = None,
        *,
        via: Any = None,
        route: str | None = None,
        method: str | None = None,
        obstacles: Clearance | None = None,
        near: Any = None,
        seed: int = 0,
    ) -> Plan:
        """A path from start to goal, both (D,), checked before it may say success.

        Args:
            start, goal: ends, kept exactly. For a geodesic, ends off the manifold are projected first.
            points: states of the path; left out, 101 for a demonstrated route, 50 for a geodesic, and among obstacles
                for a geodesic as many as the check looks at.
            via: (m, D) states to pass through, in order; none are as good as None.
            route: "demonstrated", the way the demonstrations take between such ends (default where the skill was
                learnt from two or more); "geodesic", the paper's shortest path (section IV-A2; default otherwise),
                which without obstacles keeps to the recordings' order where they spread about a curve; also tried
                where a demonstrated route cannot be pushed clear.
            method: of a geodesic: "anchored", tied to the data (default); "leaf", the paper's err_M alone. Around
                obstacles: "sampled", by trees on the manifold, shortcuts and smoothing (default where the shortest
                path is not clear); "hinge", the shortest path bent by penalties on clearance; "springs", the paper's
                Algorithm 2; "geodesic", the shortest path as it is.
            obstacles: what the path must keep clear of (section IV-B): `PointObstacles` in the space of states,
                or `robot.obstacles(scene)`.
            near: (n, D) states of an earlier path, which a geodesic without `method` bends first: faster where little
                moved since. For a query with obstacles and without via points.
            seed: of what is sampled; the same seed gives the same path.

        Returns:
            A plan, without success where the query cannot be met; what cannot be asked is an `InputError`. `stats`
            has the check; of a demonstrated route what `RouteAnswer` has; among obstacles methods and seconds.
        """
        if route is None:
            route = "demonstrated" if self.route else "geodesic"
        states = self._rows(inputs.read_query(start, goal, via, self.names, self.space))
        earlier = None if near is None else self._rows(inputs.read_path(near, self.names))
        query = read_plan(states, points, route, method, obstacles, seed, earlier)
        return answer(self.model, self.route, self.space, self.names, query, route == "demonstrated")

    def geodesic_distance(self, a: Any, b: Any) -> Any:
        """Length of the shortest path between a and b (..., D), broadcast; infinite where none was found; (...,)."""
        starts, goals = together(read_states(a, self.names), read_states(b, self.names))
        pairs = zip(starts.reshape(-1, self.n_dims), goals.reshape(-1, self.n_dims), strict=True)
        plans = [self.plan(start, goal, route="geodesic") for start, goal in pairs]
        return _scalar(np.array([p.length if p.success else np.inf for p in plans]), starts.shape[:-1])

    def sample(self, n: int, seed: int = 0) -> Array:
        """`n` states on the manifold, spread over it evenly and within the demonstrations; (n, D)."""
        return self.space.normalize(sample_surface(self.model, whole("n", n, 0, MANY), seed_of(seed)))

    def save(self, path: str | PathLike[str]) -> None:
        """Write all to one sealed NPZ file, the same skill in the same bytes; else raise a `SkillFileError`."""
        archive.write(path, *pack(self.model, self.route, facts_of(self)))

    @staticmethod
    def load(path: str | PathLike[str]) -> "SkillManifold":
        """Read a saved skill; every array is checked and nothing in the file is run.

        Raises:
            SkillFileError: the file is damaged, of another format, or no skill.
        """
        model, route, facts = unpack(path)
        return SkillManifold(model, route, **facts)

    def _states(self, x: Any) -> tuple[Array, tuple[int, ...]]:
        """Checked rows (B, D) and the batch shape."""
        array = read_states(x, self.names)
        return self._rows(array), array.shape[:-1]

    def _rows(self, states: Array) -> Array:
        """States (..., D) as rows (B, D), nearest to the data among the ways to write them."""
        rows = np.ascontiguousarray(states.reshape(-1, self.n_dims))
        return rows if self.space.is_flat else self.space.align(rows, self.model.centre)


def _scalar(values: Array, shape: tuple[int, ...]) -> Any:
    return float(values[0]) if shape == () else values.reshape(shape)
