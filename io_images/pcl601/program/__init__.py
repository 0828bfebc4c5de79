"""Stored programs of the PCL601: the instruction set and the text format.

>>> from scanrack.io_images.pcl601.program import format_program, parse_program
>>> program = parse_program('''
... LABEL again
... MOVE 4000   ; in the present direction
... FINISH
... LOOP OUTER 3 again
... END
... ''')
>>> program.size
19
>>> print(format_program(program), end="")
LABEL AGAIN
MOVE 4000
FINISH
LOOP OUTER 3 AGAIN
END
"""

from __future__ import annotations

from .instructions import BY_NAME, CAPACITY_BYTES, INSTRUCTIONS, Instruction
from .model import Program, ProgramError, Step
from .operands import TEXT_MAX
from .structure import check_structure
from .text import format_program, format_step, parse_program

__all__ = [
    "BY_NAME",
    "CAPACITY_BYTES",
    "INSTRUCTIONS",
    "TEXT_MAX",
    "Instruction",
    "Program",
    "ProgramError",
    "Step",
    "check_structure",
    "format_program",
    "format_step",
    "parse_program",
]
