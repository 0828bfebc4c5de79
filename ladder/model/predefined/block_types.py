"""Structures of function blocks: those that structured text calls, and those of diagrams alone.

[1756-RM003 and 1756-RM006, structures of each block]
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import (
    BOOL,
    DINT,
    FBD_COUNTER,
    FBD_ONESHOT,
    FBD_TIMER,
    LINT,
    LREAL,
    REAL,
    Elementary,
    Member,
    Structure,
    members,
)


def _block(name: str, parameters: Mapping[Elementary, str], hidden: tuple[Member, ...] = ()) -> Structure:
    """Return a structure: EnableIn, the parameters by type, EnableOut."""
    members = [Member(each, kind) for kind, names in parameters.items() for each in names.split()]
    enables = Member("EnableIn", BOOL, initial=True), Member("EnableOut", BOOL)
    return Structure(name, (enables[0], *members, enables[1]), hidden=hidden)


SCALE = _block(
    "SCALE",
    {
        REAL: "In InRawMax InRawMin InEUMax InEUMin Out",
        BOOL: "Limiting MaxAlarm MinAlarm InstructFault InRawRangeInv",
        DINT: "Status",
    },
)
HL_LIMIT = _block(
    "HL_LIMIT",
    {
        REAL: "In HighLimit LowLimit Out",
        DINT: "SelectLimit Status",
        BOOL: "HighAlarm LowAlarm InstructFault LimitsInv SelectLimitInv",
    },
)
SELECT = _block("SELECT", {REAL: "In1 In2 Out", BOOL: "SelectorIn"})
SELECTABLE_NEGATE = _block("SELECTABLE_NEGATE", {REAL: "In Out", BOOL: "NegateEnable"})
_CAPTURED = {REAL: "In ResetValue Out", BOOL: "Reset"}
MAXIMUM_CAPTURE = _block("MAXIMUM_CAPTURE", _CAPTURED, (Member("begun", BOOL),))
MINIMUM_CAPTURE = _block("MINIMUM_CAPTURE", _CAPTURED, (Member("begun", BOOL),))
DOMINANT_SET = _block("DOMINANT_SET", {BOOL: "Set Reset Out OutNot"})
DOMINANT_RESET = _block("DOMINANT_RESET", {BOOL: "Set Reset Out OutNot"})
FLIP_FLOP_D = _block("FLIP_FLOP_D", {BOOL: "D Clear Clock Q QNot"}, (Member("before", BOOL),))
FLIP_FLOP_JK = _block("FLIP_FLOP_JK", {BOOL: "Clear Clock Q QNot"}, (Member("before", BOOL),))
UP_DOWN_ACCUM = _block("UP_DOWN_ACCUM", {BOOL: "Initialize Hold", REAL: "InitialValue InPlus InMinus Out"})
RATE_LIMITER = _block(
    "RATE_LIMITER",
    {
        REAL: "In IncRate DecRate Out DeltaT",
        BOOL: "ByPass InstructFault IncRateInv DecRateInv",
        DINT: "TimingMode RTSTime RTSTimeStamp Status",
    },
    (Member("begun", BOOL), Member("last_ns", LINT), Member("exact", LREAL)),
)

BLOCKS: Mapping[str, Structure] = {
    "SCL": SCALE,
    "RLIM": RATE_LIMITER,
    "UPDN": UP_DOWN_ACCUM,
    "SEL": SELECT,
    "SNEG": SELECTABLE_NEGATE,
    "HLL": HL_LIMIT,
    "MAXC": MAXIMUM_CAPTURE,
    "MINC": MINIMUM_CAPTURE,
    "DFF": FLIP_FLOP_D,
    "JKFF": FLIP_FLOP_JK,
    "RESD": DOMINANT_RESET,
    "SETD": DOMINANT_SET,
}
"""Structure of each block instruction."""

BLOCK_STRUCTURES: Mapping[str, Structure] = {
    **dict.fromkeys(("TONR", "TOFR", "RTOR"), FBD_TIMER),
    "CTUD": FBD_COUNTER,
    **dict.fromkeys(("OSRI", "OSFI"), FBD_ONESHOT),
    **BLOCKS,
}
"""The same with timers, counter and one-shots."""

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
