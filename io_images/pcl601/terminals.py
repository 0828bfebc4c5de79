"""The input and output terminals, and their bits in each interface.

    interface                   a grounded input            open or high
    Modbus 1x and 3x, IR        1 (active)                  0
    I1 to I6, IF in a program   0 (its level)               1

[Inputs; I - Read inputs; Appendix 1; Appendix 3, 0x04]
"""

from __future__ import annotations

GENERAL_INPUTS = ("in1", "in2", "in3", "in4", "in5", "in6")
"""Inputs 1 to 6; inputs 5 and 6 are connected only if SW2 is in position IN5/6."""

LIMIT_INPUTS = (
    "home",
    "jog_plus",
    "jog_minus",
    "fast_jog",
    "hard_plus",
    "hard_minus",
    "soft_plus",
    "soft_minus",
)
"""The limit switch inputs in the order of the terminal block; active when grounded."""

INPUTS = (*GENERAL_INPUTS, *LIMIT_INPUTS)

HARD_LIMITS = {1: "hard_plus", -1: "hard_minus"}
"""Hard limit inputs by the direction of motion that they stop [Hard Limit Inputs]."""

SOFT_LIMITS = {1: "soft_plus", -1: "soft_minus"}
"""Soft limit inputs by the direction of motion that they stop [Soft Limit Inputs]."""

JOG_INPUTS = {1: "jog_plus", -1: "jog_minus"}
"""Jog inputs by direction of motion [Jog Inputs]."""

HARD_LIMIT_BIT = 6
SOFT_LIMIT_BIT = 7
INPUT_COUNT = 8
"""1x references 1 to 8: inputs 1 to 6, hard limit, soft limit; bits 0 to 7 of 3x1."""

OUTPUT_COUNT = 8
"""0x references 1 to 8: outputs 1 to 8."""

OUTPUT_BITS = 16
"""Number of bits in the output register; the upper eight read 0."""

ON_FLY_OUTPUT = 1 << 0
"""Bit of output 1, the output on the fly."""

RETRIES_OUTPUT = 1 << 7
"""Bit of output 8, which is on when all encoder retries have failed."""

ON_FLY_PULSE_NS = 50_000
"""Output 1 is on for 50 µs at each position [Output on the fly]."""
