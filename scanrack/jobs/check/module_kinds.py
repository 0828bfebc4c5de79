"""Names of the commands and status bits of a 3601, for rules and collectors of all languages."""

from __future__ import annotations

from scanrack.io_images.amci3601 import CommandMsw, StatusMsw

NEWEST = "4.1"
"""The assumed firmware of a module if none is given."""

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
"""Commands by their bit in output word 0."""

MOVING = frozenset(str(bit.name) for bit in (StatusMsw.MOVING_CW, StatusMsw.MOVING_CCW))
OFF_AT_END = MOVING | {str(StatusMsw.POSITION_INVALID.name)}
"""Status bits that are off when a motion has ended. No other status bit shows that by being off."""


def kinds_of(word: int) -> list[str]:
    """Return the commands in output word 0; none for a configuration."""
    return [] if word & MODE_CONFIG else [kind for bit, kind in KINDS.items() if word & bit]


def bits_of(kind: str) -> int:
    """Return the bits of output word 0 that give a command, in either direction; 0 for other commands."""
    return sum(bit for bit, each in KINDS.items() if each == kind)


def first_kind(bits: int) -> str:
    """Return the first command in bits of output word 0; "" if there is none."""
    return next((kind for bit, kind in KINDS.items() if bits & bit), "")


def command_bits(sets: int, clears: int) -> tuple[int, int]:
    """Return the command bits that a write of output word 0 sets and clears; none for a configuration."""
    return (0, 0xFFFF) if sets & MODE_CONFIG else (sets, clears)
