"""Colours that stay apart for the colour-blind (after Okabe and Ito), one per kind of lane and mark."""

from __future__ import annotations

from collections.abc import Mapping

LANES: Mapping[str, str] = {
    "command": "#b65100",
    "status": "#0060a0",
    "error": "#99004c",
    "input": "#00735c",
    "output": "#7a5c00",
}
"""Colour of a lane and its name, by group; dark enough for small letters on white."""

RAMP: tuple[str, ...] = ("#ffffff", "#56b4e9", "#cfe3f2", "#f0c05a", "#bbbbbb")
"""Colours of the ramp's states: at rest, accelerating, constant speed, decelerating, held."""

MARKS: Mapping[str, str] = {
    "broken": "#d00000",
    "rule": "#99004c",
    "stimulus": "#00735c",
    "move": "#0060a0",
    "cpu": "#444444",
}
"""Colour of a mark, by kind."""

CURVE = "#1f4e79"
GRID = "#dddddd"
INK = "#222222"
