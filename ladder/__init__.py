"""Ladder logic: rungs in Python or as text, checked, compiled, interpreted, drawn and debugged.

A program is declared tags and routines (`Program`); a controller is tags that its programs share, and
tasks (`Controller`). A scan loop calls it like any function of the scan,
which is logic just as well. The files, from the bottom up; each imports only from lines above its own:

| file | does |
|---|---|
| `collector` | the garbage collector, paused while large trees are built |
| `errors`, `arithmetic`, `types`, `quoting` | messages and faults; how Logix computes; data types; escapes |
| `tree`, `statements`, `operators` | the tree: rungs, statements, expressions |
| `scanner`, `expressions` | expressions from text |
| `stretches`, `tags`, `memory` | values of a tag in a list; declared tags to leaves; a program's values |
| `operands`, `regions` | resolved operands; stretches of memory as bytes |
| `schedule`, `scheduler` | tasks, and when they run their programs |
| `stubs` | replacements of instructions, and of the other end of a message |
| `axes`, `bound_axes` | axes that a 3601 of the rack moves: settings; its block |
| `motion_types`, `motion_words`, `words` | types and words of motion; all words of lists |
| `block_types`, `safety_types`, `predefined` | structures of blocks, of safety instructions; all types |
| `tagref`, `spec`, `operand_checks` | Python operands; one instruction, its uses; what a use accepts |
| `resolver`, `lowered`, `fault_log`, `view` | addresses to operands; a program ready to run; faults; tags |
| `interpreter/`, `engine`, `compiler/` | the two back ends: rungs, power, values; one running program |
| `whereabouts` | the task, routine and rung that a traceback leads to |
| `instructions/` | what each instruction does in both back ends: one file per family, one row each |
| `text`, `st/`, `front` | rungs from text; structured text; rungs from Python |
| `addon`, `calls` | add-on instructions; what a call passes |
| `inferred` | types of tags that nothing declares |
| `lowering_statements`, `lowering`, `checks` | tree to lowered program; checks of the whole |
| `edit` | values that outlive a program |
| `runnable`, `logic`, `controller` | what both of these are: declared, built, run; `Program`; `Controller` |
| `slc_types`, `slc/` | RSLogix 500: data files, exports; `instructions/slc` has its instructions |
| `l5x/` | exports of Studio 5000 and RSLogix 5000: read, reported, compared, written |
| `sequences/`, `axis3601/` | logic in plain Python: sequences; the 3601's axis |
| `rungreader`, `rungfile`, `steps` | `.rung` and `.st` files; `.steps` files |
| `blocks/` | the motion blocks of `USE axis3601`, as rung text |
| `modules_beside`, `program` | modules beside a program's file; any program from a file |
| `tag_values` | tags by pattern, for a recorder |
| `debug/`, `draw/` | breakpoints, forces, why, cross reference; rungs as characters and SVG |

To add an instruction:

1. In the file of its family in `instructions/`, write its row, the functions that the row names, and the
   name in `__all__`. `spec.Spec` says what the functions get and return. A rare instruction needs no
   `write`: the compiled program then calls its `run`.
2. In `tests/manual/test_ladder_semantics_*.py`, add a row with the manual's page.
3. In `docs/ladder.md`, add its name to the list; a test compares the list with the rows.

A use of operands that no instruction has yet is one more member of `spec.Use`, with its row in
`operand_checks.OPERAND_CHECKS`.
"""

from . import instructions
from .build.checks import REPEATED_COILS, REPEATED_TIMERS
from .build.controller import Controller
from .build.program import Program
from .build.runnable import LadderLogic
from .files.rungfile import read_program, write_program
from .instructions import *  # noqa: F403
from .model.errors import BuildError, LadderError, LadderFault, MinorFault, RungTextError
from .model.types import (
    BOOL,
    CONTROL,
    COUNTER,
    DINT,
    INT,
    LINT,
    LREAL,
    REAL,
    SINT,
    STRING,
    TIMER,
    UDINT,
    UINT,
    ULINT,
    USINT,
    Member,
    Structure,
)
from .run.engine import Engine

__all__ = [
    "BOOL",
    "CONTROL",
    "COUNTER",
    "DINT",
    "INT",
    "LINT",
    "LREAL",
    "REAL",
    "REPEATED_COILS",
    "REPEATED_TIMERS",
    "SINT",
    "STRING",
    "TIMER",
    "UDINT",
    "UINT",
    "ULINT",
    "USINT",
    "BuildError",
    "Controller",
    "Engine",
    "LadderError",
    "LadderFault",
    "LadderLogic",
    "Member",
    "MinorFault",
    "Program",
    "RungTextError",
    "Structure",
    "read_program",
    "write_program",
    *instructions.NAMES,
]
