"""`scanrack ladder`: draw the rungs of a program as a picture or text, or print the Python that runs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from scanrack.io_images.times import parse_time
from scanrack.jobs.bench import Bench
from scanrack.jobs.bench.opening import open_bench
from scanrack.jobs.load.loading import load_job
from scanrack.jobs.load.program import load_program
from scanrack.jobs.trust.owned import in_use
from scanrack.ladder import LadderError, LadderLogic
from scanrack.ladder.draw import captions_of, routine_text, routines_svg
from scanrack.ladder.draw.characters import WIDTH
from scanrack.ladder.model.routine import Routine
from scanrack.terminal.status import BAD_INPUT, CANNOT_WRITE, complain, reason
from scanrack.terminal.terminal import say
from scanrack.traces.files.guard import SVG, Used
from scanrack.traces.files.newfile import new_file

NARROWEST = 40
"""Minimum number of columns between the rails of a picture."""


def load_rungs(file: str) -> LadderLogic:
    """Load the ladder program of a `.rung`, `.st` or Python file, or of a rack.

    Raises:
        ValueError: the file can't be used, or its program has no rungs.
    """
    return rungs_and_files(file)[0]


def rungs_and_files(file: str) -> tuple[LadderLogic, Used]:
    """Return the program that `load_rungs` loads, and the files that it uses."""
    if file.endswith(".toml"):
        job = load_job(file)
        logic, files_in_use = job.logic, in_use(job)
    else:
        program = load_program(file)
        logic, files_in_use = program.function, {program.path: "the program"}
    if not isinstance(logic, LadderLogic):
        raise ValueError(f"{file}: the program is a Python function, which has no rungs")
    return logic, files_in_use


def selected_routines(program: LadderLogic, name: str | None) -> list[Routine]:
    """Return the routine with a name, or all routines if the name is None.

    Raises:
        ValueError: the name is unknown; the message lists all names.
    """
    if name is None:
        return list(program.routines)
    routines = [routine for routine in program.routines if routine.name.upper() == name.upper()]
    if not routines:
        names = ", ".join(routine.name for routine in program.routines)
        raise ValueError(f"no routine {name} in program {program.name}; choose from {names}")
    return routines


def with_rung(routines: Sequence[Routine], number: int | None) -> list[tuple[Routine, list[int]]]:
    """Return routines with the numbers of their selected rungs or lines.

    Raises:
        ValueError: no routine has a rung with that number.
    """
    if number is None:
        return [(routine, list(routine.numbers)) for routine in routines]
    selected = [(routine, [number]) for routine in routines if number in routine.numbers]
    if not selected:
        numbers = [rung_number for routine in routines for rung_number in routine.numbers]
        first, last = min(numbers, default=0), max(numbers, default=0)
        raise ValueError(f"no {routines[0].unit} {number}; they are numbered from {first} to {last}")
    return selected


Truths = dict[str, list[tuple[bool, ...] | None]]
"""The power flow in each rung of a routine, by routine name; None for a rung that did not run."""


def _routines_at(file: str, time: str, routines: Sequence[Routine]) -> tuple[list[Routine], Truths]:
    """Run a rack to a time; return the routines with their values, and the power flow in their rungs."""
    program = bench_at(file, time).program
    truths = {routine.name: program.truth(routine.name) for routine in routines}
    return [program.routine_now(routine.name) for routine in routines], truths


def bench_at(file: str, time: str) -> Bench:
    """Run a rack to a time; raise ValueError if it is not a rack with rungs or the time is invalid."""
    if not file.endswith((".toml", ".py")):
        raise ValueError(f"{file}: --at needs a rack file")
    bench = open_bench(file, watched=True)
    bench.scan(parse_time(time) // bench.cpu.period_ns + 1)
    return bench


def ladder(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A .rung or .st file, a Python program, or a rack file.")
    ],
    routine: Annotated[
        str | None, typer.Option("--routine", metavar="NAME", help="Only this routine.")
    ] = None,
    rung: Annotated[int | None, typer.Option("--rung", metavar="N", help="Only this rung or line.")] = None,
    width: Annotated[
        int | None,
        typer.Option(
            "--width",
            metavar="N",
            min=NARROWEST,
            help="Columns between the rails; wider rungs continue below.",
        ),
    ] = None,
    svg: Annotated[
        Path | None, typer.Option("--svg", metavar="OUT", help="Write an SVG picture instead.")
    ] = None,
    text: Annotated[bool, typer.Option("--text", help="Print the rung text instead.")] = False,
    source: Annotated[
        bool, typer.Option("--source", help="Print the Python that runs for the program.")
    ] = False,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="TIME", help="Run a rack to this time, and show the power flow."),
    ] = None,
) -> None:
    """Draw rungs; with --at, show the power flow in a scan.

    Examples:
        scanrack new feeder --from feeder
        scanrack ladder feeder/feeder.toml --at "3 s" --svg feeder.svg

    Exit status: 0 drawn, 2 a file or an option can't be used, 3 the picture can't be written.
    """
    try:
        program, files_in_use = rungs_and_files(file)
        routines = selected_routines(program, routine)
        truths: Truths = {}
        if at is not None:
            routines, truths = _routines_at(file, at, routines)
        captions = captions_of(program)
        numbered = with_rung(routines, rung)
        if svg is not None:
            with new_file(svg, SVG, used=files_in_use) as out:
                out.write(routines_svg(numbered, width or WIDTH, truths, captions))
        elif source:
            say(program.source(), whole=True)
        elif text:
            for shown, numbers in numbered:
                say(shown.text if rung is None else "\n".join(map(shown.numbered, numbers)), whole=True)
        else:
            columns = width or max(shutil.get_terminal_size((WIDTH + 8, 0)).columns - 8, NARROWEST)
            for shown, numbers in numbered:
                say(f"Routine {shown.name}\n")
                say(routine_text(shown, columns, truths.get(shown.name), numbers, captions), whole=True)
    except LadderError as error:
        raise typer.Exit(complain(f"{file}: {error}", BAD_INPUT)) from error
    except OSError as error:
        raise typer.Exit(complain(reason(error), BAD_INPUT if svg is None else CANNOT_WRITE)) from error
    except ValueError as error:
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command()(ladder)
