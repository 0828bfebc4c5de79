"""Writes the report of a failure: the file `report.txt` beside its trace."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from scanrack.io_images.times import seconds

from .explain.futures import PointOfNoReturn
from .folder_lock import write_text
from .scenarios.words import described
from .search import Counterexample


def report(
    found: Counterexample,
    late: PointOfNoReturn | None,
    cause: Sequence[str],
    chart: Sequence[str],
    again: Sequence[str],
    check: str,
) -> str:
    """Return the text of a failure's report.

    Args:
        late: the point from which the failure was inevitable; None if there was no time to find it.
        cause: the cause chain of the output that changed last.
        chart: links to the chart: all of it, and the part around the failure.
        again: commands that repeat the failure, and obstacles.
        check: command that tests a changed program.
    """
    broken = found.broken
    parts = [
        ("What it takes:", described(found.scenario)),
        (f"At the end of scan {broken.scan}, {seconds(broken.now_ns)} s:", broken.shows),
        ("Rules that fired in that scan:", broken.rules or ["none"]),
        ("When it became inevitable:", NOT_LOOKED_FOR if late is None else late.lines),
        *([("Why the last output came on before it:", cause)] if cause else []),
        ("Its picture, and the part around the failure:", chart),
        ("Run it again:", again),
        ("Check whether a changed program still fails:", [check]),
    ]
    return "\n".join([str(broken), *(line for title, lines in parts for line in _part(title, lines))]) + "\n"


def _part(title: str, lines: Sequence[str]) -> Iterator[str]:
    yield ""
    yield title
    yield from (f"    {line}" for line in lines)


def note_fixed(file: Path) -> None:
    """Add to a failure's report that the failure no longer occurs."""
    if file.is_file():
        text = file.read_text(encoding="utf-8")
        write_text(file, f"{FIXED}\n\n{text.removeprefix(FIXED).lstrip()}")


NOT_LOOKED_FOR = ("not looked for: the time of the search was over",)

FIXED = "Fixed: the program no longer fails in this scenario."
