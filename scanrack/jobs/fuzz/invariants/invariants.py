"""Invariants: conditions that are checked in every scan, as small functions of a snapshot."""

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
"""A condition of a snapshot; its answer counts as true or false."""

Watch = Callable[[Snapshot], str | None]
"""Checks every scan of one run; returns the violation, or None.

Attributes that a watch may have:

applied         whether it has had something to check
waiting         whether its clock is running
origin_scan     the scan of the cause, if a violation is detected later
same_until_ns   a method: the instant until which its answer stays the same if only the time changes, and also
                the counts of timers if its argument is true. A watch without it is called in every scan.
"""


class InvariantError(ValueError):
    """An invariant can't be loaded, or raised an exception; the message has its name, file and line."""


@dataclass(frozen=True, slots=True)
class Invariant:
    """A condition that must hold, or a goal, which can't be broken; see `goals`."""

    name: str
    sentence: str
    start: Callable[[], Watch]
    is_goal: bool = False


def always(condition: Condition) -> Invariant:
    """Make an invariant of a condition that must be true in every scan; its docstring is the sentence."""
    return _single(condition, expected=True)


def never(condition: Condition) -> Invariant:
    """Make an invariant of a condition that must be false in every scan; its docstring is the sentence."""
    return _single(condition, expected=False)


def eventually(
    limit: str, *, after: Condition, while_resting: bool = False
) -> Callable[[Condition], Invariant]:
    """Make an invariant of a condition that must come true in time.

    The clock starts in a scan in which `after` is true, unless it is already running, and stops in a scan in
    which the condition is true. It pauses while the logic rests (program mode): a program that is not called
    can't act.

    Args:
        limit: machine time with a unit, such as "5 s".
        after: condition that starts the clock.
        while_resting: also run the clock in program mode, for reactions of the machine itself.

    Raises:
        ValueError: `limit` is not a time, or the condition does not accept one argument.
    """
    limit_ns = parse_duration(limit)

    def make(condition: Condition) -> Invariant:
        _check(condition)
        return Invariant(
            _name(condition),
            _sentence(condition),
            lambda: _Eventually(condition, after, limit_ns, while_resting=while_resting),
        )

    return make


class _Eventually:
    """Watches a run for a condition that must come true in time."""

    def __init__(self, condition: Condition, after: Condition, limit_ns: int, *, while_resting: bool) -> None:
        self._condition, self._after, self._limit_ns = condition, after, limit_ns
        self._while_resting = while_resting
        self._since_ns: int | None = None
        self._paused_ns = 0
        self._last_ns = 0
        self.origin_scan = 0
        self.applied = False

    def __call__(self, now: Snapshot) -> str | None:
        step_ns, self._last_ns = now.ns - self._last_ns, now.ns
        if answer(self._condition, now):
            self._since_ns = None
            self.applied = self.applied or bool(answer(self._after, now))
        elif self._since_ns is None:
            if answer(self._after, now):
                self._start(now)
        elif now.resting and not self._while_resting:
            self._paused_ns += step_ns
        elif now.ns - self._since_ns - self._paused_ns > self._limit_ns:
            return self._why(now.ns - self._since_ns - self._paused_ns, self._since_ns)
        return None

    @property
    def waiting(self) -> bool:
        """Whether the clock is running."""
        return self._since_ns is not None

    def same_until_ns(self, counting: bool) -> int:
        """See `Watch`."""
        least = min(same_until_ns(condition, counting) for condition in (self._condition, self._after))
        return (
            least if self._since_ns is None else min(least, self._since_ns + self._paused_ns + self._limit_ns)
        )

    def _start(self, now: Snapshot) -> None:
        self._since_ns, self._paused_ns, self.origin_scan = now.ns, 0, now.scan
        self.applied = True

    def _why(self, ran_ns: int, since_ns: int) -> str:
        paused = f", {time_text(self._paused_ns)} in program mode not counted" if self._paused_ns else ""
        return f"{time_text(ran_ns)} after scan time {time_text(since_ns)} it has not come true{paused}"


def _single(condition: Condition, *, expected: bool) -> Invariant:
    _check(condition)
    return Invariant(_name(condition), _sentence(condition), lambda: _Single(condition, expected=expected))


class _Single:
    """Watches a run for a scan in which a condition has the wrong value."""

    __slots__ = ("_condition", "_expected")

    def __init__(self, condition: Condition, *, expected: bool) -> None:
        self._condition, self._expected = condition, expected

    def __call__(self, now: Snapshot) -> str | None:
        if bool(answer(self._condition, now)) is self._expected:
            return None
        return f"it is {'false' if self._expected else 'true'}"

    def same_until_ns(self, counting: bool) -> int:
        """See `Watch`."""
        return same_until_ns(self._condition, counting)


def same_until_ns(condition: Condition, counting: bool) -> int:
    """Return the time until which a condition has the same answer, see `Watch`: forever, or not at all."""
    reads = reads_of(condition)
    return (
        FOREVER_NS
        if reads is ConditionReads.IMAGES_AND_TAGS or (reads is ConditionReads.COUNTS and not counting)
        else 0
    )


def _check(condition: Condition) -> None:
    """Check that a condition accepts a snapshot.

    Raises:
        InvariantError: the condition is not a function of one argument.
    """
    try:
        signature_of(condition).bind(None)
    except TypeError as error:
        raise InvariantError(f"{_name(condition)} has to take one argument, the snapshot: {error}") from None


def _name(condition: Condition) -> str:
    return str(getattr(condition, "__name__", "condition"))


def _sentence(condition: Condition) -> str:
    return inspect.getdoc(condition) or _name(condition).replace("_", " ")


def answer(condition: Condition, now: Snapshot) -> Any:
    """Evaluate a user's condition; turn an exception into an InvariantError with its place."""
    try:
        return condition(now)
    except (Exception, SystemExit) as error:
        steps = traceback.extract_tb(error.__traceback__)[1:] or traceback.extract_tb(error.__traceback__)
        step = [frame for frame in steps if frame.filename == steps[0].filename][-1]
        problem = f"{type(error).__name__}: {error}{_hint(error)}"
        where = f"{step.filename}:{step.lineno}"
        says = f"invariant {_name(condition)} raised at {now.seconds:g} s: {problem} [{where}]"
        raise InvariantError(says) from error


def _hint(error: BaseException) -> str:
    """Return a hint with the closest name."""
    if not isinstance(error, AttributeError) or error.obj is None:
        return ""
    close = get_close_matches(str(error.name), dir(error.obj), n=1)
    return f"; did you mean {close[0]}?" if close else ""


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
        raise InvariantError(f"{path}: invariants are in a Python file (.py)")
    module = importlib.util.module_from_spec(find_beside(path, spec))
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise _not_loaded(path, error) from error
    invariants = [value for value in vars(module).values() if isinstance(value, Invariant)]
    if not invariants:
        raise InvariantError(
            f"{path}: it defines no invariant; write functions under @always, @never, @eventually"
        )
    return invariants


def _not_loaded(path: Path, error: BaseException) -> InvariantError:
    """Return the error for a file that raised an exception, with the line."""
    steps = traceback.extract_tb(error.__traceback__)
    line = next((step.lineno for step in reversed(steps) if step.filename == str(path)), 1)
    problem = error if isinstance(error, InvariantError) else f"{type(error).__name__}: {error}"
    return InvariantError(f"{path}:{line}: {problem}")
