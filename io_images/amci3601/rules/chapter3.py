"""Chapter 3: configuration mode."""

from __future__ import annotations

from .rule import COMMAND_ERROR, CONFIG_ERROR, MODE_CONFIG, MODULE_OK, NONE, Rule

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

INVALID = CONFIG_ERROR | MODE_CONFIG
REJECTED = ("CER-02",)

ROWS: tuple[Rule, ...] = (
    # Configuration Mode
    Rule("CFG-23", "chapter 3, Configuration Mode 10",
         "Home switch, backplane proximity and marker select one of four ways to home: home switch alone, "
         "home switch with backplane proximity, marker with home switch, marker with backplane proximity.",
         reading=("A-12",)),
    Rule("CFG-21", "chapter 3, Configuration Mode 10 note 3",
         "Homing to the marker pulse also requires the quadrature encoder."),
    Rule("CFG-26", "chapter 3, Configuration Mode 11",
         "Every move begins and ends at the starting speed of 1 to 1,000,000 steps/s, sent as two words."),
    # Configuration Mode Output Data
    Rule("IOM-07", "chapter 3, Configuration Mode Output Data",
         "In configuration mode the output words are: 0 configuration bits MSW, 1 configuration bits LSW, 2 "
         "and 3 starting speed, 4 to 7 zero."),
    Rule("CFG-12", "chapter 3, Configuration Mode Output Data note 1",
         "The module powers up in command mode and shows a configuration error.",
         CONFIG_ERROR | MODULE_OK, MODE_CONFIG, reading=("A-02", "A-04")),
    Rule("CFG-13", "chapter 3, Configuration Mode Output Data note 1",
         "The configuration error stays until a valid configuration has been written.",
         CONFIG_ERROR),
    Rule("CFG-14", "chapter 3, Configuration Mode Output Data note 2",
         "Configuration mode was requested while a move was running; the move runs to completion, then "
         "configuration mode is entered and the command error goes off.",
         COMMAND_ERROR, reading=("A-09", "A-10", "A-101")),
    # Configuration Bits MSW
    Rule("CFG-31", "chapter 3, Configuration Bits MSW bit 6",
         "With backplane proximity configured, homing ignores the home input until bit 12 of the command LSW "
         "goes from 0 to 1.",
         reading=("A-75",)),
    Rule("HMG-18", "chapter 3, Configuration Bits MSW bit 6",
         "The backplane home proximity bit has to go from 0 to 1; then the next time the home input becomes "
         "active counts.",
         reading=("A-75",)),
    Rule("CFG-22", "chapter 3, Configuration Bits MSW bit 10",
         "Bit 10 selects step and direction outputs (1) or CW and CCW pulse outputs (0)."),
    Rule("CFG-15", "chapter 3, Configuration Bits MSW bit 15",
         "Bit 15 of output word 0 selects configuration mode (1) or command mode (0), and bit 15 of input "
         "word 0 shows the mode the module is in.",
         MODE_CONFIG, reading=("A-07", "A-11")),
    # Input Active Level
    Rule("CFG-19", "chapter 3, Input Active Level",
         "A level bit makes its input active high for a normally open contact (1) or active low for a "
         "normally closed one (0)."),
    Rule("CFG-20", "chapter 3, Input Active Level",
         "The level bit of an input counts only if the input is configured as used.",
         reading=("A-13", "A-14")),
    # Invalid Configurations
    Rule("CFG-01", "chapter 3, Invalid Configurations 1",
         "The configuration cannot home the axis: neither the home switch nor marker homing is selected.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED, reading=("A-12",)),
    Rule("CFG-02", "chapter 3, Invalid Configurations 2",
         "The configuration has neither a CW nor a CCW end limit switch.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-18", "chapter 3, Invalid Configurations 2 note",
         "A way to home and one end limit switch have to be configured; they need not be wired."),
    Rule("CFG-03", "chapter 3, Invalid Configurations 3",
         "The configuration selects quadrature encoder and diagnostic feedback together.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-04", "chapter 3, Invalid Configurations 4",
         "The configuration selects marker homing without the quadrature encoder.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-05", "chapter 3, Invalid Configurations 5",
         "The configuration selects diagnostic feedback with CW and CCW pulse outputs.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-06", "chapter 3, Invalid Configurations 6",
         "The starting speed is outside 1 to 1,000,000 steps/s.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-07", "chapter 3, Invalid Configurations 7",
         "The lower word of the starting speed is outside 0 to 999.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-08", "chapter 3, Invalid Configurations 8",
         "An unused bit of the configuration words is set: bit 7, 11, 13 or 14 of word 0, or bit 6 to 15 of "
         "word 1.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-09", "chapter 3, Invalid Configurations 9",
         "The configuration selects marker homing with neither home switch nor backplane proximity as "
         "proximity.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-10", "chapter 3, Invalid Configurations 10",
         "The configuration selects marker homing with both home switch and backplane proximity as "
         "proximity.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-11", "chapter 3, Invalid Configurations 11",
         "An unused configuration word (output word 4 to 7) is not zero.",
         INVALID, if_broken=CONFIG_ERROR, together_with=REJECTED),
    Rule("CFG-28", "chapter 3, Invalid Configurations, closing paragraph",
         "No operation is possible before the module has been configured.",
         CONFIG_ERROR, reading=("A-05",)),
    Rule("CFG-30", "chapter 3, Invalid Configurations, closing paragraph",
         "A configuration that is not valid sets the configuration error; a valid one sent after it clears "
         "it.",
         CONFIG_ERROR, together_with=REJECTED, reading=("A-06", "A-07")),
    Rule("CFG-16", "chapter 3, Invalid Configurations, closing paragraph",
         "An accepted configuration is mirrored in input words 0 to 3.",
         NONE, CONFIG_ERROR, reading=("A-06", "A-08")),
    # Configuration Mode Input Data
    Rule("IOM-08", "chapter 3, Configuration Mode Input Data",
         "In configuration mode the input words are: 0 to 3 mirror of output words 0 to 3, 4 and 5 zero, 6 "
         "and 7 firmware revision."),
    Rule("CFG-27", "chapter 3, Configuration Mode Input Data",
         "Input words 6 and 7 report the major and minor firmware revision in configuration mode."),
    Rule("IOM-09", "chapter 3, Configuration Mode Input Data note",
         "Bits 13 to 15 of input word 0 are never mirrored: in either mode they show configuration error, "
         "module OK and mode."),
)
# fmt: on
