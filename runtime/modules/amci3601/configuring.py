"""Configuration mode: how it is entered, what it accepts, what leaving it does [chapter 3]."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....io_images.amci3601 import Configuration, StatusMsw, check
from ....io_images.image import Image
from .command_words import CommandWords
from .latches import COMMAND_ERROR, CONFIG_ERROR, MODE_CONFIG, MODULE_OK, POSITION_INVALID, STOPPED

if TYPE_CHECKING:
    from .command_layer import CommandLayer

STATUS_BELOW_LIVE_BITS = StatusMsw.CONFIG_ERROR.value - 1
"""Bits 0 to 12 of input word 0."""


def obey_mode_bit(layer: CommandLayer, now_ns: int, order: CommandWords, previous: CommandWords) -> None:
    """The mode bit is set: enter configuration mode as soon as the axis is idle [note 2], then validate."""
    fresh = order is not previous
    if not layer.in_configuration_mode:
        if not _axis_free(layer, now_ns, previous):
            return
        _enter(layer)
        fresh = True
    if fresh:
        _validate(layer, now_ns, order)


def _axis_free(layer: CommandLayer, now_ns: int, previous: CommandWords) -> bool:
    """Whether no move runs; otherwise the asking is an error, and the bits of a move count as released."""
    if layer.operation is not None:
        layer.operation.on_release(now_ns)
        layer.settle(now_ns)
    if not layer.busy:
        return True
    if not previous.configures:
        layer.fire(now_ns, "CMD-01")
    return False


def _enter(layer: CommandLayer) -> None:
    layer.held = None
    layer.blending = None
    layer.latches.clear(COMMAND_ERROR)  # that of asking during a move ends here (reading A-101)
    layer.latches.bits |= MODE_CONFIG


def _validate(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """Accept or reject the words, every time they change (reading A-08)."""
    broken = check(order.words, layer.firmware)
    if broken:
        for rule_id in broken:
            layer.latches.fire(now_ns, rule_id, bits=CONFIG_ERROR, alone=True)
        layer.latches.fire(now_ns, "CER-02")
        layer.configuration = None
    else:
        layer.configuration = _within_capabilities(layer, now_ns, order)
    accepted = layer.configuration is not None
    if accepted:
        layer.latches.clear(CONFIG_ERROR)
        layer.blend = None  # programming the configuration erases both [chapter 4]
        layer.minimum_registration = 0
    if accepted or layer.options.mirror_rejected_config:
        layer.mirror = order.words[:4]
    layer.axis.configure(layer.configuration)


def _within_capabilities(layer: CommandLayer, now_ns: int, order: CommandWords) -> Configuration | None:
    """Return the configuration of legal words, None if the axis can't do what it asks for."""
    configuration = Configuration.from_image(Image(order.words), layer.firmware)
    refusal = layer.axis.capabilities.lacking_for_configuration(configuration)
    if refusal is None:
        return configuration
    layer.refuse(now_ns, refusal)
    return None


def leave(layer: CommandLayer, now_ns: int) -> None:
    """Back to command mode: position zero and invalid [chapter 4; readings A-07, A-102]."""
    kept = POSITION_INVALID if layer.options.clear_status_after_config else STATUS_BELOW_LIVE_BITS
    layer.latches.clear(0xFFFF & ~(MODULE_OK | CONFIG_ERROR | kept))
    layer.axis.preset_position(0)
    layer.latches.fire(now_ns, "POS-01")
    if layer.options.stopped_after_config:
        layer.latches.complete(STOPPED)
