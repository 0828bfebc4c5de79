"""Chapter 4: encoder moves, diagnostic feedback, encoder follower, acceleration types."""

from __future__ import annotations

from ..firmware import FW_4_1
from .rule import (
    COMMAND_ERROR,
    ENC_FOLLOWER,
    INPUT_ERROR,
    INVALID_PROFILE,
    MOVE_COMPLETE,
    POSITION_INVALID,
    STOPPED,
    Rule,
)

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

ROWS: tuple[Rule, ...] = (
    # Encoder Move
    Rule("ENC-01", "chapter 4, Encoder Move",
         "Bit 2 of the command LSW makes an absolute or relative move an encoder move: its target is in "
         "encoder counts."),
    Rule("ENC-02", "chapter 4, Encoder Move",
         "An encoder move begins to decelerate when its count is reached, so it overshoots; Move Complete is "
         "set after the stop.",
         MOVE_COMPLETE, reading=("A-95",)),
    Rule("ENC-12", "chapter 4, Encoder Move",
         "The encoder is decoded X4 from both A and B, and is counted whether a profile runs or not."),
    Rule("ENC-03", "chapter 4, Encoder Move",
         "An absolute encoder move runs counter-clockwise if its target is below the encoder value.",
         reading=("A-51",)),
    Rule("ENC-04", "chapter 4, Encoder Move",
         "A relative encoder move runs counter-clockwise only if its target is negative."),
    Rule("ENC-05", "chapter 4, Encoder Move",
         "An encoder move was commanded on a module that is not configured to use an encoder.",
         COMMAND_ERROR | INVALID_PROFILE, together_with=("PRF-11",), reading=("A-50",)),
    Rule("ENC-06", "chapter 4, Encoder Move",
         "An encoder move cannot be held; a Hold command does not affect its motion.",
         reading=("A-23",)),
    Rule("ENC-07", "chapter 4, Encoder Move",
         "An encoder move decelerates and stops when the external input becomes active.",
         reading=("A-49",)),
    Rule("EXT-06", "chapter 4, Encoder Move",
         "The external input stops an encoder move with deceleration.",
         reading=("A-48", "A-49")),
    Rule("ENC-08", "chapter 4, Encoder Move",
         "The encoder move bit has no effect on manual moves and homing."),
    Rule("ENC-09", "chapter 4, Encoder Move",
         "The encoder move bit has to be reset before a move is measured in steps again."),
    Rule("ENC-10", "chapter 4, Encoder Move",
         "Without a working encoder an encoder move goes on until the emergency stop, the external input or "
         "Immediate Stop ends it."),
    Rule("ENC-11", "chapter 4, Encoder Move",
         "Resetting the command LSW during an encoder move makes it run past its count; resetting the MSW "
         "alone does no harm.",
         reading=("A-52",)),
    # Diagnostic Feedback
    Rule("DFB-01", "chapter 4, Diagnostic Feedback",
         "With diagnostic feedback the module counts its own steps and reports them in input words 4 and 5."),
    # Encoder Follower Function
    Rule("FOL-19", "chapter 4, Encoder Follower Function",
         "The encoder follower exists from firmware 4.1 on.",
         firmware_from=FW_4_1, reading=("A-67",)),
    Rule("FOL-02", "chapter 4, Encoder Follower Function",
         "The follower takes the multiplier from word 2, the divisor from word 3, both 1 to 32,767, zero in "
         "words 4 and 5, and rates of 0 to 2000 from words 6 and 7.",
         if_broken=COMMAND_ERROR, firmware_from=FW_4_1, reading=("A-103",)),
    Rule("FOL-01", "chapter 4, Encoder Follower Function",
         "Bit 7 of the command LSW selects encoder follower mode, and bit 7 of the status LSW confirms it.",
         ENC_FOLLOWER, firmware_from=FW_4_1),
    Rule("FOL-03", "chapter 4, Encoder Follower Function",
         "The CW manual bit makes the axis follow in the direction of the encoder, the CCW manual bit in the "
         "opposite one.",
         firmware_from=FW_4_1),
    Rule("FOL-04", "chapter 4, Encoder Follower Function",
         "In encoder follower mode nothing moves while neither manual bit is set.",
         firmware_from=FW_4_1),
    Rule("FOL-05", "chapter 4, Encoder Follower Function",
         "The follower's steps are encoder counts times multiplier over divisor; both may be changed while "
         "it follows.",
         firmware_from=FW_4_1, reading=("A-66",)),
    Rule("FOL-10", "chapter 4, Encoder Follower Function",
         "With rates of zero the follower jumps to a new speed, otherwise it ramps; the number of steps is "
         "always exact.",
         firmware_from=FW_4_1, reading=("A-97", "A-103")),
    Rule("FOL-18", "chapter 4, Encoder Follower Function",
         "S-curve acceleration was selected in encoder follower mode.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("FOL-07", "chapter 4, Encoder Follower Function",
         "The encoder follower cannot be started while an end limit switch is active.",
         firmware_from=FW_4_1, reading=("A-63",)),
    Rule("FOL-09", "chapter 4, General Notes 4",
         "An end limit switch that is reached in encoder follower mode stops the axis as in any other move.",
         INPUT_ERROR | POSITION_INVALID | STOPPED, firmware_from=FW_4_1, reading=("A-17",)),
    # New Error Bit Functions
    Rule("FOL-11", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "Encoder follower mode was selected on a module that is not configured to use an encoder.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("FOL-12", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "Encoder follower mode was selected while the axis was moving; the move runs to completion.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("FOL-13", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "The follower's multiplier or divisor was outside 1 to 32,767; the steps stop.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("FOL-14", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "The programmed speed words (output words 4 and 5) were not zero in encoder follower mode; the "
         "steps stop.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("FOL-15", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "The follower's direction was changed without a scan in between with a command word of zero; the "
         "steps stop.",
         COMMAND_ERROR, firmware_from=FW_4_1, reading=("A-64",)),
    Rule("FOL-16", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "A command other than the two manual moves was given in encoder follower mode; the steps stop.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("FOL-17", "chapter 4, Encoder Follower Function, New Error Bit Functions",
         "The follower bit was reset while a manual move bit was still set; the steps stop.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    # Acceleration Types
    Rule("PRO-12", "chapter 4, Acceleration Types",
         "S-curve acceleration is not available for homing and the encoder follower.",
         COMMAND_ERROR),
    Rule("PRO-10", "chapter 4, Acceleration Types note 1",
         "The selected acceleration type shapes the deceleration, too."),
    Rule("PRO-11", "chapter 4, Acceleration Types note 3",
         "The middle part of a trapezoidal S-curve, with constant acceleration, takes half of the ramp's "
         "time.",
         untestable_because="positions are reported in whole steps, which is too coarse to tell"),
)
# fmt: on
