"""The AMCI 3601: its words, bits, commands and rules, as data."""

from __future__ import annotations

from .bits import (
    ALL_INPUTS,
    COMPLETION_BITS,
    ERROR_BITS,
    LIVE_BITS,
    CommandLsw,
    CommandMsw,
    ConfigMsw,
    InputBit,
    StatusLsw,
    StatusMsw,
    status_names,
)
from .blend import Acceleration, BlendHeader, BlendSegment
from .command import (
    Command,
    Hold,
    Idle,
    ImmediateStop,
    PresetEncoder,
    PresetPosition,
    ResetErrors,
    StoreMinimumRegistration,
    decode,
)
from .configuration import Configuration, HomingKind, check
from .firmware import KNOWN, Firmware
from .moves import Direction, FindHome, Follower, Manual, Move, MoveKind, Resume, RunBlend
from .parameters import Parameters, rate_in_range, speed_in_range, target_in_range
from .rules import RULES, Rule, StatusBits, bit_names
from .status import ConfigurationStatus, Status, StatusView

__all__ = [
    "ALL_INPUTS",
    "COMPLETION_BITS",
    "ERROR_BITS",
    "KNOWN",
    "LIVE_BITS",
    "RULES",
    "Acceleration",
    "BlendHeader",
    "BlendSegment",
    "Command",
    "CommandLsw",
    "CommandMsw",
    "ConfigMsw",
    "Configuration",
    "ConfigurationStatus",
    "Direction",
    "FindHome",
    "Firmware",
    "Follower",
    "Hold",
    "HomingKind",
    "Idle",
    "ImmediateStop",
    "InputBit",
    "Manual",
    "Move",
    "MoveKind",
    "Parameters",
    "PresetEncoder",
    "PresetPosition",
    "ResetErrors",
    "Resume",
    "Rule",
    "RunBlend",
    "Status",
    "StatusBits",
    "StatusLsw",
    "StatusMsw",
    "StatusView",
    "StoreMinimumRegistration",
    "bit_names",
    "check",
    "decode",
    "rate_in_range",
    "speed_in_range",
    "status_names",
    "target_in_range",
]
