"""The fault log: minor faults are recorded, and major faults end the scan."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import NoReturn

from ..model.errors import (
    ASSERTION_CODE,
    CONTROL_CODE,
    OVERFLOW_CODE,
    STACK_CODE,
    SUBSCRIPT_CODE,
    TIMER_CODE,
    WATCHDOG_CODE,
    WATCHDOG_TYPE,
    LadderFault,
    MinorFault,
)
from .lowered import LoweredProgram
from .memory import Memory

KEPT = 1000
"""Maximum number of recorded minor faults; the latest ones are kept."""

MOST_RECURSION = 25
"""Maximum number of nested calls of recursive routines."""

MOST_JUMPS = 200_000
"""Maximum number of backward jumps per scan; at 2.5 µs each, they take 500 ms, the default watchdog."""


class FaultLog:
    """The faults of a running program."""

    def __init__(self, lowered: LoweredProgram, memory: Memory) -> None:
        self.minor: deque[MinorFault] = deque(maxlen=KEPT)  # the latest, one per instruction and scan
        self.now_ns = 0  # virtual time of the scan
        self.overflows = 0  # overflows and zero divisors so far
        self._jumps = 0
        self.depth = 0  # nested calls of recursive routines
        self.checked: set[int] = set()  # sites of the ASSERTs that have run
        self._lowered, self._memory = lowered, memory
        self._recorded: set[int] = set()  # sites of this scan's minor faults
        self._overflow_flag = memory.layout.leaf("S:V")
        self._minor_flag = memory.layout.leaf("S:MINOR")

    def new_scan(self, now_ns: int) -> None:
        """Start a scan, so that each instruction may record one minor fault again."""
        self.now_ns = now_ns
        self._jumps = 0
        self.depth = 0
        if self._recorded:
            self._recorded.clear()

    def overflow(self, site: int, text: str = "the result does not fit") -> None:
        """Set S:V and record a minor fault, type 4 code 4."""
        self.overflows += 1
        if self._lowered.flags:
            self._memory.write(self._overflow_flag, 0, True)
        self.record(site, text, OVERFLOW_CODE)

    def record(self, site: int, text: str, code: int) -> None:
        """Record a minor fault, type 4."""
        self._memory.write(self._minor_flag, 0, True)
        if site not in self._recorded:
            self._recorded.add(site)
            self.minor.append(MinorFault(self._lowered.sites[site], self.now_ns, text, code=code))

    def zero_divisor(self, site: int) -> None:
        """Record a zero divisor as an overflow."""
        self.overflow(site, "the divisor is 0")

    def subscript(self, site: int, tag: str, index: int, length: int) -> NoReturn:
        """Raise a fault for a subscript or bit number that is out of range."""
        text = f"subscript {index} is out of range; must be 0 to {length - 1}"
        self._stop(site, tag, text, SUBSCRIPT_CODE)

    def jumped_back(self, site: int, times: int = 1) -> None:
        """Count backward jumps; fault above a limit. Unlike a time limit, a count makes runs repeatable."""
        self._jumps += times
        if self._jumps > MOST_JUMPS:
            text = f"watchdog: more than {MOST_JUMPS:,} jumps backwards in one scan"
            jump_site = self._lowered.sites[site]
            tag = {"rung": "JMP", "line": "loop"}.get(jump_site.unit, "chart")
            raise LadderFault(jump_site, tag, text, WATCHDOG_CODE, WATCHDOG_TYPE)

    @property
    def jumps_left(self) -> int:
        """Remaining backward jumps of this scan."""
        return MOST_JUMPS - self._jumps

    def negative_control(self, site: int, tag: str, length: int, position: int) -> NoReturn:
        """Raise a fault for a CONTROL whose LEN or POS is negative."""
        self._stop(site, tag, f"LEN is {length}, POS is {position}; neither may be negative", CONTROL_CODE)

    def called(self, site: int) -> None:
        """Count a call of a recursive routine; fault if they nest too deeply."""
        self.depth += 1
        if self.depth > MOST_RECURSION:
            text = f"routines that call themselves go more than {MOST_RECURSION} deep"
            self._stop(site, "JSR", text, STACK_CODE)

    def returned(self) -> None:
        """Count the return of a recursive routine."""
        self.depth -= 1

    def check(self, site: int, is_true: bool, values: Callable[[], Mapping[str, str]]) -> None:
        """Raise a fault with the values of its tags if the condition of an ASSERT is false."""
        self.checked.add(site)
        if not is_true:
            tags = values()
            listed_values = ", ".join(f"{tag} = {value}" for tag, value in tags.items())
            text = f"the condition is false{f' [{listed_values}]' if listed_values else ''}"
            fault = LadderFault(self._lowered.sites[site], "ASSERT", text, ASSERTION_CODE)
            fault.tags = tuple(tags)
            raise fault

    def negative_timer(self, site: int, tag: str, preset: int, accumulated: int) -> NoReturn:
        """Raise a fault for a timer whose PRE or ACC is negative."""
        self._stop(site, tag, f"PRE is {preset}, ACC is {accumulated}; neither may be negative", TIMER_CODE)

    def _stop(self, site: int, tag: str, text: str, code: int) -> NoReturn:
        raise LadderFault(self._lowered.sites[site], tag, text, code)
