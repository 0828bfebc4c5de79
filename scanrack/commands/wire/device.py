"""`scanrack device`: list, identify, read, set and move devices; PCL601 and PMC006 each have a group."""

from __future__ import annotations

import typer

from . import discovery, pcl601, pmc006

app = typer.Typer(
    help="List, identify, read, set and move devices.\n\nExamples:\n    scanrack device list",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command("list")(discovery.list_command)
app.command("identify", no_args_is_help=True)(discovery.identify_command)
app.add_typer(pcl601.app, name="pcl601")
app.add_typer(pmc006.app, name="pmc006")


def register(application: typer.Typer) -> None:
    """Add the command to the application."""
    application.add_typer(app, name="device")
