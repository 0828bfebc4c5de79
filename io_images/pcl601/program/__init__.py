"""Stored programs of the PCL601: the instruction set, the text format, program memory.

>>> from scanrack.io_images.pcl601.program import assemble, disassemble, format_program, parse_program
>>> program = parse_program('''
... LABEL again
... MOVE 4000   ; in the present direction
... FINISH
... LOOP OUTER 3 again
... END
... ''')
>>> program.size, len(assemble(program))
(19, 19)
>>> print(format_program(disassemble(assemble(program))), end="")
LABEL L1
MOVE 4000
FINISH
LOOP OUTER 3 L1
END
"""

from __future__ import annotations

from .instructions import BY_NAME, CAPACITY_BYTES, INSTRUCTIONS, Instruction
from .memory import assemble, disassemble
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
    "assemble",
    "check_structure",
    "disassemble",
    "format_program",
    "format_step",
    "parse_program",
]
