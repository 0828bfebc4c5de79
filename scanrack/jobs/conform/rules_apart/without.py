"""Models of a 3601 without one of its rules.

A rule that sets bits is removed by suppressing those bits. `STATEMENTS` has the behavior without each of the
other rules. A rule without bits that is not in `STATEMENTS` stays open.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from scanrack.io_images.amci3601 import RULES, StatusLsw, StatusMsw
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.io_images.image import signed_word
from scanrack.io_images.thousands import split_reported
from scanrack.runtime.modules.amci3601.altered import Alteration, ImageWords
from scanrack.runtime.modules.amci3601.latches import bits_of

from . import departures as d
from . import layers
from .departures import AT_PRESET, AT_RESET, AT_START, hear, hide, ruled, with_words

_CW, _CCW = StatusMsw.MOVING_CW.value, StatusMsw.MOVING_CCW.value
_BOTH_WAYS = _CW | _CCW
_COMPLETE, _STOPPED = StatusMsw.MOVE_COMPLETE.value, StatusMsw.STOPPED.value
_HOLD = StatusMsw.HOLD_STATE.value
_CONFIG_ERROR, _MODE = StatusMsw.CONFIG_ERROR.value, StatusMsw.MODE_CONFIG.value
_MODULE_OK = StatusMsw.MODULE_OK.value
_ACK, _BLENDS = StatusLsw.BLEND_ACK.value << 16, StatusLsw.BLEND_RUNNING.value << 16
_MINIMUM = StatusLsw.MIN_REG_NONZERO.value << 16
_FOLLOWS = StatusLsw.ENC_FOLLOWER.value << 16
_PROFILE = d.ABSOLUTE | d.RELATIVE | d.RESUME
_MOVES = _PROFILE | d.MANUAL


def _set(words: list[int], msw: int, value: int) -> None:
    words[msw], words[msw + 1] = split_reported(value)


def _value(words: list[int], msw: int) -> int:
    return words[msw] * 1000 + words[msw + 1]


def _by_1024(words: list[int]) -> None:
    for msw in (2, 4):
        _set(words, msw, words[msw] * 1024 + words[msw + 1])


def _positive_lsw(words: list[int]) -> None:
    _set(words, 2, words[2] * 1000 + abs(words[3]))


def _scaled(number: int, factor: float) -> d.Hearing:
    """Return a function that multiplies a rate, the word with this number, by a factor."""

    def change(words: list[int]) -> None:
        if words[number] > 0:
            words[number] = min(2000, max(1, round(words[number] * factor)))

    return with_words(change)


def _no_ramps(words: list[int]) -> None:
    words[6] = words[7] = 2000


def _slower(words: list[int]) -> None:
    if _value(words, 4) >= 1000:
        _set(words, 4, _value(words, 4) * 3 // 4)


def _slower_if_short(words: list[int]) -> None:
    """Reduce the speed of a move that is too short for both ramps."""
    speed = _value(words, 4)
    rates = [word for word in words[6:8] if word > 0]
    if len(rates) == 2 and sum(speed * speed / (2000 * rate) for rate in rates) > abs(_value(words, 2)):
        _slower(words)


def _further(words: list[int]) -> None:
    _set(words, 2, _value(words, 2) + 5)


def _to_zero(words: list[int]) -> None:
    words[2] = words[3] = 0


def _less(bits: int) -> d.Hearing:
    """Return a function that ignores bits of word 1."""

    def change(words: list[int]) -> None:
        words[1] &= ~bits

    return with_words(change)


def _mirrors_nothing(words: ImageWords) -> ImageWords:
    return (signed_word(words[0] & 0xE000), 0, 0, 0, *words[4:]) if words[0] < 0 else words


def _mirrors_all(words: ImageWords) -> ImageWords:
    return (signed_word(words[0] & 0xBFFF), *words[1:]) if words[0] < 0 else words


def _no_revision(words: ImageWords) -> ImageWords:
    return (*words[:6], 0, 0) if words[0] < 0 else words


def _no_position(words: ImageWords) -> ImageWords:
    return words if words[0] < 0 else (*words[:2], 0, 0, *words[4:])


_NO_EDGES = ruled("It treats a bit that stays set as a new command.", layers.EdgeOfNothing)
_FAST = hear("Its ramps are as steep as they can be.", _MOVES, with_words(_no_ramps))
_STEEP = hear("It accelerates twice as fast.", _MOVES, _scaled(6, 2))
_NO_CURVE = hear("It has no S-curve.", _MOVES, _less(1))
_LSW_1 = hear("Its S-curves are triangular.", _MOVES, _less(2))
_NEEDS_VALID = d.refuse("It needs a valid position.", "CMD-06", d.RELATIVE | d.MANUAL, d.is_invalid)
_UNLOCKED = ruled("It executes commands during a command error.", layers.NoLock)
_DEAF = ruled("It ignores new words of a manual move.", layers.IgnoresNewWords)
_HOLD_STAYS = d.never_clears("Hold State stays when the next move starts.", _HOLD, at=AT_START)
_HOLDS_HARD = ruled("Hold stops the motor without a ramp.", layers.HoldCuts)
_MIRROR = Alteration("It mirrors no configuration.", shows=_mirrors_nothing)
_NO_RESET = d.never_clears("Reset Errors clears nothing.", AT_RESET, at=AT_RESET)
_RESETS_ALL = d.also_clears("Reset Errors clears Move Complete.", _COMPLETE, at=AT_RESET)
_NO_BLEND = hear("It accepts no blend blocks.", 0, _less(0x100))
_NO_BLOCKS = hear("It accepts no blocks.", 0, _less(0x200))
_NO_MINIMUM = hear("It stores no minimum distance.", 0, _less(0x400))
_NO_FOLLOWER = hear("It has no follower.", 0, _less(0x80))
_PLAIN = hear("It treats a registration move as a manual move.", d.MANUAL, with_words(_to_zero))
_IN_STEPS = hear("It treats encoder moves as moves in steps.", d.ABSOLUTE | d.RELATIVE, _less(4))
_FOLLOWED = hide("Stopped is not shown after the follower.", _STOPPED, "follower")
_EXTERNAL = ruled("The external input stops nothing.", layers.IgnoresExternal)

STATEMENTS: Mapping[str, Alteration] = {
    "IOM-02": hear("A word of thousands counts 1024.", _MOVES, with_words(_by_1024)),
    "IOM-03": hear("The LSW has no sign.", _MOVES | d.PRESET, with_words(_positive_lsw)),
    "IOM-06": Alteration("It shows no position.", shows=_no_position),
    "IOM-08": _MIRROR,
    "IOM-09": Alteration("It mirrors bit 14 of word 0.", shows=_mirrors_all),
    "IOM-17": Alteration("It shows no position.", shows=_no_position),
    "IOM-19": _NO_EDGES,
    "IOM-21": d.refuse("Moves need an LSW of zero.", "IOM-20", _MOVES, lambda _host, given: given.lsw != 0),
    "PRO-01": _FAST,
    "PRO-02": hear("A short move is slower.", _PROFILE, with_words(_slower_if_short)),
    "PRO-03": _STEEP,
    "PRO-04": _STEEP,
    "PRO-05": _NO_CURVE,
    "PRO-06": _LSW_1,
    "PRO-07": _STEEP,
    "PRO-08": hear("It runs at three quarters of its speed.", _MOVES, with_words(_slower)),
    "CFG-12": hide("It shows no configuration error.", _CONFIG_ERROR),
    "CFG-13": hide("It shows no configuration error.", _CONFIG_ERROR),
    "CFG-15": hide("It does not show its mode.", _MODE),
    "CFG-16": _MIRROR,
    "CFG-17": d.silent("The position stays valid over a configuration.", "POS-01"),
    "CFG-27": Alteration("It shows no revision.", shows=_no_revision),
    "CFG-28": ruled("A command without configuration is a command error.", layers.ErrorWithoutConfiguration),
    "CFG-30": hide("It shows no configuration error.", _CONFIG_ERROR),
    "MOV-02": hear("An absolute target is a distance.", d.ABSOLUTE, d.as_command(d.RELATIVE)),
    "MOV-03": hide("Moving CW is not shown in absolute moves.", _CW, "absolute"),
    "MOV-04": hide("Moving CCW is not shown in absolute moves.", _CCW, "absolute"),
    "MOV-05": hide("It never shows Move Complete.", _COMPLETE),
    "MOV-06": _NEEDS_VALID,
    "MOV-07": hear("A relative target is a position.", d.RELATIVE, d.as_command(d.ABSOLUTE)),
    "MOV-08": hide("Moving CW is not shown in relative moves.", _CW, "relative"),
    "MOV-09": hide("Moving CCW is not shown in relative moves.", _CCW, "relative"),
    "HLD-01": _HOLDS_HARD,
    "HLD-04": d.refuse(
        "In the hold state it accepts only Resume.",
        "CMD-03",
        _MOVES & ~d.RESUME,
        lambda host, _given: bool(host.state.held),
    ),
    "HLD-05": hear(
        "Hold with data is ignored.", d.HOLD, lambda words: (0, *words[1:]) if any(words[2:]) else words
    ),
    "HLD-12": _HOLD_STAYS,
    "RSM-01": ruled("Resume starts the move over.", layers.ResumesAnew),
    "RSM-02": _HOLD_STAYS,
    "RSM-04": hide("It never shows Move Complete.", _COMPLETE),
    "IST-01": ruled("Immediate Stop holds.", layers.StopHolds),
    "IST-02": d.silent("Immediate Stop leaves the position valid.", "POS-02"),
    "IST-03": d.refuse("After a stop it needs a valid position.", "CMD-06", d.RELATIVE | d.MANUAL, d.was_cut),
    "IST-04": ruled("Immediate Stop sets Stopped at rest.", layers.StoppedAtRest),
    "IST-05": hide("It never shows Stopped.", _STOPPED),
    "IST-06": _UNLOCKED,
    "MAN-01": hide("A manual move shows no direction.", _BOTH_WAYS, "manual"),
    "MAN-02": d.refuse(
        "A slow manual move needs rates.", "CMD-04", d.MANUAL, lambda _host, given: not all(given.words[6:8])
    ),
    "MAN-04": hear("A manual move accelerates at once.", d.MANUAL, _scaled(6, 2)),
    "MAN-05": hear("A manual move decelerates at another rate.", d.MANUAL, _scaled(7, 0.5)),
    "MAN-06": _EXTERNAL,
    "MAN-11": _DEAF,
    "MAN-12": _DEAF,
    "MAN-15": d.refuse(
        "A manual speed of 0 is an error.",
        "CMD-04",
        d.MANUAL,
        lambda _host, given: given.speed_words == (0, 0),
    ),
    "MAN-16": hide("A one-shot shows no direction.", _BOTH_WAYS, "one-shot manual"),
    "MAN-18": d.refuse(
        "The encoder bit prevents manual moves.", "ENC-05", d.MANUAL, lambda _host, given: bool(given.lsw & 4)
    ),
    "MAN-19": d.refuse(
        "A manual move is never slower than the starting speed.",
        "CMD-05",
        d.MANUAL,
        lambda host, given: 0 < (given.parameters.speed or 0) < host.state.start_sps,
    ),
    "MAN-20": ruled("A manual move leaves no valid position.", layers.ManualInvalidates),
    "PST-01": hear("Preset Position sets 0.", d.PRESET, with_words(_to_zero)),
    "PST-02": d.never_clears("Preset Position leaves Position Invalid.", AT_PRESET, at=AT_PRESET),
    "PST-04": d.also_clears("Preset Position clears Move Complete.", _COMPLETE, at=AT_PRESET),
    "PST-06": hear("Preset Encoder sets 0.", d.PRESET_ENCODER, with_words(_to_zero)),
    "RST-01": _NO_RESET,
    "RST-03": _UNLOCKED,
    "RST-04": d.never_clears("Reset Errors leaves Input Error.", StatusMsw.INPUT_ERROR.value, at=AT_RESET),
    "RST-05": _RESETS_ALL,
    "MC-01": hide("It never shows Move Complete.", _COMPLETE),
    "MC-02": d.never_clears("Move Complete stays when a move starts.", _COMPLETE, at=AT_START),
    "MC-03": _RESETS_ALL,
    "BLD-02": hide("It acknowledges no block.", _ACK),
    "BLD-04": _NO_BLOCKS,
    "BLD-06": d.refuse("A blend move needs a valid position.", "CMD-06", d.BLEND, d.is_invalid),
    "BLD-07": ruled("A blend profile runs once.", layers.BlendOnce),
    "BLD-08": hear("It blends clockwise only.", d.BLEND, d.as_command(0x1000)),
    "BLD-20": hide("It does not show that a blend move runs.", _BLENDS),
    "REG-01": _PLAIN,
    "REG-02": hear("A registration move makes more steps.", d.MANUAL, with_words(_further)),
    "REG-03": _PLAIN,
    "REG-04": _NO_MINIMUM,
    "REG-05": _NO_MINIMUM,
    "REG-07": _NO_MINIMUM,
    "REG-08": _DEAF,
    "REG-10": _NO_MINIMUM,
    "REG-12": hide("It does not show a minimum distance.", _MINIMUM),
    "ENC-01": _IN_STEPS,
    "ENC-02": _IN_STEPS,
    "ENC-09": _IN_STEPS,
    "ENC-10": _IN_STEPS,
    "EXT-01": _EXTERNAL,
    "EXT-02": _EXTERNAL,
    "FOL-01": hide("It does not show follower mode.", _FOLLOWS),
    "FOL-04": _NO_FOLLOWER,
    "FOL-06": _FOLLOWED,
    "LSW-00": _NO_CURVE,
    "LSW-01": _LSW_1,
    "LSW-02": _IN_STEPS,
    "LSW-07": _NO_FOLLOWER,
    "LSW-08": _NO_BLEND,
    "LSW-09": _NO_BLOCKS,
    "LSW-10": _NO_MINIMUM,
    "STOP-01": hide("Stopped is not shown after manual moves.", _STOPPED, "manual"),
    "STOP-03": hide("Stopped is not shown after relative moves.", _STOPPED, "relative"),
    "STOP-05": _FOLLOWED,
    "STOP-06": ruled("Stopped is set at every end.", layers.StoppedAtEveryEnd),
    "EST-02": d.silent("The emergency stop leaves the position valid.", "POS-03"),
    "MOK-01": hide("It never shows Module OK.", _MODULE_OK),
    **{
        f"STS-M{bit.value.bit_length() - 1:02}": hide(f"It never shows {bit.name}.", bit.value)
        for bit in StatusMsw
    },
    **{
        f"STS-L{bit.value.bit_length() - 1:02}": hide(f"It never shows {bit.name}.", bit.value << 16)
        for bit in StatusLsw
    },
}
"""By rule, a module without the rule."""


def without(rule: str, fired: Collection[str]) -> Alteration | None:
    """Return a module without a rule; None if its behavior is unknown.

    Args:
        fired: the rules that fired in the scene. Rules with the same cause that set no additional bits are
            also removed.
    """
    bits = bits_of(rule, WORDS_3601) if rule in fired else 0
    if not bits:
        return STATEMENTS.get(rule)
    same_cause = {
        other for other in fired if other in RULES[rule].together_with or rule in RULES[other].together_with
    }
    also_silent = {other for other in same_cause if not bits_of(other, WORDS_3601) & ~bits}
    return d.silent(f"It does not follow {rule}.", rule, *also_silent)
