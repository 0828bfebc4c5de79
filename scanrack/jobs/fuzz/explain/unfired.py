"""Explains why error rules of the manual never fired in a campaign, by the first reason that applies.

A rule needs commands from the program, a configuration, and active inputs, see `NEEDS`. `NEEDS` has no
conditions on numbers, such as a speed below the starting speed. If only a number is out of its range, the
last reason applies: the rule's conditions were never met together.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import reduce
from itertools import chain
from operator import and_, or_
from typing import NamedTuple

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, ConfigMsw, InputBit
from scanrack.io_images.amci3601.bits import MOTIONS, StatusMsw
from scanrack.io_images.amci3601.firmware import KNOWN, Firmware
from scanrack.io_images.amci3601.rules.rule import Rule
from scanrack.io_images.amci3601.words import WORDS_3601, Profile, is_stepper
from scanrack.io_images.drives.rules import rules_of
from scanrack.io_images.drives.translation import model_of
from scanrack.runtime.config.rackspec import SlotSpec, profile_in
from scanrack.runtime.loop.rack import Slot

_LSW = 16
"""Position of the second command word in a mask over both words, bits."""

HOME = (CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW).value
MANUAL = (CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW).value
RUN_BLEND = (CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW).value
MOVE = MOTIONS.value
PROGRAMMED = MOVE & ~MANUAL
ABSOLUTE = CommandMsw.ABSOLUTE_MOVE.value
HOLD = CommandMsw.HOLD_MOVE.value
RESUME = CommandMsw.RESUME_MOVE.value
STOP = CommandMsw.IMMEDIATE_STOP.value
PRESET = (CommandMsw.PRESET_POSITION | CommandMsw.PRESET_ENCODER).value
PRESET_ENCODER = CommandMsw.PRESET_ENCODER.value
CONFIGURE = CommandMsw.MODE_CONFIG.value
S_CURVE = CommandLsw.S_CURVE.value << _LSW
ENCODER_MOVE = CommandLsw.ENCODER_MOVE.value << _LSW
FOLLOWER = CommandLsw.ENC_FOLLOWER.value << _LSW
BLEND_PROGRAM = CommandLsw.BLEND_PROGRAM.value << _LSW
STORE_MIN_REG = CommandLsw.STORE_MIN_REG.value << _LSW

ENCODER = ConfigMsw.QUADRATURE_ENCODER.value
EXTERNAL = ConfigMsw.USE_EXTERNAL.value
ESTOP = ConfigMsw.USE_ESTOP.value
CW = ConfigMsw.USE_CW_LIMIT.value
CCW = ConfigMsw.USE_CCW_LIMIT.value
LIMIT = CW | CCW


class Need(NamedTuple):
    """The conditions that must be met before a rule can fire.

    Attributes:
        commands: masks over both command words. The program must set a bit of each mask at some time.
        configured: masks over the first configuration word. Some configuration must have a bit of each mask.
            The inputs in a mask must be active at some time.
        lacks: mask over the first configuration word. Some configuration must lack one of its bits. 0 = no
            such condition.
    """

    commands: tuple[int, ...] = ()
    configured: tuple[int, ...] = ()
    lacks: int = 0


_REGISTRATION = Need((MANUAL,))
_STILL_ACTIVE = Need((MANUAL,), (EXTERNAL,))
_BOTH_LIMITS = Need((HOME,), (CW, CCW))
_WRONG_LIMIT = Need((HOME,), (LIMIT,))
_FOLLOWING = Need((FOLLOWER,), (ENCODER,))

# fmt: off
NEEDS: Mapping[str, Need] = {
    "HOM-01": Need((HOME,)), "HOM-02": Need((HOME,)), "HOM-03": Need((HOME,), lacks=LIMIT),
    "HOM-04": _BOTH_LIMITS, "HOM-05": _WRONG_LIMIT,
    "PRF-01": Need((PROGRAMMED,)), "PRF-02": Need((MOVE,)), "PRF-03": Need((MOVE,)),
    "PRF-04": Need((BLEND_PROGRAM,)), "PRF-05": Need((BLEND_PROGRAM,)), "PRF-06": Need((BLEND_PROGRAM,)),
    "PRF-07": Need((BLEND_PROGRAM,)), "PRF-08": Need((MANUAL,)), "PRF-09": Need((MANUAL,)),
    "PRF-10": Need((MANUAL,)), "PRF-11": Need((ENCODER_MOVE,), lacks=ENCODER), "PRF-12": _STILL_ACTIVE,
    "PRF-13": _REGISTRATION, "PRF-14": _REGISTRATION, "PRF-15": _REGISTRATION, "PRF-16": _REGISTRATION,
    "PRF-17": _REGISTRATION, "PRF-18": _REGISTRATION,
    "POS-01": Need((CONFIGURE,)), "POS-02": Need((STOP, MOVE)), "POS-03": Need((MOVE,), (ESTOP,)),
    "POS-04": Need((MOVE,), (LIMIT,)), "POS-05": _BOTH_LIMITS, "POS-06": _WRONG_LIMIT,
    "INP-01": Need((), (ESTOP,)), "INP-02": Need((MOVE,), (LIMIT,)), "INP-03": Need((MANUAL,), (LIMIT,)),
    "INP-04": _BOTH_LIMITS, "INP-05": _WRONG_LIMIT,
    "CMD-01": Need((CONFIGURE, MOVE)), "CMD-02": Need((MOVE | HOLD | RESUME | STOP | PRESET,)),
    "CMD-03": Need((MOVE,)), "CMD-04": Need((MOVE | PRESET,)), "CMD-05": Need((PROGRAMMED,)),
    "CMD-06": Need((ABSOLUTE,)), "CMD-07": Need((HOLD,)), "CMD-08": Need((RESUME,)),
    "CMD-09": Need((PRESET,)),
    "CMD-10": Need((HOME, S_CURVE)), "CMD-11": Need((PRESET_ENCODER,), lacks=ENCODER),
    "CMD-12": Need((MANUAL,)), "CMD-13": Need((MANUAL,)), "CMD-14": Need((MANUAL,)),
    "CMD-15": Need((MANUAL,)),
    "CMD-16": Need((RUN_BLEND,)), "CMD-17": Need((RUN_BLEND,)), "CMD-18": Need((BLEND_PROGRAM, RUN_BLEND)),
    "CMD-19": Need((HOLD, RUN_BLEND)), "CMD-20": Need((STORE_MIN_REG,)), "CMD-21": Need((HOLD, MANUAL)),
    "CMD-22": _STILL_ACTIVE, "CMD-23": _REGISTRATION, "CMD-24": _REGISTRATION, "CMD-25": _REGISTRATION,
    "CMD-26": _REGISTRATION, "CMD-27": _REGISTRATION, "CMD-28": _REGISTRATION,
    "CMD-29": Need((FOLLOWER,), lacks=ENCODER), "CMD-30": Need((FOLLOWER, MOVE), (ENCODER,)),
    "CMD-31": _FOLLOWING, "CMD-32": _FOLLOWING, "CMD-33": Need((FOLLOWER, MANUAL), (ENCODER,)),
    "CMD-34": Need((FOLLOWER, MOVE & ~MANUAL), (ENCODER,)), "CMD-35": Need((FOLLOWER, MANUAL), (ENCODER,)),
    "CMD-36": Need((FOLLOWER, S_CURVE), (ENCODER,)),
    "CER-01": Need(), "CER-02": Need((CONFIGURE,)),
}
"""The conditions of each rule in the lists of chapter 6, from the rule's sentence in `RULES`."""
# fmt: on


