"""Waits that contain other waits, and coroutines as branches: `all_of`, `first_of`, `within`.

    all_of(a, b)       until all are over; the value is a tuple of their values. The first error ends it
    first_of(a, b)     until one is over; the value is that argument. Within a scan, the first has precedence
    within("5 s", a)   the value of a, or WaitTimeout

A branch is a sequence that is stepped by its wait. A branch that loses gets `Abort`, and the wait ends once
the branch has ended. A command that loses continues, like a PLCopen block when its Execute falls.
"""

from __future__ import annotations

from collections.abc import Coroutine
from typing import Any, Generic, TypeVar, overload

from scanrack.io_images.times import parse_time
from typing_extensions import override

from .coroutine import Sequence
from .waits import Wait

T = TypeVar("T")
T2 = TypeVar("T2")
T3 = TypeVar("T3")

Work = Wait[T] | Coroutine[Any, Any, T]
"""A wait, or a coroutine, which becomes a branch."""

AnyWork = TypeVar("AnyWork", bound=Wait[Any] | Coroutine[Any, Any, Any])


class WaitTimeout(Exception):  # noqa: N818 - the trade says timeout
    """A wait did not end in time."""


class BranchWait(Wait[T], Generic[T]):
    """A wait that starts a coroutine and steps it."""

    __slots__ = ("_error", "_sequence")

    def __init__(self, work: Coroutine[Any, Any, T]) -> None:
        self._sequence = Sequence(getattr(work, "__name__", "branch"), lambda: work)
        self._error: Exception | None = None

    @property
    @override
    def moved(self) -> int:
        return self._sequence.resumed

    @override
    def begin(self, now_ns: int) -> None:
        try:
            self._sequence.begin(now_ns)
        except Exception as error:  # raised where it is awaited, in the next scan
            self._error = error

    @override
    def poll(self, now_ns: int) -> bool:
        if self._error is not None:
            raise self._error
        self._sequence.step(now_ns)
        return self._sequence.over

    @override
    def result(self) -> T:
        return self._sequence.value  # type: ignore[return-value]  # the coroutine's own

    @override
    def give_up(self, now_ns: int) -> bool:
        self._sequence.abort()
        return self.continue_giving_up(now_ns)

    @override
    def continue_giving_up(self, now_ns: int) -> bool:
        self._sequence.step(now_ns)
        return self._sequence.over

    @override
    def drop(self) -> None:
        self._sequence.close()

    def __repr__(self) -> str:
        return str(self._sequence)


def _as_wait(work: Wait[Any] | Coroutine[Any, Any, Any], function_name: str) -> Wait[Any]:
    """Return a wait unchanged, and a coroutine as a branch; raise a TypeError for other objects."""
    if isinstance(work, Wait):
        return work
    if isinstance(work, Coroutine):
        return BranchWait(work)
    raise TypeError(f"{function_name}: {work!r} is not a wait, a command, or the call of an async function")


class Several(Wait[T], Generic[T]):
    """Several waits as one. Once the result is decided, the wait ends when the last loser has ended."""

    __slots__ = ("_decided", "_error", "_running", "waits")

    word = "several"

    def __init__(self, work: tuple[Wait[Any] | Coroutine[Any, Any, Any], ...]) -> None:
        if not work:
            raise TypeError(f"{self.word}() has no arguments; pass at least one wait")
        self.waits = tuple(_as_wait(item, self.word) for item in work)
        self._running: list[Wait[Any]] = []
        self._decided = False
        self._error: Exception | None = None

    @property
    @override
    def moved(self) -> int:
        return sum(wait.moved for wait in self.waits)

    @override
    def begin(self, now_ns: int) -> None:
        self._running, self._decided, self._error = list(self.waits), False, None
        for wait in self.waits:
            wait.begin(now_ns)

    @override
    def poll(self, now_ns: int) -> bool:
        """Return whether the result is decided and the losers have ended, perhaps over several scans."""
        if self._decided:
            return self.continue_giving_up(now_ns)
        try:
            self._decided = self.decide(now_ns)
        except Exception as error:
            self._decided, self._error = True, error
        return self._decided and self.give_up(now_ns)

    def decide(self, now_ns: int) -> bool:
        """Poll the running waits; return whether the result is decided. Raise the error of a failed wait."""
        raise NotImplementedError

    def poll_one(self, wait: Wait[Any], now_ns: int) -> bool:
        """Poll a wait, and remove it if it ends or fails; return whether it ended, or raise its error."""
        try:
            is_over = wait.poll(now_ns)
        except Exception:
            self._running.remove(wait)
            raise
        if is_over:
            self._running.remove(wait)
        return is_over

    def value(self) -> T:
        """Return the result of the `await`."""
        raise NotImplementedError

    @override
    def result(self) -> T:
        if self._error is not None:
            raise self._error
        return self.value()

    @override
    def give_up(self, now_ns: int) -> bool:
        self._running = [wait for wait in self._running if not wait.give_up(now_ns)]
        return not self._running

    @override
    def continue_giving_up(self, now_ns: int) -> bool:
        self._running = [wait for wait in self._running if not wait.continue_giving_up(now_ns)]
        return not self._running

    @override
    def drop(self) -> None:
        for wait in self._running:
            wait.drop()

    def __repr__(self) -> str:
        return f"{self.word} {', '.join(map(repr, self._running or self.waits))}"


