"""Parameters of a PMC006x3s: values in force, and values that survive without power [4.3.17]."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.pmc006.instructions import BY_NAME, PARAMETERS, ParameterStorage
from scanrack.io_images.pmc006.program import UserInstruction


class Memory:
    """A controller's memory as it leaves the factory, with the user program's lines in the EEPROM."""

    def __init__(self) -> None:
        self.lines: tuple[UserInstruction, ...] = ()
        self._eeprom = {
            row.name: row.default for row in PARAMETERS if row.keeping is not ParameterStorage.VOLATILE
        }
        self._values: dict[str, int] = {}
        self.load()

    def __getitem__(self, name: str) -> int:
        return self._values[name]

    def __setitem__(self, name: str, value: int) -> None:
        """Set a parameter; write it to the EEPROM at once if it is always kept there."""
        self._values[name] = value
        if BY_NAME[name].keeping is ParameterStorage.EEPROM:
            self._eeprom[name] = value

    @property
    def kept(self) -> dict[str, int]:
        """The parameters in the EEPROM."""
        return dict(self._eeprom)

    def restore(self, kept: Mapping[str, int]) -> None:
        """Write parameters to the EEPROM; they take effect at the next power-up.

        Raises:
            ValueError: a parameter that is not in the EEPROM, or a value that it can't have.
        """
        for name, value in kept.items():
            if name not in self._eeprom:
                raise ValueError(f"{name} is no parameter of the EEPROM; allowed: {', '.join(self._eeprom)}")
            row = BY_NAME[name]
            if not (row.allows(value) or value == row.default):
                raise ValueError(f"{name} {value}: must be {row.allowed}")
        self._eeprom |= kept

    def save(self) -> None:
        """Save all parameters that can be kept: instruction t."""
        self._eeprom = {name: self._values[name] for name in self._eeprom}

    def load(self) -> None:
        """Restore saved values at power-up; all others get their defaults."""
        self._values = {row.name: row.default for row in PARAMETERS} | self._eeprom

    def preset(self, name: str, value: int) -> None:
        """Set a parameter and save it, as if saved earlier."""
        self[name] = value
        self._eeprom[name] = value
