"""Tables of each adapter's refusals for the documentation, generated from its rows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ....io_images.amci3601 import StatusMsw
from .capabilities import CONFIG_ERROR, CommandRow, ConfigurationRow
from .pcl601 import capabilities as pcl601
from .pmc006 import capabilities as pmc006


def refusals(controller: str) -> str:
    """Return the table of refusals of "PCL601" or "PMC006", in Markdown."""
    rooms = {"PCL601": pcl601, "PMC006": pmc006}
    room = rooms[controller]
    lines = ["| asked for | refused: | shown as |", "|---|---|---|"]
    lines += _configuration_lines(room.CONFIGURATION_ROWS)
    lines += _command_lines(room.COMMAND_ROWS)
    return "\n".join(lines) + "\n"


def _configuration_lines(rows: Sequence[ConfigurationRow[Any]]) -> Iterable[str]:
    for row in rows:
        yield f"| configuration: {row.name} | {row.reason} | {_names(CONFIG_ERROR)} |"


def _command_lines(rows: Sequence[CommandRow[Any]]) -> Iterable[str]:
    for row in rows:
        features = sorted(feature.value for feature in row.features)
        asked = features[0] if len(features) == 1 else f"{row.name} of any motion"
        yield f"| {asked} | {row.reason} | {_names(row.bits)} |"


def _names(bits: int) -> str:
    return ", ".join(str(bit.name) for bit in StatusMsw if bit & bits)
