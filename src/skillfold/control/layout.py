"""What the controller's step is given: a skill, gains, limits, dynamics and obstacles, laid out in one table."""

from typing import Any

import numpy as np

from skillfold.clearance import Compiled
from skillfold.control.kernels import step as at
from skillfold.control.settings import Bounds
from skillfold.control.timing import Reference
from skillfold.manifold.model import Model
from skillfold.motion import Array
from skillfold.tables import ENTRY, Table, table_of

FAR = 4.0  # times the usual distance to the demonstrations: no foot is looked for farther out


def table_for(model: Model, bounds: Bounds, reaction: float, gains: Array, turning: Array) -> Table:
    """Table without reference, dynamics and obstacles."""
    D, E = model.kept.shape
    memory = np.zeros(at.CELLS)
    memory[[at.BLOCKED, at.SWEEP]] = np.inf
    rows = {
        slot: np.zeros(D) for slot in (at.Q, at.QD, at.GOOD, at.LAST, at.SEEN, at.FOOT, at.ACCELERATION, at.TORQUE)
    }
    own = {
        at.NUMBERS: np.array([model.trust.cap, FAR * model.trust.spacing, model.trust.ghost]),
        at.REFERENCE: np.zeros((3, D)),
        at.BASIS: np.zeros((len(model.field.weights), E)),
        at.GAINS: gains,
        at.VELOCITY: _finite(bounds.velocity),
        at.RISE: _finite(bounds.acceleration),
        at.EASE: _finite(bounds.acceleration),
        at.REACTION: _finite(reaction * bounds.acceleration),
        at.LOWER: _finite(bounds.lower),
        at.UPPER: _finite(bounds.upper),
        at.EFFORT: _finite(bounds.torque),
        at.TURNING: turning,
        at.MEMORY: memory,
        at.FUNCTIONS: np.zeros(2, np.int64),
        at.DYNAMICS: np.zeros(0, np.int64),
        at.OBSTACLES: np.zeros(0, np.int64),
        at.NOTHING: np.zeros(0),
        at.WORK: np.zeros((8, D)),
    }
    return table_of({**model.arrays, **rows, **own}, at.SLOTS)


def put(table: Table, slot: int, array: Any) -> None:
    """Replace an array of a table; whoever calls keeps the array."""
    rows, columns = array.shape if array.ndim == 2 else (1, array.size)
    table.entries[ENTRY * slot : ENTRY * slot + ENTRY] = array.ctypes.data, rows, columns


def put_reference(table: Table, reference: Reference) -> None:
    """A reference to follow from its start on."""
    memory = table.arrays[at.MEMORY]
    put(table, at.KNOTS, reference.knots.reshape(-1, reference.knots.shape[2]))
    memory[[at.PHASE, at.SLOPE, at.SCAN]] = 0.0
    memory[[at.STEP, at.DURATION, at.RATE]] = reference.step, reference.duration, 1.0
    memory[[at.SWEEP, at.BLOCKED]] = np.inf


def put_obstacles(table: Table, compiled: Compiled | None) -> None:
    """Obstacles to look out for; whoever calls keeps them."""
    arguments = table.arrays[at.NOTHING] if compiled is None else compiled.arguments
    put(table, at.OBSTACLES, arguments)
    table.arrays[at.FUNCTIONS][1] = 0 if compiled is None else compiled.clearance.address


def look_anew(table: Table) -> None:
    """Forget what was seen of obstacles so far."""
    table.arrays[at.MEMORY][[at.SWEEP, at.BLOCKED, at.CLEARANCE]] = np.inf
    table.arrays[at.MEMORY][at.SCAN] = 0.0


def put_dynamics(table: Table, compiled: Any) -> None:
    """Dynamics to answer with; whoever calls keeps them."""
    put(table, at.DYNAMICS, compiled.arguments)
    table.arrays[at.FUNCTIONS][0] = compiled.inverse.address


def _finite(limits: Array) -> Array:
    """Limits with a large number for none."""
    return np.clip(np.asarray(limits, np.float64), -at.LARGE, at.LARGE)
