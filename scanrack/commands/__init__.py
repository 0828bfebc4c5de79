"""The commands; the only place that knows all the rooms.

`application` reads words by typer. Plain words of `run`, the command that people wait for, need no typer.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, NamedTuple

from scanrack.runtime.loop.pace import ending_as_interrupt, interrupted_by
from scanrack.terminal.ending import end_in_time
from scanrack.terminal.status import BAD_INPUT, INTERRUPTED, PIPE_CLOSED, complain, reason
from scanrack.terminal.streams import LostOutput, closed_streams_plugged, guarded_output

if TYPE_CHECKING:
    import typer

__all__ = ["build", "main"]


class Entry(NamedTuple):
    """A line of `scanrack --help`."""

    module: str  # of the command, relative to this package; it has `register(app)`
    sentence: str


GROUPS = {
    "Run and watch": {
        "new": Entry(".programs.new", "Create a project."),
        "run": Entry(".programs.run", "Run a rack and record every scan."),
        "watch": Entry("..watch.command", "Open a live rack or a trace in the browser."),
    },
    "Traces": {
        "show": Entry(".recordings.show", "List events and changes."),
        "query": Entry(".recordings.query", "Find scans matching a condition."),
        "plot": Entry(".recordings.plot", "Draw a timing chart."),
        "compare": Entry(".recordings.compare", "Find where two traces differ."),
        "replay": Entry(".recordings.replay", "Replay and check for differences."),
        "share": Entry("..watch.share.command", "Export as one HTML file."),
        "export": Entry(".recordings.export", "Convert a trace for other programs."),
        "import": Entry(".recordings.imports", "Convert a network capture."),
        "repair": Entry(".recordings.repair", "Recover a damaged trace."),
    },
    "Programs": {
        "check": Entry(".programs.check", "Check a rack or program without running it."),
        "why": Entry(".programs.why", "Explain why a tag has its value."),
        "ladder": Entry(".programs.ladder", "Draw rungs."),
        "xref": Entry(".programs.why", "List where tags are read and written."),
        "tags": Entry(".programs.tags", "List the tags that clients of --server see."),
        "l5x": Entry(".programs.l5x", "Report what an L5X or SLC export supports."),
    },
    "Search and prove": {
        "fuzz": Entry(".programs.fuzz", "Search for inputs and faults that break a program."),
        "prove": Entry(".programs.prove", "Prove properties or find counterexamples."),
    },
    "Devices and hardware": {
        "device": Entry(".wire.device", "List, identify, read, set and move devices."),
        "serve": Entry(".wire.serve", "Simulate a device on a port."),
        "drive": Entry(".wire.drive", "Exercise one module with JSON requests."),
        "conform": Entry(".wire.conform", "Test a real 3601 against its manual."),
    },
    "Setup and reference": {
        "doctor": Entry(".programs.doctor", "Check this installation."),
        "editor": Entry(".programs.editor", "Connect an editor."),
        "rules": Entry(".programs.rules", "List rules and error bits of a 3601 or a drive."),
    },
}
"""The commands by their headings, in the order of --help."""

COMMANDS = {name: entry for group in GROUPS.values() for name, entry in group.items()}


def build() -> typer.Typer:
    """Return the command-line application."""
    from .application import application

    return application()


@contextmanager
def interrupted() -> Iterator[None]:
    """Let a signal that ends the process interrupt a command, with one message.

    Commands with unfinished work, such as a trace, complete it on their way out.

    Raises:
        SystemExit: the command was interrupted.
    """
    with ending_as_interrupt():
        try:
            yield
        except KeyboardInterrupt:
            raise SystemExit(complain(f"stopped by {interrupted_by()}", INTERRUPTED)) from None


def main() -> None:
    """Run the `scanrack` command; print at most one message, whatever ends it.

    Raises:
        SystemExit: always, with a status of `terminal.status`.
    """
    try:
        _main()
    except SystemExit as end:
        end_in_time(end.code)
        raise


def _main() -> None:
    closed_streams_plugged()
    try:
        with guarded_output():
            _run()
    except LostOutput as lost:
        if lost.status != PIPE_CLOSED:
            with suppress(OSError):  # standard error may be full, too
                complain(f"standard output can't be written: {lost.error.strerror}")
        sys.exit(lost.status)


def _run() -> None:
    """Run the command; report an error of a file that no command handles."""
    try:
        words, completing = sys.argv[1:], any(name.endswith("_COMPLETE") for name in os.environ)
        if words[:1] != ["run"] or completing or not _run_plainly(words[1:]):
            build()()
    except OSError as error:
        sys.exit(complain(reason(error), BAD_INPUT))


def _run_plainly(words: Sequence[str]) -> bool:
    """Run a rack, without typer; return False if the words are not plain.

    Raises:
        SystemExit: the run has ended.
    """
    from .programs.run_command import plain_arguments, run_command

    options = plain_arguments(words)
    if options is not None:
        with interrupted():
            run_command(options)
    return False
