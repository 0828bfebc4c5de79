"""`scanrack why RACK|TRACE [WHAT]` and `scanrack xref FILE [TAG]`: questions about a program."""

from __future__ import annotations

from typing import Annotated

import typer
from scanrack.terminal.as_json import JsonOption
from scanrack.terminal.grouped import grouped

from .why_arguments import WhyArguments
from .why_command import why_command


def _why_command(options: WhyArguments) -> None:
    """Explain why a tag has its value (since when, how, and the cause) in at most six lines.

    A cause outside the program comes first: a force, the mode switch, a fault or a lost link. For a value
    that never changed, the answer names the missing conditions. The last line is the cause: an input, an
    operator, an injected fault, a running timer or a rule of the module. --deep shows the whole chain: in `A
    <- B`, B caused A; with `and`, all causes were needed; with `or`, each was sufficient.

    A rack runs from power-up to that scan, or for the time in its file. The program of a trace runs on the
    recorded inputs. Python that came with the trace runs only if it is the same as in the current folder, or
    with --trust. A Python program runs once more, to trace the scan of the change line by line.

    Examples:
        scanrack new feeder --from feeder
        scanrack why feeder/feeder.toml Feeding --at "8.2 s"
        scanrack why feeder/feeder.toml Feeding --at "8.2 s" --want on
        scanrack new stations --from three_stations
        scanrack why stations/line.toml --at 3400

    Exit status: 0 answered, 1 the bit of --until has not come on, 2 a file or an option can't be used.
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

    Examples:
        scanrack new feeder --from feeder
        scanrack xref feeder/feeder.rung Homing

    Exit status: 0 listed, 1 nothing mentions the tag, 2 the file can't be used or has no such tag.
    """
    from .why_job import xref

    xref(file, tag, as_json)


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command("why", no_args_is_help=True)(grouped(_why_command, options=WhyArguments))
    app.command("xref", no_args_is_help=True)(_xref_command)
