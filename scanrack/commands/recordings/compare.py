"""`scanrack compare A B`: the first scan in which two traces differ, and how they differ altogether."""

from __future__ import annotations

import typer
from scanrack.terminal.grouped import grouped

from .comparison_options import CompareOptions


def _compare_command(options: CompareOptions) -> None:
    """Find where two traces differ: the first scan, the events before it, and a summary of all differences.

    Scans are paired by number, and every bit and time counts. With a tolerance, as for traces of real
    hardware, they are paired by time: a bit or word has to be found in the other trace within the time,
    a position may be off by the counts beside what it moves within the time.

    Exit status: 0 they show the same, 1 they differ, 2 a file or option can't be used.

    Example: scanrack compare simulated.mcap machine.mcap --tolerance-time 4ms --tolerance-counts 2
    """
    from .compare_job import compare_traces

    compare_traces(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("compare", no_args_is_help=True)(grouped(_compare_command, options=CompareOptions))
