"""The kernels, made so that Python can call those too that are for compiled code alone."""

from types import SimpleNamespace

import numba

from skillfold.manifold.kernels import acceleration as _acceleration
from skillfold.manifold.kernels import detours as _detours
from skillfold.manifold.kernels import edges as _edges
from skillfold.manifold.kernels import frames as _frames
from skillfold.manifold.kernels import geodesic as _geodesic
from skillfold.manifold.kernels import holding as _holding
from skillfold.manifold.kernels import leaf as _leaf
from skillfold.manifold.kernels import neighbours as _neighbours
from skillfold.manifold.kernels import newton as _newton
from skillfold.manifold.kernels import projection as _projection
from skillfold.manifold.kernels import pushes as _pushes
from skillfold.manifold.kernels import scratch as _scratch
from skillfold.manifold.kernels import small as _small
from skillfold.manifold.kernels import springs as _springs
from skillfold.manifold.kernels import surface as _surface
from skillfold.manifold.kernels import tangents as _tangents
from skillfold.manifold.kernels import trees as _trees
from skillfold.manifold.kernels import walking as _walking


def entered(value):
    """A function that calls an inner kernel; all else as it is."""
    if not getattr(value, "targetoptions", {}).get("no_cpython_wrapper"):
        return value

    @numba.njit
    def call(*arguments):
        return value(*arguments)

    return call


def callable_of(module):
    return SimpleNamespace(**{name: entered(value) for name, value in vars(module).items()})


acceleration, geodesic, neighbours = map(callable_of, (_acceleration, _geodesic, _neighbours))
newton, projection, small = map(callable_of, (_newton, _projection, _small))
scratch_memory, surface, tangents = map(callable_of, (_scratch, _surface, _tangents))
detours, edges, frames = map(callable_of, (_detours, _edges, _frames))
holding, leaf = map(callable_of, (_holding, _leaf))
pushes, springs, trees, walking = map(callable_of, (_pushes, _springs, _trees, _walking))


def evaluated(model, states):
    """Scratch memory in which a model was evaluated at states (n, D)."""
    scratch = scratch_memory.make_scratch(model.table, len(states))
    scratch_memory.evaluate(states, scratch)
    return scratch


@numba.njit
def relax(path, tolerance, cap, limit, share, own, rate, scratch):
    """`geodesic.relax` of a path that nothing holds."""
    return _geodesic.relax(path, tolerance, cap, limit, share, own, rate, scratch, _geodesic.leave_free, None)
