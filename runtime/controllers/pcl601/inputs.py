"""The controller's view of its inputs: contacts, levels, the analog voltage, the thumbwheel."""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.pcl601 import Error, Register
from scanrack.io_images.pcl601.terminals import HARD_LIMIT_BIT, SOFT_LIMIT_BIT

from .motor import Motor
from .pins import FULL_SCALE_VOLTS, Pcl601Pins
from .register_values import Values
from .wiring import Wiring

ALL_INPUTS = 0b111111
INPUTS_1_TO_4 = 0b001111


class Inputs:
    """The inputs as Modbus and ASCII report them.

    Args:
        motor: the motor that operates contacts by its position.
        wiring: SW2 and the thumbwheel.
        values: the registers with enable bits and ranges.
        report: function that sets an error bit.
    """

    def __init__(
        self, pins: Pcl601Pins, motor: Motor, wiring: Wiring, values: Values, report: Callable[[Error], None]
    ) -> None:
        self._pins, self._motor, self._wiring = pins, motor, wiring
        self._values, self._report = values, report

    def grounded(self) -> int:
        """Return the mask of grounded inputs 1 to 6; with SW2 at TWS, 5 and 6 are open."""
        pins = self._pins.general(self._motor.position)
        bits = sum(is_grounded << index for index, is_grounded in enumerate(pins))
        return bits & (INPUTS_1_TO_4 if self._wiring.thumbwheel_selected else ALL_INPUTS)

    def raw(self) -> int:
        """Return the mask of high inputs 1 to 6; an analog input 1 is high."""
        return ~self.grounded() & ALL_INPUTS | self._values[Register.ANALOG_ENABLE]

    def active(self) -> int:
        """Return the Modbus input register: inputs 1 to 6 and both limits; an analog input 1 is active."""
        bits = self.grounded() | self._values[Register.ANALOG_ENABLE]
        return bits | self.hard_limit << HARD_LIMIT_BIT | self.soft_limit << SOFT_LIMIT_BIT

    @property
    def hard_limit(self) -> bool:
        """Whether either hard limit is active."""
        return self._any_grounded("hard_plus", "hard_minus")

    @property
    def soft_limit(self) -> bool:
        """Whether either soft limit is active."""
        return self._any_grounded("soft_plus", "soft_minus")

    def _any_grounded(self, *names: str) -> bool:
        return any(self._pins.grounded(name, self._motor.position) for name in names)

    def analog_speed(self) -> int | None:
        """Return the maximum speed for the voltage on input 1, or None with an error bit."""
        if not self._values.analog_speed:
            return self._refuse(Error.ZERO_PARAMETERS)
        return self._analog(Register.ANALOG_SPEED_LOWER, Register.ANALOG_SPEED_UPPER)

    def analog_position(self) -> int | None:
        """Return the position for the voltage on input 1, or None with an error bit."""
        if not self._values.analog_position:
            return self._refuse(Error.ZERO_PARAMETERS)
        position = self._analog(Register.ANALOG_POS_LOWER, Register.ANALOG_POS_UPPER)
        if position is not None:
            self._values[Register.ANALOG_INDEX] = position
        return position

    def _analog(self, lower: Register, upper: Register) -> int | None:
        """Return `lower + (upper - lower) * V / 5`, rounded down; refuse it unless lower < upper."""
        lowest, highest = self._values[lower], self._values[upper]
        if lowest >= highest:
            return self._refuse(Error.RANGE)
        return lowest + int((highest - lowest) * self._pins.volts(self._motor.position) / FULL_SCALE_VOLTS)

    def thumbwheel(self) -> int | None:
        """Return the value of the seven digits, or None with an error bit."""
        if not self._values[Register.THUMBWHEEL_ENABLE]:
            return self._refuse(Error.ZERO_PARAMETERS)
        if self._wiring.thumbwheel is None or not self._wiring.thumbwheel_selected:
            return self._refuse(Error.THUMBWHEEL)
        return self._wiring.thumbwheel

    def _refuse(self, error: Error) -> int | None:
        self._report(error)
        return None
