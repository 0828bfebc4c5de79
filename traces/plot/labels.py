"""Places of the marks' labels, chosen so that no two overlap."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from .marks import KINDS, Mark

GAP = 2
"""Minimum distance of two labels in a row, letters."""

MANY = 30
"""A label that occurs more often than this is drawn once, with the number of occurrences."""


class Label(NamedTuple):
    """A label that is drawn."""

    mark: Mark  # its mark
    row: int  # 0 or more
    before: bool  # whether it ends at its mark, instead of beginning there, for lack of space


def placed(marks: Sequence[Mark], start_ns: int, end_ns: int, letter: float, rows: int) -> list[Label]:
    """Choose which marks get labels, and place these: after the mark, or before it at the right edge.

    The most important kinds come first; within a kind, earlier marks do. Of very many marks with the same
    label only the first is labeled, with their number.

    Args:
        letter: width of a letter, as a fraction of the axis' length.
        rows: number of rows of labels.
    """
    span = max(1, end_ns - start_ns)
    taken_spans: list[list[tuple[float, float]]] = [[] for _ in range(rows)]
    labels = []
    for mark in sorted(_folded(marks), key=lambda mark: KINDS.index(mark.kind)):
        left, width = (mark.time_ns - start_ns) / span, len(mark.label) * letter
        is_before = left + width > 1
        left -= width * is_before
        right = left + width
        for row, spans in enumerate(taken_spans):
            gap = GAP * letter
            if left >= 0 and all(right + gap <= begin or left >= end + gap for begin, end in spans):
                spans.append((left, right))
                labels.append(Label(mark, row, is_before))
                break
    return labels


def shortened(text: str, letters: int) -> str:
    r"""Return a name in at most `letters` letters; it loses its beginning, since the end is more specific.

    >>> shortened(r"\Main.Recipe[3].Time", 12), shortened("Run", 12)
    ('…ipe[3].Time', 'Run')
    """
    return text if len(text) <= letters else f"…{text[1 - letters :]}"


def listed(pairs: Sequence[tuple[str, str]], letters: int) -> str:
    """Return names and values as one line of about `letters` letters.

    >>> listed([("Dwell.PRE", "500"), ("Homing", "off"), ("Auto", "on")], 30)
    'Dwell.PRE 500   Homing off   …'
    """
    line = ""
    for name, value in pairs:
        entry = f"{name} {value}"
        if line and len(line) + len(entry) > letters:
            return f"{line}…"
        line += f"{entry}   "
    return line.rstrip()


def _folded(marks: Sequence[Mark]) -> Iterator[Mark]:
    """Yield the marks; of very many with the same label only the first, with their number."""
    often = Counter((mark.kind, mark.label) for mark in marks)
    labeled = set()
    for mark in marks:
        key = (mark.kind, mark.label)
        if often[key] <= MANY:
            yield mark
        elif key not in labeled:
            labeled.add(key)
            yield replace(mark, label=f"{mark.label} ×{often[key]:,}")
