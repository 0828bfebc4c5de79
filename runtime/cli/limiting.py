"""The options before the command: how much work a trace may ask for, in every command that reads one."""

from __future__ import annotations

from typing import Annotated

import typer

from ...traces.limits import CHUNK_BYTES, RECORDS, Limits, limited

MIB = 1024 * 1024


def limit_traces(
    context: typer.Context,
    max_chunk: Annotated[
        int,
        typer.Option("--max-chunk", min=1, metavar="MIB", help="Most that a chunk of a trace unpacks to."),
    ] = CHUNK_BYTES // MIB,
    max_records: Annotated[
        int, typer.Option("--max-records", min=1, help="Most records in a chunk that are nearly empty.")
    ] = RECORDS,
) -> None:
    """Put the limits for reading traces in force until the command ends."""
    context.with_resource(limited(Limits(max_chunk * MIB, max_records)))
