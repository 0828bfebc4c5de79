"""Tags of a program that are set or forced from outside, reported to the CPU, which records them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite
from typing import Protocol

from scanrack.runtime.loop.cpu import Cpu


class OperatedProgram(Protocol):
    """A program whose tags are set and forced from outside: a debugger."""

    on_outside: Callable[[], object]

    @property
    def forces(self) -> Mapping[str, str | int | float | bool]:
        """The forced tags with their values."""


def tell_cpu(program: OperatedProgram, cpu: Cpu) -> None:
    """Report every tag that is set, forced or released between scans to the CPU."""
    program.on_outside = lambda: cpu.tags_from_outside(forced_tags(program))


def forced_tags(program: OperatedProgram) -> dict[str, str | int | float | bool]:
    """Return the forced tags with JSON values; infinity and NaN as text."""
    return {
        tag: str(value) if isinstance(value, float) and not isfinite(value) else value
        for tag, value in program.forces.items()
    }
