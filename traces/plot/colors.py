"""Colors, one per kind of lane and mark, that color-blind people can distinguish (after Okabe and Ito)."""

from __future__ import annotations

from collections.abc import Mapping

LANES: Mapping[str, str] = {
    "command": "#b65100",
    "status": "#0060a0",
    "error": "#99004c",
    "input": "#00735c",
    "output": "#7a5c00",
    "tag": "#5a3e9b",
}
"""Color of a lane and its label, by group; dark enough for small text on white."""

RAMP: tuple[str, ...] = ("#ffffff", "#56b4e9", "#cfe3f2", "#f0c05a", "#bbbbbb")
"""Colors of the ramp's states: at rest, accelerating, constant speed, decelerating, held."""

BAND: tuple[str, ...] = ("#dcd6f0", "#cfe3f2", "#d5ecdc", "#f6e6bd", "#f3d9cf", "#e3e3e3")
"""Colors of a band's values, in the order in which the values first appear."""

BAND_DARK: tuple[str, ...] = ("#4a3f74", "#26506b", "#285a41", "#675423", "#6a3d2d", "#4c4c4c")
"""The colors of `BAND` on a dark background."""

MARKS: Mapping[str, str] = {
    "broken": "#d00000",
    "rule": "#99004c",
    "stimulus": "#00735c",
    "move": "#0060a0",
    "cpu": "#444444",
}
"""Color of a mark, by kind."""

CURVE = "#1f4e79"
GRID = "#dddddd"
INK = "#222222"
