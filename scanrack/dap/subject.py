"""What is debugged: scans that can be looked at by number, of a rack that runs or of a recording."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from typing import Protocol

from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug.replay import Replayer
from scanrack.ladder.debug.watching import WatchedEngine

from .breakpoints import Breakpoint, Event, Looker
from .conditions import Surroundings
from .places import Places


class Subject(Protocol):
    """A rack and its scans.

    Attributes:
        words: of the modules, by slot.
        live: whether it runs, so that values can be set and further scans done.
    """

    words: Mapping[int, ModuleWords]
    live: bool

    @property
    def extent(self) -> tuple[int, int]:
        """The first and the last scan; the last is -1 before the first one."""

    def program(self, scan: int) -> LadderLogic:
        """Return the program of a scan; a DebugError without one that can be stepped."""

    def places(self, scan: int) -> Places:
        """Return the lines of that program."""

    def replayer(self, scan: int) -> Replayer:
        """Return what runs a scan again; a DebugError if that is impossible."""

    def memory(self, scan: int) -> bytes:
        """Return the images of all modules after a scan; empty if they are not known."""

    def events(self, scan: int) -> Sequence[Event]:
        """Return the events of a scan."""

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""

    def forced(self, scan: int) -> Mapping[str, object]:
        """Return the forced tags and images in a scan."""


class Images:
    """Words in the memory block of a rack."""

    def __init__(self, words: Mapping[int, ModuleWords]) -> None:
        self.layout: MemoryLayout = memory_layout(words.items())

    def word(self, memory: bytes | bytearray, slot: int, image: str, number: int) -> int:
        """Return a word of an image, "I" or "O", signed; 0 if the block is empty."""
        if not memory:
            return 0
        at = self.layout.places[slot].image(image).start + 2 * number
        found: int = struct.unpack_from("<h", memory, at)[0]
        return found


class Past:
    """Breakpoints in scans that are run again.

    Args:
        wanted: the breakpoints; hit counts and log points have no effect backwards.
    """

    def __init__(self, subject: Subject, wanted: Sequence[Breakpoint]) -> None:
        self._subject, self._wanted = subject, wanted
        self._images = Images(subject.words)
        self._at = -1

    def looker(self, engine: WatchedEngine) -> Looker:
        """Return what looks for the breakpoints on an engine that repeats scans."""
        subject, images = self._subject, self._images
        around = Surroundings(
            subject.words,
            lambda slot, image, number: images.word(subject.memory(self._at), slot, image, number),
            lambda: subject.now_ns(self._at),
            lambda: self._at,
        )
        return Looker(self._wanted, engine, around, subject.events)

    def hits(self, first: int, last: int) -> dict[int, list[tuple[Breakpoint, str]]]:
        """Return the breakpoints that scans from one to another meet, by scan."""
        replayer = self._subject.replayer(last)
        looker = self.looker(replayer.engine)
        found: dict[int, list[tuple[Breakpoint, str]]] = {}
        begin = max(self._subject.extent[0], first - 1)  # changes are known from the second scan on
        for _now in replayer.walk(begin, last, noted=bool(looker.lines)):
            assert replayer.at is not None
            self._at = number = replayer.at
            met = looker.look(number)
            if met and number >= first:
                found[number] = [(check.breakpoint, text) for check, text in met]
        return found

    def last_before(self, scan: int) -> int | None:
        """Return the last scan before one that meets a breakpoint; None without one."""
        first = self._subject.extent[0]
        while scan > first:
            replayer = self._subject.replayer(scan - 1)
            begin = next(replayer.source.snapshots(scan - 1), first)
            found = self.hits(max(begin, first), scan - 1)
            if found:
                return max(found)
            scan = max(begin, first)
        return None

    def first_after(self, scan: int, *, slice_scans: int = 512) -> tuple[int | None, int]:
        """Return the first scan after one that meets a breakpoint, of a slice; and the last one looked at."""
        last = min(self._subject.extent[1], scan + slice_scans)
        found = self.hits(scan + 1, last) if last > scan else {}
        return (min(found), min(found)) if found else (None, last)
