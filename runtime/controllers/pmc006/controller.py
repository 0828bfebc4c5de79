"""A simulated PMC006x3s without its serial line: instructions, responses, pins and motor.

Between instructions, closed forms of time and events determine the state. An event is a pin change at a motor
position, the end of a motion, or a user instruction. The result does not depend on how often `advance` is
called.
"""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.pmc006.frame import FACTORY_ADDRESS, STATE_ERROR, UNKNOWN_ERROR
from scanrack.io_images.pmc006.instructions import BY_CODE, BY_NAME, InstructionRow, Kind
from scanrack.io_images.pmc006.program import UserProgram
from scanrack.io_images.pmc006.status import GPIO_EFFECTIVE, Gpio, Level, Status1, Status2
from scanrack.io_images.site import SettingError

from ...machine.contacts import Contact
from .interpreter import Interpreter
from .memory import Memory
from .pins import Pin, Pmc006Pins
from .pmc006_controller_options import Pmc006ControllerOptions
from .pmc006_motor import MotorActivity, SimulatedPmc006Axis

SUPPLY_LIMIT_V = 9.0
"""Lowest supply voltage [7]; below it, status bit UVL is set."""

Handler = Callable[["Pmc006Controller", int], int]
"""Function that carries out an instruction with its data and returns the response data."""


