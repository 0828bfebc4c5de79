"""The scans to debug, by number, from a running rack or a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Protocol

from scanrack.io_images.memory_layout import memory_layout
from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.debug.causes import Causes
from scanrack.ladder.debug.cells import cells_of
from scanrack.ladder.debug.chains import Chains
from scanrack.ladder.debug.crossref import CrossReference
from scanrack.ladder.debug.inquiry import Inquiry
from scanrack.ladder.debug.links import link_text
from scanrack.ladder.debug.replay import Replayer
from scanrack.ladder.model.tree import Origin
from typing_extensions import override

from .breakpoints import Breakpoint, Event, Hit, Looker, RungValues
from .conditions import ScanContext
from .executed_scan import ExecutedScan
from .places import Places
from .variables import ReadWord
from .view import View

SLICE = 512
"""Number of scans that are searched between two checks for requests."""

Poll = Callable[[int], None]
"""A function called with the number of the scan that a search has reached."""


class SearchCanceledError(Exception):
    """The client has paused a search.

    Args:
        scan: the scan that the search had reached.
    """

    def __init__(self, scan: int) -> None:
        super().__init__(scan)
        self.scan = scan


class Subject(Protocol):
    """A rack and its scans.

    Attributes:
        words: word names of the modules, by slot.
        live: whether the rack is running, so that values can be set and more scans can run.
        units: units of tags on the page, by uppercase name.
    """

    words: Mapping[int, ModuleWords]
    live: bool
    units: Mapping[str, str] = MappingProxyType({})

    @property
    def extent(self) -> tuple[int, int]:
        """The first and the last scan; the last is -1 before the first one."""

    def places(self, scan: int) -> Places:
        """Return the lines of the program that ran in a scan."""

    def view(self, scan: int) -> View:
        """Return a scan as it was executed; raise DebugError if it can't be repeated."""

    def check(self, requested: Sequence[Breakpoint], scan: int) -> None:
        """Raise ExpressionError if a breakpoint has a condition that can't be evaluated."""

    def hits_between(
        self, requested: Sequence[Breakpoint], first: int, last: int, poll: Poll = lambda _scan: None
    ) -> Iterator[tuple[int, list[Hit]]]:
        """Yield the scans that hit a breakpoint, in order; hit counts and log points have no effect."""

    def hits(self, requested: Sequence[Breakpoint], scan: int) -> list[Hit]:
        """Return the breakpoints that a scan hits; see `hits_between`."""
        return dict(self.hits_between(requested, scan, scan)).get(scan, [])

    def last_before(self, requested: Sequence[Breakpoint], scan: int, poll: Poll) -> int | None:
        """Return the last scan before `scan` that hits a breakpoint, or None.

        Raises:
            SearchCanceledError: the client has paused the search.
        """

    def first_after(self, requested: Sequence[Breakpoint], scan: int) -> tuple[int | None, int]:
        """Return the first scan in a slice after `scan` that hits a breakpoint, and the last scan checked."""
        last = min(self.extent[1], scan + SLICE)
        hit_scan = next((number for number, _hits in self.hits_between(requested, scan + 1, last)), None)
        return (None, last) if hit_scan is None else (hit_scan, hit_scan)

    def last_change(self, tag: str, scan: int) -> int | None:
        """Return the last scan up to `scan` that changed a tag, or None."""

    def why(self, tag: str, scan: int) -> list[tuple[str, Origin]]:
        """Explain the value of a tag after a scan, as a text followed by each cause with its line."""

    def memory(self, scan: int) -> bytes:
        """Return the images of all modules after a scan; empty if they are not known."""

    def events(self, scan: int) -> Sequence[Event]:
        """Return the events of a scan."""

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""

    def forced(self, scan: int) -> Mapping[str, object]:
        """Return the tags and image words that are forced in a scan."""

    def prepare(self) -> bool:
        """Do part of the preparation for later backward steps; return whether work remains."""
        return False

    def around(self, current_scan: Callable[[], int], word: ReadWord | None = None) -> ScanContext:
        """Return the context for expressions about a scan.

        Args:
            current_scan: function that returns the number of the scan.
            word: reads the words of images; by default their values after the scan.
        """
        word = word or self.words_in(lambda: self.memory(current_scan()))
        return ScanContext(self.words, word, lambda: self.now_ns(current_scan()), current_scan, self.units)

    def words_in(self, memory: Callable[[], bytes | bytearray]) -> ReadWord:
        """Return a reader of words in the rack's memory block; they are 0 if the block is empty."""
        places = memory_layout(self.words.items()).places

        def read(slot: int, image: str, number: int) -> int:
            block = memory()
            offset = places[slot].image(image).start + 2 * number
            return int.from_bytes(block[offset : offset + 2], "little", signed=True)

        return read


class RungSubject(Subject):
    """A ladder program; its scans are run again from snapshots."""

    def replayer(self, scan: int) -> Replayer:
        """Return the replayer for a scan; raise DebugError if the scan can't be run again."""
        raise NotImplementedError

    @override
    def view(self, scan: int) -> View:
        return ExecutedScan(self.replayer(scan), scan)

    def _looker(self, requested: Sequence[Breakpoint], replayer: Replayer) -> Looker:
        """Return the object that checks breakpoints in the scan that a replayer has reached."""

        def current_scan() -> int:
            return -1 if replayer.at is None else replayer.at

        return Looker(requested, RungValues(replayer.engine), self.around(current_scan), self.events)

    @override
    def check(self, requested: Sequence[Breakpoint], scan: int) -> None:
        self._looker(requested, self.replayer(scan))

    @override
    def hits_between(
        self, requested: Sequence[Breakpoint], first: int, last: int, poll: Poll = lambda _scan: None
    ) -> Iterator[tuple[int, list[Hit]]]:
        if last < first:
            return
        replayer = self.replayer(last)
        looker = self._looker(requested, replayer)
        begin = max(self.extent[0], first - 1)  # changes are known from the second scan on
        for _ in replayer.walk(begin, last, noted=bool(looker.lines)):
            scan = replayer.at
            assert scan is not None
            hits = looker.hits(scan)
            if hits and scan >= first:
                yield scan, hits

    @override
    def last_before(self, requested: Sequence[Breakpoint], scan: int, poll: Poll) -> int | None:
        first = self.extent[0]
        while scan > first:  # from each snapshot to the next one
            replayer = self.replayer(scan - 1)
            begin = max(first, next(replayer.source.snapshots(scan - 1), first))
            scans = [number for number, _hits in self.hits_between(requested, begin, scan - 1)]
            if scans:
                return scans[-1]
            scan = begin
            poll(scan)
        return None

    @override
    def last_change(self, tag: str, scan: int) -> int | None:
        replayer = self.replayer(scan)
        return replayer.last_change_of(cells_of(replayer.engine.tags.where(tag), counts=True), scan)

    @override
    def why(self, tag: str, scan: int) -> list[tuple[str, Origin]]:
        replayer = self.replayer(scan)
        engine = replayer.engine
        chain = Chains(engine.lowered, Causes(replayer), False).of_tag(tag, scan)
        if chain is None:
            inquiry = Inquiry(engine, replayer, scan, self.forced(scan), CrossReference(engine.lowered))
            return [(inquiry.why(tag), Origin())]
        return [(link_text(link), _origin(link.site)) for link in chain.path]


def _origin(site: Any) -> Origin:
    return Origin(site.file, site.line) if site is not None and site.line else Origin()
