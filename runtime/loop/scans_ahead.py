"""Scans by rows: what the phases do, scan by scan, while the inputs are known ahead (`runtime.loop.ahead`).

    scan n            phase           by rows
    at n * period     input_latch     copies the scan's row into the rack's memory
                      logic           the same
                      output_latch    compares: the memory is still the row, so nothing new is to be sent
                      record          passes on the scan; there are no events
                      housekeeping    moves on

New outputs, a request, a stop, or anything that acts on a module ends the block in the same scan, which
goes on by its phases.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import repeat
from typing import Any

from .ahead import LEAST_ROWS, Patience, numpy_is_worth_it
from .phases import Phase, ScanPhases

_WHOLE = slice(None)


class ScansAhead(ScanPhases):
    """A CPU's scans, by their phases or by rows."""

    _looks_ahead = True
    """False = every scan by its phases, as in tests and where scans are not a period apart."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.stop_requested = False
        self._latch = memoryview(self.rack.memory)
        self._patience = Patience()
        self._by_rows = False
        self._present: Phase = self.input_latch
        self._exchange.tell_before_change(self._catch_up)

    def _scan(self, scans: int) -> None:
        """Run scans until they are done or a stop is requested; `_present` is the phase that ran last."""
        while True:
            scans -= self._scan_by_phases(min(scans, self._patience.wait))
            scans -= self._scan_ahead(scans)
            if scans <= 0 or self.stop_requested:
                break

    def _scan_by_phases(self, scans: int) -> int:
        phase = self._present
        try:
            for _ in repeat(None, scans):
                for phase in self._phases:
                    phase()
                if self.stop_requested:
                    break
        finally:
            self._present = phase
        return scans

    def _scan_ahead(self, most: int) -> int:
        """Run scans by rows, as far as they are foreseen; return how many."""
        view, patience = self._view, self._patience
        if not (self._plain and self._looks_ahead and numpy_is_worth_it(view.number)):
            patience.not_calm(0)
            return 0
        if self.stop_requested or most < LEAST_ROWS or any(module.events for module in self._modules):
            return 0  # events of a module on which a listener has acted go through the next scan's phases
        calm = self._exchange.calm_scans(view.now_ns, self._period_ns)
        if calm < LEAST_ROWS:
            patience.not_calm(calm)
            return 0
        count = min(calm, most)
        block = self._exchange.foresee(view.now_ns, self._period_ns, count, patience.most_rows)
        first = view.number
        self._scan_by_rows(block.scans)
        used = view.number - first
        patience.ended(used, block.length)
        return used

    def _scan_by_rows(self, scans: Iterable[tuple[bytes, bool]]) -> None:
        view, memory, latch, logic = self._view, self.rack.memory, self._latch, self._call_logic
        tell, flags, period_ns = self._listeners.scan, self._scan_flags, self._period_ns
        phase: Phase = self.input_latch
        self._by_rows = True
        try:
            for row, view.updated in scans:
                latch[_WHOLE] = row
                phase = logic
                logic()
                if memory != row or not self._by_rows:
                    phase = self.input_latch
                    self._catch_up()
                    for phase in (self.output_latch, self.record, self.housekeeping):
                        phase()
                    return
                phase = self.record
                tell(view.number, view.now_ns, flags)
                if self._attention or self.stop_requested or not self._by_rows:
                    phase = self.housekeeping
                    self._catch_up()
                    self.housekeeping()
                    return
                view.number += 1
                view.now_ns += period_ns
            phase = self.input_latch
            self._by_rows = False
            self._exchange.catch_up(view.now_ns - period_ns)
        except BaseException:
            self._catch_up()
            raise
        finally:
            self._present = phase

    def _catch_up(self) -> None:
        """Bring the modules up to the present scan, if they are behind."""
        if self._by_rows:
            self._by_rows = False
            self._exchange.catch_up(self._view.now_ns)
