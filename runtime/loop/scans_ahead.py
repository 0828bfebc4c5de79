"""Scans by rows: the phases' work, scan by scan, while the inputs are known ahead (`runtime.loop.ahead`).

    scan n            phase           by rows
    at n * period     input_latch     copies the scan's row into the rack's memory
                      logic           the same
                      output_latch    compares: the memory still equals the row, nothing is to be sent
                      record          passes on the scan; no events exist
                      housekeeping    moves on

New outputs, a request, a stop, or any action on a module ends the block in the same scan, which
continues with its phases.

Where all rows are equal, a `RepeatFinder` may find that the coming scans repeat the latest one. Such scans
only take their time: neither logic nor listeners are called.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import repeat
from typing import Protocol

from .ahead import LEAST_ROWS, Block, Patience, numpy_is_worth_it
from .exchange import Exchange
from .phases import Phase, ScanPhases
from .rack import Rack

_WHOLE = slice(None)

MOST_APART = 63
"""Scans between two questions to a `RepeatFinder` while the program changes in each of them."""


class RepeatFinder(Protocol):
    """Finds scans that repeat the one before them: the same inputs, program state and listeners' answers."""

    def keep(self) -> None:
        """Keep the program's state before the next scan."""

    def repeats(self, scan: int, now_ns: int, most: int) -> int:
        """Return how many of the coming scans repeat the latest one, and move the program's clocks on.

        Args:
            scan: number of the next scan.
            now_ns: time of the latest scan, before which the state was kept.
            most: the largest number.
        """


class ScansAhead:
    """Runs scans, by their phases or by rows."""

    def __init__(self, phases: ScanPhases, rack: Rack, exchange: Exchange, period_ns: int) -> None:
        self._finder: RepeatFinder | None = None
        self.enabled = True  # False = every scan by its phases, as in tests and for irregular scans
        self.stop_requested = False
        self.present: Phase = phases.input_latch  # the phase that ran last
        self.patience = Patience()
        self._phases, self._exchange, self._period_ns = phases, exchange, period_ns
        self._memory, self._latch = rack.memory, memoryview(rack.memory)
        self._modules = tuple(slot.module for slot in rack.slots.values())
        self._by_rows = False
        exchange.tell_before_change(self.catch_up)

    def pass_over_repeats(self, finder: RepeatFinder) -> None:
        """Pass over scans that repeat the one before them, and look ahead more often for that."""
        self._finder = finder
        self.patience.longest_wait = self.patience.SHORTEST_WAIT

    def run(self, scans: int) -> None:
        """Run scans until they are done or a stop is requested."""
        while True:
            scans -= self._by_phases(min(scans, self.patience.wait))
            scans -= self._ahead(scans)
            if scans <= 0 or self.stop_requested:
                break

    def _by_phases(self, scans: int) -> int:
        phases, phase = self._phases, self.present
        try:
            for _ in repeat(None, scans):
                for phase in phases.order:
                    phase()
                if self.stop_requested:
                    break
        finally:
            self.present = phase
        return scans

    def _ahead(self, most: int) -> int:
        """Run foreseen scans by rows; return their number."""
        view, patience = self._phases.view, self.patience
        worth = self._finder is not None or numpy_is_worth_it(view.number)
        if not (self._phases.plain and self.enabled and worth):
            patience.not_calm(0)
            return 0
        if self.stop_requested or most < LEAST_ROWS or any(module.events for module in self._modules):
            return 0  # the next scan's phases handle events of a module that a listener has acted on
        calm = self._exchange.calm_scans(view.now_ns, self._period_ns)
        if calm < LEAST_ROWS:
            patience.not_calm(calm)
            return 0
        count = min(calm, most)
        block = self._exchange.foresee(view.now_ns, self._period_ns, count, patience.most_rows)
        first = view.number
        if self._finder is None or block.row is None:
            self._scan_rows(block.scans)
        else:
            self._scan_equal_rows(self._finder, block)
        used = view.number - first
        patience.ended(used, block.length)
        return used

    def _scan_equal_rows(self, finder: RepeatFinder, block: Block) -> None:
        """Run scans of one row, less those that repeat another one."""
        view, period_ns, scans = self._phases.view, self._period_ns, (block.row or b"", True)
        end, apart = view.number + block.length, 0
        while view.number < end:
            if apart and not self._scan_rows(repeat(scans, min(apart, end - view.number - 1))):
                return
            finder.keep()
            if not self._scan_rows(repeat(scans, 1)):
                return
            repeated = finder.repeats(view.number, view.now_ns - period_ns, end - view.number)
            apart = 0 if repeated else min(2 * apart + 1, MOST_APART)
            if repeated:
                view.number += repeated
                view.now_ns += repeated * period_ns
                self._exchange.catch_up(view.now_ns - period_ns)

    def _scan_rows(self, scans: Iterable[tuple[bytes, bool]]) -> bool:
        """Run scans by rows; return whether the last one ended by its row."""
        phases, memory, latch, period_ns = self._phases, self._memory, self._latch, self._period_ns
        view, logic, tell, flags = phases.view, phases.call_logic, phases.listeners.scan, phases.flags
        phase: Phase = phases.input_latch
        self._by_rows = True
        try:
            for row, view.updated in scans:
                latch[_WHOLE] = row
                phase = logic
                logic()
                if memory != row or not self._by_rows:
                    phase = phases.input_latch
                    self.catch_up()
                    for phase in (phases.output_latch, phases.record, phases.housekeeping):
                        phase()
                    return False
                phase = phases.record
                tell(view.number, view.now_ns, flags)
                if phases.attention or self.stop_requested or not self._by_rows:
                    phase = phases.housekeeping
                    self.catch_up()
                    phases.housekeeping()
                    return False
                view.number += 1
                view.now_ns += period_ns
            phase = phases.input_latch
            self._by_rows = False
            self._exchange.catch_up(view.now_ns - period_ns)
            return True
        except BaseException:
            self.catch_up()
            raise
        finally:
            self.present = phase

    def catch_up(self) -> None:
        """Advance the modules to the present scan, if they are behind."""
        if self._by_rows:
            self._by_rows = False
            self._exchange.catch_up(self._phases.view.now_ns)
