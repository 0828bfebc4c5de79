"""Drawings of rungs: a single layout that can be drawn in box characters or as SVG.

| file | content |
|---|---|
| `ruler`, `layout` | sizes of elements; their positions |
| `marks`, `shapes`, `markup` | symbols; lines, curves and letters; SVG elements |
| `characters`, `svg`, `live` | a routine as text, as SVG, as SVG that a page updates |
| `chart`, `diagram` | a sequential function chart, a function block diagram |
| `power` | numbers of elements, and the power on them |
"""

from .characters import routine_text, rung_text
from .chart import live_chart
from .diagram import live_diagram
from .live import LiveRung, live_rung
from .markup import LivePicture
from .power import power
from .ruler import captions_of
from .svg import routines_svg

__all__ = [
    "LivePicture",
    "LiveRung",
    "captions_of",
    "live_chart",
    "live_diagram",
    "live_rung",
    "power",
    "routine_text",
    "routines_svg",
    "rung_text",
]
