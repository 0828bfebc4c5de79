"""The controller as a stored program sees it: the interface of its instructions.

`program/` has the virtual machine that runs a program. It knows this interface, and nothing of motion:

    code 12, autorun at power-up     controller calls runner.start(now_ns)
    code 5, ".", reset               controller calls runner.stop()

The actions of a program take effect at the `now_ns` of `ProgramMachine.advance`.
"""

from __future__ import annotations

from typing import Protocol

from scanrack.io_images.pcl601 import Error, Register


class Axis601(Protocol):
    """The controller, for a stored program.

    Methods return True if carried out, and False if refused: the controller has set the error bit (busy,
    motor, range ...), and the program must end. `FINISH` waits for `busy` to be False.
    """

    @property
    def busy(self) -> bool:
        """Whether motion is in progress, including the encoder's delay and correction."""

    def write(self, register: Register, value: int) -> bool:
        """Set a register by name (32-bit ones as one signed value), with the rule of its motion lock.

        ACCEL, BASE, MAX, JOG, SETPOS, DIR, CURRENT, ENC*, OOTF*, IOTF, REGINDEX (steps), ASPEEDLO ...
        `set_analog` sets the analog flags.
        """

    def set_analog(self, *, speed: bool | None = None, position: bool | None = None) -> bool:
        """ASPEED and APOS: enable or disable one of the two analog functions."""

    def command(self, code: int) -> bool:
        """Carry out a command code: 2 and 3 home, 4 slew, 5 stop hard, 6 stop soft, 7 analog speed, 15 ..."""

    def move(self, steps: int) -> bool:
        """MOVE: index a number of steps in the present direction."""

    def move_to(self, position: int) -> bool:
        """MOVETO: index to a position."""

    def repeat(self) -> bool:
        """REPEAT: index again, by the length and direction of the last index."""

    def move_thumbwheel(self) -> bool:
        """MOVETHUMB: read the thumbwheel and index by it."""

    def move_to_analog(self) -> bool:
        """GOTOAPOS: read input 1 and index to that position."""

    def inputs_raw(self) -> int:
        """Return the input register as IF sees it: bit 0 is input 1; 1 open or high, 0 grounded."""

    def set_outputs(self, pattern: int) -> bool:
        """OUTPUTS: all eight; bit 0 is output 1; 1 is on."""

    def send_text(self, text: str) -> bool:
        """TEXT: send a text and CR; in Modbus mode send nothing and set the mode error."""

    def report(self, error: Error) -> None:
        """Set an error bit: MEMORY_COMMAND for RETURN without GOTO or an unknown instruction."""
