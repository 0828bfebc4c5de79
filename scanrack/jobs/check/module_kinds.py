"""Commands and status bits of a 3601 as rules and collectors of all languages name them."""

from __future__ import annotations

from scanrack.io_images.amci3601 import CommandMsw, StatusMsw

NEWEST = "4.1"
"""The firmware of a module whose firmware is not given."""

MODE_CONFIG = CommandMsw.MODE_CONFIG.value
"""The bit of output word 0 that requests configuration mode."""

SEARCHES = (CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW).value
MOVES = (CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE).value

KINDS = {
    CommandMsw.ABSOLUTE_MOVE.value: "move_to",
    CommandMsw.RELATIVE_MOVE.value: "move_by",
    CommandMsw.FIND_HOME_CW.value: "home",
    CommandMsw.FIND_HOME_CCW.value: "home",
    CommandMsw.RUN_BLEND_CW.value: "run_blend",
    CommandMsw.RUN_BLEND_CCW.value: "run_blend",
    CommandMsw.PRESET_POSITION.value: "set_position",
    CommandMsw.MANUAL_CW.value: "run",
    CommandMsw.MANUAL_CCW.value: "run",
}
"""Commands by their bit of output word 0."""

MOVING = frozenset(str(bit.name) for bit in (StatusMsw.MOVING_CW, StatusMsw.MOVING_CCW))
OFF_AT_END = MOVING | {str(StatusMsw.POSITION_INVALID.name)}
"""Status bits that are off when a motion has ended; of the others none says so while it is off."""


def kinds_of(word: int) -> list[str]:
    """Return the commands in output word 0; none in a configuration."""
    return [] if word & MODE_CONFIG else [kind for bit, kind in KINDS.items() if word & bit]


def first_kind(bits: int) -> str:
    """Return the command that bits of output word 0 give; "" for none."""
    return next((kind for bit, kind in KINDS.items() if bits & bit), "")


def command_bits(sets: int, clears: int) -> tuple[int, int]:
    """Return the bits that a write of output word 0 sets and clears as commands: a configuration has none."""
    return (0, 0xFFFF) if sets & MODE_CONFIG else (sets, clears)
