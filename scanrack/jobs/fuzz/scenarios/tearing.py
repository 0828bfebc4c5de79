"""Exchanges in the middle of a scan: the inputs of a CompactLogix ladder program change between two rungs.

    scan n        rung 0   rung 1  |  rung 2   rung 3
    inputs        R0       R0      |  R1       R1        a tear before rung 2

The interpreter runs a scan with a tear. Compiled code runs all other scans. A Python program has no tears,
since the scan loop latches its inputs on every controller (`runtime.loop.scan.LogicScan`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.interpreter.between import PausingInterpreter
from scanrack.ladder.model.operands import Group, Place, first_leaf
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import (
    ADD_ON,
    AddOnCall,
    LoweredLine,
    LoweredProgram,
    steps_of,
)
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.scan import LogicScan, ScanLogic
from typing_extensions import override

from ...record.logic_wrapper import LogicWrapper, unwrapped
from .scenario import TornUpdate

Rung = tuple[str, int]
"""A routine, and the number of a rung or line of structured text."""


def reading_rungs(lowered: LoweredProgram) -> tuple[Rung, ...]:
    """Return the rungs that read an input image. Only a tear before one of them has an effect."""
    rungs = [
        (routine.name, line.number)
        for routine in lowered.routines.values()
        for line in routine.lines
        if any(map(_is_input, _read_operands(lowered, line)))
    ]
    return tuple(dict.fromkeys(rungs))


def _read_operands(lowered: LoweredProgram, line: LoweredLine) -> Iterator[Place | Group]:
    """Yield the operands that a line reads, or passes to an add-on instruction by reference."""
    for step in steps_of(line.nodes):
        for mention in mentions_of(lowered.sites[step.site], step):
            if mention.reads:
                yield mention.where
        if step.name == ADD_ON:
            call: AddOnCall = step.operands[0]
            yield from call.handed.values()


def _is_input(operand: Place | Group) -> bool:
    """Return whether an operand is in an input image."""
    leaf = first_leaf(operand)
    return leaf.slot is not None and not leaf.output


class TornScans(LogicWrapper):
    """Runs a ladder program with tears.

    Attributes:
        cpu: CPU of the run; set before the first scan.
    """

    cpu: Cpu

    def __init__(self, logic: ScanLogic, tears: Iterable[TornUpdate], scan_ns: int) -> None:
        super().__init__(logic)
        program = unwrapped(logic)
        self._engine = program if isinstance(program, Engine) else None
        self._tears = {tear.at_ns // scan_ns: tear for tear in tears}

    @override
    def __call__(self, scan: LogicScan) -> None:
        """Run a scan.

        A scan with a tear is interpreted, and exchanges the images before the rung of the tear.
        """
        tear, engine = self._tears.get(scan.number), self._engine
        if tear is None or engine is None:
            self._logic(scan)
            return
        interpreter = PausingInterpreter(engine.lowered, engine.memory, engine.fault_log, engine.call_python)
        interpreter.pause_at = tear.routine.upper(), tear.rung
        interpreter.pause = lambda: self._exchange(engine, scan)
        engine.scan_by(interpreter, scan)

    def _exchange(self, engine: Engine, scan: LogicScan) -> None:
        """Exchange the images if an exchange is due, and copy the new inputs to the program."""
        if self.cpu.exchange_early():
            engine.memory.take_inputs(updated=True)
            engine.memory.take_faults(scan.slot)
