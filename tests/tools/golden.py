"""Make the golden recordings anew and show what has changed.

python tests/tools/golden.py [FOLDER] [--update]
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated

import typer
from golden_library import INDEX, TEXT, Library, Made, changes, index_of, left_over, load_library, make
from rich.console import Console
from rich.progress import track
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.status import DONE, NO
from scanrack.terminal.terminal import say

app = typer.Typer(add_completion=False, rich_markup_mode=None)


@app.command()
def golden_command(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="The library: scenarios.toml and what is made of it.")
    ] = Path("tests/golden/recordings"),
    update: Annotated[
        bool, typer.Option("--update", help="Write what has changed as what is expected.")
    ] = False,
) -> None:
    """Make the recordings of a library of scenarios anew, and show what has changed.

    Run each scenario of FOLDER/scenarios.toml, check the rules, bits and position that it states, and
    compare the run with its recording, scan by scan. --update writes the recordings and texts that differ,
    and the index, but never a run that is not as its scenario states.

    Exit status: 0 nothing has changed, 1 something has changed, 2 the scenarios can't be used.
    """
    with reported_mistakes(), tempfile.TemporaryDirectory() as scratch:
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


if __name__ == "__main__":
    app()
