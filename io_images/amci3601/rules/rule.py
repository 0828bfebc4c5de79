"""One row of the rule table, and its status bits.

A rule can set bits of both status words, so a mask covers both: input word 0 in bits 0 to 15, input word 1
from bit 16.
"""

from __future__ import annotations

from typing import TypeAlias

from ...dataclass import dataclass
from ..bits import StatusLsw, StatusMsw
from ..firmware import Firmware

StatusBits: TypeAlias = int
"""A mask over both status words: word 0 in bits 0 to 15, word 1 from bit 16."""

_LSW = 16

NONE = 0
MOVING_CW = StatusMsw.MOVING_CW.value
MOVING_CCW = StatusMsw.MOVING_CCW.value
HOLD_STATE = StatusMsw.HOLD_STATE.value
STOPPED = StatusMsw.STOPPED.value
AT_HOME = StatusMsw.AT_HOME.value
ACCELERATING = StatusMsw.ACCELERATING.value
DECELERATING = StatusMsw.DECELERATING.value
MOVE_COMPLETE = StatusMsw.MOVE_COMPLETE.value
HOME_INVALID = StatusMsw.HOME_INVALID.value
INVALID_PROFILE = StatusMsw.INVALID_PROFILE.value
POSITION_INVALID = StatusMsw.POSITION_INVALID.value
INPUT_ERROR = StatusMsw.INPUT_ERROR.value
COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
MODULE_OK = StatusMsw.MODULE_OK.value
MODE_CONFIG = StatusMsw.MODE_CONFIG.value
IN_CAPTURE = StatusLsw.IN_CAPTURE.value << _LSW
IN_EXTERNAL = StatusLsw.IN_EXTERNAL.value << _LSW
IN_HOME = StatusLsw.IN_HOME.value << _LSW
IN_ESTOP = StatusLsw.IN_ESTOP.value << _LSW
IN_CW_LIMIT = StatusLsw.IN_CW_LIMIT.value << _LSW
IN_CCW_LIMIT = StatusLsw.IN_CCW_LIMIT.value << _LSW
ENC_FOLLOWER = StatusLsw.ENC_FOLLOWER.value << _LSW
BLEND_RUNNING = StatusLsw.BLEND_RUNNING.value << _LSW
BLEND_ACK = StatusLsw.BLEND_ACK.value << _LSW
MIN_REG_NONZERO = StatusLsw.MIN_REG_NONZERO.value << _LSW
HOME_PROX_ECHO = StatusLsw.HOME_PROX_ECHO.value << _LSW

_NAMES = tuple((str(bit.name), bit.value) for bit in StatusMsw) + tuple(
    (str(bit.name), bit.value << _LSW) for bit in StatusLsw
)


def bit_names(bits: StatusBits) -> tuple[str, ...]:
    """Return the names of a rule's bits in word-and-bit order.

    >>> bit_names(ENC_FOLLOWER | STOPPED)
    ('STOPPED', 'ENC_FOLLOWER')
    """
    return tuple(name for name, mask in _NAMES if bits & mask)


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule of the 3601's manual.

    Attributes:
        id: prefix and number, for example "CMD-03"; rows of a list in chapter 6 have the numbers of the list.
        section: section of the manual.
        event: the text that traces show when the rule applies; it never changes.
        sets: status bits that the rule sets. Of the pairs MOVING_CW and MOVING_CCW, and ACCELERATING and
            DECELERATING, only the applicable bit is set. A row of a list in chapter 6 sets only the bit of
            that list.
        if_broken: status bits that the simulated module sets instead of `sets` when a command breaks the
            rule, because the manual does not state the consequence, or because other bits are already set.
        clears: status bits that the rule clears.
        list_of: the bit whose list in chapter 6 contains this row; None for other rows.
        together_with: ids of rows elsewhere that always apply together with this row.
        firmware_from: the first version with the rule; None if the rule has always existed.
        firmware_until: the first version without the rule; None if no version dropped it.
        untestable_because: why images can't show whether a module follows the rule; "" if they can.
        reading: readings ("A-36") of contradictions and gaps in the manual, see docs/readings.md.
        says: wording to use instead of `event` outside of traces; "" to use `event`.
    """

    id: str
    section: str
    event: str
    sets: StatusBits = NONE
    clears: StatusBits = NONE
    list_of: StatusBits | None = None
    together_with: tuple[str, ...] = ()
    firmware_from: Firmware | None = None
    firmware_until: Firmware | None = None
    untestable_because: str = ""
    reading: tuple[str, ...] = ()
    if_broken: StatusBits = NONE
    says: str = ""

    @property
    def text(self) -> str:
        """The text of the rule for users of a module.

        >>> Rule("CFG-02", "chapter 3", "The configuration has no limit.", says="No limit is set.").text
        'No limit is set.'
        """
        return self.says or self.event

    @property
    def clause(self) -> str:
        """The text as a clause of a sentence, with its section.

        >>> Rule("CFG-02", "chapter 3, Invalid Configurations 2", "The configuration has no limit.").clause
        'the configuration has no limit [CFG-02, chapter 3]'
        """
        source = f"[{self.id}, {self.section.partition(',')[0]}]"
        return f"{self.text[:1].lower()}{self.text[1:].removesuffix('.')} {source}"

    @property
    def testable(self) -> bool:
        """Whether images can show that a module follows the rule."""
        return not self.untestable_because

    def applies_to(self, firmware: Firmware) -> bool:
        """Return whether a module with this firmware has the rule."""
        has_begun = self.firmware_from is None or firmware >= self.firmware_from
        return has_begun and (self.firmware_until is None or firmware < self.firmware_until)
