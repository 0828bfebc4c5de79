"""AA ASCII: the direct mode for terminal programs [Anaheim Automation ASCII, Direct Talk].

    @1M2000 CR          device 1: maximum speed 2000; no reply
    @1VM CR             2000 CR LF
    @% CR               1 CR LF; % and ~ need no address

A device reads only commands with its address, between @ and CR, and ignores the replies of other devices on
the line. A refusal sets error bits and sends no reply.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from scanrack.io_images.pcl601 import Code, Error, Register
from scanrack.io_images.pcl601.talk import (
    BUFFER_MAX,
    BY_NAME,
    PARAMETERS_MAX,
    VERIFY,
    VERSION_TEXT,
    Action,
    Command,
)
from scanrack.io_images.pcl601.terminals import GENERAL_INPUTS, OUTPUT_COUNT

from .controller import Pcl601Controller, Protocol

START, END = ord("@"), ord("\r")
FLOW_CONTROL = frozenset(b"\x11\x13")
ADDRESSES = range(100)
END_OF_REPLY = "\r\n"

LINE = re.compile(r"(?P<address>[0-9]{1,2})?(?P<name>E[A-Z]?|.)?(?P<parameters>.*)", re.DOTALL)
NUMBER = re.compile(r"[+-]?[0-9]+")
NO_ADDRESS = ("%", "~")
FLAGS = {"0": 0, "1": 1}


class Direct:
    """Carries out ASCII lines and returns the replies."""

    def __init__(self, controller: Pcl601Controller) -> None:
        self._controller = controller
        self._line: bytearray | None = None  # the characters since @, None outside a line
        # an action returns the reply; None for no reply
        self._actions: dict[Action, Callable[[Command, str], str | None]] = {
            Action.SET: self._set,
            Action.DO: self._do,
            Action.HOME: self._home,
            Action.DIRECTION: self._direction,
            Action.ANALOG_POSITION: self._analog,
            Action.ANALOG_SPEED: self._analog,
            Action.OUTPUTS: self._outputs,
            Action.INPUTS: self._inputs,
            Action.VERIFY: self._verify,
            Action.ERRORS: self._without_parameters(lambda: str(int(controller.take_errors()))),
            Action.VERSION: self._without_parameters(lambda: VERSION_TEXT),
            Action.ADDRESS: self._without_parameters(lambda: str(controller.values[Register.ADDRESS])),
            Action.SET_ADDRESS: self._set_address,
            Action.TO_MODBUS: self._without_parameters(lambda: controller.speak(Protocol.MODBUS)),
        }

    def clear(self) -> None:
        """Drop an incomplete line."""
        self._line = None

    def receive(self, character: int) -> bytes:
        """Receive a character; if it completes a line, return the reply, otherwise no bytes."""
        if character == START:
            self._line = bytearray()
        elif self._line is None or character in FLOW_CONTROL:
            return b""
        elif character == END:
            line, self._line = self._line.decode("latin-1"), None
            return self._execute_line(line)
        elif len(self._line) + 1 >= BUFFER_MAX:  # the buffer contains @
            self._line = None
            self._controller.report(Error.RECEIVE_OVERFLOW)
        else:
            self._line.append(character)
        return b""

    def _execute_line(self, line: str) -> bytes:
        """Carry out a line addressed to this device; return the reply."""
        match = LINE.fullmatch(line)
        if match is None:
            return b""
        address, name, parameters = match.group("address", "name", "parameters")
        if address is None:
            is_addressed = name in NO_ADDRESS
        else:
            is_addressed = int(address) == self._controller.values[Register.ADDRESS]
        if not is_addressed:
            return b""
        reply = self._carry_out(name, parameters)
        return b"" if reply is None else (reply + END_OF_REPLY).encode("ascii")

    def _carry_out(self, name: str | None, parameters: str) -> str | None:
        """Carry out a command; return its reply, or None after a refusal or a command without a reply."""
        command = BY_NAME.get(name or "")
        if command is None:
            return self._refuse(Error.COMMAND)
        if self._controller.program_running and not command.while_running:
            return self._refuse(Error.MODE)
        if len(parameters) > PARAMETERS_MAX:
            return self._refuse(Error.RANGE)
        return self._actions[command.action](command, parameters)

    def _refuse(self, error: Error) -> str | None:
        """Set an error bit; return None, for no reply."""
        self._controller.report(error)
        return None

    def _without_parameters(self, action: Callable[[], str | None]) -> Callable[[Command, str], str | None]:
        """Wrap the action of a command so that it refuses parameters."""

        def check_and_act(_: Command, parameters: str) -> str | None:
            return self._refuse(Error.RANGE) if parameters else action()

        return check_and_act

    # commands that set

    def _set(self, command: Command, parameters: str) -> str | None:
        """Write a number to the command's register; without a number, carry out the command's code."""
        register, controller = command.register, self._controller
        if register is None:
            return self._refuse(Error.COMMAND)
        is_position = register is Register.ABS_TARGET
        if not parameters:
            if command.code is None:
                return self._refuse(Error.ZERO_PARAMETERS)
            if controller.do(command.code) and is_position:
                controller.aim_at(controller.values[Register.ABS_TARGET])
        elif not NUMBER.fullmatch(parameters):
            return self._refuse(Error.RANGE)
        elif is_position:
            controller.aim_at(int(parameters))
        else:
            controller.write(register, int(parameters))
        return None

    def _do(self, command: Command, parameters: str) -> str | None:
        """Carry out the command's code, without parameters."""
        if parameters:
            return self._refuse(Error.RANGE)
        if command.code is not None:
            self._controller.do(command.code)
        return None

    def _home(self, _: Command, parameters: str) -> str | None:
        """Start homing, type 0 or 1."""
        flag = self._flag(parameters)
        if flag is not None:
            self._controller.do(Code.HOME_TYPE_1 if flag else Code.HOME_TYPE_0)
        return None

    def _direction(self, command: Command, parameters: str) -> str | None:
        """Set the direction; + is up, - is down."""
        if parameters:
            return self._refuse(Error.RANGE)
        self._controller.write(Register.DIRECTION, int(command.name == "+"))
        return None

    def _analog(self, command: Command, parameters: str) -> str | None:
        """Enable (1) or disable (0) the analog function of the command."""
        flag = self._flag(parameters)
        if flag is not None and command.action is Action.ANALOG_SPEED:
            self._controller.values.set_analog(speed=bool(flag))
        elif flag is not None:
            self._controller.values.set_analog(position=bool(flag))
        return None

    def _flag(self, parameters: str) -> int | None:
        """Return 0 or 1; for any other value, set an error bit and return None."""
        if parameters not in FLAGS:
            self._refuse(Error.RANGE if parameters else Error.ZERO_PARAMETERS)
        return FLAGS.get(parameters)

    def _outputs(self, _: Command, parameters: str) -> str | None:
        """Set one output, `3=1`, or all outputs, `R5`."""
        if parameters in ("", "R"):
            return self._refuse(Error.ZERO_PARAMETERS)
        if output := re.fullmatch(f"([1-{OUTPUT_COUNT}])=([01])", parameters):
            mask = 1 << int(output[1]) - 1
            self._controller.set_outputs(mask if output[2] == "1" else 0, mask)
        elif (match := re.fullmatch("R([0-9]+)", parameters)) and int(match[1]) < 1 << OUTPUT_COUNT:
            self._controller.set_outputs(int(match[1]))
        else:
            return self._refuse(Error.RANGE)
        return None

    def _set_address(self, _: Command, parameters: str) -> str | None:
        """Set the address on the line, 0 to 99."""
        if not parameters:
            return self._refuse(Error.ZERO_PARAMETERS)
        if not re.fullmatch("[0-9]+", parameters) or int(parameters) not in ADDRESSES:
            return self._refuse(Error.RANGE)
        self._controller.values[Register.ADDRESS] = int(parameters)
        return None

    # commands that answer

    def _inputs(self, _: Command, parameters: str) -> str | None:
        """Return the level of one input; for R, return a mask of the inputs at low level."""
        raw = self._controller.inputs.raw()
        if parameters == "R":
            return str(~raw & (1 << len(GENERAL_INPUTS)) - 1)
        if re.fullmatch(f"[1-{len(GENERAL_INPUTS)}]", parameters):
            return str(raw >> int(parameters) - 1 & 1)
        return self._refuse(Error.RANGE if parameters else Error.ZERO_PARAMETERS)

    def _verify(self, _: Command, parameters: str) -> str | None:
        """Return the value of a register, of the limits, of the outputs or of an analog function."""
        controller = self._controller
        if parameters in VERIFY:
            return str(controller.register(VERIFY[parameters]))
        values = {
            "L": controller.inputs.hard_limit | controller.inputs.soft_limit << 1,
            "O": controller.output_pins,
            ":": controller.values.analog_position,
            ";": controller.values.analog_speed,
        }
        if parameters in values:
            return str(int(values[parameters]))
        return self._refuse(Error.COMMAND if parameters else Error.ZERO_PARAMETERS)
