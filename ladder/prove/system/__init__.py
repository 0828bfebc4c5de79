"""A program as a transition system. Each value is state, free in each scan, or held.

| value before a scan | role |
|---|---|
| a value that the scan may write, or an elapsed time | state |
| in a module's input image or fault, a consumed tag, or the status file of an SLC | free |
| a bit that nothing writes | free |
| a number that nothing writes | held at its initial value, unless `free` names it |
| a bit of a number that the program names and does not write | free, from the second scan |
| a number named like a module's inputs, such as `I:2` or `Rack:3:I` | free |
| named by `written_outside` | free, from the second scan |
| the result of an instruction that is not modeled | free |

Before the first scan, states have their values after prescan.

| file | does |
|---|---|
| `program` | a program as a system |
| `transition` | a system without a program |
| `outside` | changes from outside a program's scan |
| `events` | events between two scans: the key is turned, a run ends, a link is lost |
| `held` | numbers and bits that are held: proofs assume their values |
"""

from ..relation.places import CLOCK, Key, name_of
from .events import RUN_ONLY
from .outside import refuse
from .program import Contract, ProgramSystem, Runnable
from .transition import (
    DT,
    FIRST_SCAN,
    OFF,
    RETAINED,
    STOPPED,
    THEN,
    TURNED,
    WRITTEN,
    HeldNumber,
    ScanBounds,
    System,
    ms_of,
    shown,
)

__all__ = [
    "CLOCK",
    "DT",
    "FIRST_SCAN",
    "OFF",
    "RETAINED",
    "RUN_ONLY",
    "STOPPED",
    "THEN",
    "TURNED",
    "WRITTEN",
    "Contract",
    "HeldNumber",
    "Key",
    "ProgramSystem",
    "Runnable",
    "ScanBounds",
    "System",
    "ms_of",
    "name_of",
    "refuse",
    "shown",
]
