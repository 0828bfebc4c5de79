"""`scanrack drive TARGET`: one module on the bench, with requests and replies in JSON, in virtual time."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from typing import Annotated, TextIO

import typer
from scanrack.io_images.addresses import allowed
from scanrack.jobs.drive.requests import RequestError
from scanrack.jobs.drive.targets import BENCHES, Answer
from scanrack.terminal.status import BAD_INPUT, DONE, complain


def converse(answer: Answer, lines: Iterable[str], out: TextIO) -> int:
    """Answer each line with one line; return the exit status: 2 if any request was refused, else 0.

    Empty lines are skipped. A refused request changes nothing, and the session continues.
    """
    status = DONE
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            reply = answer(line)
        except RequestError as error:
            reply = {"error": str(error), "line": number}
            status = BAD_INPUT
        out.write(json.dumps(reply) + "\n")
        out.flush()
    return status


def drive(
    target: Annotated[
        str,
        typer.Argument(
            metavar="TARGET", help=f"What sits on the bench: {', '.join(BENCHES)}.", show_default=False
        ),
    ],
) -> None:
    """Exercise one module with JSON requests: one request per line in, one response per line out.

    Time is virtual and never waits; the same input gives the same output, byte for byte.
    A request is {"new": {...}} for a fresh bench, or {"out": [eight words], "for_ms": 100}; the error for
    an unknown key lists the allowed keys.

    Exit status: 0 done, 2 any request was refused.
    """
    if target not in BENCHES:
        raise typer.Exit(complain(f"no target {target!r}: {allowed(target, BENCHES)}", BAD_INPUT))
    if sys.stdin is None:
        raise typer.Exit(complain("no requests: standard input is closed", BAD_INPUT))
    raise typer.Exit(converse(BENCHES[target](), sys.stdin, sys.stdout))


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(no_args_is_help=True)(drive)
