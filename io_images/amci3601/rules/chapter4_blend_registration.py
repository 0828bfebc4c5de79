"""Chapter 4: blend moves and registration moves."""

from __future__ import annotations

from ..firmware import FW_3_1
from .rule import COMMAND_ERROR, INVALID_PROFILE, MIN_REG_NONZERO, NONE, STOPPED, Rule

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

REFUSED = COMMAND_ERROR | INVALID_PROFILE

ROWS: tuple[Rule, ...] = (
    # Blend Move
    Rule("BLD-01", "chapter 4, Blend Move",
         "A blend move has two to sixteen segments, each with a relative length, a target speed, a rate and "
         "an acceleration type."),
    Rule("BLD-17", "chapter 4, Blend Move",
         "Two consecutive blend segments had the same target speed.",
         INVALID_PROFILE),
    Rule("BLD-24", "chapter 4, Blend Move",
         "A blend profile is kept until power is removed, the module is configured or a new profile is "
         "programmed."),
    Rule("CFG-24", "chapter 4, Blend Move",
         "Programming the configuration erases the stored blend profile."),
    Rule("BLD-06", "chapter 4, Blend Move",
         "A blend profile is relative, so the position need not be valid."),
    Rule("BLD-10", "chapter 4, Blend Move",
         "The first blend segment starts at the starting speed, each further one at the speed of the one "
         "before it, and the last one decelerates to the starting speed and stops.",
         reading=("A-58",)),
    Rule("BLD-08", "chapter 4, Blend Move",
         "One command bit runs the whole blend profile clockwise, another counter-clockwise; it cannot "
         "reverse on its way.",
         reading=("A-61",)),
    Rule("BLD-07", "chapter 4, Blend Move",
         "The stored blend profile can be run more than once and from any position."),
    Rule("BLD-09", "chapter 4, Blend Move",
         "Other moves and homing may run between two runs of the blend profile."),
    # Registration Move
    Rule("REG-17", "chapter 4, Registration Move",
         "Registration moves exist from firmware 3.1 on.",
         firmware_from=FW_3_1),
    Rule("REG-01", "chapter 4, Registration Move",
         "A manual move with target position words of zero is a plain manual move; any other target makes it "
         "a registration move.",
         firmware_from=FW_3_1, reading=("A-98",)),
    Rule("REG-02", "chapter 4, Registration Move",
         "After its registration input a registration move makes exactly the target number of steps, "
         "deceleration included.",
         STOPPED, firmware_from=FW_3_1, reading=("A-55",)),
    Rule("REG-03", "chapter 4, Registration Move",
         "The registration input is the reset of the manual move bit, or the external input becoming active.",
         firmware_from=FW_3_1),
    Rule("REG-19", "chapter 4, Registration Move",
         "The target position words must not be changed during a registration move.",
         firmware_from=FW_3_1),
    Rule("REG-08", "chapter 4, Registration Move",
         "The speed of a registration move may be reduced before its registration input.",
         firmware_from=FW_3_1),
    Rule("REG-15", "chapter 4, Registration Move",
         "Changes of the programmed speed are ignored after the registration input.",
         firmware_from=FW_3_1),
    Rule("REG-09", "chapter 4, Registration Move",
         "Acceleration and deceleration must not be changed during a registration move; a change without a "
         "change of speed has no effect and raises no error.",
         firmware_from=FW_3_1),
    Rule("REG-18", "chapter 4, Registration Move",
         "A registration move counts steps and cannot be run as an encoder move.",
         firmware_from=FW_3_1, untestable_because="a manual move ignores the encoder move bit anyway"),
    Rule("REG-07", "chapter 4, Registration Move",
         "The minimum registration distance is measured from the start of the move.",
         firmware_from=FW_3_1),
    Rule("REG-04", "chapter 4, Registration Move",
         "With a minimum registration distance, the registration input is ignored until more steps than that "
         "have been made.",
         firmware_from=FW_3_1, reading=("A-53",)),
    Rule("REG-06", "chapter 4, Registration Move",
         "Beyond the minimum registration distance the level of the registration input counts; no transition "
         "is needed.",
         firmware_from=FW_3_1),
    Rule("REG-05", "chapter 4, Registration Move",
         "The minimum registration distance is programmed beforehand and serves every registration move from "
         "then on.",
         firmware_from=FW_3_1),
    Rule("REG-11", "chapter 4, Registration Move",
         "The minimum registration distance is 0 to 8,388,607 steps.",
         firmware_from=FW_3_1),
    Rule("REG-12", "chapter 4, Registration Move",
         "A minimum registration distance of zero turns the function off; any other sets its status bit.",
         MIN_REG_NONZERO, firmware_from=FW_3_1),
    Rule("REG-14", "chapter 4, Registration Move",
         "Power-up and configuration set the minimum registration distance to zero.",
         NONE, MIN_REG_NONZERO, firmware_from=FW_3_1),
    Rule("CFG-25", "chapter 4, Registration Move",
         "A configuration that was accepted leaves no minimum registration distance.",
         NONE, MIN_REG_NONZERO, firmware_from=FW_3_1),
    Rule("REG-16", "chapter 4, Registration Move",
         "The end limit switch opposite to the direction of motion does not stop a registration move.",
         firmware_from=FW_3_1),
    Rule("REG-10", "chapter 4, Registration Move, New Command Bit",
         "The minimum registration distance is programmed with word 0 zero, bit 10 of word 1 set, the "
         "distance in words 2 and 3, and words 4 to 7 zero.",
         if_broken=COMMAND_ERROR, firmware_from=FW_3_1, reading=("A-93", "A-114")),
    # New Error Bit Functions
    Rule("REG-13", "chapter 4, Registration Move, New Error Bit Functions",
         "The minimum registration distance was negative or above 8,388,607.",
         COMMAND_ERROR, firmware_from=FW_3_1),
    Rule("REG-27", "chapter 4, Registration Move, New Error Bit Functions",
         "A Hold command was given during a registration move; the axis stops with its deceleration.",
         COMMAND_ERROR, firmware_from=FW_3_1, reading=("A-54",)),
    Rule("REG-22", "chapter 4, Registration Move, New Error Bit Functions",
         "A registration move was started with the external input active, which is refused with and without "
         "a minimum distance.",
         REFUSED, firmware_from=FW_3_1),
    Rule("REG-20", "chapter 4, Registration Move, New Error Bit Functions",
         "A registration move was given fewer steps than it needs to decelerate and stop; it did not start.",
         REFUSED, firmware_from=FW_3_1),
    Rule("REG-21", "chapter 4, Registration Move, New Error Bit Functions",
         "A registration move was given a negative number of steps.",
         REFUSED, firmware_from=FW_3_1),
    Rule("REG-23", "chapter 4, Registration Move, New Error Bit Functions",
         "The target position words were filled while a plain manual move was running; it was stopped.",
         REFUSED, firmware_from=FW_3_1, reading=("A-56",)),
    Rule("REG-24", "chapter 4, Registration Move, New Error Bit Functions",
         "The target position words were changed while a registration move was running; it was stopped.",
         REFUSED, firmware_from=FW_3_1, reading=("A-56",)),
    Rule("REG-25", "chapter 4, Registration Move, New Error Bit Functions",
         "The speed of a running registration move was increased; it was stopped.",
         REFUSED, firmware_from=FW_3_1, reading=("A-56",)),
    Rule("REG-26", "chapter 4, Registration Move, New Error Bit Functions",
         "Acceleration or deceleration was changed together with the speed of a registration move; it was "
         "stopped.",
         REFUSED, firmware_from=FW_3_1, reading=("A-56",)),
)
# fmt: on
