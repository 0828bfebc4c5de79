"""Logic: rungs, in Python or as text, and plain functions of the scan.

A program is declared tags and routines (`Program`); a scan loop gets it as a
callable and knows nothing of where it came from. A plain Python function of one
argument, the scan, is logic just as well.
"""

from .checks import REPEATED_COILS, REPEATED_TIMERS
from .engine import Engine
from .errors import BuildError, LadderError, LadderFault, MinorFault, RungTextError
from .instructions import *  # noqa: F403
from .instructions import __all__ as _instructions
from .logic import Program
from .rungfile import read_program, write_program
from .types import BOOL, CONTROL, COUNTER, DINT, INT, LINT, REAL, SINT, STRING, TIMER, Member, Structure

__all__ = [
    "BOOL",
    "CONTROL",
    "COUNTER",
    "DINT",
    "INT",
    "LINT",
    "REAL",
    "REPEATED_COILS",
    "REPEATED_TIMERS",
    "SINT",
    "STRING",
    "TIMER",
    "BuildError",
    "Engine",
    "LadderError",
    "LadderFault",
    "Member",
    "MinorFault",
    "Program",
    "RungTextError",
    "Structure",
    "read_program",
    "write_program",
    *_instructions,
]
