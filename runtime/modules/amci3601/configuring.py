"""Configuration mode: entry, validation, exit [chapter 3]."""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration, check
from scanrack.io_images.image import Image

from .command_words import CommandWords
from .latches import CONFIG_ERROR, MODE_CONFIG, MODULE_OK, POSITION_INVALID, STOPPED, WORD_0, BrokenRule
from .operation import Host


def obey_mode_bit(host: Host, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
    """Enter configuration mode when the axis is idle [note 2]; then validate changed words."""
    needs_validation = command is not previous
    if not host.state.in_configuration_mode:
        if not _release_axis(host, now_ns, previous):
            return
        host.state.enter_configuration_mode()
        needs_validation = True
    if needs_validation:
        _validate(host, now_ns, command)


def _release_axis(host: Host, now_ns: int, previous: CommandWords) -> bool:
    """Release the command bits, which ends a jog; return whether all moves have ended.

    A move that is still running is an error (CMD-01), but only in the scan that first requests configuration
    mode.
    """
    if host.operation is not None:
        host.operation.on_release(now_ns)
        host.settle(now_ns)
    if not host.busy:
        return True
    if not previous.configures:
        host.fire(now_ns, "CMD-01")
    return False


def _validate(host: Host, now_ns: int, command: CommandWords) -> None:
    """Accept or reject the words, as the module does after every change (reading A-08)."""
    state = host.state
    broken_rules = check(command.words, host.firmware, host.profile.limits)
    faults = host.noticed(command, [BrokenRule(rule, alone=True) for rule in broken_rules])
    if faults:
        for fault in faults:
            state.latches.fire(now_ns, fault.rule, alone=True)
        state.latches.fire(now_ns, "CER-02")
        state.configuration = None
    else:
        state.configuration = _within_capabilities(host, now_ns, command)
    is_accepted = state.configuration is not None
    if is_accepted:
        state.latches.clear(CONFIG_ERROR)
        state.erase_programs()
    if is_accepted or host.options.mirror_rejected_config:
        state.mirror = command.words[:4]
    host.axis.configure(state.configuration)


def _within_capabilities(host: Host, now_ns: int, command: CommandWords) -> Configuration | None:
    """Return the configuration of valid words, or None if the axis can't use it."""
    configuration = Configuration.from_image(Image(command.words), host.firmware, host.profile.limits)
    refusal = host.axis.capabilities.lacking_for_configuration(configuration)
    if refusal is None:
        return configuration
    host.refuse(now_ns, refusal)
    return None


def leave(host: Host, now_ns: int) -> None:
    """Return to command mode with the position at zero and invalid [chapter 4; readings A-07, A-102]."""
    cleared_bits = MODE_CONFIG
    if host.options.clear_status_after_config:
        cleared_bits = WORD_0 | host.profile.further_errors
    host.state.latches.clear(cleared_bits & ~(MODULE_OK | CONFIG_ERROR | POSITION_INVALID))
    host.axis.preset_position(0)
    host.state.latches.fire(now_ns, "POS-01")
    if host.options.stopped_after_config:
        host.state.latches.complete(STOPPED)
