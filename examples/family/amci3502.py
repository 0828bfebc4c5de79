"""A 3502, a stepper of SLC 500: negative numbers by sign and magnitude [manual 1.0, page 1].

Its manual is known from this page. Commands that it does not name are refused by name; the commands that it
names, the configuration and all that the page leaves open are as of a 3601.
"""

from dataclasses import replace

from scanrack.modules import WORDS_3601, ImageForm, NumberFormat, stepper

NAMED = {"ABSOLUTE_MOVE", "RELATIVE_MOVE", "FIND_HOME_CW", "FIND_HOME_CCW", "RESET_ERRORS", "MODE_CONFIG"}
"""Moves with distance, speed and rates, homing, and the mode flag. Without Reset Errors no error ends."""

WORDS = replace(WORDS_3601, message="Amci3502", undescribed=frozenset(WORDS_3601.groups["command"]) - NAMED)

RECORD = stepper(WORDS, ImageForm(numbers=NumberFormat.SIGN_MAGNITUDE))
