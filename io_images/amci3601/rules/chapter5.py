"""Chapter 5: output words in command mode, and programming of blend profiles."""

from __future__ import annotations

from ..firmware import FW_3_1, FW_4_1
from .rule import BLEND_ACK, COMMAND_ERROR, DECELERATING, INVALID_PROFILE, NONE, POSITION_INVALID, Rule

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

REFUSED = COMMAND_ERROR | INVALID_PROFILE
NOT_SAID = "the manual does not say what happens otherwise"

ROWS: tuple[Rule, ...] = (
    Rule("IOM-05", "chapter 5, Generic Output Data",
         "In command mode the output words are: 0 command MSW, 1 command LSW, 2 and 3 target position, 4 and "
         "5 programmed speed, 6 acceleration, 7 deceleration.",
         untestable_because="every command assumes it"),
    # Command Mode Programming Information
    Rule("IOM-10", "chapter 5, Programming Information 4 and 5",
         "A target position was outside -8,388,608 to 8,388,607, its LSW was outside -999 to 999, or its "
         "words had opposite signs.",
         COMMAND_ERROR, reading=("A-36", "A-37")),
    Rule("IOM-15", "chapter 5, Programming Information 6 and 7",
         "A programmed speed was outside the starting speed to 1,000,000 steps/s, or its LSW was outside 0 "
         "to 999.",
         REFUSED),
    Rule("IOM-16", "chapter 5, Programming Information 8",
         "An acceleration or deceleration was outside 1 to 2000 steps/ms/s.",
         REFUSED),
    Rule("PRG-01", "chapter 5, Programming Information 9",
         "The PLC left run mode or its connection was lost, which stops any move and makes the position "
         "invalid.",
         POSITION_INVALID, reading=("A-78",)),
    # Command Word MSW
    Rule("PST-04", "chapter 5, Command Word MSW bit 9",
         "Preset Position does not reset Move Complete.",
         reading=("A-03",)),
    # Command Word LSW
    Rule("LSW-00", "chapter 5, Command Word LSW bit 0",
         "Bit 0 of the command LSW selects constant acceleration (0) or an S-curve (1)."),
    Rule("LSW-01", "chapter 5, Command Word LSW bit 1",
         "Bit 1 of the command LSW selects a triangular (0) or trapezoidal (1) S-curve, and counts only with "
         "bit 0 set."),
    Rule("LSW-02", "chapter 5, Command Word LSW bit 2",
         "Bit 2 of the command LSW selects a move in steps (0) or encoder counts (1), for absolute and "
         "relative moves only."),
    Rule("LSW-03", "chapter 5, Command Word MSW bit 14 and LSW bits 3 to 6, 11, 13 to 15",
         "Bit 14 of the command MSW and bits 3 to 6, 11 and 13 to 15 of the LSW are reserved.",
         if_broken=COMMAND_ERROR, untestable_because=NOT_SAID, reading=("A-32",)),
    Rule("LSW-07", "chapter 5, Command Word LSW bit 7",
         "Bit 7 of the command LSW selects encoder follower mode.",
         firmware_from=FW_4_1, reading=("A-67", "A-94")),
    Rule("LSW-08", "chapter 5, Command Word LSW bit 8",
         "Bit 8 of the command LSW programs a blend profile and stays set while the segments are "
         "programmed.",
         if_broken=COMMAND_ERROR),
    Rule("LSW-09", "chapter 5, Command Word LSW bit 9",
         "Bit 9 of the command LSW transmits a block of a blend profile.",
         reading=("A-59",)),
    Rule("LSW-10", "chapter 5, Command Word LSW bit 10",
         "Bit 10 of the command LSW stores the target position words as minimum registration distance.",
         firmware_from=FW_3_1, reading=("A-67", "A-93", "A-94")),
    Rule("LSW-12", "chapter 5, Command Word LSW bit 12",
         "Bit 12 of the command LSW is the backplane home proximity bit; it is ignored unless it is "
         "configured and the axis is homing.",
         reading=("A-75",)),
    Rule("HMG-16", "chapter 5, Command Word LSW bit 12",
         "Setting the backplane home proximity bit slows homing from the programmed speed to the starting "
         "speed.",
         DECELERATING),
    Rule("IOM-20", "chapter 5, Command Word LSW note",
         "The command LSW must be zero with Reset Errors, the presets and Run Blend Move.",
         if_broken=COMMAND_ERROR, untestable_because=NOT_SAID, reading=("A-30", "A-31")),
    Rule("PST-08", "chapter 5, Command Word LSW note",
         "A preset command was given with a command LSW that is not zero.",
         COMMAND_ERROR, untestable_because=NOT_SAID, reading=("A-31",)),
    Rule("IOM-21", "chapter 5, Command Word LSW note",
         "The command LSW need not be zero for absolute, relative and manual moves."),
    # Blend Move Programming
    Rule("BLD-02", "chapter 5, Blend Move Programming",
         "Blend programming begins when bits 8 and 9 of the command LSW are set: the module reads the first "
         "block and acknowledges it.",
         BLEND_ACK, reading=("A-57",)),
    Rule("BLD-03", "chapter 5, Blend Move Programming",
         "The acknowledge goes off when bit 9 is reset while bit 8 stays set.",
         NONE, BLEND_ACK),
    Rule("BLD-04", "chapter 5, Blend Move Programming",
         "Each further change of bit 9 from 0 to 1 makes the module read and acknowledge the next block.",
         BLEND_ACK, reading=("A-59", "A-60")),
    Rule("BLD-14", "chapter 5, Number of Segments",
         "A blend profile was programmed with fewer than 2 or more than 16 segments.",
         INVALID_PROFILE),
    Rule("BLD-12", "chapter 5, Acceleration Type",
         "Two bits give the acceleration type of each segment, segments 1 to 8 in word 4 and 9 to 16 in word "
         "3: the lower one selects an S-curve, the upper one a trapezoidal S-curve.",
         if_broken=INVALID_PROFILE, reading=("A-60",)),
    Rule("BLD-19", "chapter 5, Segment Length Restrictions",
         "The lengths of the blend segments added up to more than 8,388,607 steps.",
         INVALID_PROFILE),
    Rule("BLD-21", "chapter 5, Segment Length Restrictions",
         "The length of a blend segment was negative.",
         INVALID_PROFILE),
    Rule("BLD-22", "chapter 5, Segment Length Restrictions",
         "The LSW of a blend segment's length was outside 0 to 999.",
         INVALID_PROFILE),
    Rule("BLD-13", "chapter 5, Final Segment Deceleration & Acceleration Type",
         "Word 5 of the first block holds the final deceleration, 1 to 2000, and its type in bits 15 and 14, "
         "of which 10 is invalid.",
         if_broken=REFUSED, reading=("A-60",)),
    Rule("BLD-15", "chapter 5, Final Segment Deceleration & Acceleration Type",
         "A blend profile was programmed without a final deceleration.",
         REFUSED, together_with=("PRF-07",)),
    Rule("BLD-18", "chapter 5, Acceleration/Deceleration Parameters",
         "The rate of a blend segment was outside 1 to 2000 steps/ms/s.",
         INVALID_PROFILE, reading=("A-115",)),
    Rule("BLD-25", "chapter 5, Blend Move Programming Routine 2",
         "An error in a blend block blocks every operation until Reset Errors is given.",
         INVALID_PROFILE, reading=("A-57", "A-116")),
    Rule("BLD-11", "chapter 5, Blend Move Programming Routine 5",
         "A blend profile has at most 16 segments."),
    Rule("BLD-05", "chapter 5, Blend Move Programming Routine 6",
         "Resetting bit 8 after the last segment ends blend programming.",
         reading=("A-60",)),
)
# fmt: on
