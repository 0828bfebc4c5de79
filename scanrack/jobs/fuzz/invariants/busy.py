"""Finds commands that stay in progress while their axis rests for a second with a working link.

Homing may rest longer: two seconds on an end limit. A follower may rest while its encoder does. A blend is
programmed at rest, in phases; each phase restarts the second. If a round trip takes more than a third of a
second, the limit is three round trips.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from scanrack.io_images.amci3601.bits import StatusLsw, StatusMsw
from scanrack.io_images.times import LONGEST_NS, time_text
from scanrack.ladder.python.axis3601 import Axis3601
from scanrack.ladder.python.axis3601.evidence import HOME_REST_NS
from scanrack.ladder.python.axis3601.kinds import GEAR, HOME
from scanrack.ladder.python.sequences import Logic, parts_of
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import LoweredProgram
from scanrack.runtime.loop.scan import ScanLogic

from ...record.logic_wrapper import unwrapped
from ..last_program import remember_last


class NamedTags(Protocol):
    """The tags of a program, by name."""

    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __getitem__(self, name: str, /) -> Any: ...


SECOND_NS = 1_000_000_000

SEARCH, FOLLOWER = 4, 10
"""Kinds of commands in the motion blocks, see `axis3601.rung`."""


@dataclass(frozen=True, slots=True)
class BusyCommand:
    """A command in progress."""

    text: object  # the command's name, or an object whose string is the name
    rests: bool  # whether its axis rests, and answers
    phase: int  # changes when the command makes progress at rest
    limit_ns: int


Question = Callable[[], BusyCommand | None]
"""Returns the command of an axis that is in progress, or None."""


def axes_in(logic: ScanLogic, tags: NamedTags) -> tuple[Question, ...]:
    """Return a function for each axis of a program: of Python axes, and of motion blocks."""
    program = unwrapped(logic)
    parts = parts_of(program) if isinstance(program, Logic) else ()
    axes = [_of_python(part) for part in parts if isinstance(part, Axis3601)]
    if isinstance(program, Engine):
        names = _block_axes(program.lowered)
    else:
        names = tuple(name for name in tags if f"{name}.RunKind" in tags)
    return (*axes, *(_of_blocks(tags, name) for name in names))


@remember_last
def _block_axes(lowered: LoweredProgram) -> tuple[str, ...]:
    """Return the names of the tags that are axes of motion blocks."""
    leaves, tags = lowered.layout.leaves, lowered.layout.tags().values()
    return tuple(tag.name for tag in tags if not tag.dims and f"{tag.name}.RunKind".upper() in leaves)


def _of_python(axis: Axis3601) -> Question:
    def ask() -> BusyCommand | None:
        command = axis.commanded
        if command is None or not command.busy:
            return None
        idle = axis.status.MODULE_OK and not axis.moving
        rests = idle and not (command.kind is GEAR and axis.status.ENC_FOLLOWER)
        return BusyCommand(command, rests, axis.phase, _limit_ns(axis.trip_ns, searches=command.kind is HOME))

    return ask


def _of_blocks(tags: NamedTags, name: str) -> Question:
    def ask() -> BusyCommand | None:
        step = tags[f"{name}.Step"]
        if not step and tags[f"{name}.Ticket"] == tags[f"{name}.Taken"]:
            return None
        kind = tags[f"{name}.RunKind"]
        msw, lsw = tags[f"{name}.In[0]"], tags[f"{name}.In[1]"]
        idle = msw & StatusMsw.MODULE_OK.value and not tags[f"{name}.Moving"]
        rests = bool(idle) and not (kind == FOLLOWER and lsw & StatusLsw.ENC_FOLLOWER.value)
        limit_ns = _limit_ns(1_000_000 * tags[f"{name}.RoundTrip"], searches=kind == SEARCH)
        return BusyCommand(f"{name}, kind {kind}, step {step}", rests, tags[f"{name}.Out[1]"], limit_ns)

    return ask


def _limit_ns(trip_ns: int, *, searches: bool) -> int:
    return max(SECOND_NS, 3 * trip_ns) + HOME_REST_NS * searches


class RestMeter:
    """Measures how long the axes of a program rest during a command."""

    def __init__(self, axes: Iterable[Question]) -> None:
        self._axes = [_Rest(axis) for axis in axes]

    def too_long(self, now_ns: int, *, linked: bool) -> str | None:
        """Update the measurement; return a sentence about a command that rests for too long, or None."""
        violations = [axis.too_long(now_ns, linked=linked) for axis in self._axes]
        return next(filter(None, violations), None)

    @property
    def same_until_ns(self) -> int:
        """The instant until which no rest is too long, even if its command makes no progress, ns."""
        return min((axis.until_ns for axis in self._axes), default=LONGEST_NS)


class _Rest:
    """The rest of one axis."""

    def __init__(self, ask: Question) -> None:
        self._ask = ask
        self._since_ns: int | None = None
        self._phase = 0
        self.until_ns = LONGEST_NS

    def too_long(self, now_ns: int, *, linked: bool) -> str | None:
        busy = self._ask()
        if busy is None or not busy.rests or not linked or busy.phase != self._phase:
            self._since_ns = None
        elif self._since_ns is None:
            self._since_ns = now_ns
        self._phase = busy.phase if busy is not None else 0
        self.until_ns = LONGEST_NS
        if busy is None or self._since_ns is None:
            return None
        self.until_ns = self._since_ns + busy.limit_ns
        if now_ns <= self.until_ns:
            return None
        return f"{busy.text} is busy, and its axis has rested for {time_text(now_ns - self._since_ns)}"
