"""The commands; the only package that imports all the others.

`application` reads words by typer. Plain words of `run` and `why`, which people wait for, need no typer.
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
    """Return the command-line application, which keeps nothing between two uses."""
    from .application import application

    return application()


def main() -> None:
    """Run the `scanrack` command; print at most one message at its end.

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


PLAIN = {"run": ".programs.run_command:plain_run", "why": ".programs.why_command:plain_why"}
"""Functions that carry out the plain words of a command without typer, for a fast start."""


def _run() -> None:
    """Run the command; report an error of a file that no command handles."""
    try:
        command, completing = sys.argv[1:2], any(name.endswith("_COMPLETE") for name in os.environ)
        if not command or command[0] not in PLAIN or completing or not _run_plainly(*sys.argv[1:]):
            build()()
    except OSError as error:
        sys.exit(complain(reason(error), BAD_INPUT))


def _run_plainly(command: str, *words: str) -> bool:
    """Run a command; return False if its words are not plain.

    Raises:
        SystemExit: it has ended.
    """
    module, _, name = PLAIN[command].partition(":")
    plain: Callable[[Sequence[str]], bool] = getattr(import_module(module, __package__), name)
    with interrupted():
        return plain(words)
