"""The input image, written from the state of the command layer [chapter 3, Input Data; chapter 6]."""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.amci3601 import ALL_INPUTS, Configuration, StatusLsw, StatusMsw
from scanrack.io_images.image import signed_word
from scanrack.io_images.thousands import join_reported, split_reported

from .latches import CONFIG_ERROR, MODE_CONFIG, MODULE_OK, WORD_0
from .operation import Host

MOVING_CW = StatusMsw.MOVING_CW.value
MOVING_CCW = StatusMsw.MOVING_CCW.value
ACCELERATING = StatusMsw.ACCELERATING.value
DECELERATING = StatusMsw.DECELERATING.value
BLEND_ACK = StatusLsw.BLEND_ACK.value
MIN_REG_NONZERO = StatusLsw.MIN_REG_NONZERO.value
HOME_PROX_ECHO = StatusLsw.HOME_PROX_ECHO.value


def report(host: Host, words: memoryview[int]) -> None:
    """Write the eight input words of the present mode; the axis has been advanced to this instant."""
    state = host.state
    if state.in_configuration_mode:
        live_bits = state.latches.bits & (MODE_CONFIG | CONFIG_ERROR | MODULE_OK)
        # bits 13 to 15 are status; the others echo the configuration
        words[0] = signed_word(live_bits | state.mirror[0] & 0x1FFF)
        words[1], words[2], words[3] = state.mirror[1:4]
        words[4] = words[5] = 0
        words[6], words[7] = host.firmware.major, host.firmware.minor
    else:
        words[0] = signed_word(_status_msw(host))
        words[1] = signed_word(_status_lsw(host))
        words[2], words[3] = split_reported(host.axis.position)
        words[4], words[5] = split_reported(host.axis.encoder)
        words[6], words[7] = split_reported(state.captured)


def adopt_image(host: Host, words: Sequence[int], configuration: Configuration | None) -> None:
    """Set a host after power-up to the state shown by input words in command mode; the inverse of `report`.

    Args:
        words: the eight input words, unsigned.
    """
    state = host.state
    state.latches.bits = words[0] & ~(MOVING_CW | MOVING_CCW | ACCELERATING | DECELERATING)
    state.latches.bits |= words[1] << 16 & host.profile.further_errors
    state.configuration = configuration
    state.mirror = (0, 0, 0, 0) if configuration is None else tuple(configuration.to_image())[:4]
    host.axis.configure(configuration)
    host.axis.preset_position(_joined(words[2], words[3]))
    host.axis.preset_encoder(_joined(words[4], words[5]))
    state.captured = _joined(words[6], words[7])
    state.reported_inputs = words[1] & ALL_INPUTS
    state.active = state.reported_inputs & (0 if configuration is None else configuration.inputs_used)
    state.minimum_registration = 1 if words[1] & MIN_REG_NONZERO else 0


def _joined(msw: int, lsw: int) -> int:
    return join_reported(signed_word(msw), signed_word(lsw))


def _status_msw(host: Host) -> int:
    """Return word 0: latched bits, and motion bits of the axis or, at rest, of the operation."""
    bits = host.state.latches.bits
    direction, ramp = host.axis.direction, host.axis.ramp
    if direction == 0 and host.operation is not None:
        direction, ramp = host.operation.shown_direction, host.operation.shown_ramp
    if direction:
        bits |= MOVING_CW if direction > 0 else MOVING_CCW
        if ramp:
            bits |= ACCELERATING if ramp > 0 else DECELERATING
    return bits & WORD_0


def _status_lsw(host: Host) -> int:
    """Return word 1: inputs, further errors, and bits of homing, operation, blending and registration."""
    state = host.state
    bits = state.reported_inputs | state.latches.bits >> 16
    if state.proximity:
        bits |= HOME_PROX_ECHO  # also without homing (reading A-96)
    if host.operation is not None:
        bits |= host.operation.status_lsw
    if state.blending is not None and state.blending.acknowledged:
        bits |= BLEND_ACK
    return bits | MIN_REG_NONZERO if state.minimum_registration else bits
