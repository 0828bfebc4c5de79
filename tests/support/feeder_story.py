"""What the feeder of the examples does on each hardware, whatever its program is written in."""

from __future__ import annotations

from typing import Any

from witness import Witness

HARDWARES = {
    "amci3601": "",
    "pcl601-adapter": "",
    "pmc006-adapter": "options = { home_stroke = 20000 }",
}

STORY = [
    ("home", "home", 0),
    ("absolute", "complete", 6000),
    ("absolute", "complete", 100),
    ("absolute", "complete", 6000),
    ("absolute", "complete", 100),
    ("absolute", "cut short", None),  # the emergency stop, wherever the stroke then is
    ("home", "home", 0),
    ("absolute", "complete", 6000),
]


def moves_of(witness: Witness) -> list[tuple[Any, ...]]:
    """Return the moves that a witness saw: kind, outcome, and where one ended that was not cut short."""
    return [
        (event["name"], event["outcome"], None if event["outcome"] == "cut short" else event["to"])
        for event in witness.events
        if event.get("kind") == "move"
    ]
