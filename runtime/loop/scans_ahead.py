"""Scans by rows: the work of each phase while inputs are computed in advance (`runtime.loop.ahead`).

    scan n            phase           by rows
    at n * period     input_latch     copies the scan's row into the rack's memory
                      logic           calls the program, as usual
                      output_latch    checks that the memory still equals the row: nothing to send
                      record          passes on the scan; there are no events
                      housekeeping    advances number and time

New outputs, a request, a stop, or an action on a module ends the block in the same scan, which then
continues with the ordinary phases.

If all rows are equal, a `RepeatFinder` may find that the upcoming scans repeat the latest one. Repeated scans
only advance the time, without calling logic or listeners.

If all listeners are `RowListener`s, they receive many scans together, with the rows as images. Otherwise, or
while one of them needs every scan separately, each scan is passed on at its end; this is slower.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import repeat
from typing import Protocol

from .ahead import LEAST_ROWS, Block, Patience, numpy_is_worth_it
from .exchange import Exchange
from .phases import Phase, ScanPhases
from .rack import Rack
from .scan import LogicScan, ScanLogic

_WHOLE = slice(None)
_NO_ROWS: tuple[list[int], list[int], list[bytes]] = [], [], []
"""Numbers, times and images of pending scans, all empty."""

MOST_APART = 63
"""Maximum number of scans between two calls to a `RepeatFinder` while it finds no repeats."""


class RepeatFinder(Protocol):
    """Finds scans that repeat the previous one: the same inputs, program state and listener results."""

    def keep(self) -> None:
        """Store the program's state before the next scan."""

    def repeats(self, scan: int, now_ns: int, most: int) -> int:
        """Return how many upcoming scans repeat the latest one, and advance the program's clocks past them.

        Args:
            scan: number of the next scan.
            now_ns: time of the latest scan; the state was stored before that scan.
            most: maximum number to return.
        """


