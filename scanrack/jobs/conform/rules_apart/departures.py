"""Functions that alter how the model of a 3601 reads words, refuses commands, or shows bits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.runtime.modules.amci3601.altered import Alteration, AlteredLayer, ImageWords
from scanrack.runtime.modules.amci3601.command_words import CommandWords
from scanrack.runtime.modules.amci3601.latches import (
    CLEARED_BY_A_MOVE,
    POSITION_INVALID,
    RESETTABLE,
    STOPPED,
)
from scanrack.runtime.modules.amci3601.operation import Host
from scanrack.runtime.modules.amci3601.refusals import RefusalRule

ABSOLUTE, RELATIVE = CommandMsw.ABSOLUTE_MOVE.value, CommandMsw.RELATIVE_MOVE.value
HOLD, RESUME = CommandMsw.HOLD_MOVE.value, CommandMsw.RESUME_MOVE.value
STOP, RESET = CommandMsw.IMMEDIATE_STOP.value, CommandMsw.RESET_ERRORS.value
MANUAL = (CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW).value
PRESET, PRESET_ENCODER = CommandMsw.PRESET_POSITION.value, CommandMsw.PRESET_ENCODER.value
BLEND = (CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW).value

Hearing = Callable[[ImageWords], ImageWords]
Question = Callable[[Host, CommandWords], bool]


def hide(sentence: str, bits: int, during: str = "") -> Alteration:
    """Return a module that hides bits, always or, with `during`, only during and after one kind of motion."""
    return Alteration(sentence, hidden=bits, during=during)


def hear(sentence: str, commands: int, hearing: Hearing) -> Alteration:
    """Return a module that reads the words of some commands differently.

    Args:
        commands: bits of the commands; 0 for all commands.
    """

    def hears(words: ImageWords) -> ImageWords:
        is_concerned = words[0] >= 0 and (not commands or words[0] & commands)
        return hearing(words) if is_concerned else words

    return Alteration(sentence, hears=hears)


def as_command(instead: int) -> Hearing:
    """Return a function that reads words as a different command."""
    return lambda words: (instead, *words[1:])


def with_words(change: Callable[[list[int]], Any]) -> Hearing:
    """Return a function that changes words before they are read."""

    def hearing(words: ImageWords) -> ImageWords:
        changed_words = list(words)
        change(changed_words)
        return tuple(changed_words)

    return hearing


def refuse(
    sentence: str, rule: str, commands: int, condition: Question, *, alone: bool = False
) -> Alteration:
    """Return a module that also refuses commands under a condition, with the error bits of a rule."""

    def broken(host: Host, command: CommandWords) -> bool:
        return not command.configures and bool(command.msw & commands) and condition(host, command)

    return Alteration(sentence, also=(RefusalRule(rule, broken, alone),))


def silent(sentence: str, *rules: str) -> Alteration:
    """Return a module where some rules set no bits."""
    return Alteration(sentence, silent=frozenset(rules))


def add(sentence: str, rule: str, bits: int) -> Alteration:
    """Return a module where a rule sets additional bits."""
    return Alteration(sentence, adds={rule: bits})


def overlook(sentence: str, *rules: str) -> Alteration:
    """Return a module that does not detect violations of some rules."""
    return Alteration(sentence, overlooked=frozenset(rules))


def never_clears(sentence: str, bits: int, *, at: int) -> Alteration:
    """Return a module that leaves `bits` set when the model clears the bits `at`."""
    return Alteration(sentence, clears=lambda cleared: cleared & ~bits if cleared == at else cleared)


def also_clears(sentence: str, bits: int, *, at: int) -> Alteration:
    """Return a module that also clears `bits` when the model clears the bits `at`."""
    return Alteration(sentence, clears=lambda cleared: cleared | bits if cleared == at else cleared)


def ruled(sentence: str, layer: type[AlteredLayer]) -> Alteration:
    """Return a module with its own command layer."""
    return Alteration(sentence, layer=layer)


AT_START, AT_RESET, AT_PRESET = CLEARED_BY_A_MOVE, RESETTABLE, POSITION_INVALID
"""Bits that the model clears at the start of a move, by Reset Errors, and by Preset Position."""


def is_invalid(host: Host, _command: CommandWords) -> bool:
    """Whether the position is invalid."""
    return bool(host.state.latches.bits & POSITION_INVALID)


def was_cut(host: Host, command: CommandWords) -> bool:
    """Whether a motion was stopped and the position is invalid."""
    return bool(host.state.latches.bits & STOPPED) and is_invalid(host, command)


def is_busy(host: Host, _command: CommandWords) -> bool:
    """Whether a motion is under way."""
    return host.busy
