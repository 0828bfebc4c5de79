"""A program as a transition system: which values are state, which are free in each scan, which are held.

| value before a scan | role |
|---|---|
| the scan may write it, or it is the time since an instant | state |
| of a module's input image or fault, of a consumed tag, of the status file of an SLC | free |
| a bit that nothing writes | free |
| a number that nothing writes | held at its initial value, unless `free` names it |
| a bit of a number, if the program names it and does not write it | free, from the second scan on |
| a number with the name of a module's inputs, as `I:2` or `Rack:3:I` | free |
| named by `written_outside` | free, from the second scan on |
| what an instruction that is not modeled leaves | free |

States have their values after prescan before the first scan.

| file | does |
|---|---|
| `program` | a program as a system |
| `transition` | a system without a program |
| `outside` | what changes outside of a program's scan |
| `happenings` | what may happen between two scans: the key is turned, power goes, a link is lost |
| `held` | numbers and bits that are held: every proof about them assumes their values |
"""

from .happenings import RUN_ONLY, Happenings
from .outside import refuse
from .program import Contract, ProgramSystem, Runnable
from .transition import (
    CLOCK,
    DT,
    FIRST_SCAN,
    OFF,
    RETAINED,
    STOPPED,
    THEN,
    TURNED,
    WRITTEN,
    HeldNumber,
    Key,
    ScanBounds,
    System,
    ms_of,
    name_of,
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
    "Happenings",
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
