"""The commands; this is the only package that imports all the others.

`application` parses the command line with typer. For a fast start, simple command lines of `run` and `why`
are parsed without typer.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
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
    """Build and return the command-line application; it has no state."""
    from .application import application

    return application()


def main() -> None:
    """Run the `scanrack` command; print at most one message when it ends.

    Raises:
        SystemExit: always, with a status from `terminal.status`.
    """
    try:
        _main()
    except SystemExit as end:
        end_in_time(end.code)
        raise


def _main() -> None:
    """Run the command; if its output can't be written, end with that status and at most one message."""
    own_process()
    closed_streams_plugged()
    try:
        with guarded_output():
            _run()
    except LostOutput as lost:
        if lost.status != PIPE_CLOSED:
            with suppress(OSError):  # standard error may also be full
                complain(f"standard output can't be written: {lost.error.strerror}")
        sys.exit(lost.status)


PLAIN = {"run": ".programs.run_command:plain_run", "why": ".programs.why_command:plain_why"}
"""Functions that run simple command lines without typer."""


def _run() -> None:
    """Run the command; report a file error that the command does not handle."""
    try:
        words, is_completion = sys.argv[1:], any(name.endswith("_COMPLETE") for name in os.environ)
        may_be_plain = bool(words) and words[0] in PLAIN and not is_completion
        if not may_be_plain or not _run_plainly(*words):
            build()()
    except OSError as error:
        sys.exit(complain(reason(error), BAD_INPUT))


def _run_plainly(command: str, *words: str) -> bool:
    """Run a command without typer; return False if only typer can parse its words.

    Raises:
        SystemExit: the command has ended.
    """
    module, _, name = PLAIN[command].partition(":")
    plain: Callable[[Sequence[str]], bool] = getattr(import_module(module, __package__), name)
    with interrupted():
        return plain(words)
