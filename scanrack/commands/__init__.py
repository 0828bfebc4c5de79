"""The commands; the only place that knows all the rooms.

`application` reads words by typer. Plain words of `run`, the command that people wait for, need no typer.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING

from scanrack.terminal.ending import end_in_time
from scanrack.terminal.importing import own_process
from scanrack.terminal.interrupting import interrupted
from scanrack.terminal.status import BAD_INPUT, PIPE_CLOSED, complain, reason
from scanrack.terminal.streams import LostOutput, closed_streams_plugged, guarded_output

from .catalog import COMMANDS, GROUPS

if TYPE_CHECKING:
    import typer

__all__ = ["COMMANDS", "GROUPS", "build", "main"]


@cache
def build() -> typer.Typer:
    """Return the command-line application, which keeps nothing between two uses."""
    from .application import application

    return application()


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
    own_process()
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
