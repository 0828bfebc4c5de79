"""The controller's flags in a scan, by name.

bits 0 and 1   the mode: program, run, test, single scan
bits 2 to 7    special conditions of the scan
"""

from __future__ import annotations

MODES = ("program", "run", "test", "single scan")
"""The modes, in the order of bits 0 and 1."""

MODE_MASK = 0b11
OVERRUN = 1 << 5

# fmt: off
FLAGS = {
    2: "FIRST_SCAN",      # of the logic
    3: "INPUT_FORCES",    # are in effect
    4: "OUTPUT_FORCES",
    5: "OVERRUN",         # real time only: the scan began late
    6: "FAULT",
    7: "TAGS_FROM_OUTSIDE",  # a tag is forced, or was set from outside since the previous scan
}
# fmt: on
"""The flags by bit number."""


def flag_names(flags: int) -> list[str]:
    """Return the names of the controller's mode and flags.

    >>> flag_names(5), flag_names(0)
    (['run mode', 'FIRST_SCAN'], ['program mode'])
    """
    names = [name for number, name in FLAGS.items() if flags >> number & 1]
    return [f"{MODES[flags & MODE_MASK]} mode", *names]
