"""The AMCI 3601: its words, bits, commands and rules, as data.

The same eight words mean different things in configuration mode and in command
mode, as selected by bit 15 of word 0:

    direction  configuration mode     command mode
    output     `Configuration`        a `Command`, see `decode`; `BlendHeader`, `BlendSegment`
    input      `ConfigurationStatus`  `Status`; live: `StatusView`

Each has a method `to_image`; `from_image` or `decode` is its exact inverse.

A configuration with external input, home switch, emergency stop and both end limits (all active high), step
and direction outputs, and a starting speed of 12,345 steps/s [chapter 3]:

>>> from scanrack.io_images import Image
>>> configuration = Configuration.from_image(Image([0x843E, 0x003F, 12, 345]))
>>> configuration.homing, configuration.starting_speed
(<HomingKind.HOME_SWITCH: (True, False, False)>, 12345)

A relative move of -12,000 steps, and the module's response at its end:

>>> Move(MoveKind.RELATIVE, target=-12_000, speed=5_000, acceleration=20, deceleration=10).to_image()
Image([2, 0, -12, 0, 5, 0, 20, 10])
>>> view = StatusView(Image([0x4080, 0, -12, 0]))
>>> view.MOVE_COMPLETE, view.position
(True, -12000)

The rule table has the reason for a refusal:

>>> RULES["CMD-06"].text
'An absolute move was commanded while the current position was not valid.'
"""

from __future__ import annotations

from .bits import (
    ALL_INPUTS,
    COMPLETION_BITS,
    ERROR_BITS,
    LIVE_BITS,
    MOTIONS,
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
from .parameters import LIMITS_3601, Limits, Parameters, target_in_range
from .rules import RULES, Rule, StatusBits, bit_names
from .status import ConfigurationStatus, Status, StatusView
from .words import WORDS_3601, Profile

__all__ = [
    "ALL_INPUTS",
    "COMPLETION_BITS",
    "ERROR_BITS",
    "KNOWN",
    "LIMITS_3601",
    "LIVE_BITS",
    "MOTIONS",
    "RULES",
    "WORDS_3601",
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
    "Limits",
    "Manual",
    "Move",
    "MoveKind",
    "Parameters",
    "PresetEncoder",
    "PresetPosition",
    "Profile",
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
    "status_names",
    "target_in_range",
]
