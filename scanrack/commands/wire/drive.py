"""`scanrack drive TARGET`: send JSON requests to a module, in virtual time."""

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


def respond_to_lines(respond: Answer, lines: Iterable[str], output: TextIO) -> int:
    """Write a response to each request; return exit status 2 if a request was refused, otherwise 0.

    Empty lines are skipped. A refused request changes nothing, and the session continues.
    """
    status = DONE
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            reply = respond(line)
        except RequestError as error:
            reply = {"error": str(error), "line": number}
            status = BAD_INPUT
        output.write(json.dumps(reply) + "\n")
        output.flush()
    return status


def drive(
    target: Annotated[
        str,
        typer.Argument(metavar="TARGET", help=f"Module: {', '.join(BENCHES)}.", show_default=False),
    ],
) -> None:
    """Exercise one module with JSON requests, one request per line in and one response per line out.

    Time is virtual; the same input produces the same output, byte for byte. A request is {"new": {...}} for a
    new module, or {"out": [eight words], "for_ms": 100}. The error message for an unknown key lists the
    allowed keys.

    Examples:
        scanrack drive amci3601 < requests.jsonl > responses.jsonl

    Exit status: 0 done, 2 a request was refused.
    """
    if target not in BENCHES:
        raise typer.Exit(complain(f"no target {target!r}: {allowed(target, BENCHES)}", BAD_INPUT))
    if sys.stdin is None:
        raise typer.Exit(complain("no requests: standard input is closed", BAD_INPUT))
    raise typer.Exit(respond_to_lines(BENCHES[target](), sys.stdin, sys.stdout))


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(no_args_is_help=True)(drive)
