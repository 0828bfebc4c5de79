"""`scanrack drive TARGET`: one module on the bench, JSON in, JSON out, in virtual time."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable
from enum import StrEnum
from typing import Annotated, Any, TextIO

import typer

from ..app.drive.adapter_bench import pcl601_adapter_bench, pmc006_adapter_bench
from ..app.drive.image_bench import ImageBench, amci3601_on_bench
from ..app.drive.pcl601_bench import pcl601_bench
from ..app.drive.pmc006_bench import pmc006_bench
from ..app.drive.requests import RequestError, parse
from .status import BAD_INPUT, DONE, complain


class Target(StrEnum):
    """What sits on the bench."""

    AMCI3601 = "amci3601"
    PCL601 = "pcl601"
    PCL601_ADAPTER = "pcl601-adapter"
    PMC006_ADAPTER = "pmc006-adapter"
    PMC006 = "pmc006"


Answer = Callable[[str], dict[str, Any]]


def bench_for(target: Target) -> Answer:
    """Return what answers the lines of a session with `target`."""
    return BENCHES[target]()


def _amci3601() -> Answer:
    bench = ImageBench(amci3601_on_bench)
    return lambda line: bench.answer(parse(line))


BENCHES: dict[Target, Callable[[], Answer]] = {
    Target.AMCI3601: _amci3601,
    Target.PCL601: lambda: pcl601_bench().answer,
    Target.PCL601_ADAPTER: lambda: pcl601_adapter_bench().answer_line,
    Target.PMC006_ADAPTER: lambda: pmc006_adapter_bench().answer_line,
    Target.PMC006: lambda: pmc006_bench().answer,
}
"""What makes the bench of a target."""


def converse(answer: Answer, lines: Iterable[str], out: TextIO) -> int:
    """Answer each line with one line; return the exit status: 2 if any request was refused, else 0.

    Empty lines are passed over. A refused request changes nothing, and the session goes on.
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
    target: Annotated[Target, typer.Argument(help="What sits on the bench.", show_default=False)],
) -> None:
    """Put one module on the bench: one JSON request per line in, one JSON reply per line out.

    Time is virtual and never waits; the same input gives the same output, byte for byte.
    Exit status 2 if any request was refused. The protocol is described in docs/drive.md.
    """
    if sys.stdin is None:
        raise typer.Exit(complain("there are no requests: standard input is closed", BAD_INPUT))
    raise typer.Exit(converse(bench_for(target), sys.stdin, sys.stdout))


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(no_args_is_help=True)(drive)
