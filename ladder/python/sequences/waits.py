"""Waits: conditions, times and edges that a sequence awaits.

    scan        n          n+1         n+2
    sequence    await w    -           continues
    the wait    begin      poll: no    poll: yes, result

A wait takes at least one scan, even if its condition is already true. Times are virtual and in integer ns.
"""

from __future__ import annotations

import inspect
import linecache
import threading
from collections.abc import Callable, Generator
from functools import lru_cache
from types import CodeType
from typing import Any, Generic, NoReturn, TypeVar

from scanrack.io_images.times import parse_time
from typing_extensions import override

from .watch import Watch

T_co = TypeVar("T_co", covariant=True)

Place = tuple[memoryview, int, int]
"""Words of an image, index of the word, mask of the bits."""

Condition = Callable[[], object]
"""A function that is called in every scan; its result is evaluated as true or false."""


class SequenceTurn(threading.local):
    """Whether a sequence is taking its turn, per thread.

    Python may close coroutines at any time, the innermost first. Nothing would resume an await in their
    `finally`, so that await ends at once.

    Attributes:
        active: whether a sequence is taking its turn.
        dropped: awaits ended this way since the last turn.
    """

    active = False
    dropped = 0

    def drop(self) -> None:
        """End an await outside a turn with GeneratorExit, up to `DROPS` times, since a loop may catch it."""
        self.dropped += 1
        if self.dropped <= DROPS:
            raise GeneratorExit


stepping = SequenceTurn()
"""The turn of the current thread."""


DROPS = 100
"""Maximum number of awaits ended per close; a coroutine with more awaits has swallowed GeneratorExit."""


class Wait(Generic[T_co]):
    """An awaitable; a subclass needs at least `poll`. Charts and the debugger show its `repr`."""

    __slots__ = ("__weakref__",)

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "poll" in vars(cls) and "watched" not in vars(cls):
            cls.watched = Wait.watched  # type: ignore[method-assign]  # the base's `watched` does not match this `poll`

    def watched(self) -> Watch | None:
        """Return what the wait depends on, once it has begun; None if it must be polled in each scan."""
        return None

    @property
    def moved(self) -> int:
        """Number of times that the branches inside the wait have resumed."""
        return 0

    def begin(self, now_ns: int) -> None:
        """Begin to wait, in the scan of the await."""

    def poll(self, now_ns: int) -> bool:
        """Return whether it is over; called once in each later scan. An exception is raised at the await."""
        raise NotImplementedError(f"{type(self).__name__} has no poll")

    def result(self) -> T_co:
        """Return the value of the `await`, or raise its exception."""
        return None  # type: ignore[return-value]  # a wait without a value is a Wait[None]

    def give_up(self, now_ns: int) -> bool:
        """Stop waiting; return whether the wait has ended. A branch may need more scans for its `finally`."""
        return True

    def continue_giving_up(self, now_ns: int) -> bool:
        """Continue to stop in the next scan; return whether the wait has ended."""
        return True

    def drop(self) -> None:
        """End immediately, without a scan, and close all branches inside."""

    def __await__(self) -> Generator[Wait[Any], None, T_co]:
        if not stepping.active:
            stepping.drop()
        yield self
        return self.result()

    def __bool__(self) -> NoReturn:
        raise TypeError(f"`{self!r}` is a wait, which is neither true nor false; await it")


def check_condition(condition: object, function_name: str) -> None:
    """Raise a TypeError unless `condition` is a function."""
    if not callable(condition):
        raise TypeError(
            f"{function_name}({condition!r}) needs a function; write {function_name}(lambda: ...)"
        )
    if inspect.iscoroutinefunction(condition):
        name = getattr(condition, "__name__", "the condition")
        raise TypeError(f"{function_name}({name}) is not allowed: {_async_mistake(name)}")


def is_true(condition: Condition) -> bool:
    """Return whether a condition is true; raise a TypeError for a coroutine, which would count as true."""
    result = condition()
    if inspect.iscoroutine(result):
        result.close()  # so that Python does not warn that it was never awaited
        raise TypeError(_async_mistake(result.__name__))
    return bool(result)


def _async_mistake(name: str) -> str:
    return f"{name} is an `async def`, which returns a value only where it is awaited; make it a `def`"


def text_of(condition: Condition) -> str:
    """Return the name of a condition's function or input, or the text of a lambda's expression.

    >>> text_of(str.isdigit), text_of(eval("lambda: True"))  # whose text is in no file
    ('isdigit', 'a condition')
    """
    name = getattr(condition, "__name__", None) or getattr(condition, "name", None) or "<lambda>"
    code = getattr(condition, "__code__", None)
    if name != "<lambda>":
        return str(name)
    return (_expression(code) if isinstance(code, CodeType) else "") or "a condition"


