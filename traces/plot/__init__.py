"""Draws position, speed, ramp, changing bits and tags of a trace as a timing chart. See docs/plot.md."""

from .chart import Chart, NothingToPlotError, read_chart
from .envelope import Curve, Envelope
from .figure import save_figure
from .marks import Mark
from .page import save_page
from .panel import Panel

__all__ = [
    "Chart",
    "Curve",
    "Envelope",
    "Mark",
    "NothingToPlotError",
    "Panel",
    "read_chart",
    "save_figure",
    "save_page",
]
