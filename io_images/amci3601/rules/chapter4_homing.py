"""Chapter 4: Find Home."""

from __future__ import annotations

from .rule import AT_HOME, COMMAND_ERROR, HOME_INVALID, MOVING_CCW, MOVING_CW, NONE, POSITION_INVALID, Rule

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

MOTION = MOVING_CW | MOVING_CCW

ROWS: tuple[Rule, ...] = (
    Rule("HMG-01", "chapter 4, Find Home",
         "There are four ways to home, chosen by the configuration; bit 5 of the command word homes "
         "clockwise, bit 6 counter-clockwise.",
         reading=("A-72", "A-72b")),
    Rule("HMG-02", "chapter 4, Find Home",
         "With a proximity input, changes of the home input and marker pulses are ignored until the "
         "proximity signal has been seen.",
         reading=("A-75",)),
    Rule("HMG-03", "chapter 4, Find Home",
         "At the end of homing At Home is set and the current position, the encoder value and the captured "
         "value become zero.",
         AT_HOME, POSITION_INVALID | MOTION, reading=("A-03", "A-71", "A-77")),
    Rule("CAP-04", "chapter 4, Find Home",
         "The end of homing resets the captured value to zero."),
    Rule("HMG-19", "chapter 4, Find Home",
         "After homing the position is valid, and absolute moves are possible.",
         NONE, POSITION_INVALID),
    Rule("HMG-04", "chapter 4, Find Home",
         "Find Home needs a target of zero, a programmed speed not below the starting speed, and "
         "acceleration and deceleration.",
         COMMAND_ERROR, reading=("A-21", "A-22")),
    Rule("HMG-05", "chapter 4, Find Home",
         "Find Home needs an end limit switch configured in the commanded direction.",
         COMMAND_ERROR | HOME_INVALID, together_with=("HOM-03",), reading=("A-21",)),
    Rule("HMG-06", "chapter 4, Find Home",
         "S-curve acceleration was selected with a Find Home command.",
         COMMAND_ERROR),
    Rule("HMG-07", "chapter 4, Find Home",
         "When homing reaches an end limit switch, the axis stops at once, waits two seconds, reverses and "
         "searches again.",
         NONE, MOTION, reading=("A-74", "A-100")),
    Rule("HMG-20", "chapter 4, Find Home",
         "A high homing speed may make the motor stall at the sudden stop and reversal on an end limit "
         "switch.",
         untestable_because="it is advice about motors"),
    Rule("HMG-08", "chapter 4, Find Home, Home Limit Switch Only",
         "With the home switch alone, home is where the switch comes on when it is approached at the "
         "starting speed.",
         AT_HOME, reading=("A-72",)),
    Rule("HMG-09", "chapter 4, Find Home, Backplane Home Proximity Bit with Home Limit Switch",
         "With backplane proximity and home switch, the proximity bit slows the search to the starting "
         "speed, and home is where the switch next comes on.",
         AT_HOME, reading=("A-75",)),
    Rule("HMG-10", "chapter 4, Find Home, Marker Pulse and Proximity Switch",
         "With marker and home switch, the switch slows the search to the starting speed, and home is the "
         "next marker pulse.",
         AT_HOME, reading=("A-75",)),
    Rule("HMG-11", "chapter 4, Find Home, Marker Pulse and Proximity Switch",
         "With marker and backplane proximity, the proximity bit slows the search to the starting speed, and "
         "home is the next marker pulse.",
         AT_HOME, reading=("A-75",)),
    Rule("HMG-12", "chapter 4, Find Home, Home Limit Switch Active when the Home Command is issued",
         "If the home switch or proximity signal is on at the start, the axis first turns the other way "
         "until it is off, and then homes.",
         reading=("A-72",)),
    Rule("HMG-17", "chapter 4, Find Home, Home Limit Switch Active when the Home Command is issued note 2",
         "If backplane proximity homing starts with the home switch on, the axis turns the other way until "
         "the proximity bit, not the home input, has gone from on to off.",
         untestable_because="how long the axis turns is up to the PLC alone", reading=("A-76",)),
    Rule("HMG-13", "chapter 4, Find Home, End Limit Switch Active when the Home Command is issued",
         "If the end limit switch in the commanded direction is active at the start, the axis leaves it the "
         "other way and then homes.",
         reading=("A-73",)),
    Rule("HMG-14", "chapter 4, Find Home, End Limit Switch Active when the Home Command is issued note 2",
         "If the opposite end limit switch is active at the start, the axis homes as if it were not."),
    Rule("HMG-15", "chapter 4, Find Home, End Limit Switch Active when the Home Command is issued",
         "The axis can be homed while it stands on an end limit switch."),
)
# fmt: on
