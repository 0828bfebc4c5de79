"""`scanrack new FOLDER`: create a rack, a program that homes and moves, and a test."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from scanrack.jobs.start import LOGICS, new_project
from scanrack.terminal.terminal import say

Language = StrEnum("Language", {logic.upper(): logic for logic in LOGICS})  # type: ignore[misc]  # from the folders


def _new_command(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="A new or empty folder.", show_default=False)
    ],
    logic: Annotated[
        Language, typer.Option("--logic", metavar="|".join(LOGICS), help="Language of the program.")
    ] = Language.PYTHON,  # type: ignore[attr-defined]
    example: Annotated[
        str | None,
        typer.Option("--from", metavar="EXAMPLE", help="Copy this example.", show_default=False),
    ] = None,
) -> None:
    """Create a project: a rack, a program that homes and moves, a test, and NEXT.md.

    It never overwrites a file.

    Examples:
        scanrack new my-line
        scanrack new my-feeder --from feeder

    Exit status: 0 done; 2 the folder is not empty, or the example does not exist; 3 the folder can't be
    written.
    """
    from scanrack.terminal.complaints import reported_mistakes  # imports libraries that help does not need

    with reported_mistakes():
        paths_written = new_project(folder, logic.value, example)
    for path in paths_written:
        say(str(path))
    say(f"\nSee it run:  scanrack watch {paths_written[0]} --open")


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("new", no_args_is_help=True)(_new_command)
