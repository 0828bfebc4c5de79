"""The latched status bits of word 0, and the rules that set them.

A real module shows only the bits. The simulated module also stores the rule that set each error bit, so that
a user can find the sentence in the manual.
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import NamedTuple

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.amci3601.words import WORDS_3601, Profile

from ...loop.events import Event, JsonValue

MODE_CONFIG = StatusMsw.MODE_CONFIG.value
MODULE_OK = StatusMsw.MODULE_OK.value
CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
INPUT_ERROR = StatusMsw.INPUT_ERROR.value
POSITION_INVALID = StatusMsw.POSITION_INVALID.value
INVALID_PROFILE = StatusMsw.INVALID_PROFILE.value
HOME_INVALID = StatusMsw.HOME_INVALID.value
MOVE_COMPLETE = StatusMsw.MOVE_COMPLETE.value
STOPPED = StatusMsw.STOPPED.value
HOLD_STATE = StatusMsw.HOLD_STATE.value
AT_HOME = StatusMsw.AT_HOME.value

WORD_0 = 0xFFFF

RESETTABLE = COMMAND_ERROR | INVALID_PROFILE | HOME_INVALID | INPUT_ERROR
"""Bits that Reset Errors clears [chapter 4, Reset Errors]."""

CLEARED_BY_A_MOVE = STOPPED | AT_HOME | MOVE_COMPLETE | HOLD_STATE | INPUT_ERROR
"""Bits that the start of a move clears [chapter 6; reading A-19]."""

COMPLETION = STOPPED | AT_HOME | MOVE_COMPLETE | HOLD_STATE


class BrokenRule(NamedTuple):
    """A broken rule."""

    rule: str
    alone: bool = False  # fires without the rows that usually fire together with it

    def rows(self, profile: Profile) -> tuple[str, ...]:
        """Return the rows of the rule table that fire."""
        return (self.rule,) if self.alone else (self.rule, *profile.rules[self.rule].together_with)

    def all_bits(self, profile: Profile) -> int:
        """Return the bits that the rows set together; see `bits_of`."""
        return reduce(or_, (bits_of(row, profile) for row in self.rows(profile)))


def bits_of(row: str, profile: Profile) -> int:
    """Return the bits that a broken rule sets: bits of word 0, and errors of word 1 from bit 16."""
    rule = profile.rules[row]
    return (rule.if_broken or rule.sets) & (WORD_0 | profile.further_errors)


class Latches:
    """Status bits that stay until they are cleared.

    Attributes:
        bits: word 0 without the motion bits in bits 0 to 15, and errors of word 1 from bit 16.
        causes: the id of the rule that set each error bit.
    """

    def __init__(self, events: list[Event], profile: Profile = WORDS_3601) -> None:
        self.profile = profile
        self.bits = MODULE_OK
        self.causes: dict[int, str] = {}
        self._events = events

    def fire(self, now_ns: int, rule_id: str, *, alone: bool = False) -> int:
        """Set and report the bits of a rule and of the rules with the same cause; return the bits.

        `note` reports a rule without bits; `show` sets bits without a rule.

        Args:
            alone: fire without the rows that usually fire together with it.
        """
        fault = BrokenRule(rule_id, alone)
        for row in fault.rows(self.profile):
            self._set(now_ns, row, bits_of(row, self.profile))
        return fault.all_bits(self.profile)

    def note(self, now_ns: int, rule_id: str) -> None:
        """Report a rule, but do not set its bits, because an option has switched them off."""
        self._set(now_ns, rule_id, 0)

    def _set(self, now_ns: int, rule_id: str, bits: int) -> None:
        """Set bits, store the rule as the cause of each new error bit, and report the rule as an event."""
        rule = self.profile.rules[rule_id]
        new_bits = bits & ~self.bits & self.profile.error_bits
        self.causes.update((bit, rule_id) for bit in self.profile.masks.values() if bit & new_bits)
        self.bits |= bits
        fields: dict[str, JsonValue] = {"bits": self._names(bits), "section": rule.section}
        self._events.append(Event(now_ns, "rule", rule_id, rule.event, fields))

    def show(self, now_ns: int, kind: str, name: str, bits: int, text: str) -> int:
        """Set bits for a reason outside the manual's rules, and report the reason; return the bits."""
        self.bits |= bits
        self._events.append(Event(now_ns, kind, name, text, {"bits": self._names(bits)}))
        return bits

    def _names(self, bits: int) -> list[str]:
        return [name for name, mask in self.profile.masks.items() if mask & bits]

    def clear(self, bits: int) -> None:
        """Clear bits and their causes."""
        self.bits &= ~bits
        for bit in [bit for bit in self.causes if bit & bits]:
            del self.causes[bit]

    def complete(self, bit: int) -> None:
        """Set a completion bit, and clear the others."""
        self.bits = self.bits & ~COMPLETION | bit
