"""Finds output words that a 3601 refuses in any state, by the module's own table of refusals.

Each word that the program text does not determine is tried with several values. A rule counts as broken only
if every value breaks it.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import NamedTuple, cast

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, Configuration, Firmware, check
from scanrack.io_images.amci3601.words import Profile
from scanrack.runtime.modules.amci3601 import refusals
from scanrack.runtime.modules.amci3601.command_layer import MOVES
from scanrack.runtime.modules.amci3601.command_words import COMMAND_BITS, CommandWords
from scanrack.runtime.modules.amci3601.operation import Host

LAST_WORD: dict[str, Sequence[int]] = {
    "CMD-02": (0,),
    "CMD-04": (3, 5, 6, 7),
    "CMD-05": (5,),
    "CMD-09": (4, 5, 6, 7),
    "CMD-10": (1,),
    "CMD-11": (0,),
    "CMD-12": (3,),
    "CMD-17": (2, 3, 4, 5, 6, 7),
    "CMD-20": (3,),
    "CMD-23": (3,),
    "CMD-24": (3,),
    "CMD-29": (1,),
    "CMD-31": (2, 3),
    "CMD-32": (4, 5),
    "CMD-34": (0,),
    "CMD-36": (1,),
    "ENC-05": (1,),
    "FOL-02": (6, 7),
    "HOM-01": (5,),
    "HOM-02": (2, 3),
    "HOM-03": (0,),
    "IOM-20": (1,),
    "LSW-03": (0,),
    "PST-08": (1,),
    "REG-10": (0, 4, 5, 6, 7),
    "RST-02": (1,),
}
"""Rules that a module at rest can refuse, each with the words that can break it.

The other rules depend on the module's state.
"""

RANGES = frozenset({"CMD-04", "CMD-05", "CMD-20", "CMD-31", "FOL-02", "HOM-01"})
"""The rules of `LAST_WORD` about ranges."""

REMEDIES = {
    "CMD-02": "clear the one bit before you set the other",
    "CMD-09": "zero words 4 to 7 first",
    "CMD-17": "zero words 2 to 7 first",
    "HOM-02": "zero words 2 and 3 first",
    "HOM-03": "use the end limit of this direction in the configuration",
    "CMD-11": "configure the encoder",
    "CMD-29": "configure the encoder",
    "ENC-05": "configure the encoder",
}
"""Remedies for rules without a remedy in their own text."""

_TRIALS = ((0, 0, 0, 0, 0, 0, 0, 0), (0, 0, 0, 1, 100, 0, 1, 1), (0, 0, 8000, 999, 999, 999, 2000, 2000))
"""Values that are tried for unknown words."""


class Breach(NamedTuple):
    """A rule that words break, and the word that breaks it."""

    rule: str
    word: int
    text: str  # the rule, with its section

    def __str__(self) -> str:
        return self.text


ANY_CONFIGURATION = Configuration(inputs_used=0x3F, quadrature_encoder=True, starting_speed=1)
"""A configuration that allows every command."""


def broken(
    words: Sequence[int | None], configuration: Configuration | None, firmware: Firmware, profile: Profile
) -> tuple[Breach, ...]:
    """Return the rules that the words break at rest.

    Args:
        words: the eight signed words, with None for an unknown word. Word 0 must be known.
        configuration: configuration of the module; None if it is unknown.
    """
    used_configuration = configuration or ANY_CONFIGURATION
    state = SimpleNamespace(configuration=used_configuration, start_sps=used_configuration.starting_speed)
    at_rest = SimpleNamespace(state=state, firmware=firmware, profile=profile)  # all that these rules read
    host = cast("Host", at_rest)
    rules_by_trial = [_rules_broken(host, _filled(words, trial)) for trial in _TRIALS]
    return tuple(_breach(rule, words, profile) for rule in dict.fromkeys(_in_all(rules_by_trial)))


def wrong_configuration(words: Sequence[int | None], firmware: Firmware, profile: Profile) -> tuple[str, ...]:
    """Return the rules that the words of a configuration break."""
    return tuple(_in_all([check(_filled(words, trial), firmware, profile.limits) for trial in _TRIALS[:2]]))


def _in_all(rules_by_trial: Sequence[Sequence[str]]) -> list[str]:
    """Return the rules that all trials break."""
    first, *others = rules_by_trial
    return [rule for rule in first if all(rule in rules for rules in others)]


def _filled(words: Sequence[int | None], trial: Sequence[int]) -> tuple[int, ...]:
    """Fill in unknown words with trial values; both words of a number get the same sign."""
    filled = [value if word is None else word for word, value in zip(words, trial, strict=True)]
    for high, low in ((2, 3), (4, 5)):
        high_word, low_word = words[high], words[low]
        if high_word is None and low_word is not None and low_word < 0:
            filled[high] = -filled[high]
        if low_word is None and high_word is not None and high_word < 0:
            filled[low] = -filled[low]
    return tuple(filled)


def _rules_broken(host: Host, words: Sequence[int]) -> list[str]:
    """Return the rules that a command breaks at rest, without those that depend on the module's state."""
    command = CommandWords(words)
    bits = command.msw & COMMAND_BITS
    if command.many_bits:
        return ["CMD-02"]  # this rule is enough
    rules = [
        refusal.rule
        for refusal in _refusals(host, command)
        if refusal.rule in LAST_WORD and refusal.broken is not refusals.busy and refusal.broken(host, command)
    ]
    if bits & MOVES:
        further = host.profile.further_refusals
        rules += [rule for rule, is_broken in further if is_broken(command.words, command.parameters)]
    if bits & CommandMsw.RESERVED_14.value:
        rules.append("LSW-03")
    return rules


def _refusals(host: Host, command: CommandWords) -> refusals.Refusals:
    """Return the module's refusals that apply to a command."""
    if command.lsw & CommandLsw.ENC_FOLLOWER and host.firmware.follower and command.msw:
        return refusals.FOLLOWER_WORDS
    if command.lsw & CommandLsw.STORE_MIN_REG and host.firmware.registration:
        return (*refusals.STORE_MINIMUM, *refusals.refusals_of(host, command))
    return refusals.refusals_of(host, command)


def _breach(rule: str, words: Sequence[int | None], profile: Profile) -> Breach:
    row = profile.rules[rule]
    return Breach(rule, _word_at_fault(rule, words, profile), f"{row.text.rstrip('.')} [{row.section}]")


def _word_at_fault(rule: str, words: Sequence[int | None], profile: Profile) -> int:
    """Return the word that breaks a rule: the first illegal word for CMD-04, else the first nonzero one."""
    if rule != "CMD-04":
        candidates = LAST_WORD.get(rule, (0,))
        return next((word for word in candidates if words[word]), candidates[0])
    parameters = CommandWords(_filled(words, _TRIALS[1])).parameters
    if not parameters.target_in_range:
        return 3
    if profile.limits.takes_speed(parameters.speed):
        for word, rate in ((6, parameters.acceleration), (7, parameters.deceleration)):
            if not profile.limits.takes_rate(rate):
                return word
    return 5
