"""Note which clients of others were tried: docs/clients-tried.toml, and its table in docs/hmi-clients.md.

    python -m tests.tools.clients_tried      run the tests of clients, and write the file with today's date

A client that is not installed keeps its line. `python -m tests.tools.generate clients` writes the table.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from datetime import date
from pathlib import Path
from typing import NamedTuple

import tomli_w

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from peers import PEERS, TRIED

ROOT = Path(__file__).parents[2]
FILE = ROOT / "docs/clients-tried.toml"
PAGE = ROOT / "docs/hmi-clients.md"
HEAD = "# Written by python -m tests.tools.clients_tried: versions that tests tried last.\n\n"


class TriedVersion(NamedTuple):
    """A client as it was tried last."""

    version: str
    tried: date


def tried() -> dict[str, TriedVersion]:
    """Return the clients of the file, in the order of `PEERS`."""
    table = tomllib.loads(FILE.read_text("utf-8")) if FILE.exists() else {}
    return {name: TriedVersion(**table[name]) for name in PEERS if name in table}


def written(page: str) -> str:
    """Return the page with all clients."""
    rows = "".join(
        f"| {name} | {found.version} | {found.tried} | {PEERS[name].protocol} | {PEERS[name].tried} |\n"
        for name, found in tried().items()
    )
    head = r"(^\| client \| version \| tried \|.*\n\|[-|]+\n)(?:\|.*\n)*"
    page, tables = re.subn(head, lambda found: found[1] + rows, page, flags=re.MULTILINE)
    assert tables == 1, f"{PAGE.name} has no table of clients"
    return page


def main() -> int:
    """Run the tests; return 1 if one fails."""
    with tempfile.TemporaryDirectory() as folder:
        notes = Path(folder, "tried")
        words = [sys.executable, "-m", "pytest", "-q", "-m", "peer", "tests/peers"]
        status = subprocess.run(words, cwd=ROOT, env={**os.environ, TRIED: str(notes)}).returncode
        lines = notes.read_text("utf-8").splitlines() if notes.exists() else []
    found = dict(map(json.loads, lines))
    every = tried() | {name: TriedVersion(version, date.today()) for name, version in found.items()}
    table: dict[str, object] = {name: every[name]._asdict() for name in PEERS if name in every}
    table["by_hand"] = tomllib.loads(FILE.read_text("utf-8")).get("by_hand", {})  # no test runs these
    FILE.write_text(HEAD + tomli_w.dumps(table), encoding="utf-8", newline="\n")
    missing = [name for name in PEERS if name not in found]
    sys.stdout.write(
        f"tried {len(found)} clients" + (f"; not {', '.join(missing)}" if missing else "") + "\n"
    )
    return min(status, 1)


if __name__ == "__main__":
    sys.exit(main())
