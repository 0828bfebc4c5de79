"""Racks that run side by side and exchange tags and messages.

    line1.toml   |  scan  |  scan  |  scan  |      a consumed tag gets the value of the producer's tag
    line2.toml   |scan|scan|scan|scan|scan|        at the last multiple of the RPI, after all earlier scans

Every other rack is loaded once, and runs only as far as needed. The values of its tags are kept, so that any
scan of the first rack can be run again. Racks can refer to each other, because they form one group with a
single virtual time.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.stubs import NEVER, DataSource, Ending, Partner, Sample, Sampler, Stub
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.config.stub_tables import StubTable
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.scan import CpuMode, ScanLogic

from .building import build_cpu, build_rack
from .rungs import is_rungs

if TYPE_CHECKING:  # a Python program needs no rungs
    from scanrack.ladder.lowering.runnable import LadderLogic
    from scanrack.ladder.run.engine import Engine
    from scanrack.ladder.run.view import Tags

MOST_KEPT = 100_000
"""Maximum number of changes kept for a tag; scans before the oldest of them can't be run again."""


@dataclass(frozen=True, slots=True)
class TimeTable:
    """A `DataSource` of entries (time in ns, sample). It has no value before the first entry."""

    entries: tuple[tuple[int, Sample], ...]

    def open(self, tag: str, rpi_ns: int) -> Sampler:
        """Return a function that returns the entry at the last multiple of the interval."""
        times = [time_ns for time_ns, _ in self.entries]

        def sample(now_ns: int) -> Sample:
            count = bisect_right(times, now_ns // rpi_ns * rpi_ns)
            return self.entries[count - 1][1] if count else Sample(None)

        return sample

    def __str__(self) -> str:
        if len(self.entries) == 1 and not self.entries[0][0]:
            return "a constant"
        return f"a table of {len(self.entries)}"


@dataclass(slots=True)
class WatchedTag:
    """Samples of a tag at multiples of an interval; only changes are kept."""

    tag: str
    rpi_ns: int
    numbers: list[int] = field(default_factory=list)  # the first multiple of the interval for each sample
    samples: list[Sample] = field(default_factory=list)
    last_number: int = -1  # the latest multiple of the interval that has a sample

    def note(self, now_ns: int, tags: Tags, *, running: bool) -> None:
        """Record the current value as the sample for all multiples up to a time."""
        number = now_ns // self.rpi_ns
        if number <= self.last_number:
            return
        first, self.last_number = self.last_number + 1, number
        sample = Sample(tags[self.tag], running)
        if not self.samples or self.samples[-1] != sample:
            self.numbers.append(first)
            self.samples.append(sample)
            if len(self.numbers) > MOST_KEPT:
                del self.numbers[: MOST_KEPT // 2], self.samples[: MOST_KEPT // 2]

    def sample_at(self, now_ns: int) -> Sample:
        """Return the sample at the last multiple up to a time; raise ValueError if it is no longer kept."""
        count = bisect_right(self.numbers, now_ns // self.rpi_ns)
        if not count:
            raise ValueError(f"the value of {self.tag} at {seconds(now_ns)} s is no longer kept")
        return self.samples[count - 1]


class LinkedRack:
    """One rack of a group.

    Args:
        leads: whether it is the first rack of the group, which is run by its own job.

    Attributes:
        logic: its ladder program; None before it is loaded, and for a Python program.
        fault: the fault that stopped it; "" while it runs.
        job: the `LoadedRack`; None before it is loaded.
    """

    def __init__(self, path: Path, *, leads: bool) -> None:
        self.path, self._leads = path, leads
        self.logic: LadderLogic | None = None
        self.fault = ""
        self.job: Any = None
        self._spec: RackSpec | None = None
        self._cpu: Cpu | None = None
        self._watched: list[WatchedTag] = []

    def take(self, spec: RackSpec, logic: ScanLogic) -> None:
        """Set the program when it is loaded; the leading rack then records its watched tags while it runs."""
        self._spec = spec
        self.logic = logic if is_rungs(logic) else None
        if self._leads and self._watched and self.logic is not None:
            self.logic.before_scans(self._note_engine)

    def watch(self, tag: str, rpi_ns: int) -> Sampler:
        """Return a function that returns samples of a tag; raise LadderError if the program lacks the tag."""
        watched = WatchedTag(tag, rpi_ns)
        self._watched.append(watched)
        if self.logic is not None and tag not in self.logic.tags:
            raise LadderError(f"{self.path.name} has no tag {tag}")

        def sample(now_ns: int) -> Sample:
            """Return the sample at a time. Run this rack up to that time, unless its own job runs it."""
            if not self._leads:
                self._run(now_ns // rpi_ns * rpi_ns)
            elif watched.last_number < 0:
                return Sample(None)
            return watched.sample_at(now_ns)

        return sample

    def _run(self, until_ns: int) -> None:
        """Run all scans that begin before a time."""
        cpu = self._cpu or self._power_up()
        while cpu.now_ns < until_ns and not self.fault:
            try:
                cpu.run(1)
            except CpuFault as fault:
                self.fault = str(fault)
            self._note(cpu.now_ns, self._tags)
        if self.fault:
            self._note(until_ns, self._tags)

    def _power_up(self) -> Cpu:
        """Create the CPU and note the first values; raise LadderError without a ladder program."""
        if self._spec is None or self.logic is None:
            raise LadderError(f"{self.path.name} has no ladder program, so it has no tags")
        self._cpu = build_cpu(self._spec, self.logic, build_rack(self._spec))
        self._note(0, self._tags)
        return self._cpu

    @property
    def _tags(self) -> Tags:
        assert self.logic is not None
        return self.logic.tags

    def _note_engine(self, engine: Engine, _first: bool) -> None:
        self._note(engine.now_ns, engine.tags)

    def _note(self, now_ns: int, tags: Tags) -> None:
        running = not self.fault and (self._cpu is None or self._cpu.mode is CpuMode.RUN)
        for watched in self._watched:
            watched.note(now_ns, tags, running=running)


@dataclass(slots=True)
class RackGroup:
    """The racks that run in one virtual time, by path; the first rack leads."""

    load: Callable[[Path, RackGroup], Any]  # loads another rack file into the group and returns its job
    racks: dict[Path, LinkedRack] = field(default_factory=dict)

    def rack(self, path: Path) -> LinkedRack:
        """Return a rack; load it if it is new."""
        key = path.resolve()
        if key not in self.racks:
            self.enter(path).job = self.load(path, self)
        return self.racks[key]

    def enter(self, path: Path) -> LinkedRack:
        """Add a rack before it is loaded, and return it."""
        return self.racks.setdefault(path.resolve(), LinkedRack(path, leads=not self.racks))

    @property
    def others(self) -> Sequence[LinkedRack]:
        """All racks except the first."""
        return list(self.racks.values())[1:]


@dataclass(frozen=True, slots=True)
class FromRack:
    """A tag of another rack, as a `DataSource`."""

    rack: LinkedRack
    tag: str  # "" = the tag that the export names

    def open(self, tag: str, rpi_ns: int) -> Sampler:
        """Return a function that returns the samples of the tag."""
        if not (self.tag or tag):
            raise LadderError(f'give the tag of {self.rack.path.name}, such as tag = "Counts"')
        return self.rack.watch(self.tag or tag, rpi_ns)

    def __str__(self) -> str:
        return f"{self.tag or 'the tag'} of {self.rack.path.name}"


def stub_of_table(table: StubTable, folder: Path, group: RackGroup) -> Stub:
    """Return the stub for a table in `[stubs]`; load other rack files into the group."""
    source = _source(table, folder, group)
    if table.after_ns is None:
        assert source is not None  # the table has been validated
        return Partner(source, table.rpi_ns)
    return Ending(min(table.after_ns, NEVER), table.error, None if table.error else source, table.to)


def _source(table: StubTable, folder: Path, group: RackGroup) -> DataSource | None:
    """Return the source of values in a stub table: a tag, a time table or a constant; else None."""
    if table.rack:
        return FromRack(group.rack(folder / table.rack), table.tag)
    if table.table:
        steps = ((step.at_ns, Sample(step.value, step.running, step.faulted)) for step in table.table)
        return TimeTable(tuple(steps))
    return TimeTable(((0, Sample(table.value)),)) if table.value is not None else None
