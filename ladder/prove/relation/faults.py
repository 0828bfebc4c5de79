"""Faults in a scan on terms. Minor faults set flags under conditions; major faults end a path."""

from __future__ import annotations

from typing import Any, NoReturn

from ..algebra.numbers import add, b2i
from ..algebra.terms import FALSE, TRUE, T, and_, or_
from .paths import PathFault
from .symbols import TermScan, UnmodeledError


class TermFaults:
    """The fault log of a scan on terms.

    Attributes:
        minor: conditions for overflows, zero divisors and other minor faults, by instruction and kind.
    """

    def __init__(self, values: TermScan) -> None:
        self._values = values
        self.minor: dict[tuple[int, str], T] = {}

    @property
    def overflows(self) -> Any:
        """Return the number of overflows that this path has noted so far."""
        return self._values.symbol(self._values.paths.overflows)

    def overflow_if(self, t: T, kind: str = "overflow") -> None:
        """Note an overflow where a condition is true."""
        if t is FALSE:
            return
        values = self._values
        values.paths.overflows = add(values.paths.overflows, b2i(t))
        for name in ("S:V", "S:MINOR") if values.lowered.flags else ("S:MINOR",):
            leaf = values.lowered.layout.leaf(name)
            values.poke(leaf, 0, or_(values.value_here(leaf, 0), t))
        self._note(t, kind)

    def zero_divisor_if(self, t: T) -> None:
        """Note a zero divisor where a condition is true."""
        self.overflow_if(t, "zero divisor")

    def _note(self, t: T, kind: str) -> None:
        cause = self._values.site, kind
        noted = self.minor.get(cause, FALSE)
        self._values.log.put(self.minor, cause, or_(noted, and_(self._values.here(), t)))

    def overflow(self, _site: int, _text: str = "") -> None:
        """Note an overflow on this path."""
        self.overflow_if(TRUE)

    def zero_divisor(self, _site: int) -> None:
        """Note a zero divisor on this path."""
        self.zero_divisor_if(TRUE)

    def record(self, _site: int, text: str, code: int) -> None:
        """Note another minor fault on this path."""
        leaf = self._values.lowered.layout.leaf("S:MINOR")
        self._values.poke(leaf, 0, TRUE)
        self._note(TRUE, f"minor fault 4/{code}")

    def major(self, *_parts: object) -> NoReturn:
        """End this path."""
        raise PathFault

    def check(self, _site: int, holds: object, _values: object) -> None:
        """End this path where the condition of an ASSERT is false."""
        if not holds:
            raise PathFault

    subscript = negative_timer = negative_control = major

    def jumped_back(self, _site: int, _times: int = 1) -> None:
        """Do nothing, because the number of passes is limited separately."""

    def __getattr__(self, name: str) -> Any:
        raise UnmodeledError(f"the fault log is used by its {name}")
