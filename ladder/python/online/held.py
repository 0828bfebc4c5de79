"""Objects that a rebuilt frame keeps from the old frame.

    ContinuedAwait    an await that has begun: it yields the current wait, then continues
    RemainingPasses   an iterator of a `for` during a pass: this pass, then the remaining passes
    OpenBlock         an open `with` block, which is left without being entered
    Entering          an `async with` whose entry is waiting

None of these objects runs user code before the wait is over.
"""

from __future__ import annotations

import ctypes
from collections.abc import Awaitable, Callable, Generator, Iterator
from functools import partial
from types import TracebackType
from typing import Any

Exit = Callable[..., Any]
"""A bound `__exit__` or `__aexit__`."""


class ContinuedAwait:
    """The await of a coroutine or generator that is already waiting."""

    def __init__(self, inner: Any, wait: object) -> None:
        self.inner, self._wait = inner, wait

    def __await__(self) -> Generator[object, None, Any]:
        """Yield the current wait, then forward values to and from the coroutine until it returns."""
        wait = self._wait
        while True:
            try:
                yield wait
            except GeneratorExit:
                self.inner.close()
                raise
            except BaseException as error:
                resume: Callable[[], object] = partial(self.inner.throw, error)
            else:
                resume = partial(self.inner.send, None)
            try:
                wait = resume()
            except StopIteration as stop:
                return stop.value


class RemainingPasses:
    """The iterator of a loop during a pass; its first item represents this pass."""

    def __init__(self, inner: Iterator[Any]) -> None:
        self.inner = inner
        self._begun = False

    def __iter__(self) -> RemainingPasses:
        return self

    def __next__(self) -> Any:
        if not self._begun:
            self._begun = True
            return None
        return next(self.inner)


class OpenBlock:
    """An open `with` or `async with` block, represented by its exit."""

    def __init__(self, leave: Exit) -> None:
        self.leave = leave

    def __enter__(self) -> None:
        """Do nothing: the block is already open."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> Any:
        return self.leave(kind, error, trace)

    async def __aenter__(self) -> None:
        """Do nothing: the block is already open."""

    def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> Awaitable[Any]:
        leaving: Awaitable[Any] = self.leave(kind, error, trace)
        return leaving


class Entering(OpenBlock):
    """An `async with` block whose entry is waiting."""

    def __init__(self, entry: ContinuedAwait, leave: Exit) -> None:
        super().__init__(leave)
        self._entry = entry

    def __aenter__(self) -> Any:
        return self._entry


def unwrapped(held: Any) -> Any:
    """Return the iterator or exit that an earlier edit wrapped; return other objects unchanged."""
    if isinstance(held, RemainingPasses):
        return held.inner
    owner = getattr(held, "__self__", None)
    return owner.leave if isinstance(owner, OpenBlock) else held


def entry_of(awaited: Any) -> Any:
    """Return the coroutine or generator that an earlier edit's await continues; return others unchanged."""
    frame = getattr(awaited, "gi_frame", None)
    if frame is None or frame.f_code is not ContinuedAwait.__await__.__code__:
        return awaited
    return frame.f_locals["self"].inner


def keep_forever(work: object) -> None:
    """Keep a replaced coroutine suspended until the process ends.

    Without a reference, Python would close it and run its `finally` blocks, which belong to the new frame.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(work))
