"""A 3401, a stepper of POINT I/O: four input words, or six behind a ControlLogix [manual 2.0, pages 29, 34].

Two pages of its manual are known. Commands that they do not name are refused by name; the commands that they
name, the configuration and all that they leave open are as of a 3601.
"""

from dataclasses import replace

from scanrack.modules import WORDS_3601, ImageForm, stepper

NAMED = {
    "ABSOLUTE_MOVE",
    "RELATIVE_MOVE",
    "HOLD_MOVE",
    "IMMEDIATE_STOP",
    "FIND_HOME_CW",
    "FIND_HOME_CCW",
    "RESET_ERRORS",
    "MODE_CONFIG",
}
"""Moves, hold, stop, homing, errors, and the mode flag."""

WORDS = replace(WORDS_3601, message="Amci3401", undescribed=frozenset(WORDS_3601.groups["command"]) - NAMED)
INPUTS = ("status_msw", "status_lsw", "position_msw", "position_lsw")

RECORD = stepper(WORDS, ImageForm(INPUTS))
CONTROLLOGIX = stepper(WORDS, ImageForm(("zero0", "zero1", *INPUTS)))
