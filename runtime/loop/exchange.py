"""The exchange of images across the backplane, between the rack's memory and the modules.

End of scan (MicroLogix): inputs are read at a scan's beginning, outputs sent
at its end. A scan takes no virtual time, so that the outputs of scan n are in force from
its own instant on, and scan n + 1 sees the module after one period of them.

    scans      n ------------- n+1 ------------ n+2
    outputs    |   of scan n   |  of scan n+1   |
    inputs     ^               ^                ^

Every RPI (CompactLogix): the adapter on the backplane exchanges images on its
own, every 2 ms for this module, independently of the scan. Scans between two
exchanges see the same inputs, and only the last of their outputs is sent.

    exchanges  R0 ------------------- R1 ------------------- R2
    scans         n    n+1    n+2        n+3    n+4    n+5
    outputs    |  ...of scan n-1      |  of scan n+2         |
    inputs     all three see R0       all three see R1

An exchange at the same instant as a scan precedes it: the scan sees its
inputs, and its outputs wait for the next one. The logic of a real scan takes
time: `exchange_early` lets the next exchange happen in the middle of it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

from scanrack.io_images.image import Image
from typing_extensions import override

from .ahead import Block, RackPrediction
from .rack import Rack

RPI_NS = 2_000_000
"""The 3601's requested packet interval on a CompactLogix: fixed at 2 ms [specifications]."""


class Exchange(ABC):
    """The backplane, as the scan loop uses it."""

    __slots__ = ("_lines", "_memory", "_outlook", "_rack", "_sent")

    def attach(self, rack: Rack) -> None:
        """Connect to a rack's memory and modules; nothing has been sent yet, all outputs are 0."""
        self._rack, self._memory = rack, rack.memory
        self._sent = bytearray(len(rack.memory))
        self._lines = _lines(rack, self._sent)
        self._outlook = RackPrediction(rack, _images(rack, self._sent))

    @abstractmethod
    def latch_inputs(self, now_ns: int) -> bool:
        """Advance the modules and write their inputs at `now_ns`; return whether there was an exchange."""

    @abstractmethod
    def latch_outputs(self) -> None:
        """Send the output images in the rack's memory."""

    @abstractmethod
    def start(self) -> None:
        """Inform the modules that the PLC runs, together with the latest outputs."""

    def stop(self) -> None:
        """Inform the modules at once that the PLC does not run; the last outputs stay in force."""
        _set_modules_running(self._rack, False)

    def tell_before_change(self, notice: Callable[[], None]) -> None:
        """Call `notice` before anything other than this exchange acts on a module."""
        self._outlook.tell_before_change(notice)

    def exchange_early(self, end_ns: int) -> bool:
        """Exchange within a scan that ends at `end_ns`; return whether an exchange is due by then."""
        return False

    @abstractmethod
    def calm_scans(self, now_ns: int, period_ns: int) -> int:
        """Return the number of foreseen scans from `now_ns` on with unchanged outputs; 0 = none."""

    @abstractmethod
    def foresee(self, now_ns: int, period_ns: int, count: int, most_rows: int) -> Block:
        """Return the scans that begin with the one at `now_ns`.

        Args:
            count: their number, at most `calm_scans`.
            most_rows: maximum number of scans if an axis moves.
        """

    @abstractmethod
    def catch_up(self, now_ns: int) -> None:
        """Advance the modules to the scan at `now_ns` after foreseen scans."""


Line: TypeAlias = tuple[Callable[[int, Image], Image], Image, memoryview]
"""One module's end of the backplane: its `update`, the outputs in force there, the place of its inputs."""


