"""The options before the command: the version, and the limits for reading traces."""

from __future__ import annotations

from typing import Annotated

import typer
from scanrack.traces.format.limits import CHUNK_BYTES, RECORDS, Limits, limited

from .terminal import say

MIB = 1024 * 1024


def print_version(is_given: bool) -> None:
    """Print the version and end the command."""
    if is_given:
        from scanrack.io_images.versions import distribution_version

        say(f"scanrack {distribution_version('scanrack')}")
        raise typer.Exit


def limit_traces(
    context: typer.Context,
    _version: Annotated[
        bool,
        typer.Option("--version", callback=print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
    max_chunk: Annotated[
        int,
        typer.Option("--max-chunk", min=1, metavar="MIB", help="Maximum unpacked size of a trace's chunk."),
    ] = CHUNK_BYTES // MIB,
    max_records: Annotated[
        int,
        typer.Option("--max-records", metavar="N", min=1, help="Maximum nearly empty records in a chunk."),
    ] = RECORDS,
) -> None:
    """Apply the limits for reading traces until the command ends."""
    context.with_resource(limited(Limits(max_chunk * MIB, max_records)))
