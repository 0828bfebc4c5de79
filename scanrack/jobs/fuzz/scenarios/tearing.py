"""Exchanges in the middle of a scan: the inputs of a CompactLogix ladder program change between two rungs.

    scan n        rung 0   rung 1  |  rung 2   rung 3
    inputs        R0       R0      |  R1       R1        a tear before rung 2

The interpreter runs such a scan; all other scans run compiled code. A Python program has no tears: on every
controller, its inputs are latched by contract (`runtime.loop.scan.LogicScan`).
"""

from __future__ import annotations

from collections.abc import Iterable

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.interpreter.between import PausingInterpreter
from scanrack.ladder.model.operands import Group, Place, first_leaf
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import (
    ADD_ON,
    AddOnCall,
    LoweredLine,
    LoweredProgram,
    LoweredStep,
    steps_of,
)
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.scan import LogicScan, ScanLogic
from typing_extensions import override

from ...record.logic_wrapper import LogicWrapper, unwrapped
from .scenario import TornUpdate

Rung = tuple[str, int]
"""A routine, and the number of its rung or line of structured text."""


def reading_rungs(lowered: LoweredProgram) -> tuple[Rung, ...]:
    """Return the rungs that read an input image: a tear has an effect only before one of them."""
    return tuple(
        {
            (routine.name, line.number): None
            for routine in lowered.routines.values()
            for line in routine.lines
            if _reads_inputs(lowered, line)
        }
    )


def _reads_inputs(lowered: LoweredProgram, line: LoweredLine) -> bool:
    return any(
        _of_inputs(where)
        for step in steps_of(line.nodes)
        for where in (
            *(mention.where for mention in mentions_of(lowered.sites[step.site], step) if mention.reads),
            *_handed(step),
        )
    )


def _handed(step: LoweredStep) -> Iterable[Place | Group]:
    """Return the operands that are passed to an add-on instruction by reference."""
    if step.name != ADD_ON:
        return ()
    call: AddOnCall = step.operands[0]
    return call.handed.values()


def _of_inputs(where: Place | Group) -> bool:
    leaf = first_leaf(where)
    return leaf.slot is not None and not leaf.output


class TornScans(LogicWrapper):
    """Runs a ladder program with tears.

    Attributes:
        cpu: CPU of the run, set before its first scan.
    """

    cpu: Cpu

    def __init__(self, logic: ScanLogic, tears: Iterable[TornUpdate], scan_ns: int) -> None:
        super().__init__(logic)
        program = unwrapped(logic)
        self._engine = program if isinstance(program, Engine) else None
        self._tears = {tear.at_ns // scan_ns: tear for tear in tears}

    @override
    def __call__(self, scan: LogicScan) -> None:
        tear, engine = self._tears.get(scan.number), self._engine
        if tear is None or engine is None:
            self._logic(scan)
            return
        interpreter = PausingInterpreter(engine.lowered, engine.memory, engine.fault_log, engine.call_python)
        interpreter.pause_at = tear.routine.upper(), tear.rung
        interpreter.pause = lambda: self._read_again(engine, scan)
        engine.scan_by(interpreter, scan)

    def _read_again(self, engine: Engine, scan: LogicScan) -> None:
        if self.cpu.exchange_early():
            engine.memory.take_inputs(updated=True)
            engine.memory.take_faults(scan.slot)
