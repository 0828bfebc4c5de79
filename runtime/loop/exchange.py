"""The exchange of images across the backplane, between the rack's memory and the modules.

End of scan (MicroLogix): inputs are read at the beginning of a scan, and outputs are sent at its end. A scan
takes no virtual time, so the outputs of scan n take effect at the instant of scan n. Scan n + 1 sees the
module after one period with these outputs.

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

An exchange at the same instant as a scan precedes the scan: the scan sees the new inputs, and its outputs
wait for the next exchange. The logic of a real scan takes time, so `exchange_early` carries out the next
exchange in the middle of the logic.
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
    """The exchange of images, as the scan loop uses it."""

    __slots__ = ("_lines", "_memory", "_prediction", "_rack", "_sent")

    def attach(self, rack: Rack) -> None:
        """Connect to a rack's memory and modules; the outputs in effect are 0."""
        self._rack, self._memory = rack, rack.memory
        self._sent = bytearray(len(rack.memory))
        self._lines = _lines(rack, self._sent)
        self._prediction = RackPrediction(rack, _images(rack, self._sent))

    @abstractmethod
    def latch_inputs(self, now_ns: int) -> bool:
        """Advance the modules and write their inputs at `now_ns`; return whether there was an exchange."""

    @abstractmethod
    def latch_outputs(self) -> None:
        """Send the output images in the rack's memory."""

    @abstractmethod
    def start(self) -> None:
        """Inform the modules that the PLC is running, at the time when the latest outputs are sent."""

    def stop(self) -> None:
        """Inform the modules immediately that the PLC is not running; the latest outputs stay in effect."""
        _set_modules_running(self._rack, False)

    def call_before_change(self, notice: Callable[[], None]) -> None:
        """Arrange for `notice` to be called before anything except this exchange acts on a module."""
        self._prediction.call_before_change(notice)

    def exchange_early(self, end_ns: int) -> bool:
        """Exchange images in a scan that ends at `end_ns`; return whether an exchange is due by then."""
        return False

    @abstractmethod
    def calm_scans(self, now_ns: int, period_ns: int) -> int:
        """Return how many scans from `now_ns` on can be computed in advance if the outputs stay the same."""

    @abstractmethod
    def foresee(self, now_ns: int, period_ns: int, count: int, most_rows: int) -> Block:
        """Return a block of scans computed in advance, the first one at `now_ns`.

        Args:
            count: number of scans, at most `calm_scans`.
            most_rows: maximum number of scans if an axis is moving.
        """

    @abstractmethod
    def catch_up(self, now_ns: int) -> None:
        """Advance the modules to the scan at `now_ns`, after scans that used a block."""


Line: TypeAlias = tuple[Callable[[int, Image], Image], Image, memoryview]
"""The connection of one module: its `update`, its outputs in effect, and the memory of its inputs."""


