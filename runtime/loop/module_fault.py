"""Faults in which a module stops answering; no command causes them.

    fault           input image the PLC sees        the module itself
    LINK_LOST       the last one                    continues without words, like a PLC that
                                                    leaves run mode; Axis Err solid
    REMOVED         zeros                           without power; powers up when reinserted
    FATAL_ERROR     MODULE_OK clear, rest held      stops at once until power is cycled;
                                                    both axis lights alternate
    ASIC_LOST       the last one                    like LINK_LOST; both axis lights blink

The manual describes these states only by their lights and the Module OK bit [chapter 1, Front Panel;
chapter 6, The Module OK Flag; readings A-88, A-117]; `runtime.modules.amci3601.trouble` has the image
bit by bit. These faults occur only when a test of the user's logic injects them.
"""

from __future__ import annotations

from enum import Enum


class ModuleFault(Enum):
    """A way in which a module stops answering."""

    LINK_LOST = "link-lost"
    REMOVED = "removed"
    FATAL_ERROR = "fatal-error"
    ASIC_LOST = "asic-lost"
