"""Evaluation of terms for many runs at once; each value is an array with one element per run.

Booleans and whole numbers of up to 62 bits use numpy arrays of matching types. Wider numbers use arrays of
Python objects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from typing_extensions import override

from ...model import arithmetic
from .evaluation import Evaluator
from .meaning import BOOL, F32, FAR, INT, meaning
from .terms import T

Array = np.ndarray[Any, np.dtype[Any]]

_wrap: Callable[..., Any] = arithmetic.wrap
"""`wrap` for each element of an array, up to 62 bits. Arrays support the operators that `wrap` uses."""

LANES = 256
"""Default number of runs at once."""


class BatchEvaluator(Evaluator):
    """Computes terms for many values of their variables at once.

    Args:
        roots: the terms to compute.
        lanes: number of runs.
    """

    def __init__(self, roots: Sequence[T], lanes: int = LANES) -> None:
        self._lanes = lanes
        super().__init__(roots)

    @override
    def _constant(self, t: T) -> Array:
        return filled(t, t.val, self._lanes)

    @override
    def _function(self, t: T) -> Callable[..., Array]:
        return _function(t)

    def __len__(self) -> int:
        """Return the number of terms that are computed."""
        return len(self._steps)

    @override
    def __call__(self, values: Mapping[str, Array]) -> list[Array]:
        """Return the values of the roots; `values` has an array for each variable."""
        with np.errstate(all="ignore"):
            return super().__call__(values)


def filled(t: T, value: Any, lanes: int = LANES) -> Array:
    """Return an array with the same value for all runs."""
    return np.full(lanes, value, dtype=dtype_of(t))


def is_wide(t: T) -> bool:
    """Return whether a whole number does not fit in an array element."""
    return t.kind == INT and not -FAR < t.lo <= t.hi < FAR


def dtype_of(t: T) -> Any:
    """Return the element type of a term's array."""
    if t.kind == INT:
        return object if is_wide(t) else np.int64
    return {BOOL: np.bool_, F32: np.float32}.get(t.kind, np.float64)


def _function(t: T) -> Callable[..., Array]:
    """Return the function that computes a term's operation on arrays."""
    if is_wide(t) or any(map(is_wide, t.args)):
        return _wide(t)
    if t.op in _PLAIN:
        return _PLAIN[t.op]
    if t.op == "bit":
        number = min(t.val, 62)  # all higher bits are the sign
        return lambda a: (a >> number & 1).astype(np.bool_)
    if t.op == "shr":
        return lambda a: a >> min(t.val, 62)
    if t.op == "wrap":
        return partial(_wrap, bits=t.val)
    if t.op == "setbit":
        number, bits = t.val
        return lambda a, truth: _wrap(a & ~(1 << number) | truth.astype(np.int64) << number, bits)
    if t.op in ("f2f", "i2f"):
        kind = dtype_of(t)
        return lambda a: a.astype(np.float64).astype(kind)
    return _per_run(t)


def _wide(t: T) -> Callable[..., Array]:
    """Return a function that computes with Python numbers."""
    function: Callable[..., Array]
    if t.op == "wrap":
        function = partial(_wrap, bits=t.val)
    elif t.op in _WIDE:
        function = _PLAIN[t.op]
    else:
        return _per_run(t)
    kind = dtype_of(t)

    def computed(*operands: Array) -> Array:
        numbers = [operand if operand.dtype == np.bool_ else operand.astype(object) for operand in operands]
        return function(*numbers).astype(kind)

    return computed


def _per_run(t: T) -> Callable[..., Array]:
    """Return a function that computes each run separately, as defined by `meaning`."""
    function, kind = meaning(t.op, t.kind, t.val), dtype_of(t)

    def computed(*operands: Array) -> Array:
        lists = [operand.tolist() for operand in operands]
        return np.array([function(*arguments) for arguments in zip(*lists, strict=True)], dtype=kind)

    return computed


_PLAIN: dict[str, Callable[..., Array]] = {
    "not": np.logical_not,
    "and": np.logical_and,
    "iff": np.equal,
    "ite": np.where,
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "band": np.bitwise_and,
    "bor": np.bitwise_or,
    "bxor": np.bitwise_xor,
    "b2i": lambda a: a.astype(np.int64),
    "eq": np.equal,
    "lt": np.less,
    "fadd": np.add,
    "fsub": np.subtract,
    "fmul": np.multiply,
    "fneg": np.negative,
    "fabs": np.abs,
    "feq": np.equal,
    "flt": np.less,
    "fle": np.less_equal,
    "fnan": np.isnan,
    "ffin": np.isfinite,
}

_WIDE = frozenset({"ite", "add", "sub", "mul", "band", "bor", "bxor", "eq", "lt"})
"""Operations of `_PLAIN` that numpy can also compute on Python numbers."""
