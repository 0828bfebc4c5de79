"""`scanrack editor`: support for editors."""

from __future__ import annotations

import typer
from scanrack.lsp.command import lsp_command

from .schema import schema_command

app = typer.Typer(
    help="Connect an editor.\n\nExamples:\n    scanrack editor schema --write",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command("schema")(schema_command)
app.command("lsp")(lsp_command)


def register(application: typer.Typer) -> None:
    """Add the command to the application."""
    application.add_typer(app, name="editor")
