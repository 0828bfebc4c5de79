"""A scan as logic and listeners see it: its mode, its flags, and the argument passed to the logic."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum, IntFlag
from typing import Protocol, runtime_checkable

from .rack import Slot, as_logic_sees


class CpuMode(IntEnum):
    """The mode of the CPU."""

    PROGRAM = 0
    """Logic does not run, and outputs are not sent."""

    RUN = 1
    """Logic runs, and outputs are sent."""

    TEST = 2
    """Logic runs, but outputs are not sent."""

    SINGLE_SCAN = 3
    """One scan as in test mode, followed by program mode."""


class ScanFlag(IntFlag):
    """The CPU's flags for a scan; bits 0 and 1 are the `CpuMode`."""

    RUN = 1 << 0
    TEST = 1 << 1
    FIRST_SCAN = 1 << 2
    """First scan of the logic; see `LogicScan.first`."""

    INPUT_FORCES = 1 << 3
    OUTPUT_FORCES = 1 << 4
    OVERRUN = 1 << 5
    """Real time only: the scan began at least 0.1 ms late; see `pace.LATE_FROM_NS`."""

    FAULT = 1 << 6
    """The CPU faulted in this scan, and sent zeros as outputs."""

    TAGS_FROM_OUTSIDE = 1 << 7
    """A program tag is forced, or was set from outside since the previous scan."""


MODE_MASK = 0b11
"""Bits of the mode in the flags."""


def mode_name(mode: CpuMode) -> str:
    """Return the name of a mode.

    >>> mode_name(CpuMode.SINGLE_SCAN)
    'single scan'
    """
    return mode.name.lower().replace("_", " ")


class LogicScan:
    """The argument passed to the logic: the current scan, and the slots of the rack.

    Attributes:
        slot: the slots by number; `scan.slot[1].inputs` and `.outputs` are the images. Inputs are
            read-only.
        number: number of the scan, from 0 at power-up.
        now_ns: virtual time of the scan, ns since power-up.
        first: whether this is the first call of the logic since power-up, or since the CPU left
            program mode for run or test mode.
        updated: whether the modules have updated their inputs since the previous scan; on a CompactLogix only
            after an exchange.
    """

    __slots__ = ("first", "now_ns", "number", "period_ns", "slot", "updated")

    def __init__(self, slot: Mapping[int, Slot], period_ns: int) -> None:
        self.slot = as_logic_sees(slot)
        self.number = 0
        self.now_ns = 0
        self.period_ns = period_ns
        self.first = True
        self.updated = True


ScanLogic = Callable[[LogicScan], None]
"""A program, called once per scan, that reads input images and writes output images."""


@runtime_checkable
class AttachedLogic(Protocol):
    """Logic that is prepared with the rack before its first scan, and closed after its last scan."""

    def __call__(self, scan: LogicScan) -> None:
        """Carry out one scan."""

    def __attach_logic__(self, slots: Mapping[int, Slot]) -> None:
        """Find the required slots, before the first scan.

        Raises:
            ValueError: a slot is missing; the message lists the existing slots.
        """

    def __close_logic__(self) -> None:
        """End unfinished work after the last scan; can be called twice."""


def attached(logic: object) -> AttachedLogic | None:
    """Return the logic if it is prepared with the rack, otherwise None.

    `isinstance` returns the same, but takes as long as ten scans.
    """
    is_attached = hasattr(logic, "__attach_logic__") and hasattr(logic, "__close_logic__")
    return logic if is_attached else None  # type: ignore[return-value]
