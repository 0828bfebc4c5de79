"""The values behind the registers."""

from __future__ import annotations

from ...io_images.pcl601 import MAP, ROWS, Register, Row, with_word, word_of


class Values:
    """The registers' values, 32-bit ones as one signed number.

    Attributes:
        analog_speed: input 1 may set the maximum speed.
        analog_position: input 1 may set the absolute position.
    """

    def __init__(self) -> None:
        self._values = {row.register: row.default for row in MAP}
        self.analog_speed = False
        self.analog_position = False

    def reset(self) -> None:
        """Go back to what power-up finds: the defaults, but what is non-volatile."""
        self._values.update({row.register: row.default for row in MAP if not row.kept})
        self.analog_speed = self.analog_position = False

    def __getitem__(self, register: Register) -> int:
        if register is Register.ANALOG_ENABLE:
            return int(self.analog_speed or self.analog_position)
        return self._values[register]

    def __setitem__(self, register: Register, value: int) -> None:
        if register is Register.ANALOG_ENABLE:
            self.analog_speed = self.analog_position = bool(value)
        self._values[register] = value

    def taken(self) -> dict[Register, int]:
        """Return a copy: what a motion goes by once it has begun."""
        return dict(self._values)

    def word(self, row: Row, word: int) -> int:
        """Return a word as it is read over Modbus."""
        return word_of(self[row.register], word)

    def set_word(self, row: Row, word: int, bits: int) -> None:
        """Set a word; the pair it belongs to is not looked at until it is used."""
        self[row.register] = with_word(row, self[row.register], word, bits) if row.words == 2 else bits

    def in_range(self, *registers: Register) -> bool:
        """Whether all these hold what the map allows."""
        return all(ROWS[register].allows(self[register]) for register in registers)
