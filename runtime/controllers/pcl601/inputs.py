"""The controller's view of its inputs: contacts, levels, the analog voltage, the thumbwheel."""

from __future__ import annotations

from collections.abc import Callable

from scanrack.io_images.pcl601 import Error, Register
from scanrack.io_images.pcl601.terminals import HARD_LIMIT_BIT, SOFT_LIMIT_BIT

from .motor import Motor
from .pins import FULL_SCALE_VOLTS, Pcl601Pins
from .register_values import Values
from .wiring import Wiring

ALL = 0b111111
WITHOUT_5_AND_6 = 0b001111


class Inputs:
    """The inputs as Modbus and ASCII report them.

    Args:
        motor: the motor whose position operates contacts.
        wiring: SW2 and the thumbwheel.
        values: the registers that enable and scale.
        report: sets an error bit.
    """

    def __init__(
        self, pins: Pcl601Pins, motor: Motor, wiring: Wiring, values: Values, report: Callable[[Error], None]
    ) -> None:
        self._pins, self._motor, self._wiring = pins, motor, wiring
        self._values, self._report = values, report

    def grounded(self) -> int:
        """Return inputs 1 to 6 as contacts: bit 0 is input 1; with SW2 at TWS, 5 and 6 are open."""
        bits = sum(bit << k for k, bit in enumerate(self._pins.general(self._motor.position)))
        return bits & (WITHOUT_5_AND_6 if self._wiring.thumbwheel_selected else ALL)

    def raw(self) -> int:
        """Return inputs 1 to 6 as levels, 1 high; an analog input 1 is high."""
        return ~self.grounded() & ALL | self._values[Register.ANALOG_ENABLE]

    def active(self) -> int:
        """Return the input register of Modbus: inputs 1 to 6 and both limits; an analog input 1 is active."""
        bits = self.grounded() | self._values[Register.ANALOG_ENABLE]
        return bits | self.hard_limit << HARD_LIMIT_BIT | self.soft_limit << SOFT_LIMIT_BIT

    @property
    def hard_limit(self) -> bool:
        """Whether either hard limit is active."""
        return self._either("hard_plus", "hard_minus")

    @property
    def soft_limit(self) -> bool:
        """Whether either soft limit is active."""
        return self._either("soft_plus", "soft_minus")

    def _either(self, *names: str) -> bool:
        return any(self._pins.grounded(name, self._motor.position) for name in names)

    def analog_speed(self) -> int | None:
        """Return the maximum speed that the voltage on input 1 selects, None if refused."""
        if not self._values.analog_speed:
            return self._refuse(Error.ZERO_PARAMETERS)
        return self._analog(Register.ANALOG_SPEED_LOWER, Register.ANALOG_SPEED_UPPER)

    def analog_position(self) -> int | None:
        """Return the position that the voltage on input 1 selects, None if refused."""
        if not self._values.analog_position:
            return self._refuse(Error.ZERO_PARAMETERS)
        position = self._analog(Register.ANALOG_POS_LOWER, Register.ANALOG_POS_UPPER)
        if position is not None:
            self._values[Register.ANALOG_INDEX] = position
        return position

    def _analog(self, lower: Register, upper: Register) -> int | None:
        """Return `lower + (upper - lower) * V / 5`, rounded down; refused unless lower < upper."""
        lower_value, upper_value = self._values[lower], self._values[upper]
        if lower_value >= upper_value:
            return self._refuse(Error.RANGE)
        return lower_value + int(
            (upper_value - lower_value) * self._pins.volts(self._motor.position) / FULL_SCALE_VOLTS
        )

    def thumbwheel(self) -> int | None:
        """Return the value of the seven digits, None if refused."""
        if not self._values[Register.THUMBWHEEL_ENABLE]:
            return self._refuse(Error.ZERO_PARAMETERS)
        if self._wiring.thumbwheel is None or not self._wiring.thumbwheel_selected:
            return self._refuse(Error.THUMBWHEEL)
        return self._wiring.thumbwheel

    def _refuse(self, error: Error) -> int | None:
        self._report(error)
        return None
