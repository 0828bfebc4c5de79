"""The CPU's keyswitch, which injected faults turn to program and back."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from typing_extensions import override

from .cpu import Cpu
from .incidents import InjectedFault
from .listeners import QuietListener
from .scan import CpuMode


class _KeyTurn(NamedTuple):
    at_ns: int
    mode: CpuMode


class KeySwitch(QuietListener):
    """A listener that turns the CPU's key to program and back at the end of a scan."""

    def __init__(self, cpu: Cpu, incidents: Iterable[InjectedFault]) -> None:
        self._cpu = cpu
        turns = []
        for fault in incidents:
            turns.append(_KeyTurn(fault.at_ns, CpuMode.PROGRAM))
            if fault.for_ns:
                turns.append(_KeyTurn(fault.at_ns + fault.for_ns, CpuMode.RUN))
        self._turns = sorted(turns)

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        while self._turns and self._turns[0].at_ns <= now_ns:
            self._cpu.mode = self._turns.pop(0).mode
