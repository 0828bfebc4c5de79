"""A scan that is looked at: its rungs in the order of execution, and the values before any of them.

    order     0      1      2      3      4      5           end
    rung      Main 0        AOI 0  AOI 1  Main 1
    writes           A             B             C
    before Main 1: the values at the end, without C

A scan is always finished, as in a controller. What an editor steps through is therefore the scan as it was
executed, forwards and backwards at the same cost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

from scanrack.ladder.debug.executed import Execution, LineRun, StepRun, TracedEngine
from scanrack.ladder.debug.replay import Replayer
from scanrack.ladder.state.snapshots import restore, snapshot

from .protocol import DebugError


class Stop(NamedTuple):
    """A place before an instruction of a scan."""

    order: int  # what is written after it has not happened yet
    run: LineRun
    step: StepRun | None  # None before the first instruction of a rung
    depth: int  # calls around it


class ExecutedScan:
    """One scan, run again: compiled for the values at its end, in the interpreter for its instructions.

    Args:
        replayer: runs the scans; used for nothing else until `leave`.

    Raises:
        DebugError: the scan can't be repeated.
    """

    def __init__(self, replayer: Replayer, scan: int) -> None:
        assert isinstance(replayer.engine, TracedEngine)
        self.scan, self.engine = scan, replayer.engine
        self._replayer = replayer
        if not replayer.show(scan):
            raise DebugError(f"scan {scan:,} can no longer be repeated")
        self._end = snapshot(self.engine.memory)

    @cached_property
    def execution(self) -> Execution:
        """What was executed; the memory is then that at the end of the scan."""
        self.engine.traced = True
        try:
            self._replayer.again(self.scan)
        finally:
            self.engine.traced = False
        found = self.engine.execution
        return found if found is not None and found.scan == self.scan else Execution(self.scan)

    @cached_property
    def stops(self) -> Sequence[Stop]:
        """The places before rungs and instructions, in the order of execution."""
        return sorted(self._stops(), key=lambda each: (each.order, each.depth))

    def _stops(self) -> Iterator[Stop]:
        for run in self.execution.runs.values():
            if run.line.number < 0:  # of a chart as a whole
                continue
            depth = len(list(callers(run)))
            own = [each for each in run.steps.values() if each.parent is None]
            yield Stop(run.order, run, None, depth)
            yield from (Stop(each.order - 1, run, each, depth) for each in own[1:])

    def show(self, order: int | None) -> None:
        """Set the memory of the engine to the values after an instruction; None = at the end of the scan."""
        self._replayer.at = None
        memory = self.engine.memory
        restore(memory, self._end)
        if order is not None:
            for each in reversed(self.execution.writes):
                if each.order <= order:
                    break
                memory.write(each.cell.leaf, each.cell.index, each.before)

    def set(self, tag: str, value: object) -> None:
        """Show a value that was set after the scan, until another place is shown."""
        self.engine.tags[tag] = value

    def leave(self) -> None:
        """Give the replayer back."""
        restore(self.engine.memory, self._end)
        self._replayer.at = self.scan


def callers(run: LineRun) -> Iterator[StepRun]:
    """Yield the instructions that call the routine of a rung, innermost first."""
    step = run.caller
    while step is not None:
        yield step
        step = step.run.caller