class EndOfScan(Exchange):
    """Inputs at the beginning of the scan, outputs at its end, like a MicroLogix."""

    __slots__ = ("_latest_ns",)

    @override
    def attach(self, rack: Rack) -> None:
        super().attach(rack)
        self._latest_ns = 0

    @override
    def latch_inputs(self, now_ns: int) -> bool:
        """Advance every module to `now_ns` and take its inputs."""
        self._latest_ns = now_ns
        for update, outputs, inputs in self._lines:
            inputs[:] = update(now_ns, outputs).raw
        return True

    @override
    def latch_outputs(self) -> None:
        """Send all outputs; they take effect at the instant of the scan."""
        self._sent[:] = self._memory

    @override
    def start(self) -> None:
        """Inform the modules at the end of this scan."""
        _set_modules_running(self._rack, True)

    @override
    def calm_scans(self, now_ns: int, period_ns: int) -> int:
        outputs_of = self._outlook.outputs_of
        if outputs_of(self._memory) != outputs_of(self._sent):
            return 0
        return max(0, -(-(self._outlook.calm_until_ns() - now_ns) // period_ns))

    @override
    def foresee(self, now_ns: int, period_ns: int, count: int, most_rows: int) -> Block:
        rows = self._outlook.rows(self._latest_ns, now_ns, period_ns, min(count, most_rows))
        return Block.of(rows, count)

    @override
    def catch_up(self, now_ns: int) -> None:
        self._latest_ns = now_ns
        _advance(self._lines, now_ns)


class RecordedAtRpi(EndOfScan):
    """Inputs of a trace, which are in force from scan to scan, at the exchanges of an `EveryRpi`.

    Args:
        rpi_ns: interval between the exchanges of the trace.
    """

    __slots__ = ("_next_ns", "_rpi_ns")

    def __init__(self, rpi_ns: int) -> None:
        self._rpi_ns = rpi_ns
        self._next_ns = 0

    @override
    def latch_inputs(self, now_ns: int) -> bool:
        """Read the inputs of every scan; there was an exchange if one was due by `now_ns`."""
        super().latch_inputs(now_ns)
        due = self._next_ns <= now_ns
        if due:
            self._next_ns = (now_ns // self._rpi_ns + 1) * self._rpi_ns
        return due


class EveryRpi(Exchange):
    """An exchange every RPI, independent of the scan, like a CompactLogix.

    Exchanges happen at 0, rpi, 2 * rpi, ...; every module is advanced at each of them.

    Args:
        rpi_ns: interval between exchanges, at least 1 ns.

    Raises:
        ValueError: the interval is not positive.
    """

    __slots__ = ("_next_ns", "_starting", "_waiting", "rpi_ns")

    def __init__(self, rpi_ns: int = RPI_NS) -> None:
        if rpi_ns < 1:
            raise ValueError(f"RPI of {rpi_ns} ns: must be at least 1 ns")
        self.rpi_ns = rpi_ns

    @override
    def attach(self, rack: Rack) -> None:
        """Take the slots; the first exchange is at 0."""
        super().attach(rack)
        self._waiting = bytearray(len(rack.memory))
        self._next_ns = 0
        self._starting = False

    @override
    def latch_inputs(self, now_ns: int) -> bool:
        """Carry out all exchanges due by `now_ns`; between exchanges the inputs do not change."""
        due = self._next_ns <= now_ns
        while self._next_ns <= now_ns:
            self._exchange(self._next_ns)
            self._next_ns += self.rpi_ns
        return due

    @override
    def latch_outputs(self) -> None:
        """Queue all outputs for the next exchange."""
        self._waiting[:] = self._memory

    @override
    def exchange_early(self, end_ns: int) -> bool:
        due = self._next_ns <= end_ns
        if due:
            self._exchange(self._next_ns)
            self._next_ns += self.rpi_ns
        return due

    @override
    def start(self) -> None:
        """Inform the modules with the next exchange, which sends the outputs."""
        self._starting = True

    @override
    def stop(self) -> None:
        self._starting = False
        super().stop()

    @override
    def calm_scans(self, now_ns: int, period_ns: int) -> int:
        outputs_of = self._outlook.outputs_of
        is_steady = outputs_of(self._memory) == outputs_of(self._sent) == outputs_of(self._waiting)
        if self._starting or not is_steady:
            return 0
        calm_exchanges = max(0, -(-(self._outlook.calm_until_ns() - self._next_ns) // self.rpi_ns))
        unknown_ns = self._next_ns + calm_exchanges * self.rpi_ns
        return max(0, -(-(unknown_ns - now_ns) // period_ns))

    @override
    def foresee(self, now_ns: int, period_ns: int, count: int, most_rows: int) -> Block:
        latest_ns, rpi_ns = self._next_ns - self.rpi_ns, self.rpi_ns
        if period_ns % rpi_ns == 0:  # the last exchange of every scan is enough
            first_ns = now_ns // rpi_ns * rpi_ns
            return Block.of(self._outlook.rows(latest_ns, first_ns, period_ns, min(count, most_rows)), count)
        count = min(count, most_rows, 1 + (most_rows - 1) * rpi_ns // period_ns)
        exchanges = [(now_ns + scan * period_ns - self._next_ns) // rpi_ns for scan in range(count)]
        table = [bytes(self._memory)]  # until the next exchange
        if exchanges[-1] >= 0:
            rows = self._outlook.rows(latest_ns, self._next_ns, rpi_ns, exchanges[-1] + 1)
            table += [rows] * (exchanges[-1] + 1) if isinstance(rows, bytes) else rows
        are_fresh = [exchange > previous for previous, exchange in pairwise([-1, *exchanges])]
        return Block([table[exchange + 1] for exchange in exchanges], count, are_fresh)

    @override
    def catch_up(self, now_ns: int) -> None:
        if self._next_ns <= now_ns:
            latest_ns = now_ns // self.rpi_ns * self.rpi_ns
            self._next_ns = latest_ns + self.rpi_ns
            _advance(self._lines, latest_ns)

    def _exchange(self, at_ns: int) -> None:
        for update, outputs, inputs in self._lines:
            inputs[:] = update(at_ns, outputs).raw
        self._sent[:] = self._waiting
        if self._starting:
            self._starting = False
            _set_modules_running(self._rack, True)


def _lines(rack: Rack, sent: bytearray) -> tuple[Line, ...]:
    """Connect every slot to its place in `sent`, a block with the layout of the rack's memory.

    Modules that follow others are updated after them, so that both are at the same instant.
    """
    slots = rack.slots.values()
    lines = [
        (slot.module.update, outputs, slot.inputs.raw)
        for slot, outputs in zip(slots, _images(rack, sent), strict=True)
    ]
    follow = [bool(getattr(slot.module, "follows", ())) for slot in rack.slots.values()]
    order = sorted(range(len(lines)), key=lambda place: follow[place])
    return tuple(lines[index] for index in order)


def _images(rack: Rack, sent: bytearray) -> list[Image]:
    """Return the output images in a block laid out like the rack's memory."""
    view = memoryview(sent)
    return [Image(buffer=view[places.outputs]) for places in rack.layout.places.values()]


def _advance(lines: tuple[Line, ...], now_ns: int) -> None:
    for update, outputs, _inputs in lines:
        update(now_ns, outputs)


def _set_modules_running(rack: Rack, running: bool) -> None:
    for slot in rack.slots.values():
        slot.module.plc_run(running)
