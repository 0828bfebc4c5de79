"""The input image as the command layer has it."""

from __future__ import annotations

from ...io_images.image import signed_word
from ...io_images.thousands import split_reported
from .command_layer import CommandLayer


def report(layer: CommandLayer, words: memoryview[int]) -> None:
    """Write the eight input words [chapter 3, Input Data; chapter 6].

    Args:
        layer: whose axis has been advanced to the present instant.
        words: of the image that is written.
    """
    words[0] = signed_word(layer.status_msw())
    words[1] = signed_word(layer.status_lsw())
    if layer.in_configuration_mode:
        words[2], words[3] = layer.mirror[2], layer.mirror[3]
        words[4] = words[5] = 0
        words[6], words[7] = layer.firmware.major, layer.firmware.minor
    else:
        words[2], words[3] = split_reported(layer.axis.position)
        words[4], words[5] = split_reported(layer.axis.encoder)
        words[6], words[7] = split_reported(layer.captured)
