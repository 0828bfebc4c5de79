"""Configurations that are legal, or that break exactly one rule of chapter 3."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

from hypothesis import strategies as st

from ..amci3601 import ALL_INPUTS, KNOWN, ConfigMsw, Configuration, Firmware, HomingKind, check
from ..amci3601.bits import InputBit
from ..amci3601.configuration import INVALID_CONFIGURATIONS
from ..image import Image, signed_word
from .command_values import pick, starting_speeds

NEWEST = KNOWN[-1]

HOME = InputBit.HOME.value
CAPTURE = InputBit.CAPTURE.value
INPUTS = ALL_INPUTS + 1
LIMITS = (InputBit.CW_LIMIT | InputBit.CCW_LIMIT).value
PLAIN_INPUTS = (InputBit.EXTERNAL | InputBit.HOME | InputBit.ESTOP).value | LIMITS
"""Inputs used in the manual's own example [chapter 3]."""


class FaultyConfiguration(NamedTuple):
    """Words that break one configuration rule."""

    image: Image  # the output image; bit 15 of word 0 is set
    rule: str  # id of the broken rule


def configurations(
    firmware: Firmware = NEWEST, *, homing: HomingKind | None = None, starting_speed: int | None = None
) -> st.SearchStrategy[Configuration]:
    """Return a strategy of legal configurations.

    Args:
        firmware: the version that accepts the configurations.
        homing: None = any of the four kinds.
        starting_speed: steps/s; None = any legal one.
    """
    return _configuration(
        firmware,
        st.sampled_from(HomingKind) if homing is None else st.just(homing),
        starting_speeds() if starting_speed is None else st.just(starting_speed),
    )


_OTHER_BITS = pick(
    lambda *values: values,
    (False, True),
    (False, True),
    (True, False),
    (LIMITS, InputBit.CW_LIMIT.value, InputBit.CCW_LIMIT.value),
    (*[PLAIN_INPUTS] * INPUTS, *range(INPUTS)),
    (*[ALL_INPUTS] * INPUTS, *range(INPUTS)),
)
"""Encoder, diagnostic feedback, step outputs, limits if no other input is used, used inputs and levels."""


@st.composite
def _configuration(
    draw: st.DrawFn,
    firmware: Firmware,
    homing_kinds: st.SearchStrategy[HomingKind],
    speeds: st.SearchStrategy[int],
) -> Configuration:
    """Draw all parts, even unused ones, since Hypothesis treats examples with fewer draws as simpler."""
    switch, proximity, marker = draw(homing_kinds).value
    has_encoder, feedback, step_outputs, default_limits, inputs_used, active_high = draw(_OTHER_BITS)
    encoder = marker or has_encoder
    feedback = feedback and not encoder
    inputs_used = inputs_used & ~HOME | switch * HOME
    if not inputs_used & LIMITS:
        inputs_used |= default_limits
    if not encoder and not firmware.capture_without_encoder:
        inputs_used &= ~CAPTURE
    return Configuration(
        inputs_used=inputs_used,
        active_high=active_high,
        backplane_proximity=proximity,
        quadrature_encoder=encoder,
        diagnostic_feedback=feedback,
        step_and_direction=feedback or step_outputs,
        marker_home=marker,
        starting_speed=draw(speeds),
    )


def faulty_configurations(
    firmware: Firmware = NEWEST, rules: tuple[str, ...] = ()
) -> st.SearchStrategy[FaultyConfiguration]:
    """Return a strategy of words that a firmware version rejects because of exactly one rule.

    Args:
        firmware: the version that rejects them.
        rules: ids of the rules to break; by default, any rule of this version.

    Raises:
        ValueError: no words break one of these rules in this firmware version.
    """
    breakable = [rule for rule, _ in INVALID_CONFIGURATIONS if _can_break(rule, firmware)]
    for rule in rules:
        if rule not in breakable:
            raise ValueError(
                f"no configuration of firmware {firmware} breaks only rule {rule!r}: "
                f"choose from {', '.join(breakable)}"
            )
    return st.sampled_from(rules or breakable).flatmap(lambda rule: _breaking(rule, firmware))


def _can_break(rule: str, firmware: Firmware) -> bool:
    return rule != "CFG-29" or not firmware.capture_without_encoder


@cache
def _breaking(rule: str, firmware: Firmware) -> st.SearchStrategy[FaultyConfiguration]:
    base = configurations(firmware, homing=BASES.get(rule, HomingKind.HOME_SWITCH))
    faulty_words = st.builds(_with_fault, base, FAULTS[rule])
    words_of_one_fault = faulty_words.filter(lambda words: check(words, firmware) == (rule,))
    return words_of_one_fault.map(lambda words: FaultyConfiguration(Image(words), rule))


class _Fault(NamedTuple):
    """A defect of valid words: bits of word 0 to clear and to set, and replaced words."""

    clear: int = 0
    set: int = 0
    words: Mapping[int, int] = {}


def _with_fault(configuration: Configuration, fault: _Fault) -> tuple[int, ...]:
    words = tuple(configuration.to_image())
    msw = signed_word(words[0] & 0xFFFF & ~fault.clear | fault.set)
    return tuple(fault.words.get(index, word) for index, word in enumerate((msw, *words[1:])))


def _speed(*pairs: tuple[int, int]) -> st.SearchStrategy[_Fault]:
    return st.sampled_from([_Fault(words={2: msw, 3: lsw}) for msw, lsw in pairs])


_HOME = ConfigMsw.USE_HOME.value
_ENCODER = ConfigMsw.QUADRATURE_ENCODER.value
_FEEDBACK = ConfigMsw.DIAGNOSTIC_FEEDBACK.value
_STEPS = ConfigMsw.STEP_AND_DIRECTION.value
_PROXIMITY = ConfigMsw.BACKPLANE_PROXIMITY.value
_UNUSED_MSW = (1 << 7, 1 << 11, 1 << 13, 1 << 14)

_UNUSED_BITS = st.sampled_from(
    [*(_Fault(set=bit) for bit in _UNUSED_MSW), *(_Fault(words={1: 1 << bit}) for bit in range(6, 15))]
)
_UNUSED_WORDS = st.builds(
    lambda index, value: _Fault(words={index: value}), st.integers(4, 7), st.sampled_from([1, -1, 1000])
)

FAULTS: dict[str, st.SearchStrategy[_Fault]] = {
    "CFG-01": st.just(_Fault(clear=_HOME)),
    "CFG-02": st.just(_Fault(clear=LIMITS)),
    "CFG-03": st.just(_Fault(set=_ENCODER | _FEEDBACK | _STEPS)),
    "CFG-04": st.just(_Fault(clear=_ENCODER | CAPTURE)),
    "CFG-05": st.just(_Fault(clear=_STEPS | _ENCODER | CAPTURE, set=_FEEDBACK)),
    "CFG-06": _speed((0, 0), (1000, 1), (-1, 0), (-1, 999)),
    "CFG-07": _speed((0, 1000), (1, -1), (1, 1000), (2, -999)),
    "CFG-08": _UNUSED_BITS,
    "CFG-09": st.just(_Fault(clear=_HOME)),
    "CFG-10": st.just(_Fault(set=_PROXIMITY)),
    "CFG-11": _UNUSED_WORDS,
    "CFG-29": st.just(_Fault(clear=_ENCODER, set=CAPTURE)),
}
"""Ways to break each rule of `INVALID_CONFIGURATIONS`."""

BASES = dict.fromkeys(("CFG-04", "CFG-09", "CFG-10"), HomingKind.MARKER_HOME_SWITCH)
"""Homing kind for rules that can't be broken in isolation with a home switch."""
