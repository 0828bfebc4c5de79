"""Functions of a program that higher packages implement.

`scanrack.ladder` sets them, so lower packages do not import higher ones.
"""

from collections.abc import Callable
from typing import Any

rung_svg: Callable[[Any], str]
"""Draws a rung for a notebook."""

ask: Callable[..., Any]
"""Decides a claim about a program; see `prove.answers.ask`."""
