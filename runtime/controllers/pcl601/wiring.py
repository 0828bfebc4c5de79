"""Switch SW2 and the thumbwheel module on J1 [Slide Switch Descriptions, Thumbwheel Index]."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Wiring:
    """Settings of the switch and the thumbwheel."""

    thumbwheel_selected: bool = False  # SW2 is at TWS, which disconnects inputs 5 and 6, not at IN5/6
    thumbwheel: int | None = None  # the value of its seven digits, None without a thumbwheel
