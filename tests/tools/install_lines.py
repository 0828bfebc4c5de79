"""Pages that say how to install scanrack: the commands are those of `io_images/installing.py`.

README.md and CONTRIBUTING.md are about a checkout, whatever is published.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from scanrack.io_images.installing import install_line

ROOT = Path(__file__).parents[2]
MENTION = re.compile(
    r"""\b(?P<tool>pipx?|uv\ tool)\ install\ (?:--upgrade\ )?
    (?P<quote>["']?)(?:scanrack|\.)(?:\[(?P<extra>[\w,]+)\])?(?P=quote)(?![\w./])""",
    re.VERBOSE,
)
SUFFIXES = (".md", ".js", ".json", ".toml", ".py", ".rung", ".yml")


def pages() -> Iterator[Path]:
    """Every text of the book, the examples and the editors, and the changes that are not released."""
    for folder in ("changes", "docs", "examples", "editors"):
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix in SUFFIXES and "node_modules" not in file.parts:
                yield file


def installed_as_today(text: str) -> str:
    """Return the text with each command that installs scanrack as it works today."""
    return MENTION.sub(lambda each: install_line(each["extra"] or "", each["tool"]), text)