class Pmc006Controller:
    """A PMC006x3s without its line.

    Attributes:
        gpio: the outputs.
        supply_v: supply voltage, V.

    Args:
        address: address in the EEPROM, 1 to 120, or 255, the factory setting.
        program: program in the EEPROM; it does not start yet.

    Raises:
        ValueError: the address is invalid.
    """

    def __init__(
        self,
        options: Pmc006ControllerOptions | None = None,
        address: int = FACTORY_ADDRESS,
        program: UserProgram | None = None,
    ) -> None:
        if address != FACTORY_ADDRESS and not BY_NAME["device_address"].allows(address):
            raise SettingError(
                "address", f"address {address}: must be 1 to 120, or {FACTORY_ADDRESS} (factory setting)"
            )
        self.options = options or Pmc006ControllerOptions()
        self.memory = Memory()
        self.memory.preset("device_address", address)
        if program is not None:
            self.memory.lines = program.lines
        self.pins: Pmc006Pins = Pmc006Pins()
        self.axis: SimulatedPmc006Axis = SimulatedPmc006Axis(self.memory, self.pins)
        self.interpreter: Interpreter = Interpreter(self)
        self.pins.on_change = self._on_pins
        self.gpio = Gpio.GPIO8
        self.supply_v = 24.0
        self.overheated = False
        self.now_ns = 0

    # -- time --------------------------------------------------------------------------------

    def next_ns(self) -> int:
        """Return the instant of the next event, or `kinematics.FOREVER` if there is none."""
        return min(self.axis.next_ns(), self.interpreter.next_ns(self.now_ns))

    def advance(self, now_ns: int) -> None:
        """Handle all events up to and including `now_ns`."""
        while (due_ns := self.next_ns()) <= now_ns:
            self._arrive(due_ns)
            self.axis.end_if_due(due_ns)
            self.interpreter.tick(due_ns)
        self._arrive(now_ns)

    def _arrive(self, now_ns: int) -> None:
        """Update the motor's position and the pins to an instant at or before the next event."""
        self.now_ns = now_ns
        self.axis.go_to(now_ns)
        self.pins.sense(self.axis.physical)

    # -- actions ---------------------------------------------------------------------------

    def execute(self, code: int, data: int) -> int:
        """Carry out an instruction; return the response data.

        The data is error 6 for a refused instruction, and error 7 for an unknown one.

        Args:
            data: 32 bits, signed.
        """
        row = BY_CODE.get(code)
        if row is None:
            return UNKNOWN_ERROR
        if row.asks_by_zero and data == 0:
            return self.memory[row.name]
        if not self._allows(row, data):
            return STATE_ERROR
        handler = HANDLERS.get(row.name)
        if handler is not None:
            return handler(self, data)
        if row.kind is Kind.SET:
            self.memory[row.name] = data
        return self.memory[row.shows or row.name]

    def set_pin(self, pin: Pin, level: bool | Contact) -> None:
        """Hold an input high (True) or low (False), or connect it to a switch."""
        self.pins.hold(pin, level)
        self.pins.sense(self.axis.physical)

    def stall(self) -> None:
        """Stall a moving motor; the open-loop type has no encoder and ignores the stall."""
        if self.options.closed_loop and self.axis.moving:
            self.axis.stall()

    def power_cycle(self) -> None:
        """Cycle the power: saved parameters stay, all others return to their defaults."""
        self.memory.load()
        self.gpio = Gpio.GPIO8
        self.axis.power_up()
        self.interpreter.stop()
        if self.memory["offline_execution"]:
            self.interpreter.start(self.now_ns)

    def abort(self) -> None:
        """End any motion at once [instruction I]."""
        self.axis.halt()

    # -- state ------------------------------------------------------------------------------

    @property
    def address(self) -> int:
        """The device address."""
        return self.memory["device_address"]

    @property
    def gpio8(self) -> bool:
        """Whether the 5 V output is on."""
        return bool(self.gpio & Gpio.GPIO8)

    @property
    def coil_percent(self) -> int:
        """Duty cycle of the solenoid output, in percent [4.3.11]."""
        return self.memory["solenoid"]

    @property
    def levels(self) -> Level:
        """The pins, as instruction x reads them."""
        inputs = self.pins.levels & (Level.EXT1 | Level.EXT2 | Level.FSET)
        return Level(inputs) | (Level.GPIO8 if self.gpio8 else Level(0))

    @property
    def status1(self) -> Status1:
        """Status register 1."""
        flags = {
            Status1.BUSY: self.axis.moving,
            Status1.AUTO_DEC: self.memory["auto_current_decay"],
            Status1.STALL: self.axis.stalled,
            Status1.HOME: self.axis.homing,
            Status1.UVL: self.supply_v < SUPPLY_LIMIT_V,
        }
        return self.axis.flags | Status1(sum(bit for bit, is_on in flags.items() if is_on))

    @property
    def status2(self) -> Status2:
        """Status register 2."""
        memory = self.memory
        flags = {
            Status2.FREE_RUN: memory["free_run"],
            Status2.EXT1_EN: memory["ext_stop_enable"] & 1,
            Status2.COIL: memory["solenoid"],
            Status2.SPEED_MODE: self.axis.doing is MotorActivity.SPEED,
            Status2.DIR: memory["direction"],
            Status2.OFFLINE_AUTO: memory["offline_execution"],
            Status2.EXT2_EN: memory["ext_stop_enable"] & 2,
            Status2.OTS: self.overheated,
        }
        return Status2(sum(bit for bit, is_on in flags.items() if is_on))

    # -- instructions ------------------------------------------------------------------------

    def _allows(self, row: InstructionRow, data: int) -> bool:
        """Return whether this type of controller accepts an instruction's data."""
        if row.name == "microstepping" and data == 256:
            return self.options.max_microstep == 256
        if row.name == "set_position" and self.options.i_signed:
            return True
        return row.allows(data)

    def _step(self, steps: int) -> int:
        """Begin a move; return the acknowledgment, or an error."""
        if not (self.axis.may_start and self.axis.speeds_fit):
            return STATE_ERROR
        if self.axis.against_limit:
            return UNKNOWN_ERROR
        self.axis.step(self.now_ns, steps)
        return self.options.step_ack_value

    def _speed_mode(self, run: int) -> int:
        """Begin to run and return 1, or slow down and return 0; return an error for a refused motion."""
        if not run:
            self.axis.slow_down(self.now_ns)
            return 0
        if not (self.axis.may_start and self.axis.speeds_fit):
            return STATE_ERROR
        if self.axis.against_limit:
            return UNKNOWN_ERROR
        self.axis.run(self.now_ns)
        return 1

    def _zero_back(self, stroke: int) -> int:
        """Begin to search for the switch within a stroke; return 0, or an error."""
        if not self.axis.may_start:
            return STATE_ERROR
        self.axis.zero_back(self.now_ns, stroke)
        return 0

    def _abort(self, _data: int) -> int:
        self.abort()
        return 0

    def _free_run(self, released: int) -> int:
        """Release the motor, which ends its motion, or hold it; return the data."""
        if released:
            self.abort()
        self.memory["free_run"] = released
        return released

    def _clear_ext1(self, _data: int) -> int:
        self.axis.flags &= ~Status1.EXT1
        return 0

    def _clear_ext2(self, _data: int) -> int:
        self.axis.flags &= ~Status1.EXT2
        return 0

    def _set_position(self, position: int) -> int:
        self.axis.position = position
        return 0  # like an action: a response with position 6 or 7 would look like a refusal

    def _write_io(self, word: int) -> int:
        self.gpio = Gpio(word) & GPIO_EFFECTIVE
        return 0

    def _save(self, _data: int) -> int:
        self.memory.save()
        return 0

    def _run_program(self, _data: int) -> int:
        if not self.memory.lines:
            return STATE_ERROR
        self.interpreter.start(self.now_ns)
        return 0

    def _on_pins(self, changed: int, levels: int) -> None:
        """Pass changed pins to the axis, and pins that went low to the user program."""
        self.axis.on_pins(changed, levels)
        self.interpreter.on_pins(changed & ~levels)


HANDLERS: dict[str, Handler] = {
    "step": Pmc006Controller._step,
    "speed_mode": Pmc006Controller._speed_mode,
    "zero_back": Pmc006Controller._zero_back,
    "abort": Pmc006Controller._abort,
    "free_run": Pmc006Controller._free_run,
    "clear_ext1_flag": Pmc006Controller._clear_ext1,
    "clear_ext2_flag": Pmc006Controller._clear_ext2,
    "set_position": Pmc006Controller._set_position,
    "write_io": Pmc006Controller._write_io,
    "save_parameters": Pmc006Controller._save,
    "run_user_program": Pmc006Controller._run_program,
    "read_position": lambda controller, _data: controller.axis.position,
    "read_status1": lambda controller, _data: int(controller.status1),
    "read_status2": lambda controller, _data: int(controller.status2),
    "read_levels": lambda controller, _data: int(controller.levels),
    "read_device_id": lambda controller, _data: controller.options.device_id,
    "read_firmware": lambda controller, _data: controller.options.firmware,
}
"""Handlers for the instructions that do more than read or write a parameter."""
