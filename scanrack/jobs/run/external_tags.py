"""Reports to the CPU which tags are set or forced from outside, so that they are recorded."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite
from typing import Protocol

from scanrack.runtime.loop.cpu import Cpu


class OperatedProgram(Protocol):
    """A program whose tags can be set and forced from outside, such as a debugger."""

    on_outside: Callable[[], object]

    @property
    def forces(self) -> Mapping[str, str | int | float | bool]:
        """The forced tags with their values."""


def report_external_tags(program: OperatedProgram, cpu: Cpu) -> None:
    """Make a program report to the CPU every tag that is set, forced or released between scans."""
    program.on_outside = lambda: cpu.tags_from_outside(forced_tags(program))


def forced_tags(program: OperatedProgram) -> dict[str, str | int | float | bool]:
    """Return the forced tags with JSON values; infinity and NaN become text."""
    return {
        tag: str(value) if isinstance(value, float) and not isfinite(value) else value
        for tag, value in program.forces.items()
    }
