"""The rule table: one row for every rule of the 3601's manual, in the manual's order.

Who wants to know why a bit is set, what a chapter asks for, or which rules a
test run has touched looks it up here.

>>> rule = RULES["CMD-03"]
>>> bit_names(rule.sets), rule.section
(('COMMAND_ERROR',), 'chapter 6, Command Error 3')
>>> rule.text
'A move was started before the previous one was complete; the previous one goes on.'
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from . import chapter3, chapter6_errors
from .rule import Rule, StatusBits, bit_names

__all__ = ["RULES", "Rule", "StatusBits", "bit_names"]

_ROWS: tuple[Rule, ...] = (
    *chapter3.ROWS,
    *chapter6_errors.ROWS,
)

RULES: Mapping[str, Rule] = MappingProxyType({row.id: row for row in _ROWS})
"""Every rule by its id, in the manual's order."""
