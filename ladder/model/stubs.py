"""Stubs: replacements for instructions, results of messages, and partners of consumed tags.

| text | effect |
|---|---|
| `done after 20 ms` | EN with the rung, DN after the time; a message ends the same way |
| `error 16#00CB after 20 ms` | EN with the rung, ER and the code after the time |
| `waits` | EN with the rung only; a message ends when its TO bit is set |
| `false`, `true` | the power after the instruction |
| `plant.py:xrp` | a Python function replaces the instruction; only in `[stubs]` of a rack file |

STUB MSG : done after 20 ms                     // every message
STUB Order : error 16#00CB after 1000 ms        // the message of this tag
STUB ALMD : false                               // every ALMD

A rack file can also define the reply of a message and the data of a consumed tag: a constant, a table over
time, or a tag of another rack. Each is a `DataSource`. Its data depend only on time, so any scan can be
repeated.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any, NamedTuple, Protocol

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.times import TIME, parse_time, time_text

from .errors import LadderError

ALL_MESSAGES = "MSG"
"""Name of the default stub of messages."""

NEVER_STUBBED = frozenset({"JMP", "LBL", "JSR", "SBR", "RET", "TND", "MCR", "FOR", "BRK"})
"""Instructions that control the order of execution, so no stub can replace them."""

_TEXT = re.compile(
    rf"(?:done|error\s+(?:16#(?P<hex>[0-9A-F]{{1,4}})|(?P<code>\d{{1,5}})))\s+after\s+(?P<time>{TIME})",
    re.IGNORECASE,
)
_POWER = {"FALSE": False, "TRUE": True}


class Sample(NamedTuple):
    """One update from a partner."""

    value: Any  # as `Tags` returns values; None if nothing is new
    running: bool = True  # whether the producer is in run mode
    faulted: bool = False  # whether the connection is broken


Sampler = Callable[[int], Sample]
"""Returns the sample at a time, ns."""


class DataSource(Protocol):
    """Source of data: a constant, a table, or a tag of another rack."""

    def open(self, tag: str, rpi_ns: int) -> Sampler:
        """Return a function that returns the samples.

        Args:
            tag: tag of the other rack, unless the source specifies a tag.
            rpi_ns: interval of the samples.

        Raises:
            LadderError: the other rack has no such tag.
        """

    def __str__(self) -> str: ...


@dataclass(frozen=True, slots=True)
class Ending:
    """The result of a message or of another instruction that takes time."""

    after_ns: int  # NEVER if it does not end
    error: int = 0  # 0 for success, else its ERR, 1 to 65,535
    reply: DataSource | None = None  # the data of a message that is done
    to: str = ""  # tag that gets the data, "" for the tag in the export

    def __str__(self) -> str:
        if self.after_ns >= NEVER:
            return "waits"
        result = f"error 16#{self.error:04X}" if self.error else "done"
        after = f"{result} after {time_text(self.after_ns)}"
        return after if self.reply is None else f"{after} with {self.reply}"


@dataclass(frozen=True, slots=True)
class Partner:
    """The partner of a consumed tag."""

    source: DataSource
    rpi_ns: int = 0  # 0 for the interval in the export, or `RPI_NS` without one

    def __str__(self) -> str:
        return str(self.source)


NEVER = 1 << 62
"""Time of an instruction that does not end, ns."""

RPI_NS = 20_000_000
"""Default interval of a consumed tag, ns."""


@dataclass(frozen=True, slots=True)
class Remote:
    """The connection of a consumed tag, or the destination of a message, from an export."""

    tag: str = ""  # tag of the producer; for a message, the local tag that gets its data
    rpi_ns: int = 0


@dataclass(frozen=True, slots=True)
class Power:
    """A stub that makes an instruction do nothing; `after` is the power after it on a true rung."""

    after: bool

    def __str__(self) -> str:
        return str(self.after).lower()


@dataclass(frozen=True, slots=True)
class InPython:
    """A Python function that replaces an instruction.

    It is called in every scan as `f(tags, rung, *operands)`: the tags of the program, the rung condition, and
    the operands as numbers, characters or `Argument`. A result other than None becomes the rung condition
    after the instruction.
    """

    address: str  # `path:function`
    function: Callable[..., Any] = field(compare=False)

    def __str__(self) -> str:
        return self.address


Stub = Ending | Power | InPython | Partner


@dataclass(frozen=True, slots=True)
class Stubs:
    """The stubs in a rack file for its program."""

    by_name: Mapping[str, Stub] = field(default_factory=dict)  # by instruction or message tag, in capitals
    missing_tags: bool = False  # whether undeclared tags are declared by their use
    refused: bool = False  # whether an export runs although parts are refused; these parts do nothing
    modules: Mapping[int, ModuleWords] = field(default_factory=dict)  # words of the rack's modules by slot


NO_STUBS = Stubs()


def parse_stub(text: str) -> Ending | Power:
    """Read a stub that is not a Python function.

    >>> str(parse_stub("done after 20 ms")), str(parse_stub("error 203 after 0.5 ms")), parse_stub("false")
    ('done after 20 ms', 'error 16#00CB after 500 µs', Power(after=False))
    """
    power = _POWER.get(text.strip().upper())
    if power is not None:
        return Power(power)
    if text.strip().lower() == "waits":
        return Ending(NEVER)
    match = _TEXT.fullmatch(text.strip())
    error = 0 if match is None else int(match["hex"] or "0", 16) or int(match["code"] or 0)
    if match is None or error > 0xFFFF or ("error" in text.lower() and not error):
        raise LadderError(
            f"{text!r} is not a stub; write 'done after 20 ms', 'error 16#00CB after 20 ms' with a code up "
            "to 16#FFFF, 'waits', 'false', 'true' or, in a rack file, a function as in 'plant.py:xrp'"
        )
    try:
        return Ending(parse_time(match["time"].lower()), error)
    except ValueError as reason:
        raise LadderError(str(reason)) from None


def check_stubbed(name: str) -> None:
    """Raise a LadderError if no stub can replace an instruction, given by its name in capitals."""
    if name in NEVER_STUBBED:
        raise LadderError(f"{name} decides what runs next, so no stub can replace it")


def stub_of(stubs: Mapping[str, Stub], path: str) -> Ending | None:
    """Return the result of a message from stubs by name in capitals; None if it has no stub."""
    stub = stubs.get(path.upper()) or stubs.get(ALL_MESSAGES)
    return stub if isinstance(stub, Ending) else None


def replaces(stubs: Mapping[str, Stub], name: str) -> Stub | None:
    """Return the stub that replaces an instruction, given by its name in capitals, or None."""
    stub = stubs.get(name)
    is_message = name == ALL_MESSAGES and isinstance(stub, Ending)
    return None if is_message or isinstance(stub, Partner) else stub
