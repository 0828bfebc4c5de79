"""A PMC006 on its line, spoken to frame by frame in virtual time."""

from __future__ import annotations

from scanrack.io_images.pmc006.frame import Frame, command, decode
from scanrack.io_images.pmc006.instructions import BY_NAME
from scanrack.io_images.pmc006.program import assemble
from scanrack.io_images.pmc006.status import Status1, Status2
from scanrack.runtime import Contact, SerialBus
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.controllers.pmc006.pmc006_controller_options import Pmc006ControllerOptions
from scanrack.runtime.kinematics import FOREVER
from scanrack.runtime.line.pmc006_frames import LINE_FORMAT

MS = 1_000_000
SILENCE_NS = 300 * MS


class Bench006:
    """One controller and a host that sends frames to it."""

    def __init__(self, address: int = 1, program: str = "", **options: int) -> None:
        self.controller = Pmc006Controller(Pmc006ControllerOptions(**options), address, assemble(program))  # type: ignore[arg-type]
        self.device = Pmc006(self.controller)
        self.bus = SerialBus(self.device)
        self.address = address

    def exchange(self, data: bytes) -> bytes:
        """Put bytes on the line; return the answer, or what has come 300 ms after the last of them."""
        end_ns = self.bus.send(data, LINE_FORMAT)
        self.bus.run_until(end_ns)
        while self.bus.now_ns < end_ns + SILENCE_NS and len(self.bus.heard) < 8:
            self.bus.run_until(min(self.bus.next_event_ns() or FOREVER, end_ns + SILENCE_NS))
        return self.bus.take()

    def text(self, frame: str) -> str:
        """Exchange hex text."""
        return self.exchange(bytes.fromhex(frame)).hex(" ")

    def ask(self, char: str, data: int = 0) -> int:
        """Send an instruction; return the data of the answer."""
        answer = decode(self.exchange(command(self.address, ord(char), data)))
        assert isinstance(answer, Frame)
        assert answer.second == 0x7A
        return answer.data

    def set(self, **values: int) -> None:
        """Set parameters by name; each must be taken."""
        for name, value in values.items():
            assert self.ask(BY_NAME[name].char, value) == value, name

    def wait(self, ms: float) -> None:
        """Let time run."""
        self.bus.run_until(self.bus.now_ns + round(ms * MS))

    def pin(self, pin: Pin, level: bool | Contact) -> None:
        """Give a pin a level."""
        self.controller.set_pin(pin, level)

    def power_cycle(self) -> None:
        """Take the power away and give it back."""
        self.device.power_cycle(self.bus.now_ns)
        self.address = self.controller.address

    @property
    def position(self) -> int:
        """The position register, over the line."""
        return self.ask("c")

    @property
    def status1(self) -> Status1:
        """Status register 1, over the line."""
        return Status1(self.ask("j"))

    @property
    def status2(self) -> Status2:
        """Status register 2, over the line."""
        return Status2(self.ask("O"))
