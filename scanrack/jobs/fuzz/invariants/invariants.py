"""Invariants: conditions that are checked in every scan. A condition is a small function of a snapshot."""

from __future__ import annotations

import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from scanrack.io_images.annotations import signature_of
from scanrack.io_images.times import parse_duration, time_text

from ...load.modules_beside import find_beside
from .condition_reads import ConditionReads, reads_of
from .scan_view import Snapshot

FOREVER_NS = 1 << 62
"""An instant after the end of any run."""

Condition = Callable[[Snapshot], Any]
"""A condition on a snapshot. Its result is interpreted as true or false."""

Watch = Callable[[Snapshot], str | None]
"""Checks every scan of one run; returns a sentence about the violation, or None.

Optional attributes of a watch:

applied         whether it has had something to check
waiting         whether its clock is running
origin_scan     the scan of the cause, if a violation is detected later
same_until_ns   method that returns the instant before which the result stays the same if only the time
                changes. If its argument is true, the counts of timers change as well. A watch without this
                method is called in every scan.
"""


class InvariantError(ValueError):
    """An invariant can't be loaded, or raised an exception. The message has its name, file and line."""


@dataclass(frozen=True, slots=True)
class Invariant:
    """A requirement on every run, or a goal of the search, which can't be broken (see `goals`).

    Attributes:
        sentence: description for the user.
        start: returns a new watch for one run.
    """

    name: str
    sentence: str
    start: Callable[[], Watch]
    is_goal: bool = False


def always(condition: Condition) -> Invariant:
    """Return an invariant with a condition that must be true in every scan. Its docstring describes it."""
    return _every_scan(condition, expected=True)


def never(condition: Condition) -> Invariant:
    """Return an invariant with a condition that must be false in every scan. Its docstring describes it."""
    return _every_scan(condition, expected=False)


def eventually(
    limit: str, *, after: Condition, while_resting: bool = False
) -> Callable[[Condition], Invariant]:
    """Return a decorator for a condition that must become true within a time limit.

    A scan in which `after` is true starts the clock if it is not running. A scan in which the condition is
    true stops it. The clock pauses in program mode, since the CPU does not call the program then.

    Args:
        limit: machine time with a unit, such as "5 s".
        after: condition that starts the clock.
        while_resting: also run the clock in program mode, for reactions of the machine itself.

    Raises:
        ValueError: `limit` is not a time, or the condition does not accept one argument.
    """
    limit_ns = parse_duration(limit)

    def make(condition: Condition) -> Invariant:
        """Return the invariant for the decorated condition."""
        _check(condition)
        return Invariant(
            _name(condition),
            _sentence(condition),
            lambda: _Eventually(condition, after, limit_ns, while_resting=while_resting),
        )

    return make


class _Eventually:
    """Watches a run for a condition that must become true within a time limit."""

    def __init__(self, condition: Condition, after: Condition, limit_ns: int, *, while_resting: bool) -> None:
        self._condition, self._after, self._limit_ns = condition, after, limit_ns
        self._while_resting = while_resting
        self._start_ns: int | None = None  # None = the clock is not running
        self._paused_ns = 0  # pauses since the start of the clock
        self._last_ns = 0  # time of the previous scan
        self.origin_scan = 0
        self.applied = False

    def __call__(self, now: Snapshot) -> str | None:
        """Start, stop or pause the clock; return a sentence if it exceeds the time limit, else None."""
        step_ns, self._last_ns = now.ns - self._last_ns, now.ns
        if evaluate(self._condition, now):
            self._start_ns = None
            self.applied = self.applied or bool(evaluate(self._after, now))
        elif self._start_ns is None:
            if evaluate(self._after, now):
                self._start_clock(now)
        elif now.resting and not self._while_resting:
            self._paused_ns += step_ns
        elif now.ns - self._start_ns - self._paused_ns > self._limit_ns:
            return self._violation(now.ns - self._start_ns - self._paused_ns, self._start_ns)
        return None

    @property
    def waiting(self) -> bool:
        """Whether the clock is running."""
        return self._start_ns is not None

    def same_until_ns(self, counting: bool) -> int:
        """See `Watch`."""
        until_ns = min(same_until_ns(condition, counting) for condition in (self._condition, self._after))
        if self._start_ns is None:
            return until_ns
        return min(until_ns, self._start_ns + self._paused_ns + self._limit_ns)

    def _start_clock(self, now: Snapshot) -> None:
        self._start_ns, self._paused_ns, self.origin_scan = now.ns, 0, now.scan
        self.applied = True

    def _violation(self, clock_ns: int, start_ns: int) -> str:
        paused = f", {time_text(self._paused_ns)} in program mode not counted" if self._paused_ns else ""
        return f"still false {time_text(clock_ns)} after {time_text(start_ns)}{paused}"


