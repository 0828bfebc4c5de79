"""Finds eight output words that a 3601 refuses in any state, by the module's own table of refusals.

Words that the program text does not determine are tried with several values. A rule counts only if all of
them break it.
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
"""The rules that words break at rest, each with the word that breaks it. Others need the module's state."""

RANGES = frozenset({"CMD-04", "CMD-05", "CMD-20", "CMD-31", "FOL-02", "HOM-01"})
"""Those of the rules that are about ranges."""

WAYS_ON = {
    "CMD-02": "clear the one bit before you set the other",
    "CMD-09": "zero words 4 to 7 first",
    "CMD-17": "zero words 2 to 7 first",
    "HOM-02": "zero words 2 and 3 first",
    "HOM-03": "use the end limit of this direction in the configuration",
    "CMD-11": "configure the encoder",
    "CMD-29": "configure the encoder",
    "ENC-05": "configure the encoder",
}
"""What to do about a rule, where the rule does not say so."""

_FILLED = ((0, 0, 0, 0, 0, 0, 0, 0), (0, 0, 0, 1, 100, 0, 1, 1), (0, 0, 8000, 999, 999, 999, 2000, 2000))
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
    """Return the rules that words break at rest.

    Args:
        words: the eight signed words, with None for unknown ones; the first one is known.
        configuration: configuration of the module; None if it is unknown.
    """
    used_configuration = configuration or ANY_CONFIGURATION
    state = SimpleNamespace(configuration=used_configuration, start_sps=used_configuration.starting_speed)
    at_rest = SimpleNamespace(state=state, firmware=firmware, profile=profile)  # what these rules read
    host = cast("Host", at_rest)
    first, *others = [_rules(host, _filled(words, values)) for values in _FILLED]
    names = [rule for rule in first if all(rule in other for other in others)]
    return tuple(_breach(name, words, profile) for name in dict.fromkeys(names))


def wrong_configuration(words: Sequence[int | None], firmware: Firmware, profile: Profile) -> tuple[str, ...]:
    """Return the rules that the words of a configuration break."""
    limits = profile.limits
    first, *others = [check(_filled(words, values), firmware, limits) for values in _FILLED[:2]]
    return tuple(reason for reason in first if all(reason in other for other in others))


def _filled(words: Sequence[int | None], values: Sequence[int]) -> tuple[int, ...]:
    filled = [value if word is None else word for word, value in zip(words, values, strict=True)]
    for high, low in ((2, 3), (4, 5)):
        high_word, low_word = words[high], words[low]
        if high_word is None and low_word is not None and low_word < 0:
            filled[high] = -filled[high]
        if low_word is None and high_word is not None and high_word < 0:
            filled[low] = -filled[low]
    return tuple(filled)


def _rules(host: Host, words: Sequence[int]) -> list[str]:
    command = CommandWords(words)
    bits = command.msw & COMMAND_BITS
    if command.many_bits:
        return ["CMD-02"]  # this rule is enough
    rules = [reason.rule for reason in _of_words(host, command, _reasons(host, command))]
    if bits & MOVES:
        own = host.profile.further_refusals
        rules += [rule for rule, is_broken in own if is_broken(command.words, command.parameters)]
    return [*rules, *["LSW-03"] * bool(bits & CommandMsw.RESERVED_14.value)]


def _reasons(host: Host, command: CommandWords) -> refusals.Refusals:
    if command.lsw & CommandLsw.ENC_FOLLOWER and host.firmware.follower and command.msw:
        return refusals.FOLLOWER_WORDS
    if command.lsw & CommandLsw.STORE_MIN_REG and host.firmware.registration:
        return (*refusals.STORE_MINIMUM, *refusals.refusals_of(host, command))
    return refusals.refusals_of(host, command)


def _of_words(host: Host, command: CommandWords, reasons: refusals.Refusals) -> list[refusals.RefusalRule]:
    of_words = [
        reason for reason in reasons if reason.rule in LAST_WORD and reason.broken is not refusals.busy
    ]
    return [reason for reason in of_words if reason.broken(host, command)]


def _breach(rule: str, words: Sequence[int | None], profile: Profile) -> Breach:
    row = profile.rules[rule]
    return Breach(rule, _word(rule, words, profile), f"{row.text.rstrip('.')} [{row.section}]")


def _word(rule: str, words: Sequence[int | None], profile: Profile) -> int:
    """Return the word that breaks a rule; if there are several, the first one without a legal value."""
    places = LAST_WORD.get(rule, (0,))
    if rule == "CMD-04":
        parameters = CommandWords(_filled(words, _FILLED[1])).parameters
        rates = ((6, parameters.acceleration), (7, parameters.deceleration))
        wrong = [place for place, rate in rates if not profile.limits.takes_rate(rate)]
        legal = profile.limits.takes_speed(parameters.speed)
        return 3 if not parameters.target_in_range else (*wrong, 5)[0] if legal else 5
    return next((place for place in places if words[place]), places[0])
