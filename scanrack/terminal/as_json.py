"""The option --json: one JSON object on standard output instead of text; messages stay on standard error.

The page of each command lists the keys. Times are in ns, counts and positions are integers; NaN and infinity
are null.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Annotated, Any

import typer

from .terminal import say

JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]


def say_json(value: object) -> None:
    """Print a value; types without a JSON form are printed as text."""
    text = json.dumps(_plain(value), indent=2, default=str, allow_nan=False)
    say(text.replace("\x7f", "\\u007f"), whole=True)  # JSON does not escape this control character


def _plain(value: Any) -> Any:
    """Return a value with null in place of NaN and infinity."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
