"""Writes the report of a failure: the file `report.txt` in the folder of its trace."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from scanrack.io_images.times import seconds

from .explain.futures import PointOfNoReturn
from .folder_lock import write_text
from .scenarios.words import described
from .search import Counterexample


def report(
    failure: Counterexample,
    point: PointOfNoReturn | None,
    cause: Sequence[str],
    chart: Sequence[str],
    commands: Sequence[str],
    check: str,
) -> str:
    """Return the text of a failure's report.

    Args:
        point: the point at which the failure became inevitable; None if there was no time to find it.
        cause: cause chain of the output that turned on last.
        chart: links to the chart and to the part around the failure.
        commands: commands that repeat the failure, and notes.
        check: command that tests a changed program.
    """
    broken = failure.broken
    sections = [
        ("Events that cause the failure:", described(failure.scenario)),
        (f"State at the end of scan {broken.scan}, {seconds(broken.now_ns)} s:", broken.shows),
        ("Rules that fired in this scan:", broken.rules or ["none"]),
        ("Point of no return:", NO_TIME if point is None else point.lines),
        ("Why the last output came on before the failure:", cause),
        ("Chart, and the part around the failure:", chart),
        ("To repeat the failure:", commands),
        ("To test a changed program:", [check]),
    ]
    text_lines = [str(broken)]
    for title, lines in sections:
        if lines:
            text_lines += ["", title, *(f"    {line}" for line in lines)]
    return "\n".join(text_lines) + "\n"


def note_fixed(file: Path) -> None:
    """Write at the top of a failure's report that the failure no longer occurs."""
    if file.is_file():
        text = file.read_text(encoding="utf-8")
        write_text(file, f"{FIXED}\n\n{text.removeprefix(FIXED).lstrip()}")


NO_TIME = ("unknown, because the time of the search was up",)

FIXED = "Fixed: the program no longer fails in this scenario."
