"""Writes the coverage of a program as one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

from scanrack.traces.files.guard import PAGE
from scanrack.traces.files.newfile import new_file

from ..folder_lock import write_text
from .coverage import CoveredLine
from .unfired import UnfiredRule

STYLE = """\
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #57606a; --gap: #fff1e5; --edge: #bc4c00;
  --paper: #fff }
body { font: 15px system-ui, sans-serif; margin: 1.5em auto; max-width: 70em; padding: 0 1em;
  color: var(--ink); background: var(--paper) }
ol { list-style: none; margin: 0; padding: 0 }
li { display: flex; flex-wrap: wrap; gap: 0 1em; padding: .1em .5em; border-left: 4px solid transparent }
li.gap { background: var(--gap); border-color: var(--edge) }
li div { flex: 1 1 20em; min-width: 0 }
li span { color: var(--soft); flex: 0 0 10em } li b { color: var(--edge); flex: 1 0 100% }
code { font-family: "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: 13px; white-space: pre-wrap;
  overflow-wrap: anywhere; flex: 1 1 20em; min-width: 0 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6edf3; --soft: #9198a1; --gap: #33230f; --edge: #f0a35e; --paper: #0d1117 }
}"""


def save_coverage(
    file: Path,
    title: str,
    lines: Sequence[CoveredLine],
    runs: int,
    never: Sequence[UnfiredRule] = (),
    rules: int = 0,
) -> None:
    """Write the page.

    Args:
        runs: number of runs.
        never: error rules that never fired.
        rules: number of error rules.

    Raises:
        OSError: the file can't be written.
    """
    text = f"{coverage_line(lines)}, in {runs:,} runs with new behavior."
    parts = [_Part("", text, map(_row, lines))]
    if never:
        heading = f"Error rules that never fired: {len(never)} of {rules}"
        parts.append(_Part(heading, "", map(_rule, never)))
    write_text(file, _page(title, parts))


def save_programs(file: Path, programs: Iterable[tuple[str, Sequence[CoveredLine]]]) -> None:
    """Write a page of several programs.

    Args:
        programs: the file and lines of each program.

    Raises:
        OwnedError: the existing file is a different kind of file.
        OSError: the file can't be written.
    """
    parts = [_Part(name, f"{coverage_line(lines)}.", map(_row, lines)) for name, lines in programs]
    with new_file(file, PAGE) as page:
        page.write(_page("Rung coverage", parts))


def coverage_line(lines: Sequence[CoveredLine]) -> str:
    """Return a sentence about the number of lines with gaps."""
    gaps = sum(bool(line.never) for line in lines)
    return (
        f"{gaps:,} of {len(lines):,} lines have gaps" if gaps else f"none of {len(lines):,} lines has a gap"
    )


class _Part(NamedTuple):
    """A section of a page, with its rows as HTML."""

    heading: str
    text: str
    rows: Iterable[str]


def _page(title: str, parts: Iterable[_Part]) -> str:
    return "\n".join([*_lines(title, parts), ""])


def _lines(title: str, parts: Iterable[_Part]) -> Iterator[str]:
    """Yield the lines of the page: its head, and each part as a heading, a text and a list."""
    yield f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<style>\n{STYLE}\n</style></head><body>\n<h1>{escape(title)}</h1>"
    for part in parts:
        if part.heading:
            yield f"<h2>{escape(part.heading)}</h2>"
        if part.text:
            yield f"<p>{part.text}</p>"
        yield "<ol>"
        yield from part.rows
        yield "</ol>"
    yield "</body></html>"


def _rule(unfired: UnfiredRule) -> str:
    rule, reason = unfired.rule, escape(unfired.sentence)
    return f"<li><span>{rule.id}</span><div>{escape(rule.text)}</div><b>{reason}</b></li>"


def _row(line: CoveredLine) -> str:
    gaps = f"<b>{escape('; '.join(line.never))}</b>" if line.never else ""
    row = f"<span>{escape(line.place)}</span><code>{escape(line.text)}</code>{gaps}"
    return f'<li class="gap">{row}</li>' if line.never else f"<li>{row}</li>"