def error_rules(profile: Profile = WORDS_3601) -> list[Rule]:
    """Return the rules in the lists of chapter 6 and the rules for a module's own refusals, in rule order."""
    own_refusals = {rule_id for rule_id, _ in profile.further_refusals}
    return [
        rule
        for rule in profile.rules.values()
        if (rule.list_of or 0) & profile.error_bits or rule.id in own_refusals
    ]


class ErrorRules(NamedTuple):
    """The error rules of a rack's modules.

    Attributes:
        owners: names of the modules, or the chapter.
        ids: rule ids without duplicates. Module families share some ids.
    """

    owners: str
    ids: Sequence[str]


def rules_in(slots: Iterable[SlotSpec]) -> ErrorRules:
    """Return the error rules of the modules in a rack; the rules of a 3601 if no module has any."""
    slots = tuple(slots)
    models = {model.title: model for slot in slots if (model := model_of(slot.words))}
    ids_by_owner = {f"the {title}": [rule.id for rule in rules_of(model)] for title, model in models.items()}
    if not models or any(is_stepper(slot.words) for slot in slots):
        chapter_ids = [rule.id for rule in error_rules(profile_in(slots, None))]
        ids_by_owner = {"chapter 6": chapter_ids, **ids_by_owner}
    unique_ids = list(dict.fromkeys(chain.from_iterable(ids_by_owner.values())))
    return ErrorRules(" and ".join(ids_by_owner), unique_ids)


class UnfiredReason(IntEnum):
    """The reasons, most specific first. The last reason applies if no other reason does."""

    UNTESTABLE = 0
    COMMAND = 1
    FIRMWARE = 2
    CONFIGURATION = 3
    INPUTS = 4
    APART = 5


