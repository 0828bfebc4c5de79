"""Facts that a reader finds in a program's text, in any language."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple


class FileLine(NamedTuple):
    """A line of a file, from 1."""

    file: str
    line: int


@dataclass(frozen=True, slots=True)
class Remark:
    """A part of the program that breaks a rule by itself."""

    place: FileLine
    text: str


@dataclass(frozen=True, slots=True)
class SentCommand:
    """Output words, or a command, that the program sends to a 3601."""

    place: FileLine
    slot: int | None  # None if it is unknown
    words: tuple[int, ...] = ()  # the eight output words; empty without effect on the rules


UsesBit = Callable[[int, str, str, int, int], bool]
"""Whether a program uses a bit of a card: slot, image "I" or "O", name, word, bit."""


@dataclass(slots=True)
class Facts:
    """Facts of a program.

    Attributes:
        repeated: bits with several coils.
        unused: tags that no instruction names.
        held: command bits that it sets and never clears.
        out_of_range: constants that a 3601 refuses.
        misplaced: inputs, outputs and axes missing in the rack or claimed twice.
        endless: loops of sequences that never wait.
        unreached: steps of charts that no path leads to.
        misused: calls that fail when they are reached.
        uses_bit: tests whether it uses a bit of a card; None if that is unknown.
        not_seen: sentences about facts that the reader can't determine.
    """

    configurations: list[SentCommand] = field(default_factory=list)
    searches: list[SentCommand] = field(default_factory=list)
    repeated: list[Remark] = field(default_factory=list)
    unused: list[Remark] = field(default_factory=list)
    held: list[Remark] = field(default_factory=list)
    out_of_range: list[Remark] = field(default_factory=list)
    misplaced: list[Remark] = field(default_factory=list)
    endless: list[Remark] = field(default_factory=list)
    unreached: list[Remark] = field(default_factory=list)
    misused: list[Remark] = field(default_factory=list)
    uses_bit: UsesBit | None = None
    not_seen: list[str] = field(default_factory=list)
