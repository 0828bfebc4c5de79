"""The lines that ran in a scan of a program without rungs, with the values before each line."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from enum import Enum
from functools import cache, lru_cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

from scanrack.jobs.record.logic_wrapper import unwrapped
from scanrack.jobs.record.sequence_watch import sequences_in, wait_of
from scanrack.jobs.record.tag_names import named_values, namespace_of
from scanrack.jobs.replay.input_replay import InputReplay
from scanrack.ladder.files.steps import Steps
from scanrack.ladder.model.tree import Origin
from scanrack.ladder.python.line_marks import Observer
from scanrack.runtime.loop.faults import is_the_users
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.watch.history.watched_python import MOST
from typing_extensions import override

from .variables import BareText

DEEPEST, MOST_ITEMS = 3, 100
"""Maximum nesting depth of a copied value, and maximum number of items per level."""


class TextLine(NamedTuple):
    """A line of a program, with the part of a rung's interface that `cursor` and `places` use."""

    number: int
    origin: Origin


class TextRun(NamedTuple):
    """A line that ran."""

    routine: str  # name of its file
    line: TextLine
    name: str  # of its function
    values: Mapping[str, Any]  # local values before the line
    caller: TextCaller | None = None


class TextCaller(NamedTuple):
    """The line that called or is awaiting a function."""

    run: TextRun


class TextState(NamedTuple):
    """The values of a program at a place in a scan."""

    values: Mapping[str, Any]
    waits: Mapping[str, str]  # of sequences, and of a list of steps


class ProgramValues(Mapping[str, Any]):
    """The current values of a program, by name; empty for a list of steps."""

    def __init__(self, logic: Callable[[], ScanLogic]) -> None:
        self._logic = logic

    def _namespace(self) -> dict[str, Any]:
        logic: Any = unwrapped(self._logic())
        return {} if isinstance(logic, Steps) else namespace_of(logic)

    def __getitem__(self, name: str) -> Any:
        try:
            value = eval(_code(name), self._namespace())
        except Exception as error:  # the user's property may raise anything
            raise KeyError(name) from error
        return value.name if isinstance(value, Enum) else value

    def copies(self, names: Iterable[str]) -> dict[str, Any]:
        """Return copies of the values that exist now."""
        namespace, values = self._namespace(), dict[str, Any]()
        for name in names:
            with suppress(Exception):  # the user's property may raise anything
                values[name] = copied(eval(_code(name), namespace))
        return values

    def __iter__(self) -> Iterator[str]:
        try:
            return iter([value.name for value in named_values(self._namespace(), ["*"])[:MOST]])
        except ValueError:
            return iter(())

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        # only dotted names, since `self[name]` evaluates any expression
        if not isinstance(name, str) or not all(part.isidentifier() for part in name.split(".")):
            return False
        try:
            self[name]
        except KeyError:
            return False
        return True


@lru_cache(maxsize=4096)
def _code(name: str) -> CodeType:
    return compile(name, "<value>", "eval")


def copied(value: object, depth: int = DEEPEST) -> Any:
    """Return a copy of a value; anything but plain values, lists and dicts becomes text."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, bool | int | float | str | None):
        return value
    if depth and isinstance(value, list | tuple | set | frozenset):
        return [copied(item, depth - 1) for item in list(value)[:MOST_ITEMS]]
    if depth and isinstance(value, dict):
        return {str(key): copied(item, depth - 1) for key, item in list(value.items())[:MOST_ITEMS]}
    try:
        return repr(value)[:200]
    except Exception as error:  # the user's repr may raise anything
        return f"<{type(value).__name__}: {error}>"


class Capture(Observer):
    """A recorder of the lines of a scan, and of the values before each line."""

    def __init__(self, logic: ScanLogic) -> None:
        self.lines = None
        self._logic, self._values = logic, ProgramValues(lambda: logic)
        self._names = list(self._values)
        self.runs: list[tuple[TextRun, int, TextState]] = []

    @override
    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        above = [] if frame is None else list(_callers(frame))
        step = TextRun(file, TextLine(line, Origin(file, line)), "step", {})
        run = step if frame is None else self._run(frame, above)
        self.runs.append((run, len(above), self.state()))

    def _run(self, frame: FrameType, above: list[FrameType]) -> TextRun:
        """Return the line that a frame is about to run, with copies of its values and with its callers."""
        local_values = {
            name: copied(value) for name, value in frame.f_locals.items() if value is not self._logic
        }
        caller = TextCaller(self._run(above[0], above[1:])) if above else None
        path, line = frame.f_code.co_filename, frame.f_lineno
        return TextRun(
            Path(path).name, TextLine(line, Origin(path, line)), frame.f_code.co_name, local_values, caller
        )

    def state(self) -> TextState:
        """Return the current values."""
        return TextState(self._values.copies(self._names), waits_of(self._logic))


_is_own = cache(is_the_users)


def _callers(frame: FrameType) -> Iterator[FrameType]:
    """Yield the frames of the user's files that called or awaited a frame, innermost first."""
    above = frame.f_back
    outermost = (
        InputReplay.run_logic.__code__
    )  # outside of it, only code that uses the program, such as a test
    while above is not None and above.f_code is not outermost:
        if _is_own(above.f_code.co_filename):
            yield above
        above = above.f_back


def waits_of(logic: ScanLogic) -> Mapping[str, str]:
    """Return the line and the condition at which each sequence is waiting, by sequence name."""
    inside: Any = unwrapped(logic)
    if isinstance(inside, Steps):
        return {"step": BareText(f"line {inside.line}")}
    steps = {sequence.name: wait_of(sequence, 0) for sequence in sequences_in(inside)}
    return {
        name: BareText(f"line {step.line}: {step.wait}" if step.wait else "over")
        for name, step in steps.items()
    }
