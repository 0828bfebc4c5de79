"""An adapter on a bench: words in, bits out, and a controller whose true position can be looked at."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from scanrack.io_images import Image
from scanrack.io_images.amci3601 import InputBit, status_names
from scanrack.io_images.thousands import join_reported, split_thousands
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.modules.adapters.amci_drive.module import AMCI_DRIVE
from scanrack.runtime.modules.adapters.amci_drive.simulated import SimulatedDrive
from scanrack.runtime.modules.adapters.module import SimulatedAdapter
from scanrack.runtime.modules.adapters.pcl601.module import PCL601
from scanrack.runtime.modules.adapters.pcl601.simulated import SimulatedPcl601
from scanrack.runtime.modules.adapters.pmc006.module import PMC006
from scanrack.runtime.modules.adapters.pmc006.simulated import SimulatedPmc006

MS = 1_000_000
CONFIGURE = (0x843E, 63, 1, 0)
"""External, home, emergency stop, both limits, all active high; starting speed 1000 steps/s."""

REST = 0b1001_1100
"""HOLD_STATE, STOPPED, AT_HOME and MOVE_COMPLETE in input word 0."""

CONFIGURED = {"MODULE_OK", "MODE_CONFIG"}
"""What is shown of a configuration that the controller has."""

CONFIGURE_006 = (0x843C, 63, 1, 0)
"""The same without the external input, for which a PMC006 has no use."""


class AdapterBench:
    """One adapter, driven word by word.

    Attributes:
        lies: instants at which an image has claimed rest while the motor turned, ms.

    Args:
        switches: on the machine.
        scan_ms: period at which images are exchanged.
        options: of the adapter.
    """

    configuration = CONFIGURE

    def __init__(self, *switches: Switch, scan_ms: float = 2, **options: JsonValue) -> None:
        self.module = self.make(Machine(MachineSpec(switches=switches)), options)
        self.scan_ns = round(scan_ms * MS)
        self.now_ns = 0
        self.lies: list[float] = []
        self.outputs = Image()
        self.image = self.module.update(0, self.outputs)

    def make(self, machine: Machine, options: Mapping[str, JsonValue]) -> SimulatedAdapter[Any]:
        """Make the adapter."""
        return PCL601.simulated(machine, options)

    def put(self, *words: int) -> None:
        """Write the output words from now on; missing ones are 0."""
        self.outputs = Image(words)

    def run(self, ms: float, until: str = "") -> AdapterBench:
        """Let time run, or until a status bit is set after a scan at least."""
        end_ns = self.now_ns + round(ms * MS)
        while self.now_ns < end_ns:
            self.now_ns += self.scan_ns
            self.image = self.module.update(self.now_ns, self.outputs)
            if self.image[0] & REST and self.image[0] >= 0 and self.device.motor_turns:
                self.lies.append(self.now_ns / MS)
            if until and until in self.bits:
                break
        return self

    def give(self, *words: int, ms: float = 300, until: str = "") -> AdapterBench:
        """Write words and let time run."""
        self.put(*words)
        return self.run(ms, until)

    def release(self, ms: float = 100) -> AdapterBench:
        """Take all bits away."""
        return self.give(ms=ms)

    def configured(self, *words: int) -> AdapterBench:
        """Configure, leave configuration mode, and make the position valid at 0."""
        self.put(*(words or self.configuration))
        end_ns = self.now_ns + 400 * MS  # a PMC006 takes 370 ms, a drive 6
        while self.bits != CONFIGURED and self.now_ns < end_ns:
            self.run(self.scan_ns / MS)
        self.release(20)
        self.give(512, ms=20).release(20)
        assert self.bits == {"MODULE_OK"}
        return self

    def level(self, bit: InputBit, energized: bool) -> None:
        """Energize an input."""
        self.module.machine.set_input(bit, energized)
        self.module.look_again()

    @property
    def bits(self) -> set[str]:
        """Names of the status bits that are set."""
        return set(status_names(self.image[0] & 0xFFFF, self.image[1] & 0xFFFF))

    @property
    def position(self) -> int:
        """As the image has it."""
        return join_reported(self.image[2], self.image[3])

    @property
    def device(self) -> Any:
        """The simulated controller: a Pcl601, a Pmc006, or a drive."""
        plant = self.module.controller
        assert isinstance(plant, SimulatedPcl601 | SimulatedPmc006 | SimulatedDrive)
        return plant.device

    @property
    def motor(self) -> int:
        """Where the motor truly stands."""
        return int(self.device.motor_position)

    @property
    def reasons(self) -> list[str]:
        """Names of the refusals so far."""
        return self.told("refusal")

    def told(self, kind: str) -> list[str]:
        """Names of the events of a kind so far."""
        return [event.name for event in self.module.events if event.kind == kind]


class AdapterBench006(AdapterBench):
    """The same over a PMC006, whose strokes home are up to 100,000 steps."""

    configuration = CONFIGURE_006

    def make(self, machine: Machine, options: Mapping[str, JsonValue]) -> SimulatedAdapter[Any]:
        """Make the adapter."""
        return PMC006.simulated(machine, {"home_stroke": 100_000, **options})


CONFIGURE_DRIVE = (0x8414, 63, 1, 0)
"""Home and CW limit, both active high; starting speed 1000 steps/s."""


class AdapterBenchDrive(AdapterBench):
    """The same over a networked drive, which has two inputs."""

    configuration = CONFIGURE_DRIVE

    def make(self, machine: Machine, options: Mapping[str, JsonValue]) -> SimulatedAdapter[Any]:
        """Make the adapter."""
        return AMCI_DRIVE.simulated(machine, options)


BENCHES = {"PCL601": AdapterBench, "PMC006": AdapterBench006, "drive": AdapterBenchDrive}


def move(distance: int, speed: int = 5000, acceleration: int = 20, deceleration: int = 20) -> Iterable[int]:
    """Return the words of a relative move."""
    return (2, 0, *split_thousands(distance), *split_thousands(speed), acceleration, deceleration)
