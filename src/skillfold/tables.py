"""Tables of addresses: how arrays reach compiled loops that must not know their owners.

Handing a compiled function two dozen arrays costs more time than the work they are for, and makes every caller
compile for their types. A table is one array: for each slot the address, rows and columns of an array; scalars are
arrays of one. It keeps nothing alive: whoever holds a `Table` holds what it points to.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from skillfold.jit import inner

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]

ENTRY = 3  # numbers of a slot


@dataclass(frozen=True)
class Table:
    """A table and all that it points to.

    Attributes:
        entries: (3 · slots,) address, rows and columns of each array.
        arrays: by slot.
        owners: whatever else must live as long.
    """

    entries: Indices
    arrays: Mapping[int, np.ndarray[Any, Any]]
    owners: tuple[Any, ...]


def table_of(arrays: Mapping[int, Any], slots: int, *owners: Any) -> Table:
    """Table of float64 and int64 arrays of one or two dimensions; views of MuJoCo's are kept as they are."""
    entries = np.zeros(ENTRY * slots, np.int64)
    kept = {}
    for slot, given in arrays.items():
        array = np.asarray(given)
        array = np.ascontiguousarray(array, np.float64 if array.dtype.kind == "f" else np.int64)
        kept[slot] = array
        rows, columns = array.shape if array.ndim == 2 else (1, array.size)
        entries[ENTRY * slot : ENTRY * slot + ENTRY] = array.ctypes.data, rows, columns
    return Table(entries, kept, owners)


def _pointer_to(kind: types.Type) -> Any:
    """A compiled function from an address to a pointer to numbers of that kind."""

    def to_pointer(typing: Any, where: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.inttoptr(values[0], context.get_value_type(signature.return_type))

        return types.CPointer(kind)(types.int64), generate

    return intrinsic(to_pointer)


_real_pointer, _integer_pointer = _pointer_to(types.float64), _pointer_to(types.int64)


def _to_address(typing: Any, array: Any) -> Any:
    """Where the numbers of an array lie."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        held = context.make_array(signature.args[0])(context, builder, values[0])
        return builder.ptrtoint(held.data, context.get_value_type(types.int64))

    return types.int64(array), generate


_address_of: Any = intrinsic(_to_address)


@inner
def enter(table: Indices, slot: int, array: Any, rows: int, columns: int) -> None:
    """Put an array's address and shape into a table that compiled code makes; whoever has the array keeps it."""
    table[ENTRY * slot] = _address_of(array)
    table[ENTRY * slot + 1] = rows
    table[ENTRY * slot + 2] = columns


@inner
def reals_at(where: int, shape: Any) -> Any:
    """Array of float64 at an address, which must stay alive."""
    return carray(_real_pointer(where), shape)


@inner
def integers_at(where: int, shape: Any) -> Any:
    """Array of int64 at an address, which must stay alive."""
    return carray(_integer_pointer(where), shape)


@inner
def vector(table: Indices, slot: int) -> Array:
    """Array (n,) of numbers."""
    return reals_at(table[ENTRY * slot], (table[ENTRY * slot + 1] * table[ENTRY * slot + 2],))


@inner
def matrix(table: Indices, slot: int) -> Array:
    """Array (rows, columns) of numbers."""
    return reals_at(table[ENTRY * slot], (table[ENTRY * slot + 1], table[ENTRY * slot + 2]))


@inner
def indices(table: Indices, slot: int) -> Indices:
    """Array (n,) of indices."""
    return integers_at(table[ENTRY * slot], (table[ENTRY * slot + 1] * table[ENTRY * slot + 2],))


@inner
def index_matrix(table: Indices, slot: int) -> Indices:
    """Array (rows, columns) of indices."""
    return integers_at(table[ENTRY * slot], (table[ENTRY * slot + 1], table[ENTRY * slot + 2]))


@inner
def address(table: Indices, slot: int) -> int:
    """Where a slot's array lies."""
    return table[ENTRY * slot]


@inner
def scalar(table: Indices, slot: int) -> int:
    """The one index of a slot."""
    return integers_at(table[ENTRY * slot], (1,))[0]
