"""Chapter 4: absolute and relative moves, hold, resume, immediate stop."""

from __future__ import annotations

from ..firmware import FW_4_1
from .rule import (
    ACCELERATING,
    COMMAND_ERROR,
    DECELERATING,
    HOLD_STATE,
    MOVE_COMPLETE,
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

ROWS: tuple[Rule, ...] = (
    Rule("CFG-17", "chapter 4, Command Mode Operations",
         "When configuration mode is left, the current position is zero and not valid.",
         POSITION_INVALID, reading=("A-102",)),
    # Absolute & Relative Moves
    Rule("MOV-01", "chapter 4, Absolute & Relative Moves",
         "An absolute move needs a valid position: the axis has to be homed or preset before.",
         COMMAND_ERROR),
    Rule("MOV-02", "chapter 4, Absolute & Relative Moves",
         "An absolute move makes as many steps as its target differs from the current position, and ends on "
         "the target.",
         MOVE_COMPLETE),
    Rule("MOV-03", "chapter 4, Absolute & Relative Moves",
         "An absolute move to a target above the current position runs clockwise.",
         MOVING_CW),
    Rule("MOV-04", "chapter 4, Absolute & Relative Moves",
         "An absolute move to a target below the current position runs counter-clockwise.",
         MOVING_CCW),
    Rule("MOV-06", "chapter 4, Absolute & Relative Moves",
         "A relative move does not need a valid position, and does not make it valid."),
    Rule("MOV-07", "chapter 4, Absolute & Relative Moves",
         "The target of a relative move is a signed distance that is added to the current position."),
    Rule("MOV-08", "chapter 4, Absolute & Relative Moves",
         "A relative move with a positive target runs clockwise.",
         MOVING_CW),
    Rule("MOV-09", "chapter 4, Absolute & Relative Moves",
         "A relative move with a negative target runs counter-clockwise.",
         MOVING_CCW),
    Rule("MOV-05", "chapter 4, Absolute & Relative Moves",
         "A move that ends without error sets Move Complete; an error prevents that and sets an error bit.",
         MOVE_COMPLETE, MOTION | ACCELERATING | DECELERATING, reading=("A-27", "A-35")),
    Rule("MOV-11", "chapter 4, Absolute & Relative Moves",
         "An absolute or relative move that is started with the external input active makes one step and "
         "goes into a hold state.",
         HOLD_STATE, reading=("A-47",)),
    # Hold Move
    Rule("HLD-01", "chapter 4, Hold Move",
         "Hold decelerates the move at its programmed rate to the starting speed, stops it and sets the hold "
         "state.",
         HOLD_STATE, MOTION),
    Rule("HLD-13", "chapter 4, Hold Move",
         "In a hold state speed, acceleration and deceleration may be changed; they take effect with Resume.",
         reading=("A-84",)),
    Rule("HLD-02", "chapter 4, Hold Move",
         "A Hold command was given with other command bits set.",
         COMMAND_ERROR, reading=("A-33",)),
    Rule("HLD-03", "chapter 4, Hold Move",
         "A target that is changed with the Resume command is ignored; the move ends on its old target."),
    Rule("HLD-04", "chapter 4, Hold Move",
         "Any command is accepted in a hold state, a new move included; Resume need not be the next one.",
         reading=("A-83",)),
    Rule("HLD-05", "chapter 4, Hold Move",
         "Output words 1 to 7 may hold anything when Hold is given."),
    Rule("HLD-06", "chapter 4, Hold Move",
         "A Hold command was given during homing; homing runs to completion.",
         COMMAND_ERROR, reading=("A-25",)),
    Rule("HLD-07", "chapter 4, Hold Move",
         "A Hold command was given during a blend move; the move runs to completion, and then the command "
         "error goes off.",
         COMMAND_ERROR),
    Rule("HLD-08", "chapter 4, Hold Move",
         "A Hold command was given during a manual move; the axis decelerates and stops.",
         COMMAND_ERROR | STOPPED, reading=("A-26",)),
    Rule("HLD-09", "chapter 4, Hold Move",
         "A Hold command does not affect the motion of an encoder move.",
         reading=("A-23",)),
    Rule("HLD-10", "chapter 4, Hold Move",
         "A Hold command was given in encoder follower mode; the steps stop.",
         COMMAND_ERROR, firmware_from=FW_4_1),
    Rule("HLD-11", "chapter 4, Hold Move",
         "After a hold by the external input, the input has to be off before another move can run.",
         if_broken=COMMAND_ERROR, reading=("A-47",)),
    # Resume Move
    Rule("RSM-01", "chapter 4, Resume Move",
         "Resume, as the first command after a hold, continues the move from where it was stopped to its "
         "target.",
         NONE, HOLD_STATE, reading=("A-28",)),
    Rule("RSM-02", "chapter 4, Resume Move",
         "The hold state bit goes off when the axis is restarted.",
         NONE, HOLD_STATE),
    Rule("RSM-03", "chapter 4, Resume Move",
         "S-curve bits have to be set with Resume again if an S-curve is wanted."),
    Rule("RSM-04", "chapter 4, Resume Move",
         "A resumed move that ends on its target sets Move Complete.",
         MOVE_COMPLETE),
    Rule("RSM-05", "chapter 4, Resume Move",
         "A move may be held and resumed many times, until it reaches its target, an error occurs or another "
         "move is started."),
    # Immediate Stop
    Rule("IST-01", "chapter 4, Immediate Stop",
         "Immediate Stop cuts off the steps at once, without deceleration.",
         STOPPED | POSITION_INVALID, MOTION | ACCELERATING | DECELERATING),
    Rule("IST-02", "chapter 4, Immediate Stop",
         "The position becomes invalid when Immediate Stop cuts off a motion.",
         POSITION_INVALID, reading=("A-29",)),
    Rule("IST-03", "chapter 4, Immediate Stop",
         "Relative and manual moves are possible after an Immediate Stop; an absolute move needs a preset or "
         "homing first."),
    Rule("IST-04", "chapter 4, Immediate Stop",
         "Immediate Stop changes no status bit when nothing moves.",
         reading=("A-28", "A-29")),
)
# fmt: on