WORDS: Mapping[UnfiredReason, str] = {
    UnfiredReason.UNTESTABLE: "no image can show it",
    UnfiredReason.COMMAND: "the program never sends the command",
    UnfiredReason.FIRMWARE: "the firmware has no such rule",
    UnfiredReason.CONFIGURATION: "the configuration excludes it",
    UnfiredReason.INPUTS: "no scenario made the input active",
    UnfiredReason.APART: "its conditions were never met together",
}
"""The text of each reason, for a summary."""


class UnfiredRule(NamedTuple):
    """A rule that never fired, with the reason.

    Attributes:
        reason: kind of the reason.
        sentence: the reason as a sentence with names.
    """

    rule: Rule
    reason: UnfiredReason
    sentence: str


@dataclass(slots=True)
class WordHistory:
    """The values that a 3601's words have had so far.

    Attributes:
        commands: bits that the command words had in command mode; the second word is shifted by 16 bits.
        configurations: first output words in configuration mode.
        inputs: inputs that were active, as bits of `InputBit`.
    """

    commands: int = 0
    configurations: set[int] = field(default_factory=set)
    inputs: int = 0

    def note(self, slot: Slot) -> None:
        """Add the words of a scan."""
        first, second = slot.outputs.words[0], slot.outputs.words[1]
        if first & CONFIGURE:
            self.commands |= CONFIGURE
            self.configurations.add(first & 0xFFFF)
        else:
            self.commands |= (first & 0xFFFF) | (second & 0xFFFF) << _LSW
        if not slot.inputs.words[0] & StatusMsw.MODE_CONFIG.value:
            self.inputs |= slot.inputs.words[1] & _ALL_INPUTS


_ALL_INPUTS = reduce(or_, InputBit).value


def unfired(
    fired: Container[str],
    words: Mapping[int, WordHistory],
    oldest: Mapping[int, Firmware],
    profile: Profile = WORDS_3601,
) -> list[UnfiredRule]:
    """Return each error rule that never fired, with the first reason that applies.

    With several modules, the reason is for the module that came closest to the error.

    Args:
        fired: ids of the rules that have fired.
        words: history of each module's words, by slot.
        oldest: oldest firmware of each module in the search, by slot. The search also tries newer versions.
    """
    if not words:
        return []
    rules = [rule for rule in error_rules(profile) if rule.id not in fired]
    return [_closest(_first_reason(rule, words[slot], oldest[slot]) for slot in words) for rule in rules]


def _closest(reasons: Iterable[UnfiredRule]) -> UnfiredRule:
    return max(reasons, key=lambda unfired_rule: unfired_rule.reason)


def _first_reason(rule: Rule, words: WordHistory, oldest: Firmware) -> UnfiredRule:
    return next(_reasons(rule, NEEDS.get(rule.id, Need((MOVE,))), words, oldest))


def _reasons(rule: Rule, need: Need, words: WordHistory, oldest: Firmware) -> Iterator[UnfiredRule]:
    """Yield the reasons that apply, most specific first. The last reason always applies."""
    kind = UnfiredReason
    if not rule.testable:
        yield UnfiredRule(rule, kind.UNTESTABLE, rule.untestable_because)
    for mask in _missing(need.commands, words.commands):
        yield UnfiredRule(rule, kind.COMMAND, f"the program never sends {_command_names(mask)}")
    if not any(rule.applies_to(version) for version in KNOWN if version >= oldest):
        yield UnfiredRule(rule, kind.FIRMWARE, f"no firmware from {oldest} on has this rule")
    for mask in _missing(need.configured, reduce(or_, words.configurations, 0)):
        yield UnfiredRule(rule, kind.CONFIGURATION, f"no configuration has {_names(ConfigMsw(mask), ' or ')}")
    if need.lacks and words.configurations and reduce(and_, words.configurations) & need.lacks == need.lacks:
        bits = _names(ConfigMsw(need.lacks), " and ")
        yield UnfiredRule(rule, kind.CONFIGURATION, f"every configuration has {bits}")
    inputs = filter(None, (mask & _ALL_INPUTS for mask in need.configured))
    for mask in _missing(inputs, words.inputs):
        yield UnfiredRule(rule, kind.INPUTS, f"{_names(InputBit(mask), ' or ')} was never active")
    yield UnfiredRule(rule, kind.APART, WORDS[kind.APART])


def _missing(masks: Iterable[int], bits: int) -> Iterator[int]:
    """Yield the masks without any of the bits."""
    return (mask for mask in masks if not bits & mask)


def _command_names(mask: int) -> str:
    first, second = CommandMsw(mask & 0xFFFF), CommandLsw(mask >> _LSW)
    return _names(first or second, " or ")


def _names(bits: CommandMsw | CommandLsw | ConfigMsw | InputBit, separator: str) -> str:
    return separator.join(str(bit.name) for bit in bits)
