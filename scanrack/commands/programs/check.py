"""`scanrack check FILE`: check a rack and its program without running them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.status import BAD_INPUT, NO, complain
from scanrack.terminal.terminal import say

if TYPE_CHECKING:  # its help imports no check
    from scanrack.jobs.check import CheckReport


class ReportFormat(StrEnum):
    """Format of the report."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    JUNIT = "junit"


def _check_command(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...",
            help="Rack file (TOML or Python), ladder program, export, or stored programs (.pclt).",
            show_default=False,
        ),
    ],
    as_json: JsonOption = False,
    drive: Annotated[
        str | None,
        typer.Option(
            "--for",
            metavar="DRIVE",
            help="List the changes for a networked drive, such as smd23e2, instead of a 3601.",
        ),
    ] = None,
    form: Annotated[
        ReportFormat,
        typer.Option(
            "--format",
            metavar="text|json|sarif|junit",
            help="Format of the report.",
        ),
    ] = ReportFormat.TEXT,
) -> None:
    """Check a rack or program without running it: conditions, readers and writers, commands to axes.

    An L5X, SLC, .rung or .st file is checked without a rack. For stored programs of the PCL601 (one or more
    files), it prints the memory size of each program.

    Examples:
        scanrack new feeder --from feeder
        scanrack check feeder/feeder.toml
        scanrack check machine.L5X --format sarif > machine.sarif

    Exit status: 0 nothing found, 1 something found, 2 a file can't be used.
    """
    from scanrack.jobs.check import CheckReport, refused

    form = ReportFormat.JSON if as_json else form
    rack = files[0]
    try:
        summaries = _stored_summaries(files) if any(map(_is_stored, files)) else None
        report = _check_files(files, drive) if summaries is None else CheckReport((), ())
    except ValueError as error:
        if form is not ReportFormat.TEXT:
            _print(refused(error, rack), form, rack)
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    if summaries is not None and form is ReportFormat.TEXT:
        for line in summaries:
            say(line)
        return
    _print(report, form, rack)
    if report.findings:
        raise typer.Exit(NO)


def _check_files(files: Sequence[str], drive: str | None) -> CheckReport:
    """Check one rack or program; with a drive, list the changes if it replaces the 3601s."""
    from scanrack.io_images.drives.models import MODELS
    from scanrack.jobs.check import check_rack, check_replacement, load_any
    from scanrack.jobs.prove.serving.judging import verdicts

    if len(files) > 1:
        raise ValueError(f"{files[1]}: give one rack or program; only .pclt files may be several")
    if drive is not None and drive not in MODELS:
        raise ValueError(f"--for {drive}: no such drive; choose from {', '.join(MODELS)}")
    job, alone = load_any(files[0])
    if drive is not None:
        return check_replacement(job, MODELS[drive], alone=alone)
    return check_rack(job, alone=alone, prover=verdicts)


def _is_stored(file: str) -> bool:
    return file.lower().endswith(".pclt")


def _stored_summaries(files: list[str]) -> list[str]:
    """Return a line for each stored program of the PCL601; raise ValueError if one can't be stored."""
    from scanrack.runtime.controllers.pcl601.program import read_program

    from ..wire.pclt import summary

    other_file = next((path for path in files if not _is_stored(path)), None)
    if other_file is not None:
        raise ValueError(f"{other_file}: not a .pclt file; check it separately")
    return [f"{path}: {summary(read_program(Path(path)))}" for path in files]


def _print(report: CheckReport, form: ReportFormat, name: str) -> None:
    """Print a report in a format; JUnit also shows the name of the file."""
    from scanrack.io_images.versions import distribution_version
    from scanrack.jobs.check.formats import as_json as json_of
    from scanrack.jobs.check.formats import as_junit, as_sarif

    if form is ReportFormat.JSON:
        say_json(json_of(report))
    elif form is ReportFormat.SARIF:
        say_json(as_sarif(report, distribution_version("scanrack")))
    elif form is ReportFormat.JUNIT:
        say(as_junit(report, name), whole=True)
    else:
        _say(report)


def _say(report: CheckReport) -> None:
    """Print the findings, their number, and the limits of the checks."""
    for finding in report.findings:
        say(str(finding))
    number = len(report.findings)
    ignored = f", {report.ignored} ignored" if report.ignored else ""
    say(f"{number or 'no'} finding{'' if number == 1 else 's'}{ignored}")
    for sentence in report.not_seen:
        say(f"not seen: {sentence}")


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("check", no_args_is_help=True)(_check_command)
