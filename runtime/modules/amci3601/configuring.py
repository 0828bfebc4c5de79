"""Configuration mode: entry, validation, exit [chapter 3]."""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration, check
from scanrack.io_images.image import Image

from .command_words import CommandWords
from .latches import CONFIG_ERROR, MODE_CONFIG, MODULE_OK, POSITION_INVALID, STOPPED, WORD_0, BrokenRule
from .operation import Host


def obey_mode_bit(host: Host, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
    """Enter configuration mode as soon as the axis is idle [note 2], then validate the words."""
    is_fresh = command is not previous
    if not host.state.in_configuration_mode:
        if not _axis_free(host, now_ns, previous):
            return
        host.state.enter_configuration_mode()
        is_fresh = True
    if is_fresh:
        _validate(host, now_ns, command)


def _axis_free(host: Host, now_ns: int, previous: CommandWords) -> bool:
    """Return whether no move runs; if a move runs, report an error and treat the command bits as released."""
    if host.operation is not None:
        host.operation.on_release(now_ns)
        host.settle(now_ns)
    if not host.busy:
        return True
    if not previous.configures:
        host.fire(now_ns, "CMD-01")
    return False


def _validate(host: Host, now_ns: int, command: CommandWords) -> None:
    """Accept or reject the words, after every change (reading A-08)."""
    state = host.state
    broken_rules = host.noticed(
        command,
        [BrokenRule(rule, alone=True) for rule in check(command.words, host.firmware, host.profile.limits)],
    )
    if broken_rules:
        for fault in broken_rules:
            state.latches.fire(now_ns, fault.rule, alone=True)
        state.latches.fire(now_ns, "CER-02")
        state.configuration = None
    else:
        state.configuration = _within_capabilities(host, now_ns, command)
    accepted = state.configuration is not None
    if accepted:
        state.latches.clear(CONFIG_ERROR)
        state.erase_programs()
    if accepted or host.options.mirror_rejected_config:
        state.mirror = command.words[:4]
    host.axis.configure(state.configuration)


def _within_capabilities(host: Host, now_ns: int, command: CommandWords) -> Configuration | None:
    """Return the configuration of legal words, None if the axis can't provide it."""
    configuration = Configuration.from_image(Image(command.words), host.firmware, host.profile.limits)
    refusal = host.axis.capabilities.lacking_for_configuration(configuration)
    if refusal is None:
        return configuration
    host.refuse(now_ns, refusal)
    return None


def leave(host: Host, now_ns: int) -> None:
    """Return to command mode: the position is zero and invalid [chapter 4; readings A-07, A-102]."""
    status = WORD_0 | host.profile.further_errors if host.options.clear_status_after_config else MODE_CONFIG
    host.state.latches.clear(status & ~(MODULE_OK | CONFIG_ERROR | POSITION_INVALID))
    host.axis.preset_position(0)
    host.state.latches.fire(now_ns, "POS-01")
    if host.options.stopped_after_config:
        host.state.latches.complete(STOPPED)
