"""Monomials of several variables, in an order that lets each be made from an earlier one by one product.

The local surfaces of `anchors` are polynomials in d tangent coordinates; this file alone knows their layout.
"""

from functools import lru_cache
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
Indices = np.ndarray[Any, np.dtype[np.int64]]


class Monomials(NamedTuple):
    """The monomials of `dim` variables up to some degree; monomial 0 is the constant.

    Attributes:
        parents: (P,) monomial j = monomial parents[j] × variable factors[j], for j > 0.
        factors: (P,) see above.
        degrees: (P,) total degree of each.
    """

    parents: Indices
    factors: Indices
    degrees: Indices


@lru_cache(maxsize=64)
def monomials(dim: int, degree: int) -> Monomials:
    """All monomials of `dim` variables with total degree at most `degree`, by degree."""
    powers = [c for k in range(degree + 1) for c in combinations_with_replacement(range(dim), k)]
    position = {power: j for j, power in enumerate(powers)}
    parents = np.array([position[power[:-1]] if power else 0 for power in powers], dtype=np.int64)
    factors = np.array([power[-1] if power else 0 for power in powers], dtype=np.int64)
    return Monomials(parents, factors, np.array([len(power) for power in powers], dtype=np.int64))


def terms_of(dim: int, degree: int) -> int:
    """P, the number of monomials of `dim` variables up to a degree."""
    return len(monomials(dim, degree).parents)


def design(u: Array, table: Monomials) -> Array:
    """Values of all monomials at u (..., d); shape (..., P)."""
    values = np.ones((*u.shape[:-1], len(table.parents)))
    for j in range(1, len(table.parents)):
        values[..., j] = values[..., table.parents[j]] * u[..., table.factors[j]]
    return values
