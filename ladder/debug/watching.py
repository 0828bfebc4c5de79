"""An engine that runs compiled, or in the interpreter while it is watched.

Changes are watched in the interpreter, which is the reference for the compiler. The compiled program can
record the power of rungs and apply forces, see `compiler.observed`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..compiler import ObservedScanner, Scanner, observed_scanner_of
from ..compiler.observed import (
    NOTED,
    UNOBSERVED,
    LineKey,
    Observation,
    Reading,
    lines_of,
    true_at_end,
    truth_of,
)
from ..model.tags import Leaf
from ..run.engine import Engine
from ..state.lowered import LoweredProgram
from ..state.memory import Value
from .forces import ForcedValue, Forces, force_variables
from .watched import Change, WatchedInterpreter, WatchedMemory


class WatchedEngine(Engine):
    """An engine that runs a program compiled, or in the interpreter while it is watched."""

    memory_type = WatchedMemory
    interpreter_type = WatchedInterpreter
    memory: WatchedMemory
    interpreter: WatchedInterpreter

    def __init__(self, lowered: LoweredProgram, scanner: Scanner) -> None:
        super().__init__(lowered, scanner)
        self._compiled = self._scan
        self._calling = self._calling_compiled = self.call_routine
        self.variants: dict[Observation, ObservedScanner] = {}  # compiled with observation; may be shared
        self._has_unapplied_forces = False
        self._bound: Callable[[int], object] | None = self._compiled  # None: `_observed` must choose it
        self._variables: tuple[ForcedValue, ...] = ()  # forced values with their own variables
        self._notes: list[Any] = []  # notes of the compiled scan: first one per line of `noted`
        self._blank: list[None] = []  # resets the notes of the lines
        self._readings: Sequence[Reading] = ()  # how to read the notes, by line of `noted`
        self._positions: dict[LineKey, int] = {}  # of the lines in `noted`
        self.noted: tuple[LineKey, ...] = ()  # the lines with noted power
        self._all_lines = lines_of(lowered)
        self.watching = False  # whether the next scans are watched
        self.broken_off = False  # whether a fault ended the latest scan or a rung in it
        self.history: list[Change] = []  # changes in watched scans
        self.scans = 0  # number of scans so far
        self.outside: tuple[tuple[Leaf, int, Value], ...] = ()  # external writes before the next scan

    # --- observation

    def hold(self, forces: Forces) -> None:
        """Replace all forces, starting with the next scan; the mapping is kept and must not be modified."""
        if forces is self.memory.forces:
            return
        self._variables = self.memory.hold(forces)
        self._has_unapplied_forces = True
        self._bound = None

    def note(self, lines: tuple[LineKey, ...]) -> None:
        """Note the power of only these lines, beginning with the next scan."""
        if lines is not self.noted and lines != self.noted:
            self.noted = lines
            self._notes, self._blank, self._readings = [], [], ()
            self._positions = {key: position for position, key in enumerate(lines)}
            self._bound = None

    def note_all(self) -> None:
        """Note the power of all lines, beginning with the next scan."""
        self.note(self._all_lines)

    @property
    def notes_all(self) -> bool:
        """Whether the power of all lines was noted in the latest scan."""
        return self.noted is self._all_lines

    @property
    def notes(self) -> Sequence[object]:
        """The notes of the latest scan; equal notes mean equal `truths`."""
        return list(self.interpreter.truths.items()) if self.watching else self._notes

    @property
    def truths(self) -> Mapping[LineKey, tuple[bool, ...]]:
        """The power of lines in the latest scan: all lines if it was watched, otherwise the noted lines."""
        if self.watching:
            return dict(self.interpreter.truths)
        truths = {}
        for position, reading in enumerate(self._readings):
            truth = truth_of(self._notes, position, reading)
            if truth is not None:
                truths[self.noted[position]] = truth
        return truths

    def ran(self, key: LineKey) -> bool:
        """Return whether a noted line ran in the latest scan."""
        if self.watching:
            return key in self.interpreter.truths
        position = self._positions.get(key)
        return position is not None and bool(self._notes) and self._notes[position] is not None

    def true_at_end(self, key: LineKey) -> bool:
        """Return whether a noted line was true at its end in the latest scan, which ran compiled."""
        position = self._positions.get(key)
        if position is None or not self._notes:
            return False
        return true_at_end(self._notes, position, self._readings[position])

    def _observed(self) -> Callable[[int], object]:
        """Return the compiled program with the current notes and forces."""
        if self._bound is None:
            forced_variables = frozenset(
                (variable.leaf.ident, variable.free_mask is not None) for variable in self._variables
            )
            observation = Observation(forced_variables, self.noted, bool(self.memory.forces))
            self._bound, self._calling = self._compiled, self._calling_compiled
            if observation != UNOBSERVED:
                variant = self.variants.get(observation)
                if variant is None:
                    variant = self.variants[observation] = observed_scanner_of(self.lowered, observation)
                self._notes, self._readings = [None] * variant.note_count, variant.readings
                self._blank = [None] * len(self.noted)
                self._bound = variant.bind(self, {NOTED: self._notes, **force_variables(self._variables)})
                self._calling = self.call_routine
        return self._bound

    # --- scans

    def do(self, now_ns: int, first: bool) -> None:
        """Run one scan; may raise a LadderFault."""
        if self._bound is None or self._scan is not self._bound or self.outside or self.watching:
            self._scan_at(now_ns, first=first)
            return
        if self._blank:
            self._notes[: len(self._blank)] = self._blank  # other notes are read only with these
        scheduler = self.scheduler
        handled = 0 if scheduler is None else scheduler.handled
        self.broken_off = True
        try:
            Engine._scan_at(self, now_ns, first)  # it observes the same as in the previous scan
            self.broken_off = scheduler is not None and handled != scheduler.handled
        finally:
            self.scans += 1

    def _scan_at(self, now_ns: int, first: bool) -> None:
        """Make external writes and apply forces, then run a scan: interpreted if watched, or compiled."""
        self.history.clear()
        self.interpreter.truths.clear()
        self.now_ns = now_ns
        self._notes[: len(self._blank)] = self._blank  # other notes are read only with these
        if self.watching:
            self._scan, self.call_routine = self.interpreter.scan, self.interpreter.run
        else:
            self._scan = self._observed()
            self.call_routine = self._calling
        self.memory.watcher = self._changed if self.watching else None
        self.broken_off, handled = True, self._handled
        try:
            for leaf, index, value in self.outside:
                self.memory.write(leaf, index, value)
            self.outside = ()
            if self._has_unapplied_forces:
                self.apply_forces()
            super()._scan_at(now_ns, first)
            self.broken_off = handled != self._handled
        finally:
            self.memory.watcher = None
            self.scans += 1

    @property
    def _handled(self) -> int:
        return self.scheduler.handled if self.scheduler is not None else 0

    def apply_forces(self) -> None:
        """Write the forced values to the memory."""
        self._has_unapplied_forces = False
        memory = self.memory
        for forced in memory.forced_by_key.values():
            memory.write(forced.leaf, forced.index, memory.read(forced.leaf, forced.index))

    def _changed(self, leaf: Leaf, index: int, before: Value, after: Value) -> None:
        """Record a change, with the instruction that made it and its conditions."""
        interpreter = self.interpreter
        self.history.append(
            Change(
                scan=self.scans,
                now_ns=self.now_ns,
                leaf=leaf,
                index=index,
                before=before,
                after=after,
                site=interpreter.present,
                power=interpreter.power,
                blockers=interpreter.blockers(),
                mode=interpreter.mode,
                read=interpreter.read,
                inside=tuple(interpreter.heads),
                instance=interpreter.instance,
            )
        )
