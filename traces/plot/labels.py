"""Places the labels of marks so that no two labels overlap."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from .marks import KINDS, Mark

GAP = 2
"""Minimum distance between two labels in a row, letters."""

MANY = 30
"""A label that occurs more than this many times is drawn once, with the number of occurrences."""


class Label(NamedTuple):
    """The place of a mark's label."""

    mark: Mark
    row: int  # 0 or more, from the lowest row
    before: bool  # whether it ends at its mark because the space after the mark is too small


def placed(marks: Sequence[Mark], start_ns: int, end_ns: int, letter: float, rows: int) -> list[Label]:
    """Return the labels that fit. A label is to the right of its mark, or to the left at the right edge.

    Marks get their labels in the order of `KINDS`, and within a kind in their own order. If more than `MANY`
    marks have the same label, only the first is labeled, with the number of marks.

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
        if is_before:
            left -= width
        right = left + width
        for row, spans in enumerate(taken_spans):
            gap = GAP * letter
            if left >= 0 and all(right + gap <= begin or left >= end + gap for begin, end in spans):
                spans.append((left, right))
                labels.append(Label(mark, row, is_before))
                break
    return labels


def shortened(text: str, letters: int) -> str:
    r"""Shorten a name to at most `letters` letters, keeping its end, which is more specific.

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
    """Yield the marks; if more than `MANY` have the same label, yield only the first, with their number."""
    counts = Counter((mark.kind, mark.label) for mark in marks)
    folded = set()
    for mark in marks:
        kind_and_label = (mark.kind, mark.label)
        count = counts[kind_and_label]
        if count <= MANY:
            yield mark
        elif kind_and_label not in folded:
            folded.add(kind_and_label)
            yield replace(mark, label=f"{mark.label} ×{count:,}")
