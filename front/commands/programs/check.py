"""`scanrack check RACK`: finds mistakes in a rack without running it."""

from __future__ import annotations

from typing import Annotated

import typer

from ...jobs.check import CheckReport, check_rack
from ...jobs.load.loading import load_job
from ...ladder import LadderError
from ...terminal.as_json import JsonOption, say_json
from ...terminal.status import BAD_INPUT, NO, complain
from ...terminal.terminal import say


def _as_json(report: CheckReport) -> dict[str, object]:
    findings = [
        {"rule": each.rule, "file": each.place.file, "line": each.place.line, "text": each.text}
        for each in report.findings
    ]
    return {"findings": findings, "not_seen": report.not_seen}


def _check_command(
    rack: Annotated[str, typer.Argument(metavar="RACK", help="Rack file, TOML or Python.")],
    as_json: JsonOption = False,
) -> None:
    """Check a rack without running it: wiring, tags, coils, command bits, ranges.

    Example: scanrack check examples/feeder/feeder.toml

    Exit status: 0 nothing found, 1 something found, 2 a file can't be used.
    """
    try:
        report = check_rack(load_job(rack))
    except (LadderError, ValueError) as error:
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    if as_json:
        say_json(_as_json(report))
    else:
        for finding in report.findings:
            say(str(finding))
        number = len(report.findings)
        say(f"{number or 'no'} finding{'' if number == 1 else 's'}")
        for sentence in report.not_seen:
            say(f"not seen: {sentence}")
    if report.findings:
        raise typer.Exit(NO)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("check", no_args_is_help=True)(_check_command)
