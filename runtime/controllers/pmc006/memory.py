"""Parameters of a PMC006x3s: active values and saved values [4.3.17]."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.pmc006.instructions import BY_NAME, PARAMETERS, ParameterStorage
from scanrack.io_images.pmc006.program import UserInstruction


class Memory:
    """A device's memory, which initially has the factory settings.

    Attributes:
        lines: the user program in the EEPROM.
    """

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
        """Set a parameter; some parameters are also written to the EEPROM at once."""
        self._values[name] = value
        if BY_NAME[name].keeping is ParameterStorage.EEPROM:
            self._eeprom[name] = value

    @property
    def saved(self) -> dict[str, int]:
        """The parameters in the EEPROM."""
        return dict(self._eeprom)

    def restore(self, saved: Mapping[str, int]) -> None:
        """Write parameters to the EEPROM; they take effect at the next power-up.

        Raises:
            ValueError: a parameter is not in the EEPROM, or a value is invalid.
        """
        for name, value in saved.items():
            if name not in self._eeprom:
                raise ValueError(f"{name} is not in the EEPROM; choose from {', '.join(self._eeprom)}")
            row = BY_NAME[name]
            if not (row.allows(value) or value == row.default):
                raise ValueError(f"{name} {value}: must be {row.allowed}")
        self._eeprom |= saved

    def save(self) -> None:
        """Save all parameters that the EEPROM stores, as instruction t does."""
        self._eeprom = {name: self._values[name] for name in self._eeprom}

    def load(self) -> None:
        """Load the saved values, and the defaults of all other parameters, as at power-up."""
        self._values = {row.name: row.default for row in PARAMETERS} | self._eeprom

    def preset(self, name: str, value: int) -> None:
        """Set and save a parameter."""
        self[name] = value
        self._eeprom[name] = value
