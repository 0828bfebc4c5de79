"""A sequence, which is one coroutine and its wait.

    in its turn of a scan       the sequence
    it has an order             gets Abort at its await, after its branches have ended
    its wait is not over        stays
    its wait is over or fails   continues to its next wait, which begins in this scan

`abort` and `restart` are orders for the next turn. A `finally` may await. Ending then takes more scans, and
`restart` starts the sequence over in the scan in which it ends. A sequence that continues after a second
Abort has swallowed it, and faults the controller.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Coroutine
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any

from .waits import Wait, stepping
from .watch import NOTHING

_OURS = f"{Path(__file__).parent}{os.sep}"


class Abort(BaseException):
    """The sequence is aborted; raised at its await. `except Exception` does not catch it."""


class Sequence:
    """One coroutine and its wait; `logic.cycle` is one."""

    def __init__(
        self, name: str, make: Callable[[], Coroutine[Any, Any, object]], starts: bool = True
    ) -> None:
        self.name = name
        self.starts = starts  # whether it begins in the first scan, or waits for `restart`
        self.since_ns = 0  # virtual time at which its current wait began, or at which it ended
        self.value: object = None  # the return value of its coroutine
        self._make = make
        self._work: Coroutine[Any, Any, object] | None = None
        self._wait: Wait[Any] | None = None  # None while it is not running
        self._resumed = 0  # starts and resumptions, without those of branches in the current wait
        self._ordered = False  # whether it gets Abort in its next turn
        self._again = False  # whether it begins again after its end
        self._giving_up = False  # whether it waits for the end of branches before Abort
        self._aborted = False  # whether it has got Abort since it began
        self._due = False  # whether it takes its turn in each scan
        self._seen = 0  # the masked word at its last turn
        self._words, self._word, self._mask, self._until_ns, self._flag, _ = NOTHING

    # -- for the logic

    def abort(self) -> None:
        """End it: `Abort` is raised at its await, in its next turn. Its commands continue."""
        self._ordered, self._again, self._due = True, False, True

    def restart(self) -> None:
        """End it if it is running, and start it over."""
        self._ordered = self._again = self._due = True

    @property
    def over(self) -> bool:
        """Whether it is not running."""
        return self._wait is None

    # -- for observers; reading changes nothing

    @property
    def resumed(self) -> int:
        """Number of times that it or its branches have been started or resumed."""
        wait = self._wait
        return self._resumed if wait is None else self._resumed + wait.moved

    @property
    def frame(self) -> FrameType | None:
        """The innermost waiting frame of the user's code; None if the sequence is not running.

        While the user's code is running, this is the running frame; before 3.13, reading `cr_await` then may
        crash Python.
        """
        work: Any = self._work
        innermost = None
        while (frame := getattr(work, "cr_frame", None)) is not None:
            if not frame.f_code.co_filename.startswith(_OURS):
                innermost = frame
            work = None if work.cr_running else work.cr_await
        return innermost

    @property
    def line(self) -> int | None:
        """The line where the sequence waits; None if it is not running."""
        frame = self.frame
        return None if frame is None else frame.f_lineno

    @property
    def file(self) -> str | None:
        """The file of `line`."""
        frame = self.frame
        return None if frame is None else frame.f_code.co_filename

    @property
    def waits_for(self) -> str:
        """Text of its wait, created on demand; "" if it is not running."""
        return "" if self._wait is None else repr(self._wait)

    def __str__(self) -> str:
        return f"{self.name}: over" if self.over else f"{self.name}, line {self.line}: {self.waits_for}"

    def __repr__(self) -> str:
        return f"<{self}>"

    # -- for the scan

    def begin(self, now_ns: int) -> None:
        """Begin it, in this scan."""
        self._ordered = self._again = self._giving_up = self._aborted = False
        self._work = self._make()
        self._resume(now_ns, None)

    def step(self, now_ns: int) -> None:
        """Take this scan's turn; raise an exception of the sequence."""
        if self._ordered or self._giving_up:
            self._follow_order(now_ns)
            return
        wait = self._wait
        if wait is None:
            return
        try:
            if not wait.poll(now_ns):
                return
        except Exception as error:
            self._resume(now_ns, error)
        else:
            self._resume(now_ns, None)
        if self._aborted:
            self._begin_again_if_ordered(now_ns)

    def step_after_change(self, now_ns: int) -> None:
        """Take this scan's turn, after a change that the sequence depends on."""
        resumed = self._resumed
        self.step(now_ns)
        if self._resumed == resumed:
            self._seen = self._words[self._word] & self._mask

    def close(self) -> None:
        """End it outside scans: run `finally` without further awaits, and raise its exceptions."""
        work, self._work = self._work, None
        wait, self._wait = self._wait, None
        self._ordered = self._again = self._giving_up = self._aborted = False
        self._depend_on(None)
        if wait is not None:
            wait.drop()
        if work is not None:
            stepping.dropped = 0
            _close(work)

    def __del__(self) -> None:
        self.close()

    def _follow_order(self, now_ns: int) -> None:
        """Carry out an order, or continue one that is waiting for branches."""
        wait = self._wait
        if wait is None:
            self._ordered = False
            self._depend_on(None)
        else:
            is_over = wait.give_up(now_ns) if self._ordered else wait.continue_giving_up(now_ns)
            self._ordered, self._giving_up = False, not is_over
            if is_over:
                self._abort(now_ns)
        self._begin_again_if_ordered(now_ns)

    def _abort(self, now_ns: int) -> None:
        """Raise Abort at the await; raise a RuntimeError if the sequence swallows a second one."""
        was_aborted, self._aborted = self._aborted, True
        self._resume(now_ns, Abort())
        if was_aborted and self._wait is not None:
            raise _located(
                self.frame,
                RuntimeError(
                    f"{self.name} swallows Abort: it continues after the second; write `except Exception`"
                ),
            )

    def _begin_again_if_ordered(self, now_ns: int) -> None:
        if self._wait is None and self._again:
            self.begin(now_ns)

    def _resume(self, now_ns: int, error: BaseException | None) -> None:
        """Resume the coroutine up to its next wait."""
        if self._wait is not None:
            self._resumed += self._wait.moved
            self._wait = None
        self._resumed += 1
        self.since_ns = now_ns
        self._depend_on(None)
        wait = self._advance(error)
        while not isinstance(wait, Wait):
            if wait is _OVER:
                return
            text = f"{self.name} awaits {wait!r}, which is not a wait of scanrack; {NO_LOOP}"
            wait = self._advance(TypeError(text))
        wait.begin(now_ns)
        self._wait = wait
        self._depend_on(wait)

    def _depend_on(self, wait: Wait[Any] | None) -> None:
        """Store the dependencies of its next turns, see `watch`; an order makes the next turn due."""
        watch = NOTHING if wait is None else wait.watched()
        self._due = watch is None or self._ordered
        if watch is not None:
            self._words, self._word, self._mask, self._until_ns, self._flag, at_once = watch
            self._seen = _UNSEEN if at_once else self._words[self._word] & self._mask

    def _advance(self, error: BaseException | None) -> object:
        """Run the coroutine up to its next await; return what it awaits, or `_OVER` after its end."""
        work = self._work
        assert work is not None, "a sequence that continues has begun"
        was_stepping, stepping.active = stepping.active, True
        try:
            return work.send(None) if error is None else work.throw(error)
        except StopIteration as stop:
            self.value = stop.value
        except Abort:
            pass  # the requested end
        except RuntimeError as error:
            if str(error) == "no running event loop":  # the text of asyncio
                text = f"{error}: {self.name} awaits an object of asyncio; {NO_LOOP}"
                raise RuntimeError(text).with_traceback(error.__traceback__) from None
            if isinstance(error.__cause__, StopIteration):  # Python's form of a StopIteration that escapes
                error = error.with_traceback(error.__cause__.__traceback__)  # with the user's line
            raise error
        finally:
            stepping.active = was_stepping
            stepping.dropped = 0
        self._work = None
        return _OVER


NO_LOOP = 'a sequence waits for a time with `await dwell("2 s")`, for a condition with `await until(...)`'
"""Advice for an await of an asyncio object."""

_OVER = object()  # marks the end of the coroutine
_UNSEEN = -1  # no masked word


def _close(work: Coroutine[Any, Any, object]) -> None:
    """Close a coroutine; ignore an await that keeps it from ending."""
    try:
        work.close()
    except RuntimeError:
        if getattr(work, "cr_frame", None) is None:
            raise  # raised by its own code; a coroutine that swallows its end is abandoned


def _located(frame: FrameType | None, error: Exception) -> Exception:
    """Return an error with a traceback to a frame, so that the fault names the user's line."""
    if frame is None:
        return error
    return error.with_traceback(TracebackType(None, frame, frame.f_lasti, frame.f_lineno))
