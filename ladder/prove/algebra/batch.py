"""Terms on many numbers at once: each value is an array with a place for each run.

Truths and whole numbers of up to 62 bits are
arrays of numpy; wider ones are Python's numbers in arrays of objects.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from .meaning import BOOL, F32, FAR, INT, meaning
from .terms import T, reach

Array = np.ndarray[Any, np.dtype[Any]]

LANES = 256
"""Runs at once."""


class BatchEvaluator:
    """Computes terms for many values of their variables at once.

    Args:
        roots: the terms.

    Attributes:
        variables: those that decide them.
    """

    def __init__(self, roots: Sequence[T], lanes: int = LANES) -> None:
        order = reach(roots)
        slots = {t.id: number for number, t in enumerate(order)}
        self.variables = [t for t in order if t.op == "var"]
        self._inputs = [(slot, t) for slot, t in enumerate(order) if t.op == "var"]
        self._found: list[Any] = [filled(t, t.val, lanes) if t.op == "const" else None for t in order]
        self._steps = [
            (slot, _function(t), [slots[a.id] for a in t.args])
            for slot, t in enumerate(order)
            if t.op not in ("const", "var")
        ]
        self._roots = [slots[t.id] for t in roots]

    def __len__(self) -> int:
        """Number of terms that are computed."""
        return len(self._steps)

    def __call__(self, values: Mapping[str, Array]) -> list[Array]:
        """Compute the roots; `values` has an array for each variable."""
        found = self._found
        for slot, t in self._inputs:
            found[slot] = values[t.val]
        with np.errstate(all="ignore"):
            for slot, function, operands in self._steps:
                found[slot] = function(*[found[each] for each in operands])
        return [found[slot] for slot in self._roots]


def filled(t: T, value: Any, lanes: int = LANES) -> Array:
    """Return the array of a term that has the same value in all runs."""
    return np.full(lanes, value, dtype=dtype_of(t))


def is_wide(t: T) -> bool:
    """Whether a whole number needs more bits than an array's."""
    return t.kind == INT and not -FAR < t.lo <= t.hi < FAR


def dtype_of(t: T) -> Any:
    """Return the type of a term's array."""
    if t.kind == INT:
        return object if is_wide(t) else np.int64
    return np.bool_ if t.kind == BOOL else np.float32 if t.kind == F32 else np.float64


def _function(t: T) -> Callable[..., Array]:
    if is_wide(t) or any(map(is_wide, t.args)):
        return _wide(t)
    if t.op in _PLAIN:
        return _PLAIN[t.op]
    if t.op == "bit":
        number = min(t.val, 62)
        return lambda a: (a >> number & 1).astype(np.bool_)
    if t.op == "shr":
        return lambda a: a >> min(t.val, 62)
    if t.op == "wrap":
        return partial(_wrapped, bits=t.val)
    if t.op == "setbit":
        number, bits = t.val
        return lambda a, truth: _wrapped(a & ~(1 << number) | truth.astype(np.int64) << number, bits)
    if t.op in ("f2f", "i2f"):
        kind = dtype_of(t)
        return lambda a: a.astype(np.float64).astype(kind)
    return _each(t)


def _wide(t: T) -> Callable[..., Array]:
    """Compute with Python's numbers."""
    function: Callable[..., Array]
    if t.op == "wrap":
        function = partial(_wrapped, bits=t.val)
    elif t.op in _WIDE:
        function = _PLAIN[t.op]
    else:
        return _each(t)
    kind = dtype_of(t)

    def computed(*operands: Array) -> Array:
        numbers = [each if each.dtype == np.bool_ else each.astype(object) for each in operands]
        return function(*numbers).astype(kind)

    return computed


def _wrapped(a: Array, bits: int) -> Array:
    """Keep low bits, of at most 62, as `arithmetic.wrap` does."""
    if bits < 0:
        return a & (1 << -bits) - 1
    half = 1 << bits - 1
    return (a + half & half + half - 1) - half


def _each(t: T) -> Callable[..., Array]:
    """Compute run by run, as `meaning` says."""
    function, kind = meaning(t.op, t.kind, t.val), dtype_of(t)

    def computed(*operands: Array) -> Array:
        lists = [each.tolist() for each in operands]
        return np.array([function(*each) for each in zip(*lists, strict=True)], dtype=kind)

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
"""Operations of `_PLAIN` that numpy does on Python's numbers too."""
