"""The tags of a rack as a table, a file for HMI software, or an initial `[server]` table."""

from __future__ import annotations

import re
from pathlib import Path

from scanrack.io_images.csv_cells import csv_text, line_text
from scanrack.jobs.load.loading import load_job
from scanrack.jobs.run.servers.offered import database_of_job
from scanrack.jobs.run.servers.tag_formats import FORMATS
from scanrack.runtime.tag_servers.database import Database, Writable
from scanrack.runtime.tag_servers.nearest import nearest, unknown_patterns
from scanrack.runtime.tag_servers.tag_list import TagRow, first_map, tag_rows
from scanrack.terminal.as_json import say_json
from scanrack.terminal.status import BAD_INPUT, DONE, NO, complain
from scanrack.terminal.terminal import say

from ..recordings.show import new_table, print_block

COLUMNS = ("name", "type", "access", "Modbus", "OPC UA", "EtherNet/IP", "description")
SHOWN_MOST = 3
"""Maximum number of omitted tags that a message names."""


def tags(
    rack: Path, names: list[str], as_json: bool, as_csv: bool, software: str | None, server_map: bool
) -> int:
    """Print the tags of a rack, or only the tags that match patterns; return the exit status."""
    if as_json + as_csv + server_map + (software is not None) > 1:
        return complain("--json, --csv, --for and --map: give only one of them", BAD_INPUT)
    try:
        job = load_job(str(rack))
        database = database_of_job(job)
        server = job.spec.server
        if problems := unknown_patterns(database, server.writable):
            return complain("; ".join(problems), BAD_INPUT)
        rows = list(tag_rows(database, server.modbus))
        if names:
            rows = _chosen(rows, names, database)
    except ValueError as error:
        return complain(str(error), BAD_INPUT)
    if server_map:
        text, left_out = first_map(rows, server.writable)
        say(text.rstrip(), whole=True)
        return _left_out("Modbus", left_out, rows)
    if software is not None:
        return _print_file(software, rows, job.spec.name)
    if as_json:
        say_json({"rack": job.spec.name, "tags": [_as_object(row) for row in rows]})
    elif as_csv:
        say(_csv(rows).rstrip(), whole=True)
    else:
        _print_table(rows)
    return DONE


def _print_file(software: str, rows: list[TagRow], title: str) -> int:
    file = FORMATS[software](rows, title)
    say(file.text.rstrip(), whole=True)
    return _left_out(software, file.left_out, rows)


def _left_out(target: str, names: list[str], rows: list[TagRow]) -> int:
    """Report the tags that a format can't represent, if any; return the exit status."""
    if not names:
        return DONE
    missing_names = ", ".join(names[:SHOWN_MOST]) + (", ..." if len(names) > SHOWN_MOST else "")
    return complain(f"{target} can't represent {len(names)} of {len(rows)} tags: {missing_names}", NO)


def _chosen(rows: list[TagRow], patterns: list[str], database: Database) -> list[TagRow]:
    """Return the rows that match patterns; raise ValueError for a pattern without a match."""
    chosen = []
    for text in patterns:
        matches = Writable([text]).matches
        matching = [row for row in rows if row.name == text or matches(re.sub(r"\[[^]]*\]", "", row.name))]
        if not matching:
            raise ValueError(f"no tag {text!r}{nearest(database, text)}")
        chosen += [row for row in matching if row not in chosen]
    return chosen


def _cells(row: TagRow) -> tuple[str, ...]:
    return row.name, row.type, row.access, ", ".join(row.modbus), row.node, row.enip, row.description


def _as_object(row: TagRow) -> dict[str, object]:
    return {
        "name": row.name,
        "type": row.type_name,
        "dimensions": list(row.dims),
        "writable": row.writable,
        "description": row.description,
        "modbus": list(row.modbus),
        "opc_ua": row.node or None,
        "ethernet_ip": row.enip,
    }


def _csv(rows: list[TagRow]) -> str:
    return csv_text([COLUMNS, *((*_cells(row)[:-1], line_text(row.description)) for row in rows)])


def _print_table(rows: list[TagRow]) -> None:
    """Print the tags as a table, without columns that are empty."""
    cells = [_cells(row) for row in rows]
    columns_used = [
        column for column in range(len(COLUMNS)) if any(line_cells[column] for line_cells in cells)
    ]
    table = new_table(*(COLUMNS[column] for column in columns_used))
    for row_cells in cells:
        table.add_row(*(row_cells[column] for column in columns_used))
    print_block(table)
