"""`scanrack tags`: list the tags of a rack as clients of `--server` see them."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from scanrack.terminal.as_json import JsonOption


class Software(StrEnum):
    """Software that imports a list of tags; see `tag_formats.FORMATS`."""

    IGNITION = "ignition"
    KEPWARE = "kepware"
    FACTORYTALK = "factorytalk"
    NODE_RED = "node-red"


def _tags_command(
    rack: Annotated[
        Path, typer.Argument(metavar="RACK", help="A rack file or an export.", show_default=False)
    ],
    tag: Annotated[
        list[str] | None, typer.Argument(metavar="TAG", help="Only these tags: Run, Recipe.*, Local:1:*.")
    ] = None,
    as_json: JsonOption = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print the table as CSV.")] = False,
    software: Annotated[
        Software | None, typer.Option("--for", metavar="SOFTWARE", help="Print a file that SOFTWARE imports.")
    ] = None,
    first_map: Annotated[bool, typer.Option("--map", help="Print a first [server] table.")] = False,
) -> None:
    """List the tags that clients of --server see.

    Each value has its type, access, description, Modbus address, OPC UA node and EtherNet/IP name.

    SOFTWARE is ignition (JSON of tags), kepware or factorytalk (CSV of tags), or node-red (a flow).

    scanrack watch --server serves them.

    Examples:
        scanrack new feeder --from feeder
        scanrack tags feeder/feeder.toml
        scanrack tags line.toml "Hmi*" Position --for node-red > flow.json
        scanrack tags line.toml --map >> line.toml
        scanrack watch line.toml --server ethernet-ip

    Exit status: 0 listed, 1 SOFTWARE can't represent some tags, 2 a file can't be used.
    """
    from .tags_job import tags

    raise typer.Exit(tags(rack, tag or [], as_json, as_csv, software, first_map))


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("tags", no_args_is_help=True)(_tags_command)
