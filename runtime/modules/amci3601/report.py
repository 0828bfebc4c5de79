"""The input image as the command layer has it [chapter 3, Input Data; chapter 6]."""

from __future__ import annotations

from ....io_images.amci3601 import StatusLsw, StatusMsw
from ....io_images.image import signed_word
from ....io_images.thousands import split_reported
from .blending import BlendRun
from .command_layer import CommandLayer
from .follower import EncoderFollower
from .latches import CONFIG_ERROR, MODE_CONFIG, MODULE_OK

MOVING_CW = StatusMsw.MOVING_CW.value
MOVING_CCW = StatusMsw.MOVING_CCW.value
ACCELERATING = StatusMsw.ACCELERATING.value
DECELERATING = StatusMsw.DECELERATING.value
ENC_FOLLOWER = StatusLsw.ENC_FOLLOWER.value
BLEND_RUNNING = StatusLsw.BLEND_RUNNING.value
BLEND_ACK = StatusLsw.BLEND_ACK.value
MIN_REG_NONZERO = StatusLsw.MIN_REG_NONZERO.value
HOME_PROX_ECHO = StatusLsw.HOME_PROX_ECHO.value


def report(layer: CommandLayer, words: memoryview[int]) -> None:
    """Write the eight input words.

    Args:
        layer: whose axis has been advanced to the present instant.
        words: of the image that is written.
    """
    if layer.in_configuration_mode:
        live = layer.latches.bits & (MODE_CONFIG | CONFIG_ERROR | MODULE_OK)
        words[0] = signed_word(live | layer.mirror[0] & 0x1FFF)
        words[1], words[2], words[3] = layer.mirror[1:4]
        words[4] = words[5] = 0
        words[6], words[7] = layer.firmware.major, layer.firmware.minor
    else:
        words[0] = signed_word(_status_msw(layer))
        words[1] = signed_word(_status_lsw(layer))
        words[2], words[3] = split_reported(layer.axis.position)
        words[4], words[5] = split_reported(layer.axis.encoder)
        words[6], words[7] = split_reported(layer.captured)


def _status_msw(layer: CommandLayer) -> int:
    bits = layer.latches.bits
    direction, ramp = layer.axis.direction, layer.axis.ramp
    if direction == 0 and layer.operation is not None:
        direction, ramp = layer.operation.shown_direction, layer.operation.shown_ramp
    if direction:
        bits |= MOVING_CW if direction > 0 else MOVING_CCW
        if ramp:
            bits |= ACCELERATING if ramp > 0 else DECELERATING
    return bits


def _status_lsw(layer: CommandLayer) -> int:
    bits = layer.reported_inputs
    if layer.proximity:
        bits |= HOME_PROX_ECHO  # a plain echo, homing or not (reading A-96)
    if isinstance(layer.operation, BlendRun):
        bits |= BLEND_RUNNING
    elif isinstance(layer.operation, EncoderFollower):
        bits |= ENC_FOLLOWER
    if layer.blending is not None and layer.blending.acknowledged:
        bits |= BLEND_ACK
    return bits | MIN_REG_NONZERO if layer.minimum_registration else bits