class ScansAhead:
    """The loop that runs scans, by their phases or by rows.

    Attributes:
        enabled: whether scans may run by rows; False = every scan runs by phases, as in tests and for
            irregular scans.
        stop_requested: whether the present scan is the last one.
        present: the phase that ran last.
    """

    def __init__(self, phases: ScanPhases, rack: Rack, exchange: Exchange, period_ns: int) -> None:
        self._finder: RepeatFinder | None = None
        self.enabled = True
        self.stop_requested = False
        self.present: Phase = phases.input_latch
        self.patience = Patience()
        self._phases, self._exchange, self._period_ns = phases, exchange, period_ns
        self._memory, self._latch = rack.memory, memoryview(rack.memory)
        self._modules = tuple(slot.module for slot in rack.slots.values())
        self._by_rows = False  # whether the modules may be behind
        self._ends = False  # whether the present scan ends its block
        self._pending = _NO_ROWS
        exchange.call_before_change(self.catch_up)

    def pass_over_repeats(self, finder: RepeatFinder) -> None:
        """From now on, only advance the time in repeated scans, and look ahead more often to find them."""
        self._finder = finder
        self.patience.longest_wait = self.patience.SHORTEST_WAIT

    def run(self, scans: int) -> None:
        """Run scans until they are done or a stop is requested."""
        while True:
            scans -= self._by_phases(min(scans, self.patience.wait))
            scans -= self._ahead(scans)
            if scans <= 0 or self.stop_requested:
                break

    def stop(self) -> None:
        """Make the present scan the last one of the run; may be called from a signal handler."""
        self.stop_requested = self._ends = True

    def end_block(self) -> None:
        """End the block of rows with the present scan, since the next scan must process a change."""
        self._ends = True

    def before_new_listeners(self) -> None:
        """End the block, and pass all scans before the present one to the current listeners."""
        self._ends = True
        self._pass_on(self._phases.view.number)

    def catch_up(self) -> None:
        """Advance the modules to the present scan, if they are behind."""
        if self._by_rows:
            self._by_rows, self._ends = False, True
            self._exchange.catch_up(self._phases.view.now_ns)

    def _by_phases(self, scans: int) -> int:
        """Run scans phase by phase until they are done or a stop is requested; return `scans`."""
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
        """Run up to `most` scans by rows; return how many were run."""
        view, patience = self._phases.view, self.patience
        calm = self._calm_scans(most)
        if calm < LEAST_ROWS:
            if calm >= 0:
                patience.not_calm(calm)
            return 0
        block = self._exchange.foresee(view.now_ns, self._period_ns, min(calm, most), patience.most_rows)
        first_scan = view.number
        if self._finder is not None and isinstance(block.rows, bytes) and block.updated is None:
            self._scan_repeats(self._finder, block)
        else:
            self._scan_block(block)
        scans_used = view.number - first_scan
        patience.ended(scans_used, block.length)
        return scans_used

    def _calm_scans(self, most: int) -> int:
        """Return how many scans can run by rows now; 0 if unknown, -1 if the next scan can't."""
        phases = self._phases
        is_worth_it = self._finder is not None or numpy_is_worth_it(phases.view.number)
        if not (phases.plain and self.enabled and is_worth_it):
            return 0
        self._ends = False  # reset before the checks below, so that no end of a block is missed
        if self.stop_requested or phases.attention or most < LEAST_ROWS:
            return -1
        if any(module.events for module in self._modules):
            return -1  # a listener has acted on a module: the phases of the next scan pass on its events
        return self._exchange.calm_scans(phases.view.now_ns, self._period_ns)

    def _scan_repeats(self, finder: RepeatFinder, block: Block) -> None:
        """Run the scans of a block that has a single row, except for repeated scans."""
        view, period_ns = self._phases.view, self._period_ns
        end, scans_between = view.number + block.length, 0
        while view.number < end:
            if scans_between:
                length = min(scans_between, end - view.number - 1)
                if not self._scan_block(block._replace(length=length)):
                    return
            finder.keep()
            if not self._scan_block(block._replace(length=1)):
                return
            repeated = finder.repeats(view.number, view.now_ns - period_ns, end - view.number)
            scans_between = 0 if repeated else min(2 * scans_between + 1, MOST_APART)
            if repeated:
                view.number += repeated
                view.now_ns += repeated * period_ns
                self._exchange.catch_up(view.now_ns - period_ns)

    def _scan_block(self, block: Block) -> bool:
        """Run scans by rows; return whether all of them could run by rows."""
        view, start = self._phases.view, 0
        self._by_rows = True
        try:
            while self._by_rows and start < block.length:
                rows_most = self._phases.rows_at_once()
                if rows_most:
                    count = min(rows_most, block.length - start)
                    self._scan_at_once(block, start, count)
                else:
                    count = block.length - start
                    self._scan_one_by_one(block.scans(start))
                start += count
            is_complete = self._by_rows
            if is_complete:
                self.present = self._phases.input_latch
                self._by_rows = False
                self._exchange.catch_up(view.now_ns - self._period_ns)
            return is_complete
        except BaseException:
            self.catch_up()
            raise

    # each scan is passed on at its end

    def _scan_one_by_one(self, scans: Iterable[tuple[bytes, bool]]) -> None:
        """Run scans by rows; each is passed on at its end.

        A scan that ends the block continues with the phases that are still due. After an error, `present` is
        the phase that failed.
        """
        phases, memory, latch, period_ns = self._phases, self._memory, self._latch, self._period_ns
        view, logic, pass_on, flags = phases.view, phases.call_logic, phases.listeners.scan, phases.flags
        phase: Phase = phases.input_latch
        try:
            for row, view.updated in scans:
                latch[_WHOLE] = row
                phase = logic
                logic()
                if memory != row or not self._by_rows:
                    phase = phases.input_latch
                    self.catch_up()
                    for phase in phases.after_logic:
                        phase()
                    return
                phase = phases.record
                pass_on(view.number, view.now_ns, flags)
                if phases.attention or self.stop_requested or not self._by_rows:
                    phase = phases.housekeeping
                    self.catch_up()
                    phases.housekeeping()
                    return
                view.number += 1
                view.now_ns += period_ns
        finally:
            self.present = phase

    # many scans are passed on together

    def _scan_at_once(self, block: Block, start: int, count: int) -> None:
        """Run `count` scans by rows from index `start`, and pass them on together.

        A scan that ends the block is passed on with them if it is complete. Otherwise, the phases after its
        logic run now.
        """
        phases, view, period_ns = self._phases, self._phases.view, self._period_ns
        numbers = list(range(view.number, view.number + count))
        times = list(range(view.now_ns, view.now_ns + count * period_ns, period_ns))
        rows = block.rows_from(start, count)
        self._pending = numbers, times, rows
        self.present, is_complete = phases.call_logic, False
        try:
            is_complete = self._run_logic(numbers, times, rows, self._program_in_rows(block, start))
            self.present = phases.record
        finally:
            self._pass_on(view.number + 1 if is_complete else view.number)
            self._pending = _NO_ROWS
        if is_complete and not self._ends:
            view.number += 1
            view.now_ns += period_ns
            return
        self.present = phases.input_latch
        self.catch_up()
        for self.present in (phases.housekeeping,) if is_complete else phases.after_logic:
            self.present()

    def _pass_on(self, end: int) -> None:
        """Pass the scans by rows to the listeners, up to but not including number `end`."""
        numbers, times, rows = self._pending
        count = end - numbers[0] if numbers else 0
        if count:
            self._pending = numbers[count:], times[count:], rows[count:]
            self._phases.listeners.rows(numbers[:count], times[:count], self._phases.flags, rows[:count])

    def _program_in_rows(self, block: Block, start: int) -> ScanLogic:
        """Return the program, wrapped if `updated` must be set before it or listeners called after it."""
        program, looks = self._phases.program, self._phases.listeners.looks
        self._phases.view.updated = True
        if not looks and block.updated is None:
            return program
        updates = block.updates(start)

        def program_with_looks(scan: LogicScan) -> None:
            scan.updated = next(updates)
            program(scan)
            for look in looks:
                if look():
                    self._ends = True

        return program_with_looks

    def _run_logic(self, numbers: list[int], times: list[int], rows: list[bytes], program: ScanLogic) -> bool:
        """Run the logic of scans; return False if the present scan ends the block, before it is passed on."""
        memory, latch, view = self._memory, self._latch, self._phases.view
        for view.number, view.now_ns, row in zip(numbers, times, rows, strict=True):
            latch[_WHOLE] = row
            program(view)
            if memory != row or self._ends:
                return False
        return True


LOGIC_CALLERS = (ScanPhases.logic.__code__, ScansAhead._run_logic.__code__)
"""Functions that call the logic; while one of them is on the stack, the logic is running."""
