"""`scanrack query TRACE QUERY`: find the scans in which a condition was true, and for how long."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer
from rich.table import Table
from scanrack.io_images.times import seconds_column, time_text
from scanrack.terminal.as_json import JsonOption, say_json
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import print_notes, reading
from scanrack.terminal.shared_options import QuietOption, TraceArgument
from scanrack.terminal.status import DONE, NO
from scanrack.terminal.terminal import say
from scanrack.traces.query import Answer, Occurrence, query
from scanrack.traces.read.reader import open_trace

from .show import new_table, print_block


def print_answer(answer: Answer, limit: int | None) -> None:
    """Print a count, or a table of at most `limit` occurrences and their total number."""
    if answer.aggregate == "count":
        say(answer.count)
        return
    occurrences = answer.occurrences[:limit]
    if occurrences:
        print_block(_table(occurrences))
    further = len(answer.occurrences) - len(occurrences)
    if further:
        say(f"... and {further:,} more")
    if answer.aggregate is not None:
        say(f"of {answer.count:,}")
    elif answer.count != 1:
        say(f"{answer.count:,} times" if answer.count else "never")


def _as_json(answer: Answer, limit: int | None) -> dict[str, object]:
    occurrences = [
        {**asdict(occurrence), "duration_ns": occurrence.duration_ns}
        for occurrence in answer.occurrences[:limit]
    ]
    return {"aggregate": answer.aggregate, "count": answer.count, "occurrences": occurrences}


def _table(occurrences: tuple[Occurrence, ...]) -> Table:
    """Return the occurrences as a table, with the values of the shown signals on the right."""
    result = new_table(
        "scan>", "to scan>", "time s>", "lasted", *(f"{name}>" for name in occurrences[0].shown)
    )
    for occurrence in occurrences:
        values = [_text(value) for value in occurrence.shown.values()]
        lasted = time_text(occurrence.duration_ns) + (" or more" if occurrence.open else "")
        result.add_row(
            str(occurrence.first), str(occurrence.last), seconds_column(occurrence.start_ns), lasted, *values
        )
    return result


def _text(value: float | bool | None) -> str:
    """Return a value as text: "-" for None, 0 or 1 for a bit, numbers with separated thousands."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, int) or value.is_integer():
        return f"{int(value):,}"
    return f"{value:,.1f}"


def _query_command(  # its help is below
    trace: TraceArgument,
    text: Annotated[
        str,
        typer.Argument(metavar="QUERY", help="Condition, such as slot1.in.MOVING_CW.", show_default=False),
    ],
    show: Annotated[
        list[str] | None,
        typer.Option("--show", metavar="SIGNAL", help="Also print this signal per match; may be repeated."),
    ] = None,
    limit: Annotated[
        int | None, typer.Option("--limit", metavar="N", min=0, help="Maximum rows.", show_default="all")
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Find scans matching a condition, and how long each match lasts.

    Names of signals are slot1.in.COMMAND_ERROR, slot1.in.position, slot1.out.target, slot1.speed, and for any
    bit of a word slot1.in.word3.12.

    Examples:
        scanrack query run.mcap "rose(slot1.in.COMMAND_ERROR)"
        scanrack query run.mcap "longest(rose(slot1.out.ABSOLUTE_MOVE) then slot1.in.MOVING_CW)"
        scanrack query run.mcap "slot1.in.position > 4_000 and slot1.in.STOPPED for 20 ms"

    Exit status: 0 found, 1 nothing found, 2 the query or the file can't be used.
    """
    with reported_mistakes():
        with open_trace(trace) as opened, reading(opened, quiet=quiet) as progress:
            answer = query(opened, text, show=show or (), progress=progress)
        if as_json:
            say_json(_as_json(answer, limit))
        else:
            print_answer(answer, limit)
        print_notes(opened)
    raise typer.Exit(DONE if answer.count else NO)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("query", no_args_is_help=True)(_query_command)
