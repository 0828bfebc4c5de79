"""The stored values of the registers."""

from __future__ import annotations

from scanrack.io_images.pcl601 import MAP, ROWS, Register, Row, with_word


class Values(dict[Register, int]):
    """The registers' values; a 32-bit register is stored as one signed number.

    ANALOG_ENABLE, the register for both analog functions, sets both flags, and reads as 1 if either flag is
    set.

    Attributes:
        analog_speed: whether input 1 can set the maximum speed; see `set_analog`.
        analog_position: whether input 1 can set the absolute position; see `set_analog`.
    """

    def __init__(self) -> None:
        super().__init__({row.register: row.default for row in MAP})
        self.analog_speed = self.analog_position = False

    def reset(self) -> None:
        """Reset the volatile registers to their defaults, as at power-up."""
        self.update({row.register: row.default for row in MAP if not row.kept})
        self.set_analog(speed=False, position=False)

    def set_analog(self, *, speed: bool | None = None, position: bool | None = None) -> None:
        """Enable or disable the analog functions; None leaves a function unchanged."""
        self.analog_speed = self.analog_speed if speed is None else speed
        self.analog_position = self.analog_position if position is None else position
        super().__setitem__(Register.ANALOG_ENABLE, int(self.analog_speed or self.analog_position))

    def __setitem__(self, register: Register, value: int) -> None:
        if register is Register.ANALOG_ENABLE:
            self.set_analog(speed=bool(value), position=bool(value))
        else:
            super().__setitem__(register, value)

    def set_word(self, row: Row, word: int, bits: int) -> None:
        """Set one word of a register without checking it; a pair of words is checked when it is used."""
        self[row.register] = with_word(row, self[row.register], word, bits) if row.words == 2 else bits

    def in_range(self, *registers: Register) -> bool:
        """Return whether the registers' values are within the map's ranges."""
        return all(ROWS[register].allows(self[register]) for register in registers)
