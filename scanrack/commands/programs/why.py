"""`scanrack why RACK|TRACE [WHAT]` and `scanrack xref FILE [TAG]`: questions about a program."""

from __future__ import annotations

from typing import Annotated

import typer
from scanrack.terminal.as_json import JsonOption
from scanrack.terminal.grouped import grouped

from .why_arguments import WhyArguments
from .why_command import why_command


def _why_command(options: WhyArguments) -> None:
    """Explain why a tag has its value: since when, how, and the cause, in at most six lines.

    A cause outside of the program comes first: a force, the mode switch, a fault, a lost link. For a value
    that never changed, the answer names the missing conditions. The last line is the cause: an input, an
    operator, an injected fault, a timer that still runs, a rule of the module. --deep shows all: `A <- B`
    means that B made A, `and` that all were needed, `or` that each would have done.

    A rack runs from power-up to that scan, or for as long as its file says. The program of a
    trace runs on the recorded inputs; Python that came with the trace is run only if it is the same as in
    the current folder, or you say --trust. A Python program then runs once more, and the scan in which the
    change was made is traced line by line.

    Examples: scanrack new feeder --from feeder; scanrack why feeder/feeder.toml Feeding --at "8.2 s";
    scanrack why feeder/feeder.toml Feeding --at "8.2 s" --want on;
    scanrack new stations --from three_stations; scanrack why stations/line.toml --at 3400

    Exit status: 0 answered, 1 --until has not become true, 2 a file or an option can't be used.
    """
    why_command(options)


def _xref_command(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A .rung or .st file, a Python program, or a rack file.")
    ],
    tag: Annotated[
        str | None, typer.Argument(metavar="[TAG]", help="Only this tag, and the tags that contain it.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """List where tags are read and written.

    Examples: scanrack new feeder --from feeder; scanrack xref feeder/feeder.rung Homing

    Exit status: 0 listed, 1 nothing mentions the tag, 2 the file can't be used or has no such tag.
    """
    from .why_job import xref

    xref(file, tag, as_json)


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command("why", no_args_is_help=True)(grouped(_why_command, options=WhyArguments))
    app.command("xref", no_args_is_help=True)(_xref_command)
