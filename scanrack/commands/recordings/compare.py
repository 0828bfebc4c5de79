"""`scanrack compare A B`: find the first scan in which two traces differ, and all differences."""

from __future__ import annotations

import typer
from scanrack.terminal.grouped import grouped

from .comparison_options import CompareOptions


def _compare_command(options: CompareOptions) -> None:
    """Find where two traces differ: the first scan, the events before it, and a summary of all differences.

    Scans are paired by number, and every bit and time is compared. With a tolerance, as for traces of real
    hardware, they are paired by time: a bit or word must appear in the other trace within the time, and a
    position may differ by the counts plus its motion within the time.

    Examples:
        scanrack compare simulated.mcap machine.mcap --tolerance-time 4ms --tolerance-counts 2

    Exit status: 0 no difference, 1 a difference, 2 a file or option can't be used.
    """
    from .compare_job import compare_traces

    compare_traces(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("compare", no_args_is_help=True)(grouped(_compare_command, options=CompareOptions))
