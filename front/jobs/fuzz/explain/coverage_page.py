"""The coverage of a program as one HTML page, without network."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

from ..folder_lock import write_text
from .coverage import CoveredLine

STYLE = """\
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #57606a; --gap: #fff1e5; --edge: #bc4c00;
  --paper: #fff }
body { font: 15px system-ui, sans-serif; margin: 1.5em auto; max-width: 70em; padding: 0 1em;
  color: var(--ink); background: var(--paper) }
ol { list-style: none; margin: 0; padding: 0 }
li { display: flex; flex-wrap: wrap; gap: 0 1em; padding: .1em .5em; border-left: 4px solid transparent }
li.gap { background: var(--gap); border-color: var(--edge) }
li span { color: var(--soft); flex: 0 0 10em } li b { color: var(--edge); flex: 1 0 100% }
code { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: 13px; white-space: pre-wrap;
  overflow-wrap: anywhere; flex: 1 1 20em; min-width: 0 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6edf3; --soft: #9198a1; --gap: #33230f; --edge: #f0a35e; --paper: #0d1117 }
}"""


def save_coverage(file: Path, title: str, lines: Sequence[CoveredLine], runs: int) -> None:
    """Write the page.

    Args:
        runs: number of the runs that it is of.

    Raises:
        OSError: it can't be written.
    """
    write_text(file, "\n".join([*_page(title, lines, runs), ""]))


def coverage_line(lines: Sequence[CoveredLine]) -> str:
    """Return how much of a program was covered, in a sentence."""
    gaps = sum(bool(each.never) for each in lines)
    return (
        f"{gaps:,} of {len(lines):,} lines have gaps" if gaps else f"none of {len(lines):,} lines has a gap"
    )


def _page(title: str, lines: Sequence[CoveredLine], runs: int) -> Iterator[str]:
    yield f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<style>\n{STYLE}\n</style></head><body>\n<h1>{escape(title)}</h1>"
    yield f"<p>{coverage_line(lines)}, in {runs:,} runs that showed something new.</p>\n<ol>"
    yield from map(_row, lines)
    yield "</ol>\n</body></html>"


def _row(line: CoveredLine) -> str:
    gaps = f"<b>{escape('; '.join(line.never))}</b>" if line.never else ""
    row = f"<span>{escape(line.place)}</span><code>{escape(line.text)}</code>{gaps}"
    return f'<li class="gap">{row}</li>' if line.never else f"<li>{row}</li>"
