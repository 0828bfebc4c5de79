"""Places of a program on terms, in its memory and in arguments of add-on instructions."""

from __future__ import annotations

from typing import Any, cast

from ...model.tags import Layout, Leaf
from ...model.types import Elementary
from ...state.memory import InterpretedAddOnStore
from ..algebra.meaning import BOOL, F32, F64, INT
from ..algebra.numbers import bit, eq, setbit, sub
from ..algebra.terms import T, const, interval_of, ite
from .symbols import TermScan, TermSymbol, UnmodeledError, term_of

Key = tuple[str, int]
"""A place, given by the path of its leaf in capitals and its flat index."""

CLOCK = "~LAST_NS"
"""Path suffix of a hidden member for an instant; its term is the time since this instant, in ms."""

AGE = 1 << 32
"""Maximum time since an instant in a term, in ms; it exceeds the range of all timers."""


def name_of(key: Key) -> str:
    """Return the name of a place's variable."""
    return f"{key[0]}[{key[1]}]"


MOST_ELEMENTS = 2048
"""Maximum number of elements that a computed subscript can select."""


def kind_of(kind: Elementary) -> tuple[str, int, int]:
    """Return the kind and the interval of a type's terms."""
    if kind.is_bool:
        return BOOL, 0, 0
    if kind.is_real or kind.is_double:
        return (F32 if kind.is_real else F64), 0, 0
    return INT, *interval_of(kind.wraps)


class TermMemory:
    """The memory of a scan on terms, as a `Store`."""

    def __init__(self, values: TermScan, layout: Layout) -> None:
        self.layout, self._values = layout, values
        self.left = 1  # as in the interpreter's memory: elements of an argument

    def read(self, leaf: Leaf, index: Any = 0) -> Any:
        """Return a value; a computed index chooses among the elements."""
        values = self._values
        if not isinstance(index, TermSymbol):
            return values.symbol(values.value_here(leaf, index))
        number, indices = _choices(leaf, index.t)
        return values.symbol(chosen([values.value_here(leaf, element) for element in indices], number))

    def write(self, leaf: Leaf, index: Any, value: Any) -> None:
        """Set a value of the leaf's type."""
        if not isinstance(index, TermSymbol):
            self._values.poke(leaf, index, term_of(value))
            return
        number, indices = _choices(leaf, index.t)
        for k, element in enumerate(indices):
            self._values.poke(leaf, element, term_of(value), eq(number, const(k)))

    def column(self, *_target: object) -> None:
        """Return None, because terms are not in a list."""

    def bytes_at(self, *_target: object) -> None:
        """Return None, because terms are not bytes."""

    def bit_of(self, word: Any, number: Any) -> Any:
        """Return a bit of a word."""
        term = term_of(word, INT)
        if not isinstance(number, TermSymbol):
            return self._values.symbol(bit(term, number))
        bits = [bit(term, k) for k in range(number.t.hi + 1)]
        return self._values.symbol(chosen(bits, number.t))

    def with_bit(self, word: Any, number: Any, truth: Any, kind: Elementary) -> Any:
        """Return a word of a type with one bit replaced."""
        term, on = term_of(word, INT), term_of(truth, BOOL)
        if not isinstance(number, TermSymbol):
            return self._values.symbol(setbit(term, number, on, kind.wraps))
        changed = term
        for k in range(number.t.lo, number.t.hi + 1):  # `subscript` has checked its range
            changed = ite(eq(number.t, const(k)), setbit(term, k, on, kind.wraps), changed)
        return self._values.symbol(changed)

    def __getattr__(self, name: str) -> Any:
        raise UnmodeledError(f"memory is used by its {name}")


def _choices(leaf: Leaf, index: T) -> tuple[T, range]:
    """Return which possible element an index selects, as a term counted from 0, and all their indices."""
    number, step, begin = index, 1, 0  # index = number * step + begin
    if number.op == "add" and number.args[1].op == "const":
        number, begin = number.args[0], number.args[1].val
    if number.op == "mul" and number.args[1].op == "const" and number.args[1].val > 0:
        number, step = number.args[0], number.args[1].val
    first = max(number.lo, -(begin // step))
    last = min(number.hi, (leaf.size - 1 - begin) // step)
    if last - first >= MOST_ELEMENTS:
        raise UnmodeledError(f"a computed subscript among {last - first + 1} elements")
    if last < first:
        return const(0), range(begin % step, begin % step + 1)
    return sub(number, const(first)), range(begin + first * step, begin + last * step + 1, step)


def chosen(values: list[T], number: T) -> T:
    """Return the value selected by a number, which is always in range."""
    k = 0
    while len(values) > 1:
        truth = bit(number, k)
        pairs = [values[start : start + 2] for start in range(0, len(values), 2)]
        values = [ite(truth, pair[-1], pair[0]) for pair in pairs]
        k += 1
    return values[0]


class TermArgument(InterpretedAddOnStore):
    """An argument of an add-on instruction, as a `Store`; its place may be computed."""

    __slots__ = ()

    @property
    def _terms(self) -> TermMemory:
        return cast(TermMemory, self._memory)

    def read(self, leaf: Leaf, index: Any = 0) -> Any:
        """Return a value."""
        value = self._memory.read(*self._target(leaf, index))
        return value if self.bit is None else self._terms.bit_of(value, self.bit)

    def write(self, leaf: Leaf, index: Any, value: Any) -> None:
        """Set a value of the leaf's type."""
        memory_leaf, memory_index = self._target(leaf, index)
        if self.bit is not None:
            word = self._memory.read(memory_leaf, memory_index)
            value = self._terms.with_bit(word, self.bit, value, memory_leaf.type)
        self._memory.write(memory_leaf, memory_index, value)
