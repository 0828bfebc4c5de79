"""A CPU that repeats the scans of a recording, and substitutes for modules and logic.

    recorded outputs -> modules         logic is `recorded_outputs`
    recorded inputs  -> logic           modules are `RecordedInputs`
    stimuli          -> both            modules and logic are real, the stimuli a timeline

The numbers, times and modes of the scans come from the recording, so scans may be irregular and begin
anywhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import Image
from scanrack.io_images.memory_layout import MemoryLayout
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.exchange import Exchange
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.pace import Watchdog
from scanrack.runtime.loop.phases import runs_logic
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode, LogicScan, ScanFlag, ScanLogic
from scanrack.runtime.machine import MachineSpec, TimelineEntry

from ..record.link_losses import LinkChange


@dataclass(frozen=True, slots=True)
class ReplayPlan:
    """The recorded scans to repeat."""

    numbers: Sequence[int]
    times: Sequence[int]  # virtual times, ns
    flags: Sequence[int]
    forces: Mapping[int, Mapping[str, int]]  # scan number -> all forces in effect from that scan, by address

    def mode(self, row: int) -> CpuMode:
        """Return the mode of a scan."""
        return CpuMode(self.flags[row] & MODE_MASK)


class Playback(Cpu):
    """A CPU that repeats recorded scans, with their numbers, times, modes and forces.

    Call `play`; the listeners receive every scan.
    """

    def __init__(
        self,
        score: ReplayPlan,
        rack: Rack,
        logic: ScanLogic,
        period_ns: int,
        *,
        exchange: Exchange,
        listeners: Iterable[ScanListener],
        watchdog: Watchdog,
    ) -> None:
        super().__init__(
            rack,
            logic,
            period_ns,
            exchange=exchange,
            mode=score.mode(0),
            listeners=listeners,
            watchdog=watchdog,
        )
        self._ahead.enabled = False
        self._score = score
        self._rows = len(score.numbers)
        self._row = 0
        self._ask_for(0)
        self._turn_to(0)

    def play(self) -> None:
        """Repeat all scans, or until `stop` is called.

        Raises:
            CpuFault: see `Cpu.run`.
        """
        self.run(len(self._score.numbers))

    def housekeeping(self) -> None:
        """Request the mode and forces of the next scan, and move on to it."""
        self._row += 1
        has_more = self._row < self._rows
        if has_more:
            self._ask_for(self._row)
        super().housekeeping()
        if has_more:
            self._turn_to(self._row)

    def _turn_to(self, row: int) -> None:
        self._view.number, self._view.now_ns = self._score.numbers[row], self._score.times[row]
        first = bool(self._score.flags[row] & ScanFlag.FIRST_SCAN)
        if first is not self._view.first:
            self._view.first = first
            self._prepare()

    def _ask_for(self, row: int) -> None:
        mode = self._score.mode(row)
        if mode is not self.mode:
            self.mode = mode
        forces = self._score.forces.get(self._score.numbers[row])
        if forces is not None:
            self.forces.clear()
            for address, value in forces.items():
                self.forces.set(address, value)


class RecordedInputs:
    """A module that shows the recorded input images, one after the other.

    Args:
        images: the bytes of an image per scan.
        times: times of the images, ns, ascending.
        links: losses and returns of its link, ascending.
    """

    def __init__(
        self, images: Sequence[bytes], times: Sequence[int], links: Iterable[LinkChange] = ()
    ) -> None:
        self.events: list[Event] = []
        self._images = images
        self._times = times
        self._last = len(times) - 1
        self._row = -1
        self._image = Image(buffer=bytearray(images[0])) if images else Image()
        self._links = list(links)
        self.linked = True

    def update(self, now_ns: int, outputs: Image) -> Image:
        """Return the image in force at `now_ns`; see `Module.update`."""
        row = self._row
        while row < self._last and self._times[row + 1] <= now_ns:
            row += 1
        if row != self._row:
            self._row = row
            self._image.raw[:] = self._images[row]
        while self._links and self._links[0].now_ns <= now_ns:
            self.linked = self._links.pop(0).good
        return self._image

    def plc_run(self, running: bool) -> None:
        """Do nothing: the recording continues; see `Module.plc_run`."""

    def power_cycle(self) -> None:
        """Do nothing: the recording continues; see `Module.power_cycle`."""


def recorded_outputs(score: ReplayPlan, memory: Sequence[bytes], layout: MemoryLayout) -> ScanLogic:
    """Return logic that writes the output images of a recording, scan by scan."""
    written = (image for row, image in enumerate(memory) if runs_logic(score.flags[row]))

    def logic(scan: LogicScan) -> None:
        image = next(written)
        for slot in scan.slot.values():
            slot.outputs.raw[:] = image[layout.places[slot.number].outputs]

    return logic


@dataclass(frozen=True, slots=True)
class Stimulus:
    """A recorded stimulus."""

    at_ns: int
    slot: int
    input: InputBit
    energized: bool | None  # the new level; None = controlled by the machine's switch or station


def stimulated(machine: MachineSpec, stimuli: Iterable[Stimulus], *, switches: bool = True) -> MachineSpec:
    """Return a machine with the recorded stimuli as its only timed changes.

    Its own timeline and stations are removed, since they have already acted in the recording. An input that
    they would have released is de-energized.

    Args:
        stimuli: stimuli of its slot, in time order.
        switches: whether to keep the machine's switches; otherwise the stimuli set all levels.
    """
    bare = replace(machine, timeline=(), stations=(), switches=machine.switches if switches else ())
    entries = []
    for stimulus in stimuli:
        let_go = stimulus.energized is None and not bare.fed_inputs & stimulus.input.value
        entries.append(TimelineEntry(stimulus.at_ns, stimulus.input, False if let_go else stimulus.energized))
    return replace(bare, timeline=tuple(entries))
