"""Timers and counters."""

from __future__ import annotations

from typing import Any

from .. import arithmetic as math
from ..operands import Group
from ..types import DINT
from .values import Values

MS = 1_000_000
"""Nanoseconds of a millisecond."""


class TimeInstructions(Values):
    """Timers and counters."""

    def _count_time(self, timer: Group) -> None:
        """Add the time since the last scan of the instruction, in whole ms; what is over waits."""
        last = timer.member("~last_ns")
        elapsed = (self._now - int(self.get(last))) // MS
        accumulated = timer.member("ACC")
        self.put(accumulated, min(int(self.get(accumulated)) + elapsed, DINT.highest))
        self.put(last, int(self.get(last)) + elapsed * MS)

    def _start_time(self, timer: Group) -> None:
        self.put(timer.member("~last_ns"), self._now)

    def _reached(self, timer: Group) -> bool:
        preset, accumulated = int(self.get(timer.member("PRE"))), int(self.get(timer.member("ACC")))
        if preset < 0 or accumulated < 0:
            self._fault_log.negative_timer(self._site, timer.text, preset, accumulated)
        return accumulated >= preset

    def _set_bits(self, structure: Group, **bits: bool) -> None:
        for name, value in bits.items():
            self.put(structure.member(name), value)

    def _time_on(self, timer: Group) -> None:
        if self.get(timer.member("DN")):
            self._set_bits(timer, EN=True, TT=False)
            return
        if self.get(timer.member("EN")):
            self._count_time(timer)
        else:
            self._start_time(timer)
        done = self._reached(timer)
        self._set_bits(timer, EN=True, TT=not done, DN=done)

    def _ton(self, power: bool, timer: Group) -> None:
        if power:
            self._time_on(timer)
        else:
            self._set_bits(timer, EN=False, TT=False, DN=False)
            self.put(timer.member("ACC"), 0)

    def _rto(self, power: bool, timer: Group) -> None:
        if power:
            self._time_on(timer)
        else:
            self._set_bits(timer, EN=False, TT=False)

    def _tof(self, power: bool, timer: Group) -> None:
        if power:
            self._set_bits(timer, EN=True, TT=False, DN=True)
            self.put(timer.member("ACC"), 0)
        elif self.get(timer.member("DN")):
            if self.get(timer.member("EN")):
                self._start_time(timer)
            else:
                self._count_time(timer)
            done = self._reached(timer)
            self._set_bits(timer, EN=False, TT=not done, DN=not done)
        else:
            self._set_bits(timer, EN=False, TT=False)

    def _count(self, power: bool, counter: Group, enable: str, by: int) -> None:
        if not power:
            self.put(counter.member(enable), False)
            return
        if not self.get(counter.member(enable)):
            self.put(counter.member(enable), True)
            self._one_count(counter, by)
        over, under = self.get(counter.member("OV")), self.get(counter.member("UN"))
        reached = self.get(counter.member("ACC")) >= self.get(counter.member("PRE"))
        self.put(counter.member("DN"), bool(over or (reached and not under)))

    def _one_count(self, counter: Group, by: int) -> None:
        accumulated = counter.member("ACC")
        exact = int(self.get(accumulated)) + by
        self.put(accumulated, math.wrap(exact, 32))
        if exact != self.get(accumulated):
            beyond, back = ("OV", "UN") if by > 0 else ("UN", "OV")
            if self.get(counter.member(back)):
                self.put(counter.member(back), False)
            else:
                self.put(counter.member(beyond), True)

    def _ctu(self, power: bool, counter: Group) -> None:
        self._count(power, counter, "CU", 1)

    def _ctd(self, power: bool, counter: Group) -> None:
        self._count(power, counter, "CD", -1)

    def _res(self, structure: Group) -> None:
        for member in _structure(structure).members:
            if member.name not in ("PRE", "LEN"):
                self.put(structure.member(member.name), member.type.zero)


def _structure(group: Group) -> Any:
    return group.type
