"""Reports the waits of sequences and of a list of steps to a recorder or a journal.

    scan     602                       603 to 1,402   1,403
    cycle    waits at line 14          waits          waits at line 15
    written  /sequences                nothing        /sequences

A waiting sequence costs one comparison per scan; the text is created only after a step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from scanrack.ladder.files.steps import Steps
from scanrack.ladder.python.sequences import Logic, Sequence, parts_of, sequences_of
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.listeners import ScanListener, by_rows
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.format.topics import SEQUENCES
from scanrack.traces.read.sequence_steps import Step

from .logic_wrapper import unwrapped


def sequences_in(logic: ScanLogic) -> tuple[Sequence, ...]:
    """Return the sequences of a program in order of definition; none if it is not a `Logic`."""
    program = unwrapped(logic)
    return sequences_of(program) if isinstance(program, Logic) else ()


Waiting = Sequence | Steps
"""A sequence or list of steps, which waits at a line of the program."""


def waiting_in(logic: ScanLogic) -> tuple[Waiting, ...]:
    """Return the sequences of a program, or its list of steps."""
    program: object = unwrapped(logic)
    return (program,) if isinstance(program, Steps) else sequences_in(logic)


def declared_axes(logic: ScanLogic) -> dict[int, str]:
    """Return the lines that declare the axes of a program, by slot."""
    if not isinstance(logic, Logic):
        return {}
    from scanrack.ladder.python.axis3601 import Axis3601  # not needed without sequences

    declarations = parts_of(logic)
    return {
        declaration.slot: declaration.declared.spot
        for declaration in declarations
        if isinstance(declaration, Axis3601)
    }


def wait_of(sequence: Waiting, scan: int) -> Step:
    """Return the current wait of a sequence or list of steps."""
    file = Path(sequence.file or "").name
    line = sequence.line or 0
    return Step(scan, sequence.since_ns, sequence.name, file, line, sequence.waits_for)


def watching(listener: ScanListener, logic: ScanLogic) -> ScanListener:
    """Return a listener that also receives the waits of a program; the same listener if there are none."""
    sequences = waiting_in(logic)
    return WatchesSequences(listener, sequences) if sequences else listener


class WatchesSequences:
    """Reports each scan's sequence steps to a listener before passing on the scan.

    If a sequence steps in every scan but always waits for the same condition at the same line, that wait is
    reported only once.
    """

    def __init__(self, listener: ScanListener, sequences: tuple[Waiting, ...]) -> None:
        self._listener = listener
        self._rows = by_rows(listener)
        self.watch(sequences)

    def watch(self, sequences: tuple[Waiting, ...]) -> None:
        """Watch the sequences of an edited program instead."""
        self._watched = [_SequenceState(sequence) for sequence in sequences]

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Pass on an event."""
        self._listener.event(scan, now_ns, topic, fields)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Report sequences with a new step, and pass on the scan."""
        for state in self._watched:
            resumed = state.sequence.resumed
            if resumed != state.resumed:
                state.resumed = resumed
                step = state.step(scan)
                if step is not None:
                    self._listener.event(scan, now_ns, SEQUENCES.name, _fields_of(step))
        self._listener.scan(scan, now_ns, flags)

    @property
    def look(self) -> Callable[[], bool]:
        """The function to call within rows. It returns whether a sequence has made a step."""
        watched, look_of_listener = self._watched, None if self._rows is None else self._rows.look

        def look() -> bool:
            for state in watched:
                if state.sequence.resumed != state.resumed:
                    return True
            return look_of_listener is not None and look_of_listener()

        return look

    def begin_rows(self, scan: int) -> int:
        """Return how many scans the listener can receive at once."""
        return 0 if self._rows is None else self._rows.begin_rows(scan)

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Pass on scans in which no sequence has made a step."""
        assert self._rows is not None, "`begin_rows` has allowed them"
        self._rows.rows(scans, times, flags, images)

    def close(self) -> None:
        """Close the listener."""
        self._listener.close()


class _SequenceState:
    """A sequence and its last reported wait."""

    def __init__(self, sequence: Waiting) -> None:
        self.sequence = sequence
        self.resumed = 0  # number of steps at the last look
        self._scan = -1
        self._last_wait: tuple[str, int, str] | None = None  # file, line and condition

    def step(self, scan: int) -> Step | None:
        """Return the new wait; None if the wait is unchanged."""
        step = wait_of(self.sequence, scan)
        wait = step.file, step.line, step.wait
        is_repeated = wait == self._last_wait and scan == self._scan + 1
        self._scan, self._last_wait = scan, wait
        return None if is_repeated else step


def _fields_of(step: Step) -> dict[str, JsonValue]:
    """Return the fields of a message on /sequences for a step."""
    return {"sequence": step.sequence, "file": step.file, "line": step.line, "wait": step.wait}
