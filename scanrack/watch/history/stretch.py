"""The programs of a session by scan; each edit begins another stretch.

scan       0 ................ 4,010 ................. 9,200 ....
stretch    number 0           number 1                number 2
power      each scan with its own program
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import ModuleWords
from scanrack.jobs.why.source.class_names import Names
from scanrack.ladder import LadderLogic
from scanrack.ladder.lowering.edited import RungIndex
from scanrack.ladder.python.online.fields import Fields
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.loop.faults import Fault
from scanrack.runtime.loop.scan import ScanLogic

from .catalog import Catalog, tag_hits
from .event_log import LAST_SCAN
from .lanes import TagLanes, ValueHistory
from .program_file import digest
from .program_replica import ProgramReplica, SnapshotStore, ValueFile
from .python_source import PythonSource
from .timeline import Timeline

Json = dict[str, Any]


@dataclass(eq=False)
class Stretch:
    """A program and its scans, starting with `first`.

    Attributes:
        logic: the program; None if it is unknown or must not run.
        lacks: why the program can't be shown; "" if it can.
        history: values that were read from a Python program.
        store: stored values of a ladder program.
        catalog: the rungs and tags of a ladder program; None for any other program.
        source: the text of a Python program; None for a ladder program.
        hints: suggestions for unknown names, see `panels.bindings`.
    """

    number: int
    first: int
    logic: ScanLogic | None
    file: Path | None
    lacks: str
    words: Mapping[int, ModuleWords]
    timeline: Timeline
    history: ValueHistory
    store: SnapshotStore
    hints: dict[tuple[str, int], str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ladder = self.logic if isinstance(self.logic, LadderLogic) else None
        self.catalog = None if ladder is None else Catalog(ladder)
        self.source = None if ladder is not None or self.file is None else PythonSource(self.file)

    @cached_property
    def rung_index(self) -> RungIndex:
        """The index for checks of edited rungs."""
        return RungIndex(self.ladder)

    @property
    def ladder(self) -> LadderLogic:
        """The program, which must be a ladder program."""
        assert isinstance(self.logic, LadderLogic)
        return self.logic

    @cached_property
    def digest(self) -> str:
        """Digest of the program's file, see `online`; "" if the file can't be read."""
        try:
            return "" if self.file is None else digest(self.file.read_bytes())
        except OSError:
            return ""

    @cached_property
    def layout(self) -> MemoryLayout:
        """The locations of the images in a row."""
        return memory_layout(self.words.items())

    @cached_property
    def live(self) -> ProgramReplica | None:
        """The replica for the latest scans; None for a program without rungs."""
        return self._replica()

    @cached_property
    def past(self) -> ProgramReplica | None:
        """The replica for any scan; None for a program without rungs."""
        return self._replica()

    @cached_property
    def lanes(self) -> TagLanes:
        """The lanes of tags in the timing strip."""
        return TagLanes(self.timeline, self._replica(), self.history, self.address, self.layout)

    def address(self, name: str) -> Address | None:
        """Return the image word or bit to which a name refers; None for any other name."""
        with suppress(ValueError):
            return parse_address(name, self.words)
        address = self.aliases.get(name) if self.catalog is None else self.catalog.addresses([name]).get(name)
        with suppress(ValueError):  # an alias of a connection fault is not a word
            return None if address is None else parse_address(address, self.words)
        return None

    @cached_property
    def aliases(self) -> Mapping[str, str]:
        """The addresses of the inputs and outputs of a `Logic` program, by name: `line.start`."""
        if not isinstance(self.logic, Logic):
            return {}
        names = Names(self.logic, self.words)
        return {f"{names.prefix}{name}": address for name, address in names.addresses.items()}

    def alias_tags(self) -> list[Json]:
        """Return the aliases as tags for `hello`."""
        return [
            {
                "name": name,
                "type": "INT" if parse_address(address, self.words).bit is None else "BOOL",
                "description": address,
                "writable": False,
                "address": address,
            }
            for name, address in self.aliases.items()
        ]

    def _replica(self) -> ProgramReplica | None:
        if not isinstance(self.logic, LadderLogic):
            return None
        return ProgramReplica(self.logic, self.layout, self.timeline, self.store)

    def described(self, values: Mapping[str, object]) -> Json:
        """Return the routines, tags and stubs for a page."""
        if self.catalog is not None:
            routines = self.catalog.routines()
            stubs = list(self.logic.stubs_in_use) if isinstance(self.logic, LadderLogic) else []
            tags = self.catalog.tags()
            return {"routines": routines, "tags": tags, "stubs": stubs, "lacks": "", "settable": True}
        logic = self.logic
        fields = Fields(lambda: logic) if isinstance(logic, Logic) else ()
        tags = [
            {"name": name, "type": _type_of(value), "description": "", "writable": name in fields}
            for name, value in values.items()
        ]
        routines = [] if self.source is None else self.source.routines()
        tags, settable = tags + self.alias_tags(), isinstance(logic, Logic)
        return {"routines": routines, "tags": tags, "stubs": [], "lacks": self.lacks, "settable": settable}

    def find(self, text: str, values: Mapping[str, object]) -> list[Json]:
        """Return the tags or values, and the rungs or lines, that contain a text."""
        if self.catalog is not None:
            return self.catalog.find(text)
        lines = [] if self.source is None else self.source.find(text)
        return tag_hits(self.described(values)["tags"], text) + lines

    def place_of_fault(self, fault: Fault) -> str | None:
        """Return the rung or line of a fault, such as Main.3 or line.py.62; None if unknown."""
        source = self.catalog or self.source
        return None if source is None else source.place_of_fault(fault)

    def tags_of_fault(self, fault: Fault, values: Mapping[str, object]) -> list[str]:
        """Return the tags or values that the rung or line of a fault reads, the most relevant first."""
        if self.catalog is not None:
            return self.catalog.tags_of_fault(fault)
        return [] if self.source is None else self.source.tags_of_fault(fault, values)


class Stretches:
    """The programs of a session or a recording."""

    def __init__(self, words: Mapping[int, ModuleWords], timeline: Timeline, history: ValueHistory) -> None:
        self._words, self._timeline, self._history = words, timeline, history
        self.clear()

    def clear(self) -> None:
        """Drop all programs, since another session begins."""
        self.all: list[Stretch] = []
        self._stores: dict[int, SnapshotStore] = {}
        self._file = ValueFile()

    def add(self, first: int, logic: ScanLogic | None, file: Path | None, lacks: str = "") -> Stretch:
        """Add the program that runs from a scan on."""
        number, store = len(self.all), self.store(len(self.all))
        stretch = Stretch(
            number, first, logic, file, lacks, self._words, self._timeline, self._history, store
        )
        self.all.append(stretch)
        return stretch

    def lose(self, first: int) -> None:
        """Show no program from a scan on, since an unknown program ran in those scans."""
        self.all = [stretch for stretch in self.all if stretch.first < first]
        self.add(first, None, None, "The trace does not contain the program of this scan.")

    def store(self, number: int) -> SnapshotStore:
        """Return the stored values of a program by its number; they may arrive before the program."""
        return self._stores.setdefault(number, SnapshotStore(self._file))

    @property
    def latest(self) -> Stretch:
        """The running program."""
        return self.all[-1]

    def at(self, scan: int | None) -> Stretch:
        """Return the program that ran in a scan; None = the latest."""
        if scan is None:
            return self.latest
        return next((stretch for stretch in reversed(self.all) if stretch.first <= scan), self.all[0])

    def end_of(self, program: Stretch) -> int:
        """Return the last scan of a program; `LAST_SCAN` for the latest one."""
        later = self.all[program.number + 1 :]
        return later[0].first - 1 if later else LAST_SCAN


def _type_of(value: object) -> str:
    return {bool: "BOOL", int: "LINT", str: "TEXT"}.get(type(value), "LREAL")
