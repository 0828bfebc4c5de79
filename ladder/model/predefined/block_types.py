"""Structures of function blocks that structured text can call, and of blocks found only in diagrams.

[1756-RM003 and 1756-RM006, structures of each block]
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import FBD_COUNTER, FBD_ONESHOT, FBD_TIMER, Structure, for_each
from .process_types import PROCESS, block_structure

_CAPTURED = "REAL In BOOL Reset REAL ResetValue", "REAL Out", None
_LATCHED = "Set Reset", "Out OutNot", None

BLOCKS: Mapping[str, Structure] = {
    **PROCESS,
    "UPDN": block_structure(
        "UP_DOWN_ACCUM", "Initialize REAL InitialValue InPlus InMinus BOOL Hold", "REAL Out"
    ),
    "BTDT": block_structure(
        "FBD_BIT_FIELD_DISTRIBUTE", "DINT Source SourceBit Length=1 DestBit Target", "DINT Dest"
    ),
    "SEL": block_structure("SELECT", "REAL In1 In2 BOOL SelectorIn", "REAL Out"),
    "SNEG": block_structure("SELECTABLE_NEGATE", "REAL In BOOL NegateEnable=1", "REAL Out"),
    "MAXC": block_structure("MAXIMUM_CAPTURE", *_CAPTURED, hidden="BOOL begun"),
    "MINC": block_structure("MINIMUM_CAPTURE", *_CAPTURED, hidden="BOOL begun"),
    "DFF": block_structure("FLIP_FLOP_D", "D Clear Clock", "Q QNot", hidden="BOOL before"),
    "JKFF": block_structure("FLIP_FLOP_JK", "Clear Clock", "Q QNot", hidden="BOOL before"),
    "RESD": block_structure("DOMINANT_RESET", *_LATCHED),
    "SETD": block_structure("DOMINANT_SET", *_LATCHED),
}
"""Structure of each block instruction."""

BLOCK_STRUCTURES: Mapping[str, Structure] = {
    **dict.fromkeys(("TONR", "TOFR", "RTOR"), FBD_TIMER),
    "CTUD": FBD_COUNTER,
    **dict.fromkeys(("OSRI", "OSFI"), FBD_ONESHOT),
    **BLOCKS,
}
"""Structure of each block instruction, including timers, counters and one-shots."""

BLOCK_TYPES: Mapping[str, Structure] = {kind.name: kind for kind in BLOCKS.values()}


_EIGHT = for_each("In#", *range(1, 9))

DIAGRAM_TYPES: Mapping[str, Structure] = {
    name: block_structure(name, *parts)
    for name, *parts in (
        ("FBD_BOOLEAN_AND", for_each("In#=1", *range(1, 9)), "Out"),
        ("FBD_BOOLEAN_OR", _EIGHT, "Out"),
        ("FBD_BOOLEAN_XOR", "In1 In2", "Out"),
        ("FBD_BOOLEAN_NOT", "In", "Out"),
        ("FBD_MATH", "REAL SourceA SourceB", "REAL Dest"),
        ("FBD_MATH_ADVANCED", "REAL Source", "REAL Dest"),
        ("FBD_TRUNCATE", "REAL Source", "DINT Dest"),
        ("FBD_CONVERT", "DINT Source", "DINT Dest"),
        ("FBD_COMPARE", "REAL SourceA SourceB", "Dest"),
        ("FBD_LIMIT", "REAL LowLimit Test HighLimit", "Dest"),
        ("FBD_MASK_EQUAL", "DINT Source Mask Compare", "Dest"),
        ("FBD_LOGICAL", "DINT SourceA SourceB", "DINT Dest"),
        ("FBD_MASKED_MOVE", "DINT Source Mask Target", "DINT Dest"),
        ("MULTIPLEXER", f"REAL {_EIGHT} DINT Selector=1", "REAL Out", "SelectorInv"),
    )
}
"""Structures of blocks that exist only in diagrams."""
