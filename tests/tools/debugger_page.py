"""The arguments and the requests in docs/debugger.md, from their tables in `scanrack.dap`."""

from __future__ import annotations

import re
from pathlib import Path

from scanrack.dap.requests import REQUESTS
from scanrack.dap.starting import LAUNCH

PAGE = Path(__file__).parents[2] / "docs/debugger.md"


def written(page: str) -> str:
    """Return the page with all arguments and requests."""
    arguments = "".join(f"| `{name}` | {says} |\n" for name, (_kind, says) in LAUNCH.items())
    requests = "".join(
        f"| `{name}` | {each.description} | {f'`{each.capability}`' if each.capability else ''} |\n"
        for name, each in REQUESTS.items()
    )
    for head, rows in (("argument | value", arguments), ("request | does | announced as", requests)):
        found = rf"(^\| {re.escape(head)} \|\n\|[-|]+\n)(?:\|.*\n)*"
        table = re.search(found, page, flags=re.MULTILINE)
        assert table, f"docs/debugger.md has no table with {head}"
        page = f"{page[: table.end(1)]}{rows}{page[table.end() :]}"
    return page
