"""Finds the waits of a module with a 3601's words, from its two images and their history.

    link lost                for its link
    in configuration mode    for a valid configuration, or for bit 15 of output word 0 to return to 0
    moving                   MOVE_COMPLETE not yet: command, position, target
    a command bit is on      for it to return to 0: a command begins when its bit goes from 0 to 1
    idle                     for a command

Then come the error bits that are on, each with the rule that set it and the command that clears it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from scanrack.io_images.amci3601 import (
    COMPLETION_BITS,
    KNOWN,
    MOTIONS,
    RULES,
    CommandLsw,
    CommandMsw,
    Firmware,
    Parameters,
    StatusLsw,
    StatusMsw,
    check,
)
from scanrack.io_images.amci3601.words import Profile, may_be_stepper, profile_of
from scanrack.io_images.thousands import join_reported
from scanrack.io_images.times import seconds

from .drive_waits import command_on, drive_waits, still_on
from .overrides import losses
from .past import SlotPast, event_text

MOVING = StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW

COMMANDS = 0x7FFF
"""All bits of output word 0 except the mode."""

_MANUAL = CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW
_HOME = CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW
_TO_A_TARGET = CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE
_MODE_BIT = StatusMsw.MODE_CONFIG.value
_BLENDING = CommandLsw.BLEND_PROGRAM.value
_BY_RESET, _ONLY_RESET = RULES["RST-01"], RULES["RST-03"]

CLEARED_BY = {
    "CONFIG_ERROR": "a valid configuration clears it [CFG-13, chapter 3]",
    "POSITION_INVALID": "a home or a preset clears it; until then it refuses absolute moves",
    "INPUT_ERROR": "the next move and RESET_ERRORS clear it [STS-M11, chapter 6]",
}
"""The command that clears each error bit; RESET_ERRORS clears all others."""


def waits(past: SlotPast) -> list[str]:
    """Return what a module is waiting for, as sentences."""
    lost_link = _without_link(past)
    if lost_link is not None:
        return [lost_link]
    if not may_be_stepper(past.slot.words):
        return drive_waits(past)
    state = next(state for state_of in STATES if (state := state_of(past)) is not None)
    return [state, *_errors(past)]


def refused_configuration(past: SlotPast) -> str | None:
    """Return the rules that the last configuration broke; None if it broke none."""
    row = past.past.last_change(past.slot.number, "out", 0, _MODE_BIT)
    if row is None:
        return None
    if not past.words_at("out", row)[0] & _MODE_BIT:
        row -= 1  # the last scan with the configuration in the output words
    broken = _broken_rules(past, past.words_at("out", row))
    return f"the module refused its configuration: {broken}" if broken else None


def is_idle(past: SlotPast) -> bool:
    """Return whether a module is waiting only for a command."""
    return next(state_of for state_of in STATES if state_of(past) is not None) is _idle


def searches_home(past: SlotPast) -> bool:
    """Return whether homing is in progress."""
    row = _row_of_start(past) if past.inputs[0] & MOVING else None
    return row is not None and bool(past.words_at("out", row)[0] & _HOME)


def _without_link(past: SlotPast) -> str | None:
    """Return a sentence about the lost link to a module; None if the link is not lost."""
    lost = next((loss for loss in losses(past.past.events, past.slot.number) if loss.until is None), None)
    if lost is None:
        return None
    moment = f"scan {lost.scan:,} ({seconds(lost.now_ns)} s)"
    return f"the link to it is lost since {moment}: its inputs keep their last state; no command reaches it"


# --- the states: each function describes one of them, and returns None in any other


def _not_ok(past: SlotPast) -> str | None:
    if past.inputs[0] & StatusMsw.MODULE_OK:
        return None
    return f"MODULE_OK is 0{past.since('in', 0, StatusMsw.MODULE_OK.value)}: it accepts no command"


def _configuring(past: SlotPast) -> str | None:
    """Describe configuration mode, and the reason why the module remains in it."""
    if not past.inputs[0] & _MODE_BIT:
        return None
    state = f"in configuration mode{past.since('in', 0, _MODE_BIT)}"
    if not past.out[0] & _MODE_BIT:
        return f"{state}: bit 15 of output word 0 is 0, so it leaves with its next update"
    broken = _broken_rules(past, past.out)
    if broken:
        return f"{state}: it waits for a valid configuration: {broken}"
    if past.inputs[0] & StatusMsw.CONFIG_ERROR:
        return f"{state}: it checks the configuration with its next update"
    return f"{state}, configured: it accepts no command until bit 15 of output word 0 goes back to 0"


def _broken_rules(past: SlotPast, words: Sequence[int]) -> str:
    """Return the rules that a configuration's words break; "" if there are none."""
    profile = profile_of(past.slot.words)
    broken = check(words, _firmware(past), profile.limits)
    return "; ".join(profile.rules[rule].clause for rule in broken)


