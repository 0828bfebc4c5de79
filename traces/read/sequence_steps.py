"""Reads the waits of a program's sequences from the messages of /sequences.

A sequence has a message in each scan in which a wait begins. The wait lasts until the sequence's next
message.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds

from ..format.topics import SEQUENCES

if TYPE_CHECKING:  # a run does not read recordings
    from .reader import Trace, TraceEvent

OVER = "over"
"""Value of `wait` for a sequence that has ended or has not begun."""


@dataclass(frozen=True, slots=True)
class Step:
    """A wait of a sequence, which begins in a scan."""

    scan: int
    now_ns: int
    sequence: str
    file: str  # name of the file; empty once the sequence is over
    line: int  # the line of the wait; 0 once the sequence is over
    wait: str  # the condition; empty once the sequence is over

    @property
    def label(self) -> str:
        """The line and condition of the wait as text.

        >>> Step(602, 1_204_000_000, "cycle", "line.py", 14, "axis.move_to(4000)").label
        'line 14: axis.move_to(4000)'
        """
        return f"line {self.line}: {self.wait}" if self.line else OVER

    def __str__(self) -> str:
        """Return the line, the condition and the start time of the wait.

        >>> str(Step(602, 1_204_000_000, "cycle", "line.py", 14, "axis.move_to(4000)"))
        'cycle waits at line 14 of line.py for axis.move_to(4000) since 1.204 s'
        """
        since_text = f"since {seconds(self.now_ns)} s"
        if not self.line:
            return f"{self.sequence} is over {since_text}"
        return f"{self.sequence} waits at line {self.line} of {self.file} for {self.wait} {since_text}"


def step_of(event: TraceEvent) -> Step:
    """Return the step in a message of /sequences; missing fields are empty."""
    line = event.fields.get("line")
    sequence, file, wait = (str(event.fields.get(name) or "") for name in ("sequence", "file", "wait"))
    return Step(event.scan, event.now_ns, sequence, file, line if isinstance(line, int) else 0, wait)


def steps_of(events: Iterable[TraceEvent]) -> dict[str, list[Step]]:
    """Return the steps of each sequence in order; sequences are in the order of their first steps."""
    steps: dict[str, list[Step]] = {}
    for event in events:
        if event.topic == SEQUENCES.name:
            step = step_of(event)
            steps.setdefault(step.sequence, []).append(step)
    return steps


def sequence_steps(trace: Trace) -> dict[str, list[Step]]:
    """Return the steps of each sequence in a trace; empty if none are recorded."""
    return steps_of(trace.events()) if SEQUENCES.name in trace.head.channels else {}
