"""`scanrack check FILE`: finds mistakes in a rack and its program without running them."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from ...terminal.as_json import JsonOption, say_json
from ...terminal.status import BAD_INPUT, NO, complain
from ...terminal.terminal import say

if TYPE_CHECKING:  # its help imports no check
    from ...jobs.check import CheckReport


class ReportFormat(StrEnum):
    """Format of the report."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    JUNIT = "junit"


def _check_command(
    rack: Annotated[
        str, typer.Argument(metavar="FILE", help="Rack file, TOML or Python; or a ladder program or export.")
    ],
    as_json: JsonOption = False,
    form: Annotated[
        ReportFormat, typer.Option("--format", help="Of the report: text, json, sarif or junit.")
    ] = ReportFormat.TEXT,
) -> None:
    """Check a rack or program without running it: conditions, readers and writers, commands to axes.

    An L5X, SLC, .rung or .st file is also checked without a rack.

    Examples: scanrack new feeder --from feeder; scanrack check feeder/feeder.toml
    Example: scanrack check machine.L5X --format sarif > machine.sarif

    Exit status: 0 nothing found, 1 something found, 2 a file can't be used.
    """
    from ...jobs.check import check_rack, load_any, refused
    from ...jobs.prove.serving.judging import verdicts

    try:
        job, alone = load_any(rack)
        report = check_rack(job, alone=alone, prover=verdicts)
    except ValueError as error:
        if form is not ReportFormat.TEXT or as_json:
            _print(refused(error, rack), ReportFormat.JSON if as_json else form, rack)
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    _print(report, ReportFormat.JSON if as_json else form, rack)
    if report.findings:
        raise typer.Exit(NO)


def _print(report: CheckReport, form: ReportFormat, name: str) -> None:
    from importlib.metadata import version

    from ...jobs.check.formats import as_json as json_of
    from ...jobs.check.formats import as_junit, as_sarif

    if form is ReportFormat.JSON:
        say_json(json_of(report))
    elif form is ReportFormat.SARIF:
        say_json(as_sarif(report, version("scanrack")))
    elif form is ReportFormat.JUNIT:
        say(as_junit(report, name), whole=True)
    else:
        _say(report)


def _say(report: CheckReport) -> None:
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
