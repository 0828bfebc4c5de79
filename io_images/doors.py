"""Doors for texts from outside: the only callers of the parsers of TOML and JSON.

A parser alone costs time and memory out of proportion to some texts, or leaves by a RecursionError. What
comes from a file has its limits in `text_limits`; a message has those of what carries it. The other doors are
`rockwell.l5x.xml.document` for XML, `io_images.captures.packets` for captures, and `traces.read.reader` and
`traces.repair` for recordings: `tests/unit/tools/test_doors.py` finds a parser that is called elsewhere.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from typing import Any

from .text_limits import TextKind, check_text


def toml_tables(text: str, kind: TextKind = TextKind.TOML) -> dict[str, Any]:
    """Return the tables of a TOML text; fractions are decimal.

    Raises:
        TextLimitError: it is beyond the limits of a text.
        tomllib.TOMLDecodeError: it is not TOML.
    """
    check_text(text, kind)
    return tomllib.loads(text, parse_float=_fraction)


def _fraction(text: str) -> Decimal:
    """Return a number; NaN, which nothing takes, for one whose exponent no Decimal has."""
    try:
        return Decimal(text)
    except InvalidOperation:
        return Decimal("NaN")


def json_value(
    text: str | bytes,
    kind: TextKind | None = None,
    *,
    parse_float: Callable[[str], Any] | None = None,
    parse_constant: Callable[[str], Any] | None = None,
) -> Any:
    """Return the value of a JSON text.

    Args:
        kind: of a text from a file, whose limits are checked; None for a message.
        parse_float: as for `json.loads`.
        parse_constant: as for `json.loads`: NaN and infinities are numbers without it.

    Raises:
        TextLimitError: it is beyond the limits of its kind.
        ValueError: it is not JSON, or nested too deep; a JSONDecodeError has the line.
    """
    if kind is not None:
        check_text(text if isinstance(text, str) else text.decode("utf-8"), kind)
    try:
        return json.loads(text, parse_float=parse_float, parse_constant=parse_constant)
    except RecursionError:
        raise ValueError("it is nested too deep") from None
