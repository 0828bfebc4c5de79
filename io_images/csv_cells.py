"""Writes tables of comma-separated values for all of scanrack.

A spreadsheet treats a cell that begins with `=`, `+`, `-` or `@` as a formula, which may read other files or
access the network. Untrusted text, such as names, descriptions and string values, is therefore never written
as a formula.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Characters that can begin a formula."""


def cell(value: object) -> object:
    """Return the value of a cell; text that a spreadsheet would treat as a formula gets a leading quote.

    >>> cell("=HYPERLINK(0)"), cell("+1"), cell("Motor"), cell(-1)
    ("'=HYPERLINK(0)", "'+1", 'Motor', -1)
    """
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def line_text(text: str) -> str:
    r"""Return text as a single line.

    >>> line_text("Motor\nof the belt")
    'Motor of the belt'
    """
    return " ".join(text.split())


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as comma-separated values [RFC 4180]; text in them is never a formula.

    >>> csv_text([["a", "=1"], [-1, "b, c"]]).splitlines()
    ["a,'=1", '-1,"b, c"']
    """
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(map(cell, row) for row in rows)
    return out.getvalue()
