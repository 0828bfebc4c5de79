"""Structures and keywords of the safety instructions."""

from __future__ import annotations

from collections.abc import Mapping

from ..types import Structure, members_of

DCI_STOP = Structure(
    "DCI_STOP",
    members_of(
        "BOOL EnableIn ChannelA ChannelB InputStatus Reset RestartType ColdStartType "
        "DINT SafetyFunction InputType DiscrepancyTime BOOL EnableOut O1 FP DINT FaultCode DiagnosticCode"
    ),
    hidden=members_of("BOOL reset valid tested free apart both DINT left LINT since_ns"),
)
CONFIGURABLE_ROUT = Structure(
    "CONFIGURABLE_ROUT",
    members_of(
        "BOOL EnableIn Actuate FeedbackType Feedback1 Feedback2 InputStatus OutputStatus Reset "
        "DINT FeedbackReactionTime BOOL EnableOut O1 O2 FP DINT FaultCode DiagnosticCode"
    ),
    hidden=members_of("BOOL reset valid powered settled moved held LINT since_ns"),
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