def _every_scan(condition: Condition, *, expected: bool) -> Invariant:
    """Return an invariant whose condition must have the expected value in every scan."""
    _check(condition)
    return Invariant(_name(condition), _sentence(condition), lambda: _EveryScan(condition, expected=expected))


class _EveryScan:
    """Watches a run for a scan in which a condition has the wrong value."""

    __slots__ = ("_condition", "_expected")

    def __init__(self, condition: Condition, *, expected: bool) -> None:
        self._condition, self._expected = condition, expected

    def __call__(self, now: Snapshot) -> str | None:
        if bool(evaluate(self._condition, now)) is self._expected:
            return None
        return f"the condition is {'false' if self._expected else 'true'}"

    def same_until_ns(self, counting: bool) -> int:
        """See `Watch`."""
        return same_until_ns(self._condition, counting)


def same_until_ns(condition: Condition, counting: bool) -> int:
    """Return the instant before which a condition's result can't change, see `Watch`; `FOREVER_NS` or 0."""
    reads = reads_of(condition)
    is_same = reads is ConditionReads.IMAGES_AND_TAGS or (reads is ConditionReads.COUNTS and not counting)
    return FOREVER_NS if is_same else 0


def _check(condition: Condition) -> None:
    """Check that a condition accepts one argument.

    Raises:
        InvariantError: the condition is not a function of one argument.
    """
    try:
        signature_of(condition).bind(None)
    except TypeError as error:
        raise InvariantError(f"{_name(condition)} must accept one argument, the snapshot: {error}") from None


def _name(condition: Condition) -> str:
    return str(getattr(condition, "__name__", "condition"))


def _sentence(condition: Condition) -> str:
    return inspect.getdoc(condition) or _name(condition).replace("_", " ")


def evaluate(condition: Condition, now: Snapshot) -> Any:
    """Evaluate a user's condition.

    Raises:
        InvariantError: the condition raised an exception.
    """
    try:
        return condition(now)
    except (Exception, SystemExit) as error:
        frames = list(traceback.extract_tb(error.__traceback__))
        frames = frames[1:] or frames  # without the frame of this function
        last_frame = [frame for frame in frames if frame.filename == frames[0].filename][-1]
        problem = f"{type(error).__name__}: {error}{_hint(error)}"
        place = f"{last_frame.filename}:{last_frame.lineno}"
        raise InvariantError(
            f"invariant {_name(condition)} raised at {now.seconds:g} s: {problem} [{place}]"
        ) from error


def _hint(error: BaseException) -> str:
    """Return a hint with the closest attribute name, or an empty text."""
    if not isinstance(error, AttributeError) or error.obj is None:
        return ""
    close_names = get_close_matches(str(error.name), dir(error.obj), n=1)
    return f"; did you mean {close_names[0]}?" if close_names else ""


def load_invariants(path: Path | str) -> list[Invariant]:
    """Load the invariants of a Python file, in order of definition.

    Raises:
        InvariantError: the file can't be read or run, or defines no invariant.
    """
    path = Path(path)
    if not path.is_file():
        raise InvariantError(f"{path}: no such file with invariants")
    spec = importlib.util.spec_from_file_location(f"scanrack_invariants_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InvariantError(f"{path}: invariants must be in a Python file (.py)")
    module = importlib.util.module_from_spec(find_beside(path, spec))
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise _loading_error(path, error) from error
    invariants = [value for value in vars(module).values() if isinstance(value, Invariant)]
    if not invariants:
        raise InvariantError(
            f"{path}: defines no invariant; decorate a function with @always, @never or @eventually"
        )
    return invariants


def _loading_error(path: Path, error: BaseException) -> InvariantError:
    """Return the error with file and line for a file that raised an exception."""
    frames = traceback.extract_tb(error.__traceback__)
    line = next((frame.lineno for frame in reversed(frames) if frame.filename == str(path)), 1)
    problem = error if isinstance(error, InvariantError) else f"{type(error).__name__}: {error}"
    return InvariantError(f"{path}:{line}: {problem}")
