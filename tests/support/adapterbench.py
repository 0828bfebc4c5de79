"""A PCL601 adapter on a bench: words in, bits out, and a controller whose true position can be looked at."""

from __future__ import annotations

from collections.abc import Iterable

from scanrack.io_images import Image
from scanrack.io_images.amci3601 import InputBit, status_names
from scanrack.io_images.thousands import join_reported, split_thousands
from scanrack.runtime.adapters.pcl601.module import Pcl601Adapter
from scanrack.runtime.events import JsonValue
from scanrack.runtime.machine import Machine, MachineSpec, Switch

MS = 1_000_000
CONFIGURE = (0x843E, 63, 1, 0)
"""External, home, emergency stop, both limits, all active high; starting speed 1000 steps/s."""


class AdapterBench:
    """One adapter, driven word by word.

    Args:
        switches: on the machine.
        scan_ms: period at which images are exchanged.
        options: of the adapter.
    """

    def __init__(self, *switches: Switch, scan_ms: float = 2, **options: JsonValue) -> None:
        self.module = Pcl601Adapter(Machine(MachineSpec(switches=switches)), options)
        self.scan_ns = round(scan_ms * MS)
        self.now_ns = 0
        self.outputs = Image()
        self.image = self.module.update(0, self.outputs)

    def put(self, *words: int) -> None:
        """Write the output words from now on; missing ones are 0."""
        self.outputs = Image(words)

    def run(self, ms: float, until: str = "") -> AdapterBench:
        """Let time run, or until a status bit is set after a scan at least."""
        end_ns = self.now_ns + round(ms * MS)
        while self.now_ns < end_ns:
            self.now_ns += self.scan_ns
            self.image = self.module.update(self.now_ns, self.outputs)
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
        self.give(*(words or CONFIGURE)).release()
        self.give(512).release()
        assert self.bits == {"MODULE_OK"}
        return self

    def level(self, bit: InputBit, energised: bool) -> None:
        """Energise an input."""
        self.module.machine.set_input(bit, energised)
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
    def motor(self) -> int:
        """Where the motor truly stands."""
        return self.module.controller.device.controller.motor.position

    @property
    def reasons(self) -> list[str]:
        """Names of the refusals so far."""
        return [event.name for event in self.module.events if event.kind == "refusal"]


def move(distance: int, speed: int = 5000, acceleration: int = 20, deceleration: int = 20) -> Iterable[int]:
    """Return the words of a relative move."""
    return (2, 0, *split_thousands(distance), *split_thousands(speed), acceleration, deceleration)
