"""Functions from higher packages that a program offers.

`scanrack.ladder` sets them, so that no import points upward.
"""

from collections.abc import Callable
from typing import Any

rung_svg: Callable[[Any], str]
"""Draws a rung for a notebook."""

ask: Callable[..., Any]
"""Decides a claim about a program, see `prove.answers.ask`."""
