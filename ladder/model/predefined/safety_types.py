"""Structures of the safety instructions, and the words of their lists."""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, LINT, DataType, Member, Structure


def _members(kind: DataType, names: str) -> tuple[Member, ...]:
    return tuple(Member(name, kind) for name in names.split())


DCI_STOP = Structure(
    "DCI_STOP",
    (
        *_members(BOOL, "EnableIn ChannelA ChannelB InputStatus Reset RestartType ColdStartType"),
        *_members(DINT, "SafetyFunction InputType DiscrepancyTime"),
        *_members(BOOL, "EnableOut O1 FP"),
        *_members(DINT, "FaultCode DiagnosticCode"),
    ),
    hidden=(
        *_members(BOOL, "reset valid tested free apart both"),
        *_members(DINT, "left"),
        Member("since_ns", LINT),
    ),
)
CONFIGURABLE_ROUT = Structure(
    "CONFIGURABLE_ROUT",
    (
        *_members(BOOL, "EnableIn Actuate FeedbackType Feedback1 Feedback2 InputStatus OutputStatus Reset"),
        *_members(DINT, "FeedbackReactionTime"),
        *_members(BOOL, "EnableOut O1 O2 FP"),
        *_members(DINT, "FaultCode DiagnosticCode"),
    ),
    hidden=(*_members(BOOL, "reset valid powered settled moved held"), Member("since_ns", LINT)),
)

SAFETY: Mapping[str, Structure] = {"DCS": DCI_STOP, "CROUT": CONFIGURABLE_ROUT}
"""What each instruction works on."""

FUNCTIONS = (
    *("EMERGENCY STOP", "E-STOP", "SAFETY GATE", "LIGHT CURTAIN", "AREA SCANNER", "SAFETY MAT"),
    *("CABLE PULL SWITCH", "ROPE PULL SWITCH", "USER DEFINED"),
)
INPUT_TYPES = ("EQUIVALENT - ACTIVE HIGH", "COMPLEMENTARY")
STARTS = ("MANUAL", "AUTOMATIC")
FEEDBACKS = ("NEGATIVE", "POSITIVE")
WORDS = (*FUNCTIONS, *INPUT_TYPES, *STARTS, *FEEDBACKS)
"""All words, as rungs print them."""
