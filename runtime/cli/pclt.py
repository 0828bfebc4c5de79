"""`scanrack pclt`: stored programs of the PCL601, checked, assembled and disassembled."""

from __future__ import annotations

from itertools import accumulate
from pathlib import Path
from typing import Annotated

import typer

from ...io_images.pcl601.program import (
    CAPACITY_BYTES,
    Program,
    ProgramError,
    assemble,
    disassemble,
    format_program,
    format_step,
    parse_program,
)
from .slices import told_mistakes
from .terminal import say

app = typer.Typer(
    help="Stored programs of the PCL601: check, assemble, disassemble; see docs/pcl601-programs.md.",
    no_args_is_help=True,
)

FileArgument = Annotated[Path, typer.Argument(metavar="FILE", help="The program.", show_default=False)]
OutputOption = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="OUT", help="Write there.", show_default=False)
]


def read_program(file: Path) -> Program:
    """Read a program in the text format.

    Raises:
        ValueError: it is none, or can't be read; the message names file, line and column.
    """
    try:
        return parse_program(file.read_text(encoding="utf-8"))
    except ProgramError as error:
        raise ValueError(f"{file}: {error}") from error
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"{file}: it is no text: byte {error.start} is not UTF-8") from error


def listing(program: Program) -> str:
    """Return a program line by line: address, bytes, instruction."""
    memory = assemble(program)
    ends = list(accumulate(step.size for step in program.steps))
    starts = [0, *ends]
    return "\n".join(
        f"{start:5}  {memory[start:end].hex(' '):<23}  {format_step(step)}"
        for start, end, step in zip(starts, ends, program.steps, strict=False)
    )


def summary(program: Program) -> str:
    """Return what a program takes of the memory."""
    count = len(program.steps)
    return f"{count} instructions, {program.size} of {CAPACITY_BYTES} bytes"


@app.command("check", no_args_is_help=True)
def check_command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Programs.", show_default=False)],
) -> None:
    """Say whether programs can be stored, and what they take of the memory.

    Example: scanrack pclt check examples/pcl601/sample1.pclt

    Exit status: 0 they can; 2 one can't: the message names its line, column and what is allowed.
    """
    with told_mistakes():
        for file in files:
            say(f"{file}: {summary(read_program(file))}")


@app.command("assemble", no_args_is_help=True)
def assemble_command(file: FileArgument, output: OutputOption = None) -> None:
    """Print a program as it stands in memory, or write its bytes.

    The bytes are this simulator's own: the real unit's are not published.

    Example: scanrack pclt assemble examples/pcl601/sample1.pclt -o sample1.bin
    """
    with told_mistakes():
        program = read_program(file)
        if output is None:
            say(listing(program))
        else:
            output.write_bytes(assemble(program))
            say(f"{output}: {summary(program)}")


@app.command("disassemble", no_args_is_help=True)
def disassemble_command(file: FileArgument, output: OutputOption = None) -> None:
    """Print the program in a file of bytes as text; labels are called L1, L2, ...

    Example: scanrack pclt disassemble sample1.bin
    """
    with told_mistakes():
        try:
            text = format_program(disassemble(file.read_bytes()))
        except ProgramError as error:
            raise ValueError(f"{file}: {error}") from error
        if output is None:
            say(text, nl=False)
        else:
            output.write_text(text, encoding="utf-8")


def register(parent: typer.Typer) -> None:
    """Add the commands to the application."""
    parent.add_typer(app, name="pclt", rich_help_panel=None)
