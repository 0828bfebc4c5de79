"""`scanrack doctor`: the installed and the missing parts of this installation."""

from __future__ import annotations

import typer
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.status import NO
from scanrack.terminal.terminal import say


def _doctor_command(as_json: JsonOption = False) -> None:
    """Check this installation: Python, extras, ports, real-time rights, browser, programs.

    Each line that is not "ok" states a remedy, or the benefit of the missing part. The command changes
    nothing, and sends nothing over a network.

    Exit status: 0 scanrack runs here, with or without optional parts; 1 something is broken.
    """
    from dataclasses import asdict

    from scanrack.jobs.start.doctor import Health, examined

    diagnoses = examined()
    if as_json:
        say_json([asdict(diagnosis) for diagnosis in diagnoses])
    else:
        width = max(len(diagnosis.name) for diagnosis in diagnoses)
        for finding in diagnoses:
            say(f"{finding.state.value:6}  {finding.name:{width}}  {finding.says}")
            if finding.remedy:
                say(f"{'':{width + 10}}{finding.remedy}")
    if any(diagnosis.state is Health.BROKEN for diagnosis in diagnoses):
        raise typer.Exit(NO)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("doctor")(_doctor_command)
