"""Writes tables of comma-separated values for all of scanrack.

A spreadsheet treats a cell that begins with `=`, `+`, `-` or `@` as a formula, which may read other files or
access the network. So untrusted texts, such as names, descriptions and string values, never become formulas.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""First characters of a formula."""


def cell(value: object) -> object:
    """Return the value of a cell, with a quote before a text that a spreadsheet would treat as a formula.

    >>> cell("=HYPERLINK(0)"), cell("+1"), cell("Motor"), cell(-1)
    ("'=HYPERLINK(0)", "'+1", 'Motor', -1)
    """
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA) else value


def line_text(text: str) -> str:
    r"""Return a text as one line.

    >>> line_text("Motor\nof the belt")
    'Motor of the belt'
    """
    return " ".join(text.split())


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as comma-separated values [RFC 4180]; texts in them are not formulas.

    >>> csv_text([["a", "=1"], [-1, "b, c"]]).splitlines()
    ["a,'=1", '-1,"b, c"']
    """
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(map(cell, row) for row in rows)
    return out.getvalue()
