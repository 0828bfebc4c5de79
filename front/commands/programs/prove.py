"""`scanrack prove RACK`: claims about a ladder program, for every input, or the scenario that breaks them."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from ...jobs.prove.proving import Result, no_progress, prove_all
from ...jobs.prove.report import as_json as json_of
from ...jobs.prove.report import assumptions, below, line_of
from ...jobs.prove.subject import Subject, subject_of
from ...ladder.prove.induction import Kind
from ...ladder.prove.solving.solver import SolverMissingError
from ...terminal.as_json import JsonOption, say_json
from ...terminal.complaints import reported_mistakes
from ...terminal.status import BAD_INPUT, DONE, NO, complain
from ...terminal.terminal import say

UNDECIDED = 3
"""Exit status: nothing is refuted, and something is unknown."""


def _prove_command(
    rack: Annotated[
        str, typer.Argument(metavar="RACK", help="Rack file, TOML or Python; or a ladder program or export.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FOLDER", help="Where scenarios go.", show_default="RACK-prove"),
    ] = None,
    as_json: JsonOption = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Prove properties of a ladder program for every input, any scan time in a range and any number of scans.

    Properties are those of the rack file ([[prove.property]]), of comments (prove: never Fwd AND Rev) and of
    a routine NEVER. Each is proved, refuted with a scenario that the program and the rack have replayed, or
    unknown, with the instruction or the limit to blame. What the proofs assume is listed below them.

    Example: scanrack prove examples/feeder/feeder.toml

    Exit status: 0 all proved, 1 one is refuted, 2 a file can't be used, 3 none is refuted and one unknown.
    """
    with reported_mistakes(), ExitStack() as held:
        try:
            subject = subject_of(rack)
            folder = out or Path(f"{subject.name}-prove")
            results = list(_told(subject, folder, held, quiet=quiet, silent=as_json))
        except SolverMissingError as error:
            raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    if as_json:
        say_json(json_of(subject, results))
    else:
        _say_assumptions(subject, results)
    raise typer.Exit(status_of(results))


def _told(subject: Subject, folder: Path, held: ExitStack, *, quiet: bool, silent: bool) -> Iterator[Result]:
    """Decide all claims; print each as soon as it is decided, unless `silent`."""
    width = max((len(each.claim.name) for each in subject.program.properties), default=0)
    shown = not quiet and sys.stderr.isatty()
    for result in prove_all(subject, folder, held, _progress if shown else no_progress):
        if not silent:
            say(line_of(result, width))
            for line in below(result):
                say(f"    {line}")
        yield result


def _progress(name: str, number: int, of: int) -> None:
    say(f"proving {number} of {of}: {name}", err=True)


def _say_assumptions(subject: Subject, results: Sequence[Result]) -> None:
    if not results:
        say("nothing to prove: a rack file has [[prove.property]], a rung's comment prove: never CONDITION")
        return
    say("assumed:")
    for each in assumptions(subject, results):
        say(f"    {each}")


def status_of(results: Sequence[Result]) -> int:
    """Return the exit status of some answers."""
    words = {each.answer.word for each in results}
    if Kind.REFUTED in words:
        return NO
    return UNDECIDED if Kind.UNKNOWN in words else DONE


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("prove", no_args_is_help=True)(_prove_command)
