"""Finds commands in progress whose axis is at rest for over a second with a working link.

Homing can rest two seconds longer on an end limit. A follower can rest while its encoder rests. A blend is
programmed at rest in phases, and each phase restarts the measurement. If a round trip takes more than a third
of a second, the limit is three round trips.
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

    text: object  # the command's name, or an object with this string
    rests: bool  # whether its axis rests and responds
    phase: int  # changes with the command's progress at rest
    limit_ns: int  # maximum duration of a rest


BusyReader = Callable[[], BusyCommand | None]
"""Returns the command in progress on an axis, or None."""


def axes_in(logic: ScanLogic, tags: NamedTags) -> tuple[BusyReader, ...]:
    """Return a reader for each axis of a program. An axis is a Python object or a tag of motion blocks."""
    program = unwrapped(logic)
    parts = parts_of(program) if isinstance(program, Logic) else ()
    axes = [_python_reader(part) for part in parts if isinstance(part, Axis3601)]
    if isinstance(program, Engine):
        names = _block_axes(program.lowered)
    else:
        names = tuple(name for name in tags if f"{name}.RunKind" in tags)
    return (*axes, *(_block_reader(tags, name) for name in names))


@remember_last
def _block_axes(lowered: LoweredProgram) -> tuple[str, ...]:
    """Return the names of the tags that are axes of motion blocks."""
    leaves, tags = lowered.layout.leaves, lowered.layout.tags().values()
    return tuple(tag.name for tag in tags if not tag.dims and f"{tag.name}.RunKind".upper() in leaves)


def _python_reader(axis: Axis3601) -> BusyReader:
    """Return a reader of the command in progress on an axis object."""

    def read() -> BusyCommand | None:
        command = axis.commanded
        if command is None or not command.busy:
            return None
        is_idle = axis.status.MODULE_OK and not axis.moving
        rests = is_idle and not (command.kind is GEAR and axis.status.ENC_FOLLOWER)
        limit_ns = _limit_ns(axis.trip_ns, is_homing=command.kind is HOME)
        return BusyCommand(command, rests, phase=axis.phase, limit_ns=limit_ns)

    return read


def _block_reader(tags: NamedTags, name: str) -> BusyReader:
    """Return a reader of the command in progress on an axis of motion blocks, from the tags of the axis."""

    def read() -> BusyCommand | None:
        step = tags[f"{name}.Step"]
        if not step and tags[f"{name}.Ticket"] == tags[f"{name}.Taken"]:
            return None
        kind = tags[f"{name}.RunKind"]
        msw, lsw = tags[f"{name}.In[0]"], tags[f"{name}.In[1]"]
        is_idle = msw & StatusMsw.MODULE_OK.value and not tags[f"{name}.Moving"]
        rests = bool(is_idle) and not (kind == FOLLOWER and lsw & StatusLsw.ENC_FOLLOWER.value)
        limit_ns = _limit_ns(1_000_000 * tags[f"{name}.RoundTrip"], is_homing=kind == SEARCH)
        text = f"{name}, kind {kind}, step {step}"
        return BusyCommand(text, rests, phase=tags[f"{name}.Out[1]"], limit_ns=limit_ns)

    return read


def _limit_ns(trip_ns: int, *, is_homing: bool) -> int:
    return max(SECOND_NS, 3 * trip_ns) + HOME_REST_NS * is_homing


class RestMeter:
    """Measures how long the axes of a program are at rest during a command."""

    def __init__(self, axes: Iterable[BusyReader]) -> None:
        self._rests = [_Rest(axis) for axis in axes]

    def update(self, now_ns: int, *, linked: bool) -> str | None:
        """Update the measurement; return a sentence about a command that rests for too long, or None."""
        violations = [rest.update(now_ns, linked=linked) for rest in self._rests]
        return next(filter(None, violations), None)

    @property
    def same_until_ns(self) -> int:
        """The instant before which no rest can be too long, even if no command makes progress, ns."""
        return min((rest.until_ns for rest in self._rests), default=LONGEST_NS)


class _Rest:
    """Measures how long one axis is at rest.

    Attributes:
        until_ns: the instant before which the rest is not too long, ns.
    """

    def __init__(self, read_busy: BusyReader) -> None:
        self._read_busy = read_busy
        self._since_ns: int | None = None  # beginning of the rest
        self._phase = 0
        self.until_ns = LONGEST_NS

    def update(self, now_ns: int, *, linked: bool) -> str | None:
        """Update the measurement; return a sentence if the rest is too long, or None."""
        busy = self._read_busy()
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
