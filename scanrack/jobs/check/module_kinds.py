"""Names of the commands and status bits of a 3601, for rules and collectors of all languages."""

from __future__ import annotations

from typing import Any

from scanrack.io_images.amci3601 import CommandMsw, Limits, StatusMsw
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MAX
from scanrack.io_images.thousands import PARAMETER_MAX, PARAMETER_MIN

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
"""Status bits that are off when a motion has ended. No other status bit shows an end when it is off."""


def shows_end(status: str, *, on: bool) -> bool:
    """Whether a status bit that is on (or off) may show that a motion has ended."""
    return status not in MOVING if on else status in OFF_AT_END


FROM_STARTING_SPEED = ("home", "move_to", "move_by")
"""Commands whose speed must reach the starting speed [3601 manual, chapter 6, Invalid Profile 1]."""

RUNNING = ("run", "register", "gear")
"""Commands with the sign of the speed as direction: manual moves, registration moves, and the follower."""


def allowed(kind: str, limits: Limits) -> dict[str, tuple[int, int]]:
    """Return the lowest and highest value of each argument of a command [chapter 5, notes 4 to 8]."""
    least = 0 if kind in RUNNING else 1
    return {
        "position": (PARAMETER_MIN, PARAMETER_MAX),
        "distance": (0 if kind == "store_minimum" else PARAMETER_MIN, PARAMETER_MAX),
        "register": (1, PARAMETER_MAX),
        "speed": (-limits.speed if kind in RUNNING else 1, limits.speed),
        "acceleration": (least, limits.rate),
        "deceleration": (least, limits.rate),
        "final_deceleration": (1, limits.rate),
        "numerator": (-WORD_MAX, WORD_MAX),
        "denominator": (1, WORD_MAX),
    }


def kinds_of(word: int) -> list[str]:
    """Return the commands in output word 0; none for a configuration."""
    return [] if word & MODE_CONFIG else [kind for bit, kind in KINDS.items() if word & bit]


def bits_of(kind: str) -> int:
    """Return the bits of output word 0 that send a command, in either direction; 0 for other commands."""
    return sum(bit for bit, name in KINDS.items() if name == kind)


def action_fields(sets: int, clears: int) -> dict[str, Any]:
    """Return the fields of a `StepAction` for a write of output word 0: its command and its bits."""
    if sets & MODE_CONFIG:
        sets, clears = 0, UNSIGNED_MAX
    kind = next(iter(kinds_of(sets)), "")
    return {"kind": kind, "text": f"the command {kind}", "sets": sets, "clears": clears}
