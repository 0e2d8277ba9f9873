"""Random surfaces among random balls, in whole coordinates turned at random, for the loops that go around things."""

from dataclasses import dataclass

import numpy as np

from manifold import twins_around
from manifold.random_models import RandomModel, random_model
from manifold.twins_around import Balls, Land
from skillfold import PointObstacles
from skillfold.clearance import Compiled
from skillfold.manifold.kernels.walking import Chart, Support
from skillfold.planning.barrier import barrier_of

# (D - f, d, M, K, degree) of the surface and f free directions.
TERRAINS = [
    ((3, 2, 40, 8, 2), 0),
    ((3, 2, 40, 8, 2), 1),
    ((2, 1, 30, 3, 2), 2),
    ((5, 3, 300, 6, 1), 1),
]
MARGIN = 0.12  # rms radii; balls are as large as that


@dataclass(repr=False)
class Terrain:
    model: RandomModel
    land: Land
    obstacles: PointObstacles
    compiled: Compiled
    margin: float

    @property
    def barrier(self):
        return barrier_of(self.compiled)

    @property
    def arguments(self):
        """What most kernels take first."""
        return self.model.table, *self.land[2:4], self.barrier

    @property
    def width(self):
        """D."""
        return len(self.land.chart.centre)

    @property
    def dim(self):
        """d, free directions included."""
        return self.width - self.land.surface.points.shape[0] + self.land.field.weights.shape[0]

    def __repr__(self):
        return "terrain"

    def ball_centres(self):
        """Whole coordinates (m, D)."""
        chart = self.land.chart
        return (self.obstacles.points - chart.centre) @ chart.axes.T / chart.scale

    def states(self, count, spread=0.05):
        """Whole coordinates (count, D) near the surface."""
        inner = self.model.states(count, spread)
        free = self.width - inner.shape[1]
        return np.hstack([inner, self.model.rng.uniform(-0.6, 0.6, (count, free))])

    def on_surface(self, count):
        """The same, settled there and clear by more than a margin."""
        found = []
        for _ in range(100 * count):
            z, _, good = twins_around.settle(self.land, self.states(1)[0])
            state = twins_around.to_state(self.land.chart, z)
            if good and twins_around.in_limits(self.land.chart, state):
                found += [z] * bool(self.land.balls.clearance(state) > 1.1 * self.margin)
            if len(found) == count:
                return np.array(found)
        raise AssertionError("hardly any state is clear")

    def path(self, count, bow=0.1):
        """A first path between two states on the surface, beside the straight line and off the surface."""
        start, goal = self.on_surface(2)
        share = np.linspace(0.0, 1.0, count)[:, None]
        beside = bow * np.sin(np.pi * share) * self.model.rng.normal(size=self.width)
        return start + share * (goal - start) + beside

    def blocked_path(self, count):
        """The same, but over the ball nearest to its middle, slightly beside the ball's centre."""
        path, centres = self.path(count, 0.0), self.ball_centres()
        middle = path[count // 2]
        ball = centres[np.linalg.norm(centres - middle, axis=1).argmin()]
        over = np.sin(np.pi * np.linspace(0.0, 1.0, count)[:, None])
        return path + over * (ball - middle + 0.02 * self.model.rng.normal(size=self.width))


def random_terrain(seed, shape, free, balls=8):
    model = random_model(seed, *shape)
    rng, D = model.rng, shape[0] + free
    scale, centre = rng.uniform(0.3, 3.0), rng.normal(size=D)
    axes = np.ascontiguousarray(np.linalg.qr(rng.normal(size=(D, D)))[0])
    chart = Chart(centre, scale, axes, centre - 1.6 * scale, centre + 1.6 * scale)
    inner = np.hstack([model.states(balls, 0.02), rng.uniform(-0.6, 0.6, (balls, free))])
    margin = MARGIN * scale
    obstacles = PointObstacles(centre + scale * inner @ axes, 2 * margin)
    land = Land(model.surface, model.field, Support(0.8, 0.3), chart, Balls(obstacles.points, margin))
    return Terrain(model, land, obstacles, obstacles.compiled(), margin)
