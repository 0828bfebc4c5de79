"""The controller as a stored program sees it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....io_images.pcl601 import Code, Error, Register

if TYPE_CHECKING:
    from .controller import Controller


class ProgramAxis:
    """What `stored.Axis601` describes."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller

    @property
    def busy(self) -> bool:
        """Whether motion is in progress, encoder delay and correction included."""
        return self._controller.busy

    def set_parameter(self, register: Register, value: int) -> bool:
        """Set a register, with the rule of its motion lock."""
        return self._controller.write(register, value)

    def set_analog(self, *, speed: bool | None = None, position: bool | None = None) -> bool:
        """Enable or disable the analog functions."""
        self._controller.values.set_analog(speed=speed, position=position)
        return True

    def command(self, code: int) -> bool:
        """Carry out a command code; a hard stop of its own does not end the program."""
        if code == Code.STOP_MOTION:
            self._controller.axis.stop_hard()
            return True
        return self._controller.do(code)

    def move(self, steps: int) -> bool:
        """Index so many steps in the present direction."""
        return self._controller.move(steps)

    def move_to(self, position: int) -> bool:
        """Index to a position."""
        return self._controller.move_to(position)

    def repeat(self) -> bool:
        """Index again, by the length and direction of the last index."""
        return self._controller.repeat()

    def move_thumbwheel(self) -> bool:
        """Read the thumbwheel and index by it."""
        steps = self._controller.inputs.thumbwheel()
        return steps is not None and self._controller.move(steps)

    def move_to_analog(self) -> bool:
        """Read input 1 and index to that position."""
        position = self._controller.inputs.analog_position()
        return position is not None and self._controller.move_to(position)

    def inputs_raw(self) -> int:
        """Return the input register as levels: bit 0 is input 1."""
        return self._controller.inputs.raw()

    def set_outputs(self, pattern: int) -> bool:
        """Set all eight outputs: bit 0 is output 1."""
        self._controller.set_outputs(pattern)
        return True

    def send_text(self, text: str) -> bool:
        """Send a text with CR after it, unless it ends in a line feed; refused in Modbus mode."""
        return self._controller.send_text(text)

    def fail(self, error: int) -> None:
        """Set an error bit."""
        self._controller.report(Error(error))
