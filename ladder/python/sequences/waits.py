"""Waits: what a sequence awaits.

    scan        n          n+1         n+2
    sequence    await w    -           goes on
    the wait    begin      poll: no    poll: yes, result

A wait takes one scan at least, even one that holds already. Times are virtual and in integer ns.
"""

from __future__ import annotations

import inspect
import threading
from collections.abc import Callable, Generator
from typing import Any, Generic, NoReturn, TypeVar

from typing_extensions import override

from .durations import duration_ns

T_co = TypeVar("T_co", covariant=True)

Condition = Callable[[], object]
"""A question that is asked in every scan; its answer counts as true or false."""


class SequenceTurn(threading.local):
    """Whether a sequence takes its turn, in this thread.

    Python may close a coroutine at any time, the innermost first. Nothing would resume an await in its
    `finally` then, so that await ends at once.

    Attributes:
        now: whether one does.
        dropped: how many awaits were ended so since the last turn.
    """

    now = False
    dropped = 0

    def drop(self) -> None:
        """End an await outside of a turn; a loop that swallows that gets to wait after all.

        Raises:
            GeneratorExit: the coroutine is closed.
        """
        self.dropped += 1
        if self.dropped <= DROPS:
            raise GeneratorExit


stepping = SequenceTurn()
"""Of the thread that asks."""


DROPS = 100
"""How many awaits end at once outside of a turn; a coroutine that makes more swallows its end."""


class Wait(Generic[T_co]):
    """Something to await. Subclass it, with `poll` at least, for a wait of your own.

    Its `repr` is what `show`, the chart and the debugger say of a sequence that waits for it.
    """

    __slots__ = ("__weakref__",)

    @property
    def moved(self) -> int:
        """How often a branch inside of it has gone on since it began."""
        return 0

    def begin(self, now_ns: int) -> None:
        """Begin to wait, in the scan of the await."""

    def poll(self, now_ns: int) -> bool:
        """Return whether it holds; asked once in every later scan.

        Raises:
            Exception: the wait has failed; the sequence gets it at its await.
        """
        raise NotImplementedError(f"{type(self).__name__} has no poll")

    def result(self) -> T_co:
        """Return what the `await` returns, once it holds.

        Raises:
            Exception: what the `await` raises.
        """
        return None  # type: ignore[return-value]  # a wait without a value is a Wait[None]

    def give_up(self, now_ns: int) -> bool:
        """Stop waiting; return whether it is gone. A branch may need further scans for its `finally`."""
        return True

    def gone(self, now_ns: int) -> bool:
        """Take the next scan of giving up; return whether it is gone."""
        return True

    def drop(self) -> None:
        """End at once, without a scan; what is inside is closed."""

    def __await__(self) -> Generator[Wait[Any], None, T_co]:
        if not stepping.now:
            stepping.drop()
        yield self
        return self.result()

    def __bool__(self) -> NoReturn:
        raise TypeError(f"`{self!r}` is a wait, neither true nor false: await it")


def check_condition(condition: object, what: str) -> None:
    """Refuse what can't be asked in every scan.

    Raises:
        TypeError: it is not a function.
    """
    if not callable(condition):
        raise TypeError(f"{what}({condition!r}) is not allowed: write {what}(lambda: ...), a function")
    if inspect.iscoroutinefunction(condition):
        name = getattr(condition, "__name__", "the condition")
        raise TypeError(f"{what}({name}) is not allowed: {_never_answers(name)}")


def holds(condition: Condition) -> bool:
    """Ask a condition.

    Raises:
        TypeError: it answers with a coroutine, which would count as true.
    """
    answer = condition()
    if inspect.iscoroutine(answer):
        answer.close()  # lest Python warns that nobody awaits it
        raise TypeError(_never_answers(answer.__name__))
    return bool(answer)


def _never_answers(name: str) -> str:
    return f"{name} is an `async def`, which answers only where it is awaited: make it a `def`"


def text_of(condition: Condition) -> str:
    """Return what a condition is called: the name of its function, or of the input that it is.

    >>> text_of(lambda: True), text_of(str.isdigit)
    ('a condition', 'isdigit')
    """
    name = getattr(condition, "__name__", None) or getattr(condition, "name", None) or "<lambda>"
    return "a condition" if name == "<lambda>" else str(name)


class until(Wait[None]):  # noqa: N801 - it reads as a word of the language
    """A condition that is true, from the next scan on.

    Args:
        condition: a function without arguments.
        text: what it is called in charts and messages.
    """

    __slots__ = ("condition", "text")

    def __init__(self, condition: Condition, text: str = "") -> None:
        check_condition(condition, "until")
        self.condition = condition
        self.text = text

    @override
    def poll(self, now_ns: int) -> bool:
        return holds(self.condition)

    def __repr__(self) -> str:
        return self.text or f"until {text_of(self.condition)}"


class dwell(Wait[None]):  # noqa: N801
    """A time, from the scan of the await on; it holds in the first scan at or after its end.

    Args:
        time: a number and its unit, such as "2 s".

    Raises:
        ValueError: it is not a time.
    """

    __slots__ = ("_over_ns", "length_ns", "time")

    def __init__(self, time: str) -> None:
        self.length_ns = duration_ns(time)
        self.time = time
        self._over_ns = 0

    @override
    def begin(self, now_ns: int) -> None:
        self._over_ns = now_ns + self.length_ns

    @override
    def poll(self, now_ns: int) -> bool:
        return now_ns >= self._over_ns

    def __repr__(self) -> str:
        return f"dwell {self.time}"


class steady(Wait[None]):  # noqa: N801
    """A condition that is true for a time without a break.

    The time runs from the first scan after the await in which the condition is true.

    Args:
        condition: a function without arguments.
        time: a number and its unit, such as "1 s".
        text: what it is called in charts and messages.

    Raises:
        ValueError: it is not a time.
    """

    __slots__ = ("_since_ns", "condition", "length_ns", "text", "time")

    def __init__(self, condition: Condition, time: str, text: str = "") -> None:
        check_condition(condition, "steady")
        self.condition = condition
        self.length_ns = duration_ns(time)
        self.time = time
        self.text = text
        self._since_ns: int | None = None

    @override
    def begin(self, now_ns: int) -> None:
        self._since_ns = None

    @override
    def poll(self, now_ns: int) -> bool:
        if not holds(self.condition):
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = now_ns
        return now_ns - self._since_ns >= self.length_ns

    def __repr__(self) -> str:
        return f"{self.text or text_of(self.condition)} steady for {self.time}"


class Edge(Wait[None]):
    """A signal that changes to a level after the scan of the await.

    Args:
        read: returns the signal's level.
        to: the level that it changes to.
        text: what it is called.
    """

    __slots__ = ("_before", "_read", "_to", "text")

    def __init__(self, read: Callable[[], bool], to: bool, text: str) -> None:
        self._read, self._to, self.text = read, to, text
        self._before = to

    @override
    def begin(self, now_ns: int) -> None:
        self._before = self._read()

    @override
    def poll(self, now_ns: int) -> bool:
        before, self._before = self._before, self._read()
        return self._before is self._to and before is not self._to

    def __repr__(self) -> str:
        return self.text