class EndOfScan(Exchange):
    """Exchanges inputs at the beginning of a scan and outputs at its end, as on a MicroLogix."""

    __slots__ = ("_latest_ns",)

    @override
    def attach(self, rack: Rack) -> None:
        super().attach(rack)
        self._latest_ns = 0

    @override
    def latch_inputs(self, now_ns: int) -> bool:
        """Advance every module to `now_ns`, and copy its inputs."""
        self._latest_ns = now_ns
        for update, outputs, inputs in self._lines:
            inputs[:] = update(now_ns, outputs).raw
        return True

    @override
    def latch_outputs(self) -> None:
        """Send all outputs, which take effect at the instant of the scan."""
        self._sent[:] = self._memory

    @override
    def start(self) -> None:
        """Inform the modules at the end of this scan."""
        _set_modules_running(self._rack, True)

    @override
    def calm_scans(self, now_ns: int, period_ns: int) -> int:
        outputs_of = self._prediction.outputs_of
        if outputs_of(self._memory) != outputs_of(self._sent):
            return 0
        return max(0, -(-(self._prediction.calm_until_ns() - now_ns) // period_ns))

    @override
    def foresee(self, now_ns: int, period_ns: int, count: int, most_rows: int) -> Block:
        rows = self._prediction.rows(self._latest_ns, now_ns, period_ns, min(count, most_rows))
        return Block.all_updated(rows, count)

    @override
    def catch_up(self, now_ns: int) -> None:
        self._latest_ns = now_ns
        _advance(self._lines, now_ns)


class RecordedAtRpi(EndOfScan):
    """Replays a trace's inputs, which change with each scan; its exchanges are due as in `EveryRpi`.

    Args:
        rpi_ns: interval between the exchanges of the trace.
    """

    __slots__ = ("_next_ns", "_rpi_ns")

    def __init__(self, rpi_ns: int) -> None:
        self._rpi_ns = rpi_ns
        self._next_ns = 0

    @override
    def latch_inputs(self, now_ns: int) -> bool:
        """Read the inputs in every scan; return whether the trace had an exchange by `now_ns`."""
        super().latch_inputs(now_ns)
        due = self._next_ns <= now_ns
        if due:
            self._next_ns = (now_ns // self._rpi_ns + 1) * self._rpi_ns
        return due


class EveryRpi(Exchange):
    """Exchanges images every RPI, independently of the scan, as on a CompactLogix.

    Exchanges take place at 0, rpi, 2 * rpi, ... Every exchange advances every module.

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
        """Connect to a rack; the first exchange is at 0."""
        super().attach(rack)
        self._waiting = bytearray(len(rack.memory))
        self._next_ns = 0
        self._starting = False

    @override
    def latch_inputs(self, now_ns: int) -> bool:
        """Carry out all exchanges due by `now_ns`; return whether there were any."""
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
        """Carry out the next exchange if it is due by the end of the scan; return whether it was."""
        due = self._next_ns <= end_ns
        if due:
            self._exchange(self._next_ns)
            self._next_ns += self.rpi_ns
        return due

    @override
    def start(self) -> None:
        """Inform the modules at the next exchange, which sends the outputs."""
        self._starting = True

    @override
    def stop(self) -> None:
        self._starting = False
        super().stop()

    @override
    def calm_scans(self, now_ns: int, period_ns: int) -> int:
        """Return how many scans come before the first unknown exchange; 0 while the outputs change."""
        outputs_of = self._prediction.outputs_of
        is_steady = outputs_of(self._memory) == outputs_of(self._sent) == outputs_of(self._waiting)
        if self._starting or not is_steady:
            return 0
        # exchanges and then scans, rounded up: both are counted up to the first unknown instant
        calm_exchanges = max(0, -(-(self._prediction.calm_until_ns() - self._next_ns) // self.rpi_ns))
        unknown_ns = self._next_ns + calm_exchanges * self.rpi_ns
        return max(0, -(-(unknown_ns - now_ns) // period_ns))

    @override
    def foresee(self, now_ns: int, period_ns: int, count: int, most_rows: int) -> Block:
        """Return the rows for the next scans; each scan sees the inputs of its latest exchange."""
        latest_ns, rpi_ns = self._next_ns - self.rpi_ns, self.rpi_ns
        if period_ns % rpi_ns == 0:  # each scan sees only its last exchange
            first_ns = now_ns // rpi_ns * rpi_ns
            return Block.all_updated(
                self._prediction.rows(latest_ns, first_ns, period_ns, min(count, most_rows)), count
            )
        # the exchanges in these scans, which may be more than the scans, must also fit into `most_rows`
        count = min(count, most_rows, 1 + (most_rows - 1) * rpi_ns // period_ns)
        # for each scan the index of its latest exchange: the next exchange has index 0, the one before -1
        latest = [(now_ns + scan * period_ns - self._next_ns) // rpi_ns for scan in range(count)]
        exchange_count = latest[-1] + 1
        rows = [bytes(self._memory)]  # of index -1
        if exchange_count:
            coming = self._prediction.rows(latest_ns, self._next_ns, rpi_ns, exchange_count)
            rows += [coming] * exchange_count if isinstance(coming, bytes) else coming
        updated = [index > previous for previous, index in pairwise([-1, *latest])]
        return Block([rows[index + 1] for index in latest], count, updated)

    @override
    def catch_up(self, now_ns: int) -> None:
        if self._next_ns <= now_ns:
            latest_ns = now_ns // self.rpi_ns * self.rpi_ns
            self._next_ns = latest_ns + self.rpi_ns
            _advance(self._lines, latest_ns)

    def _exchange(self, at_ns: int) -> None:
        """Update all modules with the previously sent outputs, read inputs, and send the queued outputs."""
        for update, outputs, inputs in self._lines:
            inputs[:] = update(at_ns, outputs).raw
        self._sent[:] = self._waiting
        if self._starting:
            self._starting = False
            _set_modules_running(self._rack, True)


def _lines(rack: Rack, sent: bytearray) -> tuple[Line, ...]:
    """Return the connections of all modules; `sent` has the layout of the rack's memory.

    Modules that follow others come last, so that they see the other modules at the same instant.
    """
    pairs = zip(rack.slots.values(), _images(rack, sent), strict=True)
    ordered = sorted(pairs, key=lambda pair: bool(getattr(pair[0].module, "follows", ())))
    return tuple((slot.module.update, outputs, slot.inputs.raw) for slot, outputs in ordered)


def _images(rack: Rack, sent: bytearray) -> list[Image]:
    """Return the output images in `sent`, which has the layout of the rack's memory."""
    view = memoryview(sent)
    return [Image(buffer=view[places.outputs]) for places in rack.layout.places.values()]


def _advance(lines: tuple[Line, ...], now_ns: int) -> None:
    for update, outputs, _inputs in lines:
        update(now_ns, outputs)


def _set_modules_running(rack: Rack, running: bool) -> None:
    for slot in rack.slots.values():
        slot.module.plc_run(running)
