"""The commands; the only place that knows all the rooms."""

from __future__ import annotations

import typer

from . import (
    compare,
    drive,
    export,
    fuzz,
    golden,
    ladder,
    pclt,
    plot,
    query,
    repair,
    replay,
    rerun,
    rules,
    run,
    serve,
    show,
    why,
)
from .benching import open_bench

__all__ = ["build", "main", "open_bench"]

COMMANDS = (
    run,
    show,
    query,
    plot,
    export,
    compare,
    repair,
    replay,
    rerun,
    golden,
    ladder,
    why,
    fuzz,
    drive,
    serve,
    pclt,
    rules,
)
"""The commands, in the order in which --help lists them."""


def build() -> typer.Typer:
    """Return the command-line application."""
    app = typer.Typer(
        name="scanrack",
        help="A PLC rack in software for stepper controllers.\n\n"
        "Run your logic scan by scan against a simulated AMCI 3601 bolted to a simulated machine; "
        "every scan is recorded.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    for command in COMMANDS:
        command.register(app)
    return app


def main() -> None:
    """Run the `scanrack` command."""
    build()()