def _firmware(past: SlotPast) -> Firmware:
    """Return the firmware of a module; the latest one if it is not recorded."""
    try:
        return Firmware.parse(past.slot.firmware)
    except ValueError:  # an adapter, or a recording without the firmware
        return KNOWN[-1]


def _enters_configuration(past: SlotPast) -> str | None:
    """Describe a request for configuration mode, which waits for the end of a motion."""
    if not past.out[0] & _MODE_BIT:
        return None
    since = past.since("out", 0, _MODE_BIT)
    if past.inputs[0] & MOVING:
        return f"{_motion_text(past)}; configuration mode, requested{since}, waits for the end of the motion"
    return f"bit 15 of output word 0 is 1{since}: it enters configuration mode with its next update"


def _unconfigured(past: SlotPast) -> str | None:
    if not past.inputs[0] & StatusMsw.CONFIG_ERROR:
        return None
    return "it waits for a configuration in the output words, with bit 15 of word 0"


def _moves(past: SlotPast) -> str | None:
    return _motion_text(past) if past.inputs[0] & MOVING else None


def _motion_text(past: SlotPast) -> str:
    """Return the current motion with its position and its end."""
    status = past.inputs[0]
    direction = "CW" if status & StatusMsw.MOVING_CW else "CCW"
    rate = next((f", {name}" for bit, name in _RATES if status & bit), "")
    position = f"at {join_reported(past.inputs[2], past.inputs[3]):,}"
    if past.inputs[1] & StatusLsw.ENC_FOLLOWER:
        return f"moving {direction} as encoder follower, {position}"
    row = _row_of_start(past)
    state = f"moving {direction}{rate}, {position}"
    if row is None:
        return f"{state}, since before the recording"
    words = past.words_at("out", row)
    command = _command_bits(words[0] & MOTIONS.value)[-1]
    return f"{state}: {command.name} since {past.past.when(row)}{_end_text(past, command, row, words)}"


_RATES = ((StatusMsw.ACCELERATING, "accelerating"), (StatusMsw.DECELERATING, "decelerating"))


def _row_of_start(past: SlotPast) -> int | None:
    """Return the row in which the last motion began; None if none is recorded."""
    return next((row for row, _bits_on in past.rises(MOTIONS.value)), None)


def _end_text(past: SlotPast, command: CommandMsw, row: int, words: Sequence[int]) -> str:
    """Return the end of the motion that a command began in a row: the awaited bit and the target, steps."""
    if command & _MANUAL:
        return f"; it runs until {command.name} goes back to 0"
    if command & _HOME:
        return "; AT_HOME not yet"
    target = Parameters.read(words).target
    if not command & _TO_A_TARGET or target is None or words[1] & CommandLsw.ENCODER_MOVE:
        return "; MOVE_COMPLETE not yet"
    if command is CommandMsw.RELATIVE_MOVE:
        inputs = past.words_at("in", row)
        target += join_reported(inputs[2], inputs[3])
    return f"; MOVE_COMPLETE not yet, its target is {target:,}"


def _held(past: SlotPast) -> str | None:
    if not past.inputs[0] & StatusMsw.HOLD_STATE:
        return None
    since = past.since("in", 0, StatusMsw.HOLD_STATE.value)
    return f"held{since}: it waits for RESUME_MOVE, or for another move{still_on(past, _commands(past))}"


