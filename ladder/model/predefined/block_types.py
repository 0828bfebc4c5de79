"""Structures of function blocks: blocks that structured text calls, and blocks of diagrams only.

[1756-RM003 and 1756-RM006, structures of each block]
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, FBD_COUNTER, FBD_ONESHOT, FBD_TIMER, REAL, Member, Structure, members
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

BLOCK_TYPES: Mapping[str, Structure] = {each.name: each for each in BLOCKS.values()}


def _of_diagrams(name: str, inputs: tuple[Member, ...], outputs: tuple[Member, ...]) -> Structure:
    return Structure(
        name,
        (Member("EnableIn", BOOL, initial=True), *inputs, Member("EnableOut", BOOL), *outputs),
    )


_EIGHT = " ".join(f"In{number}" for number in range(1, 9))
_TRUE = tuple(Member(name, BOOL, initial=True) for name in _EIGHT.split())  # set on the first download
_DEST = {kind: members(kind, "Dest") for kind in (BOOL, DINT, REAL)}
_OUT = members(BOOL, "Out")

DIAGRAM_TYPES: Mapping[str, Structure] = {
    name: _of_diagrams(name, inputs, outputs)
    for name, inputs, outputs in (
        ("FBD_BOOLEAN_AND", _TRUE, _OUT),
        ("FBD_BOOLEAN_OR", members(BOOL, _EIGHT), _OUT),
        ("FBD_BOOLEAN_XOR", members(BOOL, "In1 In2"), _OUT),
        ("FBD_BOOLEAN_NOT", members(BOOL, "In"), _OUT),
        ("FBD_MATH", members(REAL, "SourceA SourceB"), _DEST[REAL]),
        ("FBD_MATH_ADVANCED", members(REAL, "Source"), _DEST[REAL]),
        ("FBD_TRUNCATE", members(REAL, "Source"), _DEST[DINT]),
        ("FBD_CONVERT", members(DINT, "Source"), _DEST[DINT]),
        ("FBD_COMPARE", members(REAL, "SourceA SourceB"), _DEST[BOOL]),
        ("FBD_LIMIT", members(REAL, "LowLimit Test HighLimit"), _DEST[BOOL]),
        ("FBD_MASK_EQUAL", members(DINT, "Source Mask Compare"), _DEST[BOOL]),
        ("FBD_LOGICAL", members(DINT, "SourceA SourceB"), _DEST[DINT]),
        ("FBD_MASKED_MOVE", members(DINT, "Source Mask Target"), _DEST[DINT]),
        (
            "MULTIPLEXER",
            (*members(REAL, _EIGHT), Member("Selector", DINT, initial=1)),
            (*members(REAL, "Out"), *members(DINT, "Status"), *members(BOOL, "InstructFault SelectorInv")),
        ),
    )
}
"""Structures of blocks that only diagrams have."""
