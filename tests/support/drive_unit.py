"""A networked drive, operated word by word in virtual time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scanrack.io_images.drives.bits import StatusBit
from scanrack.io_images.drives.models import MODELS
from scanrack.runtime.machine import Machine, MachineSpec, Switch
from scanrack.runtime.modules.drives.drive import DriveUnit

MS = 1_000_000
ENABLE = 0x8000
VALID = (0x8000, 0x0003, 1, 0, 2048, 0, 0, 20, 28, 0)
"""A valid configuration: no functions, both inputs active high, starting speed 1000."""


class Unit:
    """A drive with its inputs in1 and in2."""

    def __init__(self, model: str = "smd23e2", machine: MachineSpec | None = None, **options: Any) -> None:
        self.drive = DriveUnit(MODELS[model], Machine(machine or MachineSpec()), options)

    def wait(self, ms: float) -> Unit:
        """Let time pass."""
        self.drive.advance(self.drive.now_ns + round(ms * MS))
        return self

    def write(self, *words: int, at: int = 0, ms: float = 1) -> Unit:
        """Write output words from one on, and let time pass."""
        fresh = list(self.drive.words)
        fresh[at : at + len(words)] = [word & 0xFFFF for word in words]
        self.drive.obey(fresh)
        return self.wait(ms)

    def configure(self, changed: Mapping[int, int] | None = None) -> Unit:
        """Write the valid configuration with some words changed, and return to command mode, enabled."""
        words = [(changed or {}).get(at, word) for at, word in enumerate(VALID)]
        return self.write(*words).write(0, ENABLE, *(0,) * 8)

    def preset(self, value: int = 0) -> Unit:
        """Preset the position, in thousands."""
        sign = -1 if value < 0 else 1
        upper, lower = divmod(abs(value), 1000)
        return self.write(0x0200, ENABLE, sign * upper, sign * lower).write(0, ENABLE)

    def command(
        self,
        bit: int,
        target: tuple[int, int] = (0, 0),
        speed: tuple[int, int] = (5, 0),
        rates: tuple[int, int] = (20, 10),
        current: int = 0,
        jerk: int = 0,
        modifiers: int = 0,
        ms: float = 0,
    ) -> Unit:
        """Write a zero command word, then the command."""
        self.write(0, ENABLE | modifiers, ms=0)
        return self.write(bit, ENABLE | modifiers, *target, *speed, *rates, current, jerk, ms=ms)

    def input(self, number: int, on: bool = True, ms: float = 1) -> Unit:
        """Energize an input, 1 or 2, or not."""
        self.drive.operate(self.drive.terminals[number - 1], on)
        return self.wait(ms)

    def switch(self, number: int, first: int | None, last: int | None) -> Unit:
        """Tie an input to a range of the shaft."""
        bit = self.drive.terminals[number - 1]
        self.drive.machine.rewire(bit, [Switch(bit, first, last)])
        return self

    def word(self, at: int) -> int:
        """Return an input word, unsigned."""
        return self.drive.inputs()[at] & 0xFFFF

    @property
    def status(self) -> set[str]:
        """The names of the status bits that are on, without the heartbeat."""
        bits = StatusBit(self.word(0) | self.word(1) << 16) & ~StatusBit.HEARTBEAT
        return {str(bit.name) for bit in bits}

    @property
    def position(self) -> int:
        """The position, in thousands."""
        return 1000 * self.drive.inputs()[2] + self.drive.inputs()[3]

    @property
    def rules(self) -> list[str]:
        """The rules that fired since the last call."""
        fired = [event.name for event in self.drive.events if event.kind == "rule"]
        self.drive.events.clear()
        return fired


def ready(model: str = "smd23e2", changed: Mapping[int, int] | None = None, **options: Any) -> Unit:
    """Return a configured unit at position 0, enabled."""
    unit = Unit(model, **options).configure(changed).preset()
    assert not unit.status & {"COMMAND_ERROR", "CONFIG_ERROR", "POSITION_INVALID"}
    _ = unit.rules
    return unit
