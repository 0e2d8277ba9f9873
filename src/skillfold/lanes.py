"""Four numbers side by side, in compiled loops: sums over short rows that the compiler does not vectorise by itself.

Rows of three to a dozen numbers are the rule here, and a loop whose length is not known when it is compiled costs
more than such a row. Filled up to a multiple of four, one is a few `load`s, and + − × act on all four at once. A
processor without registers that wide does them two at a time.
"""

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, overload, register_model

LANES = 4
_FOUR = ir.VectorType(ir.DoubleType(), LANES)
_FIRST = ir.Constant(ir.IntType(32), 0)
_ALL_FIRST = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
# As in `jit`: NaN and infinities keep their meaning.
_MATHS = ("reassoc", "contract", "nsz", "arcp")
_ALIGNED = 8  # bytes, as single numbers are


class _Lanes(types.Type):
    def __init__(self) -> None:
        super().__init__("lanes")


_lanes = _Lanes()


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _FOUR)


def padded(n: int) -> int:
    """`n`, or the next multiple of four."""
    return -(-n // LANES) * LANES


def _place(context: Any, builder: Any, kind: Any, array: Any, start: Any) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [start]), _FOUR.as_pointer())


def _load(typing: Any, array: Any, start: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.load(_place(context, builder, signature.args[0], *values), align=_ALIGNED)

    return _lanes(array, types.int64), generate


def _store(typing: Any, value: Any, array: Any, start: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        builder.store(values[0], _place(context, builder, signature.args[1], *values[1:]), align=_ALIGNED)
        return context.get_dummy_value()

    return types.void(_lanes, array, types.int64), generate


def _spread(typing: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        nothing = ir.Constant(_FOUR, ir.Undefined)
        return builder.shuffle_vector(builder.insert_element(nothing, values[0], _FIRST), nothing, _ALL_FIRST)

    return _lanes(types.float64), generate


def _chosen(comparison: str) -> Any:
    """The second of two where it compares so with the first, else the first: what is no number stays."""

    def choose(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            first, second = values
            return builder.select(builder.fcmp_ordered(comparison, second, first), second, first)

        return _lanes(_lanes, _lanes), generate

    return intrinsic(choose)


smaller, larger = _chosen("<"), _chosen(">")
# Of a contiguous array, of any shape, the four numbers from number `start` on: nobody looks whether there are four.
load: Any = intrinsic(_load)  # (array, start)
store: Any = intrinsic(_store)  # (lanes, array, start)
spread: Any = intrinsic(_spread)  # one number, four times


def _define(symbol: Callable[..., Any], instruction: str) -> None:
    """What an operator does with lanes on both sides."""

    def of_both(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return getattr(builder, instruction)(*values, flags=_MATHS)

        return _lanes(_lanes, _lanes), generate

    act: Any = intrinsic(of_both)

    @overload(symbol, strict=False)
    def choose(a: Any, b: Any) -> Any:
        if isinstance(a, _Lanes) and isinstance(b, _Lanes):
            return lambda a, b: act(a, b)
        return None


_define(operator.add, "fadd")
_define(operator.sub, "fsub")
_define(operator.mul, "fmul")
