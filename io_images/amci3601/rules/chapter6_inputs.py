"""Chapter 6: the Module OK flag, the inputs, the encoder; and the manual's revision history."""

from __future__ import annotations

from ..firmware import FW_2_1, FW_3_1, FW_4_1
from .rule import (
    COMMAND_ERROR,
    CONFIG_ERROR,
    HOLD_STATE,
    INPUT_ERROR,
    INVALID_PROFILE,
    MODULE_OK,
    MOVING_CCW,
    MOVING_CW,
    POSITION_INVALID,
    STOPPED,
    Rule,
)

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

MOTION = MOVING_CW | MOVING_CCW
CUT = STOPPED | POSITION_INVALID | INPUT_ERROR

ROWS: tuple[Rule, ...] = (
    Rule("MOK-01", "chapter 6, The Module OK Flag",
         "Module OK is set as long as the module operates; only a fatal error clears it.",
         MODULE_OK, reading=("A-88",)),
    # Capture Input
    Rule("CAP-01", "chapter 6, Capture Input",
         "The capture input becoming active copies the current position to the captured value if no "
         "quadrature encoder is configured.",
         firmware_from=FW_2_1, reading=("A-69",)),
    Rule("CAP-02", "chapter 6, Capture Input",
         "The capture input becoming active copies the encoder value to the captured value if a quadrature "
         "encoder is configured."),
    Rule("CAP-03", "chapter 6, Capture Input",
         "The captured value stays until the capture input becomes active the next time."),
    # External Input
    Rule("EXT-01", "chapter 6, External Input",
         "The external input stops a manual move with deceleration and leaves the position valid.",
         STOPPED),
    Rule("EXT-02", "chapter 6, External Input",
         "The external input stops an absolute or relative move with deceleration and puts it in a hold "
         "state.",
         HOLD_STATE),
    Rule("EXT-03", "chapter 6, External Input",
         "A move that is started with the external input active makes one step and stops.",
         reading=("A-46", "A-47")),
    Rule("EXT-05", "chapter 6, External Input",
         "A registration move was started with the external input active.",
         COMMAND_ERROR | INVALID_PROFILE, firmware_from=FW_3_1),
    Rule("FOL-08", "chapter 6, External Input",
         "The external input has no effect on the encoder follower.",
         firmware_from=FW_4_1),
    # Emergency Stop Input and end limits
    Rule("EST-01", "chapter 6, Emergency Stop Input",
         "The emergency stop input cuts off the steps at once, without deceleration.",
         CUT, MOTION),
    Rule("EST-02", "chapter 6, Emergency Stop Input",
         "The emergency stop input makes the position invalid if the axis was moving when it became active.",
         POSITION_INVALID, reading=("A-15",)),
    Rule("EST-03", "chapter 6, Emergency Stop Input",
         "Relative and manual moves are possible after an emergency stop; an absolute move needs a preset or "
         "homing first.",
         reading=("A-16",)),
    # Manual Revision History
    Rule("CFG-29", "Manual Revision History, revision 0.1",
         "The configuration uses the capture input without the quadrature encoder, which needs firmware 2.1.",
         CONFIG_ERROR, together_with=("CER-02",), firmware_until=FW_2_1),
)
# fmt: on
