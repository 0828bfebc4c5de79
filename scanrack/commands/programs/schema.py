"""`scanrack editor schema`: the JSON Schema of rack files, for editors."""

from __future__ import annotations

import json
from typing import Annotated

import typer
from scanrack.terminal.terminal import say


def schema_command(
    draft4: Annotated[
        bool,
        typer.Option("--draft4", help="Use Draft 4, for taplo, instead of 2020-12, for tombi."),
    ] = False,
    write: Annotated[bool, typer.Option("--write", help="Write rack.schema.json in this folder.")] = False,
) -> None:
    """Print the JSON Schema of rack files.

    The schema has all keys with their meanings and limits, and the options of each module.

    An editor with tombi or taplo uses the schema if the first line of a rack file is
    #:schema rack.schema.json. Only `scanrack check` finds conflicts between keys.

    Examples:
        scanrack editor schema --write

    Exit status: 0 done; 2 rack.schema.json is a different file; 3 it can't be written.
    """
    from scanrack.runtime.config.rack_schema import HINT, NAME, rack_schema

    text = json.dumps(rack_schema(draft4=draft4), indent=1, ensure_ascii=False)
    if not write:
        say(text, whole=True)
        return
    from scanrack.terminal.complaints import reported_mistakes
    from scanrack.traces.files.guard import SCHEMA
    from scanrack.traces.files.newfile import new_file

    with reported_mistakes(), new_file(NAME, SCHEMA) as file:
        file.write(f"{text}\n")
    say(f"{NAME}\n\nPut this line first in a rack file beside it:  {HINT}")
