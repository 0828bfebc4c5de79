"""Word names of a 3601, shared by compatible modules."""

from __future__ import annotations

from ..module_words import PLAIN_WORDS, ModuleWords, flag_places
from .bits import PROFILE_BITS, CommandLsw, CommandMsw, StatusLsw, StatusMsw

# fmt: off
WORDS_3601 = ModuleWords(
    "Amci3601",
    # chapter 5, output data in command mode    chapter 6, input data in command mode
    outputs=("command_msw", "command_lsw",      "target_msw", "target_lsw",
             "speed_msw", "speed_lsw",          "acceleration", "deceleration"),
    inputs=("status_msw", "status_lsw",         "position_msw", "position_lsw",
            "encoder_msw", "encoder_lsw",       "captured_msw", "captured_lsw"),
    groups={
        "command": flag_places("O", CommandMsw, CommandLsw),
        "status": flag_places("I", StatusMsw, StatusLsw),
    },
    profile=PROFILE_BITS,
    # chapter 6, Status Word MSW: bits 8, 9, 11, 12, 13
    errors=("HOME_INVALID", "INVALID_PROFILE", "INPUT_ERROR", "COMMAND_ERROR", "CONFIG_ERROR"),
)
# fmt: on


def is_stepper(words: ModuleWords) -> bool:
    """Whether a module has the words of a 3601."""
    return words == WORDS_3601


def may_be_stepper(words: ModuleWords) -> bool:
    """Whether a module has the words of a 3601, or unnamed words.

    A user's own 3601-compatible module need not name them.

    >>> may_be_stepper(PLAIN_WORDS), is_stepper(PLAIN_WORDS)
    (True, False)
    """
    return words in (WORDS_3601, PLAIN_WORDS)
