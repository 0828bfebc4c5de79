"""The controller's interface for a stored program.

`program/` contains the machine that runs a program. The controller and the machine call each other as
follows:

    code 12, autorun at power-up     controller calls runner.start(now_ns)
    code 5, ".", reset               controller calls runner.stop()

An instruction takes effect at the `now_ns` passed to `ProgramMachine.advance`.
"""

from __future__ import annotations

from typing import Protocol

from scanrack.io_images.pcl601 import Error, Register


class Axis601(Protocol):
    """The controller, as a stored program sees it.

    Methods return whether the controller accepts the instruction. A refusal sets an error bit, and the
    program ends.
    """

    @property
    def busy(self) -> bool:
        """Whether a motion is in progress, including the encoder's delay and correction."""

    def write(self, register: Register, value: int) -> bool:
        """ACCEL, BASE, MAX, JOG, SETPOS ...: set a register, unless a motion locks it."""

    def set_analog(self, *, speed: bool | None = None, position: bool | None = None) -> bool:
        """ASPEED and APOS: enable or disable an analog function."""

    def command(self, code: int) -> bool:
        """HOME0, HOME1, SLEW, STOPHARD ...: carry out a command code."""

    def move(self, steps: int) -> bool:
        """MOVE: index a number of steps in the direction set by the direction register."""

    def move_to(self, position: int) -> bool:
        """MOVETO: index to a position."""

    def repeat(self) -> bool:
        """REPEAT: repeat the last index with the same length and direction."""

    def move_thumbwheel(self) -> bool:
        """MOVETHUMB: read the thumbwheel, and index by that number of steps."""

    def move_to_analog(self) -> bool:
        """GOTOAPOS: read the voltage on input 1, and index to the position that it selects."""

    def inputs_raw(self) -> int:
        """IF: return the levels of the inputs; bit 0 is input 1; 1 is open or high, 0 is grounded."""

    def set_outputs(self, pattern: int) -> bool:
        """OUTPUTS: set all eight outputs; bit 0 is output 1; 1 is on."""

    def send_text(self, text: str) -> bool:
        """TEXT: send a text and CR; refuse it in Modbus mode with the mode error."""

    def report(self, error: Error) -> None:
        """Set an error bit."""
