"""`scanrack l5x`: report the contents of an exported controller and the parts that run.

The export is an L5X from Studio 5000, or text from RSLogix 500 (`SOR ... EOR`) with any suffix except L5X.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from scanrack.terminal.grouped import grouped

from .l5x_options import L5xOptions


def _l5x_command(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="An L5X or SLC export, or a folder of them.", show_default=False),
    ],
    options: L5xOptions,
) -> None:
    """Report what an L5X or SLC export supports: its imported, refused and running parts, with reasons.

    A trial runs the imported rungs both interpreted and compiled; "ran" counts the rungs of programs for
    which both runs agree after every scan.

    With --run, the export also runs on a rack, where parts that are not simulated are only memory. The report
    then lists the conditions for which the program waits, the unchanged inputs, and the modules.

    For a folder, it prints totals: rungs, whole controllers, and reasons for refusals without tag names.

    Examples:
        scanrack l5x machine.L5X
        scanrack l5x exports --json
        scanrack l5x machine.L5X --run
        scanrack l5x machine.L5X --print-rack > machine.toml
        scanrack l5x machine.L5X --print-rack --stepper Feed > machine.toml
        scanrack l5x machine.L5X --against before.L5X
        scanrack l5x machine.L5X --against before.L5X --html review.html
        scanrack l5x machine.L5X --text
        scanrack l5x line.rung --export Main.Sequence > sequence.L5X
        scanrack l5x machine.L5X --out copy.L5X

    Exit status: 0 all is imported, or no difference; 1 a part is refused, or a difference; 2 a file can't be
    used; 3 a file can't be written.
    """
    from .l5x_job import l5x

    l5x(file, options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("l5x", no_args_is_help=True)(grouped(_l5x_command, options=L5xOptions))
