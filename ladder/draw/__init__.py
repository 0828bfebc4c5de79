"""Rungs as pictures: one layout (`layout`), box characters (`characters`) or SVG (`svg`, `live`)."""

from .characters import routine_text, rung_text
from .live import LiveRung, live_rung
from .power import power
from .ruler import captions_of
from .svg import routines_svg

__all__ = ["LiveRung", "captions_of", "live_rung", "power", "routine_text", "routines_svg", "rung_text"]
