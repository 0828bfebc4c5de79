"""Rungs as pictures: one layout (`layout`), drawn with box characters (`characters`) or as SVG (`svg`)."""

from .characters import routine_text, rung_text
from .ruler import captions_of
from .svg import routines_svg

__all__ = ["captions_of", "routine_text", "routines_svg", "rung_text"]
