"""Chapter 4: manual moves, presets, Reset Errors, the general notes."""

from __future__ import annotations

from ..firmware import FW_3_1
from .rule import (
    ACCELERATING,
    COMMAND_ERROR,
    DECELERATING,
    HOME_INVALID,
    INPUT_ERROR,
    INVALID_PROFILE,
    MOVING_CCW,
    MOVING_CW,
    NONE,
    POSITION_INVALID,
    STOPPED,
    Rule,
)

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

MOTION = MOVING_CW | MOVING_CCW
CUT_BY_INPUT = STOPPED | POSITION_INVALID | INPUT_ERROR
NOT_SAID = "the manual does not say what happens otherwise"

ROWS: tuple[Rule, ...] = (
    # Manual Move
    Rule("MAN-01", "chapter 4, Manual Move",
         "A manual move runs in the commanded direction as long as its command bit is set.",
         MOTION),
    Rule("MAN-18", "chapter 4, Manual Move",
         "The encoder move bit is ignored in a manual move."),
    Rule("MAN-02", "chapter 4, Manual Move",
         "A manual move at or below the starting speed jumps to its speed; acceleration and deceleration are "
         "ignored.",
         reading=("A-81",)),
    Rule("MAN-03", "chapter 4, Manual Move",
         "The speed of a manual move in constant speed mode was changed; it was stopped.",
         COMMAND_ERROR | INVALID_PROFILE | STOPPED, reading=("A-42",)),
    Rule("MAN-04", "chapter 4, Manual Move",
         "A manual move above the starting speed begins at the starting speed, accelerates to the programmed "
         "speed and keeps it.",
         ACCELERATING),
    Rule("MAN-05", "chapter 4, Manual Move",
         "A manual move whose command bit is turned off decelerates to the starting speed and stops.",
         STOPPED),
    Rule("MAN-06", "chapter 4, Manual Move",
         "A manual move decelerates and stops when the external input becomes active.",
         STOPPED, reading=("A-46",)),
    Rule("MAN-07", "chapter 4, Manual Move",
         "A manual move stops without deceleration on Immediate Stop.",
         STOPPED | POSITION_INVALID),
    Rule("MAN-08", "chapter 4, Manual Move",
         "A manual move stops without deceleration when the emergency stop input becomes active.",
         CUT_BY_INPUT),
    Rule("MAN-09", "chapter 4, Manual Move",
         "A manual move stops without deceleration when it reaches the end limit switch in its direction.",
         CUT_BY_INPUT),
    Rule("MAN-17", "chapter 4, Manual Move",
         "A manual move was stopped by setting all eight output words to zero; only the command word should "
         "be reset.",
         COMMAND_ERROR, firmware_until=FW_3_1, reading=("A-39",)),
    Rule("MAN-20", "chapter 4, Manual Move",
         "A manual move that is stopped with deceleration keeps its position valid."),
    Rule("MAN-11", "chapter 4, Manual Move",
         "The speed of a manual move that began above the starting speed may be changed while it runs; the "
         "axis ramps to it.",
         ACCELERATING | DECELERATING),
    Rule("MAN-12", "chapter 4, Manual Move",
         "The new speed of a running manual move may be below the starting speed."),
    Rule("MAN-13", "chapter 4, Manual Move",
         "New acceleration and deceleration of a running manual move take effect only when the speed is "
         "changed."),
    Rule("MAN-14", "chapter 4, Manual Move",
         "The speed of a running manual move was changed while speed, acceleration or deceleration was "
         "invalid; the axis decelerates at once and stops.",
         COMMAND_ERROR | INVALID_PROFILE | STOPPED, reading=("A-40", "A-41", "A-104")),
    Rule("MAN-15", "chapter 4, Manual Move",
         "A manual move with a programmed speed of zero makes exactly one step.",
         reading=("A-43", "A-44")),
    Rule("MAN-16", "chapter 4, Manual Move",
         "After a one-shot manual move the direction bit stays on until the command bit is reset, and "
         "Stopped is not set then.",
         MOTION, STOPPED, reading=("A-43",)),
    Rule("LIM-02", "chapter 4, Manual Move",
         "Only the end limit switch in the direction of motion stops a manual or registration move.",
         CUT_BY_INPUT),
    Rule("MAN-10", "chapter 4, Manual Move",
         "The end limit switch opposite to the direction of motion does not stop a manual move, so that the "
         "axis can be moved off it."),
    # Presets
    Rule("PST-01", "chapter 4, Preset Current Position",
         "Preset Position sets the current position to the target position words; it is not accepted during "
         "a motion.",
         if_broken=COMMAND_ERROR, reading=("A-82",)),
    Rule("DFB-02", "chapter 4, Preset Current Position",
         "Preset Position sets the diagnostic feedback count, too."),
    Rule("PST-05", "chapter 4, Preset Current Position",
         "With diagnostic feedback, the count takes the same value as the preset position."),
    Rule("PST-02", "chapter 4, Preset Current Position",
         "Preset Position makes the position valid.",
         NONE, POSITION_INVALID),
    Rule("PST-03", "chapter 4, Preset Current Position",
         "A preset needs programmed speed, acceleration and deceleration words of zero.",
         COMMAND_ERROR),
    Rule("PST-06", "chapter 4, Preset Encoder Position",
         "Preset Encoder sets the encoder value to the target position words and leaves the position alone; "
         "it is not accepted during a motion.",
         if_broken=COMMAND_ERROR, reading=("A-82",)),
    Rule("PST-07", "chapter 4, Preset Encoder Position",
         "Preset Encoder needs a module that is configured to use an encoder.",
         COMMAND_ERROR, reading=("A-70",)),
    # Reset Errors
    Rule("RST-01", "chapter 4, Reset Errors",
         "Reset Errors clears all errors that can be recovered from.",
         NONE, COMMAND_ERROR | INVALID_PROFILE | HOME_INVALID | INPUT_ERROR, reading=("A-85", "A-87")),
    Rule("RST-02", "chapter 4, Reset Errors",
         "The lower command word (output word 1) must be zero when Reset Errors is given.",
         if_broken=COMMAND_ERROR, untestable_because=NOT_SAID, reading=("A-31", "A-92")),
    Rule("RST-03", "chapter 4, Reset Errors",
         "With a command error, nothing but Reset Errors is accepted; a running move is not affected."),
    # General Command Mode Operation Notes
    Rule("IOM-18", "chapter 4, General Notes 1",
         "Only one bit may be set in the command word (output word 0) at a time.",
         COMMAND_ERROR),
    Rule("GEN-01", "chapter 4, General Notes 1",
         "A command word should be written as a whole, with an instruction that copies words.",
         untestable_because="it is advice for the PLC's program"),
    Rule("MOV-10", "chapter 4, General Notes 2",
         "A move should be started only while Move Complete, Stopped or Hold is set.",
         COMMAND_ERROR, reading=("A-02",)),
    Rule("IOM-19", "chapter 4, General Notes 3",
         "Only the change of a command bit from 0 to 1 starts an operation; a bit that stays set does "
         "nothing more.",
         reading=("A-11", "A-34")),
    Rule("GEN-04", "chapter 4, General Notes 4",
         "An end limit switch that is reached acts like an emergency stop: the motor stops and the position "
         "becomes invalid.",
         CUT_BY_INPUT),
    Rule("GEN-05", "chapter 4, General Notes 5",
         "Homing may start from an end limit switch."),
)
# fmt: on
