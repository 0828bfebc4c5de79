"""Where the words of a slot are in a trace's columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..columns import SLOT_WORDS
from ..layout import SlotInfo


def slot_places(slots: Sequence[SlotInfo]) -> Mapping[int, int]:
    """Return for each slot the first column of its output words."""
    return {slot.number: SLOT_WORDS * place for place, slot in enumerate(slots)}
