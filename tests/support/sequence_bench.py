"""Logic in Python on a small rack, scan by scan: a 3601 in slot 1, a card with inputs and outputs in slot 2.

bench = SequenceBench(Line)
bench.press(0).scan(3)
assert bench.lamp(0)

The card's input n is Local:2:I.Data.n, its output n Local:2:O.Data.n. Input 0 is named start, input 1 stop.
"""

from __future__ import annotations

from typing import Any

from bench3601 import CONFIGURATION
from scanrack import Configuration
from scanrack.io_images.amci3601 import WORDS_3601, InputBit
from scanrack.io_images.cards import DISCRETE16
from scanrack.io_images.image import Image
from scanrack.ladder.python.sequences import Sequence, sequences_of
from scanrack.runtime import Amci3601, Card, Cpu, Rack, Watchdog
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.exchange import EndOfScan, EveryRpi
from scanrack.runtime.loop.scan import CpuMode
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.modules.cards.card_options import CardOptions

NO_WATCHDOG = Watchdog(0)
"""For benches that run one scan at a time: arming it costs as much as the scan."""

PERIOD_NS = 2_000_000
SETUP = Configuration.from_image(Image(CONFIGURATION))
RATES: Any = {"acceleration": 20, "deceleration": 10}
SLOW: Any = {"speed": 5_000, **RATES}

CARD_WORDS = CardOptions(inputs={"start": 0, "stop": 1}).words(DISCRETE16)


class Terminals:
    """A card whose inputs a test sets."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.inputs = Image()

    def update(self, now_ns: int, outputs: Image) -> Image:
        return self.inputs

    def plc_run(self, running: bool) -> None:
        pass

    def power_cycle(self) -> None:
        pass


class SequenceBench:
    """A rack and the logic that runs on it.

    Args:
        kind: the class of the logic, or an instance.
        firmware: of the 3601.
        switches: switch ranges by input name.
        rpi_ms: period of an asynchronous exchange; None exchanges at the end of the scan.
        scan_ms: scan period.
    """

    def __init__(
        self,
        kind: Any,
        *,
        firmware: str = "4.1",
        switches: dict[str, tuple[int | None, int | None]] | None = None,
        rpi_ms: int | None = None,
        scan_ms: int = 2,
    ) -> None:
        wired = tuple(Switch(InputBit[name.upper()], *ends) for name, ends in (switches or {}).items())
        self.module = Amci3601(firmware, Machine(MachineSpec(switches=wired)))
        self.card = Terminals()
        self.rack = Rack(
            [
                Card(1, self.module, "amci3601", firmware, WORDS_3601),
                Card(2, self.card, "discrete16", "", CARD_WORDS),
            ]
        )
        self.logic: Any = kind() if isinstance(kind, type) else kind
        exchange = EndOfScan() if rpi_ms is None else EveryRpi(rpi_ms * 1_000_000)
        self.cpu = Cpu(self.rack, self.logic, scan_ms * 1_000_000, exchange=exchange, watchdog=NO_WATCHDOG)

    def scan(self, scans: int = 1) -> SequenceBench:
        """Let scans pass."""
        self.cpu.run(scans)
        return self

    def press(self, number: int, on: bool = True) -> SequenceBench:
        """Set an input of the card, from the next scan on."""
        self.card.inputs.set_bit(0, number, on)
        return self

    def estop(self, pressed: bool) -> SequenceBench:
        """Press or release the emergency stop of the 3601."""
        self.module.machine.set_input(InputBit.ESTOP, pressed)
        self.module.look_again()
        return self

    def restart(self) -> SequenceBench:
        """Turn the key to program mode and back to run, with a scan in program mode."""
        self.cpu.mode = CpuMode.PROGRAM
        self.cpu.run(1)
        self.cpu.mode = CpuMode.RUN
        return self

    def until(self, condition: Any, scans: int = 20_000) -> SequenceBench:
        """Scan until a condition is true."""
        for _ in range(scans):
            if condition():
                return self
            self.cpu.run(1)
        raise AssertionError(f"it never came: {[str(each) for each in self.sequences]}")

    def lamp(self, number: int) -> bool:
        """Return whether an output of the card is on."""
        return self.rack.slots[2].outputs.bit(0, number)

    @property
    def words(self) -> list[int]:
        """Output words of the 3601."""
        return list(self.rack.slots[1].outputs)

    @property
    def sequences(self) -> tuple[Sequence, ...]:
        return sequences_of(self.logic)
