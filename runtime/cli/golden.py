"""`scanrack golden [FOLDER]`: make the recordings of a library anew and show what has changed."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track

from .library import INDEX, TEXT, Library, Made, changes, index_of, left_over, load_library, make
from .slices import told_mistakes
from .status import DONE, NO
from .terminal import say


def _golden_command(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="The library: scenarios.toml and what is made of it.")
    ] = Path("traces/golden"),
    update: Annotated[
        bool, typer.Option("--update", help="Write what has changed as what is expected.")
    ] = False,
) -> None:
    """Make the recordings of a library of scenarios anew, and show what has changed.

    Each scenario of FOLDER/scenarios.toml is run, held against what it says of rules, bits and position,
    and compared with its recording, scan by scan. With --update the recordings and texts that differ are
    written, and the index; one that is not as its scenario says never is.

    Exit status: 0 all is as it was, 1 something has changed, 2 the scenarios can't be used.
    """
    with told_mistakes(), tempfile.TemporaryDirectory() as scratch:
        library = load_library(folder)
        console = Console(stderr=True)
        scenarios = track(
            library.scenario, "scenarios", console=console, transient=True, disable=not console.is_terminal
        )
        all_made = [make(library, scenario, Path(scratch)) for scenario in scenarios]
        lines = [line for made in all_made for line in (*_faults(made), *changes(made, folder))]
        lines += [f"{path.name}: no scenario makes it" for path in left_over(library, folder)]
        if _index_differs(library, folder):
            lines.append(f"{INDEX}: it differs")
        for line in lines:
            say(line)
        if update:
            _write(library, all_made, folder)
        faulty = any(made.wrong for made in all_made)
        say(f"{len(all_made)} recordings, {'as they were' if not lines else 'not all as they were'}")
    raise typer.Exit(NO if faulty or (lines and not update) else DONE)


def _faults(made: Made) -> list[str]:
    return [f"{made.scenario.name}: {wrong}" for wrong in made.wrong]


def _index_differs(library: Library, folder: Path) -> bool:
    path = folder / INDEX
    return not path.exists() or path.read_text("utf-8") != index_of(library)


def _write(library: Library, all_made: list[Made], folder: Path) -> None:
    """Write what has changed and is as its scenario says, and remove what no scenario makes."""
    for made in all_made:
        if not made.wrong and changes(made, folder):
            _put(folder / made.trace.name, made.trace.read_bytes())
            _put(folder / f"{made.scenario.name}{TEXT}", made.text.encode("utf-8"))
    for path in left_over(library, folder):
        path.unlink()
    _put(folder / INDEX, index_of(library).encode("utf-8"))


def _put(path: Path, data: bytes) -> None:
    """Write a file anew; a symbolic link that stands there is replaced, not followed."""
    path.unlink(missing_ok=True)
    with path.open("xb") as file:
        file.write(data)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("golden")(_golden_command)
