"""The formats in docs/query.md, from their rows in `traces/export`: the command's line, and the table."""

from __future__ import annotations

import re
from pathlib import Path

from scanrack.traces.export import formats

PAGE = Path(__file__).parents[2] / "docs/query.md"


def written(page: str) -> str:
    """Return the page with all formats."""
    options = " ".join(f"[{each.option} OUT]" for each in formats.FORMATS)
    page, commands = re.subn(
        r"(^    scanrack export TRACE )(\[--\w+ OUT\] )+", rf"\1{options} ", page, flags=re.MULTILINE
    )
    rows = "".join(f"| `{each.option}` | {each.contents} | {each.reader} |\n" for each in formats.FORMATS)
    head = r"(^\| \| holds \| for \|\n\|[-|]+\n)(?:\|.*\n)*"
    page, tables = re.subn(head, lambda found: found[1] + rows, page, flags=re.MULTILINE)
    assert (commands, tables) == (1, 1), "docs/query.md has no line or no table of formats"
    return page