class All(Several[tuple[Any, ...]]):
    """All of several waits."""

    __slots__ = ()

    word = "all_of"

    @override
    def decide(self, now_ns: int) -> bool:
        for wait in tuple(self._running):
            if self.poll_one(wait, now_ns):
                wait.result()  # an error in one ends the wait for all immediately
        return not self._running

    @override
    def value(self) -> tuple[Any, ...]:
        return tuple(wait.result() for wait in self.waits)


class First(Several[Any]):
    """The first of several waits."""

    __slots__ = ("_winner", "_work")

    word = "first_of"

    def __init__(self, work: tuple[Wait[Any] | Coroutine[Any, Any, Any], ...]) -> None:
        super().__init__(work)
        self._work = work
        self._winner = 0

    @override
    def decide(self, now_ns: int) -> bool:
        """Return whether any wait has ended; the first in argument order is the result."""
        for place, wait in enumerate(self.waits):
            if self.poll_one(wait, now_ns):
                self._winner = place
                wait.result()
                return True
        return False

    @override
    def value(self) -> Any:
        return self._work[self._winner]


class Within(Several[T], Generic[T]):
    """A wait with a timeout."""

    __slots__ = ("_over_ns", "length_ns", "time")

    word = "within"

    def __init__(self, time: str, work: Wait[T] | Coroutine[Any, Any, T]) -> None:
        super().__init__((work,))
        self.length_ns = parse_time(time)
        self.time = time
        self._over_ns = 0

    @override
    def begin(self, now_ns: int) -> None:
        super().begin(now_ns)
        self._over_ns = now_ns + self.length_ns

    @override
    def decide(self, now_ns: int) -> bool:
        """Return whether the wait has ended; raise a WaitTimeout once the time is over."""
        if self.poll_one(self.waits[0], now_ns):
            return True
        if now_ns >= self._over_ns:
            raise WaitTimeout(f"{self.waits[0]!r} took longer than {self.time}")
        return False

    @override
    def value(self) -> T:
        return self.waits[0].result()  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return f"within {self.time} {self.waits[0]!r}"


@overload
def all_of(first: Work[T], second: Work[T2], /) -> Wait[tuple[T, T2]]: ...
@overload
def all_of(first: Work[T], second: Work[T2], third: Work[T3], /) -> Wait[tuple[T, T2, T3]]: ...
@overload
def all_of(*work: Work[T]) -> Wait[tuple[T, ...]]: ...
def all_of(*work: Any) -> Wait[Any]:
    """Wait until all have ended; the value is a tuple of their values, in order.

    Args:
        work: waits, commands, and calls of async functions, which become branches.

    Raises:
        Exception: at the await, the first error; the other branches are aborted.
    """
    return All(work)


def first_of(*work: AnyWork) -> Wait[AnyWork]:
    """Wait until one has ended; the value is that argument. The other branches are aborted.

    Commands continue. If several end in one scan, the first in order has precedence.

    Args:
        work: waits, commands, and calls of async functions, which become branches.

    Raises:
        Exception: at the await, the error of the first to end.
    """
    return First(work)


def within(time: str, work: Work[T]) -> Wait[T]:
    """Wait for `work`, but not longer than `time`; the await returns the value of `work`.

    Args:
        time: a number and its unit, such as "5 s".
        work: a wait, a command, or the call of an async function, which becomes a branch.

    Raises:
        WaitTimeout: at the await, if the time has run out. A branch is aborted; a command continues.
    """
    return Within(time, work)
