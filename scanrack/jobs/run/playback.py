"""A CPU that repeats the scans of a recording, and stand-ins for modules and logic.

    recorded outputs -> modules         logic is `recorded_outputs`
    recorded inputs  -> logic           modules are `RecordedInputs`
    stimuli          -> both            modules and logic are real, the stimuli a timeline

The numbers, times and modes of the scans come from the recording, so scans can be irregular and begin
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
        plan: ReplayPlan,
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
            mode=plan.mode(0),
            listeners=listeners,
            watchdog=watchdog,
        )
        self._ahead.enabled = False  # every recorded scan is run
        self._plan = plan
        self._rows = len(plan.numbers)
        self._row = 0
        self._request(0)
        self._set_clock(0)

    def play(self) -> None:
        """Repeat the scans until all are done or `stop` is called.

        Raises:
            CpuFault: see `Cpu.run`.
        """
        self.run(len(self._plan.numbers))

    def housekeeping(self) -> None:
        """Request the mode and forces of the next scan, and move on to it."""
        self._row += 1
        has_more = self._row < self._rows
        if has_more:
            self._request(self._row)
        super().housekeeping()
        if has_more:
            self._set_clock(self._row)

    def _set_clock(self, row: int) -> None:
        """Set the number and time of the next scan. Prepare the scan again if its first-scan flag differs."""
        self._view.number, self._view.now_ns = self._plan.numbers[row], self._plan.times[row]
        is_first = bool(self._plan.flags[row] & ScanFlag.FIRST_SCAN)
        if is_first is not self._view.first:
            self._view.first = is_first
            self._prepare()

    def _request(self, row: int) -> None:
        """Request the mode of a scan, and set the forces that are in effect from it."""
        mode = self._plan.mode(row)
        if mode is not self.mode:
            self.mode = mode
        forces = self._plan.forces.get(self._plan.numbers[row])
        if forces is not None:
            self.forces.clear()
            for address, value in forces.items():
                self.forces.set(address, value)


class RecordedInputs:
    """A module that returns the recorded input images in order.

    Args:
        images: the bytes of the image in each scan.
        times: times of the images, ns, ascending.
        links: losses and returns of the module's link, in ascending order.
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
        """Return the image at `now_ns`; see `Module.update`."""
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
        """Do nothing, since the recording continues; see `Module.plc_run`."""

    def power_cycle(self) -> None:
        """Do nothing, since the recording continues; see `Module.power_cycle`."""


def recorded_outputs(plan: ReplayPlan, memory: Sequence[bytes], layout: MemoryLayout) -> ScanLogic:
    """Return logic that writes the output images of a recording, scan by scan."""
    blocks = (block for row, block in enumerate(memory) if runs_logic(plan.flags[row]))

    def logic(scan: LogicScan) -> None:
        block = next(blocks)
        for slot in scan.slot.values():
            slot.outputs.raw[:] = block[layout.places[slot.number].outputs]

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

    Its timeline and stations are removed, since the recording has their stimuli. A released input that no
    switch drives is de-energized.

    Args:
        stimuli: stimuli of its slot, in time order.
        switches: whether to keep the machine's switches; otherwise the stimuli set all levels.
    """
    bare = replace(machine, timeline=(), stations=(), switches=machine.switches if switches else ())
    entries = []
    for stimulus in stimuli:
        is_undriven = stimulus.energized is None and not bare.fed_inputs & stimulus.input.value
        energized = False if is_undriven else stimulus.energized
        entries.append(TimelineEntry(stimulus.at_ns, stimulus.input, energized))
    return replace(bare, timeline=tuple(entries))
