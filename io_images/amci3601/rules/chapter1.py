"""Module Overview and chapter 1: the link to the PLC, specifications, front panel."""

from __future__ import annotations

from ..firmware import FW_2_2, FW_3_1
from .rule import CONFIG_ERROR, MODULE_OK, Rule

# One row of the manual is one row here; the formatter would spread each over ten lines.
# fmt: off

PANEL = "the front panel is not part of the images"
ELECTRICAL = "an image shows nothing of the wiring"

ROWS: tuple[Rule, ...] = (
    # Module Overview
    Rule("IOM-01", "Module Overview",
         "The PLC sends eight 16-bit output words to the module and receives eight 16-bit input words from "
         "it.",
         untestable_because="every image assumes it"),
    Rule("IOM-02", "Module Overview",
         "A value that needs more than 16 bits is sent as two words: the MSW holds the thousands, the LSW "
         "the rest."),
    Rule("IOM-03", "Module Overview",
         "A negative value makes both of its words negative independently: -12,345 is -12 and -345, -12,000 "
         "is -12 and 0, -345 is 0 and -345."),
    Rule("IOM-04", "Module Overview",
         "The module has no non-volatile memory: configuration, blend profile, minimum registration distance "
         "and position are lost when power is removed.",
         CONFIG_ERROR | MODULE_OK),
    # Installing the module
    Rule("HWS-05", "chapter 1, Installing the 3601 module",
         "The module draws 400 mA at 5 V from the backplane and may be no farther than the seventh module "
         "from the power supply.",
         untestable_because=ELECTRICAL),
    Rule("IOM-25", "chapter 1, CompactLogix Generic Configuration",
         "A CompactLogix addresses the module through input assembly 101 and output assembly 100 of 8 words "
         "each and configuration assembly 102 of size 0, as Data-INT.",
         untestable_because="it concerns the PLC's project, not the images"),
    Rule("IOM-24", "chapter 1, MicroLogix 1500 Configuration",
         "A MicroLogix 1500 identifies the module as vendor 3, product type 10, product code 25, with 8 "
         "input and 8 output words.",
         firmware_from=FW_2_2, untestable_because="it concerns the PLC's project, not the images"),
    # Module Specifications
    Rule("IOM-23", "chapter 1, Module Specifications",
         "The module scans its inputs every 250 µs, so an input must be on for 250 µs to be seen.",
         reading=("A-01",)),
    Rule("IOM-22", "chapter 1, Module Specifications",
         "The RPI of a CompactLogix is fixed at 2 ms for this module.",
         untestable_because="it is a property of the PLC", reading=("A-91",)),
    Rule("HWS-01", "chapter 1, Module Specifications",
         "The step outputs reach at most 1 MHz.",
         untestable_because=ELECTRICAL),
    Rule("HWS-02", "chapter 1, Module Specifications",
         "The encoder inputs take 5 V differential signals, need both A and B, and count at most 1 MHz after "
         "X4 decoding, which is 250 kHz per channel.",
         untestable_because=ELECTRICAL),
    Rule("DFB-03", "chapter 1, Module Specifications",
         "Diagnostic feedback counts correctly up to 500 kHz.",
         untestable_because="a simulated wire has no frequency limit"),
    Rule("HWS-03", "chapter 1, Module Specifications",
         "The discrete inputs are on from 8 to 24 V and off from 0 to 2 V, and follow within 5 µs.",
         untestable_because=ELECTRICAL),
    Rule("EXT-04", "chapter 1, Module Specifications",
         "The external input affects absolute, relative, encoder, manual and registration moves; it has no "
         "effect on homing, blend moves and the encoder follower.",
         reading=("A-48",)),
    # Front Panel
    Rule("LED-01", "chapter 1, Front Panel",
         "The module LED is solid green while the module is owned and communicates both ways.",
         untestable_because=PANEL),
    Rule("LED-02", "chapter 1, Front Panel",
         "Axis OK and Axis Error blink alternately when the module has failed its power-up diagnostics.",
         untestable_because=PANEL),
    Rule("LED-03", "chapter 1, Front Panel",
         "Axis OK and Axis Error blink together when the module's CPU has lost its link to the backplane.",
         untestable_because=PANEL),
    Rule("LED-04", "chapter 1, Front Panel",
         "Axis OK is solid green while the module is all right and nothing moves.",
         untestable_because=PANEL),
    Rule("LED-05", "chapter 1, Front Panel",
         "Axis OK blinks green during motion, in encoder follower mode, and while the bit of a one-shot "
         "manual move stays set.",
         untestable_because=PANEL),
    Rule("LED-06", "chapter 1, Front Panel",
         "Axis OK is off while the module is not configured and while Axis Error blinks for an error.",
         untestable_because=PANEL, reading=("A-86",)),
    Rule("LED-07", "chapter 1, Front Panel",
         "Axis Error is solid red while communication with the PLC is interrupted.",
         untestable_because=PANEL),
    Rule("LED-08", "chapter 1, Front Panel",
         "Axis Error blinks red for a configuration, command, input, home invalid or invalid profile error.",
         untestable_because=PANEL),
    # Wiring
    Rule("HWS-04", "chapter 1, Single Ended Encoder Wiring",
         "Modules with serial numbers below 96317 have single-ended encoders and diagnostic feedback wired "
         "the other way round.",
         firmware_until=FW_3_1, untestable_because=ELECTRICAL),
)
# fmt: on
