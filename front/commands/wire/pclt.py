"""`scanrack pclt`: stored programs of the PCL601, checked and listed."""

from __future__ import annotations

from itertools import accumulate
from pathlib import Path
from typing import Annotated

import typer

from ...io_images.pcl601.program import CAPACITY_BYTES, Program, format_step
from ...runtime.controllers.pcl601.program import read_program
from ...terminal.complaints import reported_mistakes
from ...terminal.terminal import say

app = typer.Typer(
    help="Check and list stored programs of the PCL601.",
    no_args_is_help=True,
)


def listing(program: Program) -> str:
    """Return a program line by line: address, size in bytes, instruction."""
    addresses = accumulate((step.size for step in program.steps), initial=0)
    return "\n".join(
        f"{address:5}  {step.size:2}  {format_step(step)}"
        for address, step in zip(addresses, program.steps, strict=False)
    )


def summary(program: Program) -> str:
    """Return the memory size of a program."""
    count = len(program.steps)
    return f"{count} instructions, {program.size} of {CAPACITY_BYTES} bytes"


@app.command("check", no_args_is_help=True)
def check_command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Programs.", show_default=False)],
) -> None:
    """Say whether programs can be stored, and what they take of the memory.

    Example: scanrack pclt check program.pclt

    Exit status: 0 they can; 2 one can't: the message names its line, column and what is allowed.
    """
    with reported_mistakes():
        for file in files:
            say(f"{file}: {summary(read_program(file))}")


@app.command("list", no_args_is_help=True)
def list_command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The program.", show_default=False)],
) -> None:
    """Print a program line by line: address and size in program memory, in bytes, and the instruction.

    Sizes are this simulator's: of the real unit's only "2 to 7 bytes" is published.

    Example: scanrack pclt list program.pclt
    """
    with reported_mistakes():
        say(listing(read_program(file)), whole=True)


def register(parent: typer.Typer) -> None:
    """Add the commands to the application."""
    parent.add_typer(app, name="pclt", rich_help_panel=None)
