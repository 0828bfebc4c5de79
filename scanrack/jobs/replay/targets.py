"""The receivers of a recording, and the stimuli of its machine."""

from enum import StrEnum


class ReplayTarget(StrEnum):
    """The receiver of a replayed recording."""

    MODULE = "module"
    PROGRAM = "program"
    RACK = "rack"
    SESSION = "session"


class Stimuli(StrEnum):
    """The stimuli of the machine."""

    MACHINE = "machine"
    """The rack file's timeline and stations."""

    RECORDED = "recorded"
    """The stimuli of the trace."""

    INPUTS = "inputs"
    """The levels of the inputs in the recorded status bits, the only record from real hardware."""
