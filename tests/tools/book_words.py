"""How many words a reader of the book reads: reading pages, without code and targets of links.

python tests/tools/book_words.py
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
READING = ("Tutorial", "How to", "Explanation")
"""Parts of docs/index.md; a reference is looked up in, and decision records are not part of the book."""
CODE = re.compile(r"```.*?```|^ {4}.*?$", re.DOTALL | re.MULTILINE)
TARGET = re.compile(r"\]\([^)]*\)")
WORD = re.compile(r"[A-Za-z]")


def pages() -> list[Path]:
    """Return the reading pages, in the order of the contents."""
    text = (DOCS / "index.md").read_text(encoding="utf-8")
    found = [DOCS / "index.md"]
    parts = re.split(r"^## (.*)$", text, flags=re.MULTILINE)
    for caption, body in zip(parts[1::2], parts[2::2], strict=True):
        names = re.findall(r"^\* \[.+\]\((\S+)\)$", body, re.MULTILINE) if caption in READING else ()
        found += [DOCS / name for name in names if "/index" not in name]
    return found


def words(page: Path) -> int:
    """Return the number of words in a page's sentences and tables."""
    text = TARGET.sub("]", CODE.sub("", page.read_text(encoding="utf-8")))
    return sum(bool(WORD.search(each)) for each in text.split())


def main() -> None:
    """Print the words of each page, and of all."""
    counts = {page.relative_to(DOCS).as_posix(): words(page) for page in pages()}
    lines = [f"{count:6,}  {name}" for name, count in counts.items()]
    sys.stdout.write("\n".join([*lines, f"{sum(counts.values()):6,}  in {len(counts)} pages", ""]))


if __name__ == "__main__":
    main()
