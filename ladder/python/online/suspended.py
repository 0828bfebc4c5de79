"""Reads a waiting frame: the position of its await, its locals, and the objects of its open blocks.

CPython shows a suspended coroutine's value stack to its garbage collector, in order: the iterators of `for`
loops, the exits of `with` blocks, the exception before a handler, and on top the awaitable.
"""

from __future__ import annotations

import gc
from collections.abc import Sequence
from enum import Enum
from itertools import islice
from types import CodeType
from typing import Any

from scanrack.io_images.dataclass import dataclass

from .held import entry_of, unwrapped

_EXITS = ("__exit__", "__aexit__")

Range = tuple[int, int, int, int]
"""A position: first and last line, first and last column."""


class BlockKind(Enum):
    """The kinds of open blocks that keep an object on the stack of a Python frame."""

    ITERATOR = "for"
    EXIT = "with"
    HANDLER = "except"


class UnknownStackError(Exception):
    """The stack of a frame is not as expected."""


@dataclass(frozen=True, slots=True)
class WaitingFrame:
    """A waiting frame."""

    work: Any  # the coroutine
    code: CodeType
    module: str
    position: Range  # position of its await
    values: dict[str, Any]  # its locals
    awaited: Any  # the coroutine or generator that it awaits

    def block_objects(self, kinds: Sequence[BlockKind]) -> list[Any]:
        """Return the objects of its open blocks, outermost first; a handler's object is its exception.

        Args:
            kinds: kinds of the blocks, outermost first.

        Raises:
            UnknownStackError: the stack does not match the blocks.
        """
        stack = gc.get_referents(self.work)
        present = None  # the exception in a handler: the last referent, if there was one
        if stack and stack[-1] is not self.work.cr_await:
            present = stack.pop()
        if not stack or stack.pop() is not self.work.cr_await:
            raise UnknownStackError
        if (present is None) is (BlockKind.HANDLER in kinds):
            raise UnknownStackError
        values: list[Any] = []
        for kind in reversed(kinds):
            item = stack.pop() if stack else None
            if kind is BlockKind.HANDLER:  # the stack has the exception before the present one
                values.append(present)
                item, present = present, item
            if kind is BlockKind.EXIT and not _is_of_kind(kind, item):
                item = _bound_exit(stack.pop() if stack else None, item)
            if not _is_of_kind(kind, item):
                raise UnknownStackError
            if kind is not BlockKind.HANDLER:
                values.append(unwrapped(item))
        return values[::-1]


def _bound_exit(function: Any, owner: Any) -> Any:
    """Return the bound exit of an object; since Python 3.14, the stack has the function below the object."""
    is_exit = getattr(function, "__name__", "") in _EXITS and hasattr(function, "__get__")
    return function.__get__(owner) if is_exit else None


def _is_of_kind(kind: BlockKind, item: Any) -> bool:
    """Return whether an object from the stack can belong to a block of this kind."""
    if kind is BlockKind.ITERATOR:
        return hasattr(item, "__next__")
    if kind is BlockKind.EXIT:
        return getattr(item, "__name__", "") in _EXITS and hasattr(item, "__self__")
    return isinstance(item, BaseException)


def suspended(work: Any) -> WaitingFrame:
    """Return the frame of a waiting coroutine, with its locals and the source position of its await."""
    frame = work.cr_frame
    # an instruction has two bytes, and `co_positions` has one entry for each instruction
    position = next(islice(frame.f_code.co_positions(), frame.f_lasti // 2, None))
    line, end_line, column, end_column = (number or 0 for number in position)
    values = {name: value for name, value in frame.f_locals.items() if not name.startswith(".")}
    return WaitingFrame(
        work,
        frame.f_code,
        module=frame.f_globals.get("__name__", ""),
        position=(line, end_line, column, end_column),
        values=values,
        awaited=entry_of(work.cr_await),
    )
