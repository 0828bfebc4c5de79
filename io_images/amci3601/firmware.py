"""Firmware versions of the 3601 and their features.

    version   from serial   new feature
    2.0       -             the initial release
    2.1       -             capture without an encoder [revision history, 0.1]
    2.2       78769         MicroLogix 1500 [chapter 1, MicroLogix 1500 Configuration]
    3.1       96317         registration moves [chapter 4, Registration Move]
    4.1       04060162      encoder follower [chapter 4, Encoder Follower Function]

A serial number is just another way to specify a version. Serial numbers of the new format have a leading zero
and are compared as numbers (reading A-67).
"""

from __future__ import annotations

from ..dataclass import dataclass
from ..site import SettingError


@dataclass(frozen=True, slots=True, order=True)
class Firmware:
    """A firmware version; versions are ordered.

    >>> Firmware(2, 2) < Firmware.parse("3.1"), str(Firmware(4, 1))
    (True, '4.1')
    """

    major: int
    minor: int

    @classmethod
    def parse(cls, text: str) -> Firmware:
        """Return the version in a text such as "4.1", or for a serial number such as "serial 96317".

        Raises:
            ValueError: the text is not a version (2.0, 2.1, 2.2, 3.1 or 4.1) or a serial number.
        """
        name, _, serial = text.strip().partition(" ")
        if name.lower() == "serial" and serial:
            return cls.of_serial(serial)
        for revision in KNOWN:
            if str(revision) == text.strip():
                return revision
        allowed = ", ".join(map(str, KNOWN))
        text = f"unknown 3601 firmware {text!r}; choose from {allowed}, or a serial number: serial 96317"
        raise SettingError("firmware", text)

    @classmethod
    def of_serial(cls, serial: int | str) -> Firmware:
        """Return the factory version of the module with a serial number.

        Serial numbers below 78769 may have version 2.0 or 2.1; 2.0 is returned.

        >>> [str(Firmware.of_serial(serial)) for serial in (96316, 96317, "04060162")]
        ['2.2', '3.1', '4.1']

        Raises:
            ValueError: the serial number is not a positive decimal number.
        """
        number = int(serial) if str(serial).strip().isdecimal() else 0
        if number < 1:
            raise SettingError(
                "firmware", f"serial number {serial!r} of a 3601: a positive decimal number is needed"
            )
        return next((version for first_serial, version in _SERIALS if number >= first_serial), FW_2_0)

    def __str__(self) -> str:
        return f"{self.major}.{self.minor}"

    @property
    def capture_without_encoder(self) -> bool:
        """Whether capture works without a configured encoder, storing the position (from 2.1)."""
        return self >= FW_2_1

    @property
    def micrologix(self) -> bool:
        """Whether the module runs in a MicroLogix 1500 (from 2.2)."""
        return self >= FW_2_2

    @property
    def registration(self) -> bool:
        """Whether this version has registration moves and the minimum registration distance (from 3.1)."""
        return self >= FW_3_1

    @property
    def follower(self) -> bool:
        """Whether this version has encoder follower mode (from 4.1)."""
        return self >= FW_4_1


FW_2_0 = Firmware(2, 0)
FW_2_1 = Firmware(2, 1)
FW_2_2 = Firmware(2, 2)
FW_3_1 = Firmware(3, 1)
FW_4_1 = Firmware(4, 1)

KNOWN = (FW_2_0, FW_2_1, FW_2_2, FW_3_1, FW_4_1)
"""The versions that the manual distinguishes, oldest first."""

_SERIALS = ((4_060_162, FW_4_1), (96_317, FW_3_1), (78_769, FW_2_2))
"""The first serial number of each version, newest first."""
