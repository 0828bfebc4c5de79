"""Entry points for untrusted texts: the only callers of the TOML and JSON parsers.

The bare parsers take excessive time and memory for some input, or raise a RecursionError. Text from a file is
subject to `text_limits`; the size of a message is limited by its transport. The other entry points are
`rockwell.l5x.xml.document` for XML, `io_images.captures.packets` for captures, and `traces.read.reader` and
`traces.repair` for traces. `tests/unit/tools/test_doors.py` finds parser calls elsewhere.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from typing import Any

from .text_limits import TextKind, check_text


def toml_tables(text: str, kind: TextKind = TextKind.TOML) -> dict[str, Any]:
    """Return the tables of a TOML text, with fractions as `Decimal`.

    Raises:
        TextLimitError: the text exceeds the limits of its kind.
        tomllib.TOMLDecodeError: the text is not TOML.
    """
    check_text(text, kind)
    return tomllib.loads(text, parse_float=_fraction)


def _fraction(text: str) -> Decimal:
    """Return a number; return NaN, which all callers refuse, if its exponent is too large for Decimal."""
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
        kind: the kind of a text from a file, to check its limits; None for a message.
        parse_float: as for `json.loads`.
        parse_constant: as for `json.loads`; if None, NaN and infinities are numbers.

    Raises:
        TextLimitError: the text exceeds the limits of its kind.
        ValueError: the text is not JSON (a JSONDecodeError with the line), or is nested too deeply.
    """
    if kind is not None:
        check_text(text if isinstance(text, str) else text.decode("utf-8"), kind)
    try:
        return json.loads(text, parse_float=parse_float, parse_constant=parse_constant)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