def _programs_blend(past: SlotPast) -> str | None:
    """Describe the next step of the handshake that transmits the blocks of a blend move."""
    if not past.out[1] & _BLENDING:
        return None
    transmitting = past.out[1] & CommandLsw.BLEND_TRANSMIT
    acknowledged = past.inputs[1] & StatusLsw.BLEND_ACK
    if transmitting and acknowledged:
        awaited = "BLEND_TRANSMIT to go back to 0: it has accepted the block"
    elif transmitting:
        awaited = "its next update, to accept the block (BLEND_TRANSMIT is 1)"
    elif acknowledged:
        awaited = "BLEND_TRANSMIT to go from 0 to 1 with the next block, or BLEND_PROGRAM back to 0"
    else:
        awaited = "its next update, to set BLEND_ACK"
    return f"programming a blend{past.since('out', 1, _BLENDING)}: it waits for {awaited}"


def _command_on(past: SlotPast) -> str | None:
    on = _commands(past)
    return command_on(past, on, _rest_text(past)) if on else None


def _commands(past: SlotPast) -> dict[str, int]:
    """Return the command bits that are on, by name."""
    return {str(bit.name): bit.value for bit in _command_bits(past.out[0] & COMMANDS)}


def _idle(past: SlotPast) -> str:
    awaited = "a command bit to go from 0 to 1"
    if past.inputs[0] & StatusMsw.COMMAND_ERROR:
        awaited = f"RESET_ERRORS, and accepts no other command [{_ONLY_RESET.id}, {_ONLY_RESET.section}]"
    return f"{_rest_text(past)}: it waits for {awaited}"


STATES: Sequence[Callable[[SlotPast], str | None]] = (
    _not_ok,
    _configuring,
    _enters_configuration,
    _unconfigured,
    _moves,
    _held,
    _programs_blend,
    _command_on,
    _idle,
)
"""The possible states of a module; the first one that applies counts."""


def _rest_text(past: SlotPast) -> str:
    """Return the position at rest in steps, and how the previous motion ended."""
    completions = [bit for bit in StatusMsw if bit & COMPLETION_BITS & past.inputs[0]]
    position = f"at rest at {join_reported(past.inputs[2], past.inputs[3]):,}"
    if not completions:
        return position
    return f"{position}, {completions[0].name}{past.since('in', 0, completions[0].value)}"


def _command_bits(mask: int) -> list[CommandMsw]:
    return [bit for bit in CommandMsw if bit.value & mask]


def _errors(past: SlotPast) -> Iterator[str]:
    """Yield each error bit that is on: since when, its cause, and what clears it."""
    status = past.inputs[0]
    if status & _MODE_BIT:
        return  # the configuration error has been reported, and the other bits mirror the configuration
    profile = profile_of(past.slot.words)
    # as in the masks: word 0 in the low half, word 1 in the high half
    status_bits = status & 0xFFFF | (past.inputs[1] & 0xFFFF) << 16
    for name, mask in profile.masks.items():
        if mask & profile.error_bits & status_bits:
            signal = profile.groups["status"][name]
            since = past.since("in", signal.word, 1 << signal.bit)
            yield f"{name}{since}: {_error_cause(past, profile, name)}; {_cure(name)}"


def _cure(name: str) -> str:
    return CLEARED_BY.get(name, f"RESET_ERRORS clears it [{_BY_RESET.id}, {_BY_RESET.section}]")


def _error_cause(past: SlotPast, profile: Profile, name: str) -> str:
    """Return the recorded rule that set a bit; without one, the section of the manual with its causes."""
    for event in reversed(past.past.rules(past.slot.number)):
        bit_names = event.fields.get("bits")
        if isinstance(bit_names, list) and name in bit_names:
            rule = profile.rules.get(str(event.fields.get("name")))
            if rule is None:
                return event_text(event)
            sentence = rule.text[:1].lower() + rule.text[1:].removesuffix(".")
            return f"{sentence} [{rule.id}, {rule.section}]"
    lists = [rule.section for rule in profile.rules.values() if rule.list_of == profile.masks[name]]
    return f"the manual lists what sets it in {lists[0].rstrip(' 0123456789')}" if lists else "see chapter 6"
