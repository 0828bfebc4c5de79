"""The rule table: one row per rule of the 3601's manual, in the manual's order.

It shows the causes of each bit, the rules of each chapter, and the rules without a test.

>>> rule = RULES["CMD-03"]
>>> bit_names(rule.sets), rule.section
(('COMMAND_ERROR',), 'chapter 6, Command Error 3')
>>> rule.text
'A move was started before the previous one was complete; the previous one goes on.'
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from . import (
    chapter1,
    chapter2,
    chapter3,
    chapter4_blend_registration,
    chapter4_encoder,
    chapter4_homing,
    chapter4_manual,
    chapter4_moves,
    chapter5,
    chapter6_errors,
    chapter6_inputs,
    chapter6_status,
)
from .rule import Rule, StatusBits, bit_names

__all__ = ["RULES", "Rule", "StatusBits", "bit_names"]

_ROWS: tuple[Rule, ...] = (
    *chapter1.ROWS,
    *chapter2.ROWS,
    *chapter3.ROWS,
    *chapter4_moves.ROWS,
    *chapter4_homing.ROWS,
    *chapter4_manual.ROWS,
    *chapter4_blend_registration.ROWS,
    *chapter4_encoder.ROWS,
    *chapter5.ROWS,
    *chapter6_status.ROWS,
    *chapter6_errors.ROWS,
    *chapter6_inputs.ROWS,
)

RULES: Mapping[str, Rule] = MappingProxyType({row.id: row for row in _ROWS})
"""Rules by id, in the manual's order."""
