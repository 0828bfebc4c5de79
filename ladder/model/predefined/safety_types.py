"""Structures and keywords of the safety instructions."""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, LINT, Member, Structure, members

DCI_STOP = Structure(
    "DCI_STOP",
    (
        *members(BOOL, "EnableIn ChannelA ChannelB InputStatus Reset RestartType ColdStartType"),
        *members(DINT, "SafetyFunction InputType DiscrepancyTime"),
        *members(BOOL, "EnableOut O1 FP"),
        *members(DINT, "FaultCode DiagnosticCode"),
    ),
    hidden=(
        *members(BOOL, "reset valid tested free apart both"),
        *members(DINT, "left"),
        Member("since_ns", LINT),
    ),
)
CONFIGURABLE_ROUT = Structure(
    "CONFIGURABLE_ROUT",
    (
        *members(BOOL, "EnableIn Actuate FeedbackType Feedback1 Feedback2 InputStatus OutputStatus Reset"),
        *members(DINT, "FeedbackReactionTime"),
        *members(BOOL, "EnableOut O1 O2 FP"),
        *members(DINT, "FaultCode DiagnosticCode"),
    ),
    hidden=(*members(BOOL, "reset valid powered settled moved held"), Member("since_ns", LINT)),
)

SAFETY: Mapping[str, Structure] = {"DCS": DCI_STOP, "CROUT": CONFIGURABLE_ROUT}
"""Structure of each safety instruction."""

FUNCTIONS = (
    *("EMERGENCY STOP", "E-STOP", "SAFETY GATE", "LIGHT CURTAIN", "AREA SCANNER", "SAFETY MAT"),
    *("CABLE PULL SWITCH", "ROPE PULL SWITCH", "USER DEFINED"),
)
INPUT_TYPES = ("EQUIVALENT - ACTIVE HIGH", "COMPLEMENTARY")
STARTS = ("MANUAL", "AUTOMATIC")
FEEDBACKS = ("NEGATIVE", "POSITIVE")
WORDS = (*FUNCTIONS, *INPUT_TYPES, *STARTS, *FEEDBACKS)
