"""Progress and notes of commands that read a trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from .terminal import on_a_line, say

if TYPE_CHECKING:  # a run imports no recordings
    from scanrack.traces.files.guard import Used
    from scanrack.traces.read.reader import Trace
    from scanrack.traces.signals import Selection


@contextmanager
def reading(
    trace: Trace, selection: Selection | None = None, *, quiet: bool
) -> Iterator[Callable[[int], None]]:
    """Show a bar of the processed scans if standard error is a terminal; yield a function that adds scans."""
    # imported late, since a run needs no bar of a trace
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from scanrack.traces.signals import ALL, count

    from .bars import shown_bar

    columns = (TextColumn("scans"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with shown_bar(*columns, quiet=quiet, total=lambda: count(trace, selection or ALL)) as update:
        yield lambda scans: update(advance=scans)


class HasNotes(Protocol):
    """A trace, or a result of reading one, with the defects of its file."""

    @property
    def notes(self) -> Sequence[str]:
        """The defects of the file."""


def print_notes(*traces: HasNotes) -> None:
    """Print the defects of the files on standard error."""
    for trace in traces:
        for note in trace.notes:
            say(on_a_line(f"note: {note}"), err=True)


def itself(trace: Path) -> Used:
    """Return the command's input as an entry in the files that its output must not overwrite."""
    return {trace: "the trace itself"}