LONGEST = 80
"""Maximum number of characters of a condition's text."""


@lru_cache(maxsize=1024)
def _expression(code: CodeType) -> str:
    """Return the text of a lambda's expression in its file; "" if the file has changed."""
    text = _source_text(code)
    if not text or len(text) > LONGEST:
        return ""
    try:
        read = compile(f"({text})", "<condition>", "eval")
    except (SyntaxError, ValueError):
        return ""
    names = {*code.co_names, *code.co_freevars}
    return text if {*read.co_names} == names and _plain(read) == _plain(code) else ""


def _source_text(code: CodeType) -> str:
    """Return the source text of code as one line; "" if it is unknown."""
    begins, ends = [], []
    for line, end_line, column, end_column in code.co_positions():
        if line and end_line and column is not None and end_column is not None and column != end_column:
            begins.append((line, column))
            ends.append((end_line, end_column))
    if not begins:
        return ""
    (first_line, first_column), (last_line, last_column) = min(begins), max(ends)
    linecache.checkcache(code.co_filename)
    lines = [line.encode() for line in linecache.getlines(code.co_filename)[first_line - 1 : last_line]]
    if lines:
        lines[-1] = lines[-1][:last_column]  # columns count bytes
        lines[0] = lines[0][first_column:]
    return " ".join(b"".join(lines).decode(errors="replace").split())


def _plain(code: CodeType) -> set[str]:
    """Return the texts of a code's constants, without None and inner functions."""
    return {
        repr(constant)
        for constant in code.co_consts
        if constant is not None and not isinstance(constant, CodeType)
    }


class until(Wait[None]):  # noqa: N801 - it reads as a word of the language
    """Waits until a condition, a function without arguments, is true in a later scan; `text` describes it."""

    __slots__ = ("_place", "condition", "text")

    def __init__(self, condition: Condition, text: str = "") -> None:
        check_condition(condition, "until")
        self.condition = condition
        self.text = text
        self._place: Place | None = None

    @classmethod
    def of_input(cls, condition: Condition, text: str, place: Place | None) -> until:
        """Create a wait for the level of an input; `place` is everything that the condition reads."""
        wait = cls(condition, text)
        wait._place = place
        return wait

    @override
    def watched(self) -> Watch | None:
        return None if self._place is None else Watch(*self._place, at_once=True)

    @override
    def poll(self, now_ns: int) -> bool:
        return is_true(self.condition)

    def __repr__(self) -> str:
        return self.text or f"until {text_of(self.condition)}"


class dwell(Wait[None]):  # noqa: N801
    """Waits for a time such as "2 s", from the scan of the await to the first scan at or after its end."""

    __slots__ = ("_over_ns", "length_ns", "time")

    def __init__(self, time: str) -> None:
        self.length_ns = parse_time(time)
        self.time = time
        self._over_ns = 0

    @override
    def begin(self, now_ns: int) -> None:
        self._over_ns = now_ns + self.length_ns

    @override
    def watched(self) -> Watch:
        return Watch(until_ns=self._over_ns)

    @override
    def poll(self, now_ns: int) -> bool:
        return now_ns >= self._over_ns

    def __repr__(self) -> str:
        return f"dwell {self.time}"


class steady(Wait[None]):  # noqa: N801
    """Waits until a condition has been true for a time such as "1 s" without interruption."""

    __slots__ = ("_since_ns", "condition", "length_ns", "text", "time")

    def __init__(self, condition: Condition, time: str, text: str = "") -> None:
        check_condition(condition, "steady")
        self.condition = condition
        self.length_ns = parse_time(time)
        self.time = time
        self.text = text
        self._since_ns: int | None = None

    @override
    def begin(self, now_ns: int) -> None:
        self._since_ns = None

    @override
    def poll(self, now_ns: int) -> bool:
        if not is_true(self.condition):
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = now_ns
        return now_ns - self._since_ns >= self.length_ns

    def __repr__(self) -> str:
        return f"{self.text or text_of(self.condition)} steady for {self.time}"


class Edge(Wait[None]):
    """Waits for a change of a signal to a level, after the scan of the await."""

    __slots__ = ("_last_level", "_level", "_place", "_read", "text")

    def __init__(self, read: Callable[[], bool], level: bool, text: str, place: Place | None = None) -> None:
        self._read, self._level, self.text = read, level, text
        self._place = place  # everything that `read` reads
        self._last_level = level

    @override
    def watched(self) -> Watch | None:
        return None if self._place is None else Watch(*self._place)

    @override
    def begin(self, now_ns: int) -> None:
        self._last_level = self._read()

    @override
    def poll(self, now_ns: int) -> bool:
        last_level, self._last_level = self._last_level, self._read()
        return self._last_level is self._level and last_level is not self._level

    def __repr__(self) -> str:
        return self.text
