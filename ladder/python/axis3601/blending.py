"""Programs a blend profile, block by block [3601 manual, chapter 5, Blend Move Programming].

words out, word 1        BLEND_ACK    next
program and transmit     on           transmit goes off
program                  off          the next block, or zeros after the last
zeros, for a round trip               the end
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence

from scanrack.io_images.amci3601.bits import CommandLsw, StatusLsw
from scanrack.io_images.amci3601.blend import PROGRAM_AND_TRANSMIT, BlendHeader, BlendSegment
from scanrack.io_images.drives.translation import HEADER
from scanrack.io_images.image import WORDS, Image
from typing_extensions import override

from .command import Command, Handshake
from .kinds import PROGRAM_BLEND

_PROGRAM = CommandLsw.BLEND_PROGRAM.value
_RATE = 0x3FFF
"""Bits of the final deceleration in word 5 of the first block."""
_ACKNOWLEDGED = StatusLsw.BLEND_ACK.value


class BlendProgramming(Command):
    """The programming of a profile."""

    __slots__ = ("_parameters_sent_ns", "_remaining", "_zeros_since_ns", "handshake_over")

    attended = True

    def __init__(self, axis: str, text: str) -> None:
        super().__init__(axis, PROGRAM_BLEND, text)
        self._remaining: list[array[int]] = []  # blocks to be sent
        self._zeros_since_ns: int | None = None  # since when zeros are sent; None before that
        self._parameters_sent_ns: int | None = None  # when a block was sent without its transmit bit
        self.handshake_over = False

    def fill(self, header: BlendHeader, segments: Sequence[BlendSegment]) -> None:
        """Store the blocks to send; raise a ValueError if the header has a different number of segments."""
        if header.segments != len(segments):
            raise ValueError(f"the header is for {header.segments} segments, not {len(segments)}")
        self.set_words(header.to_image())
        self._remaining = [array("h", segment.to_image().words) for segment in segments]

    def for_drive(self) -> Image:
        """Set word 7 of each block for a networked drive (HEADER or deceleration); return the first."""
        self.words[7] = HEADER
        for block in self._remaining:
            block[7] = block[6]
        self._remaining[-1][7] = self.words[5] & _RATE
        return Image(self.words)

    @property
    def unfit_for_drives(self) -> str:
        """The reason why a networked drive can't run the profile; "" if it can."""
        if self.words[3] or self.words[4] or self.words[5] & ~_RATE:  # types of acceleration
            return "a drive's blend has no S-curve"
        speed_before, last_speed = (1000 * block[4] + block[5] for block in self._remaining[-2:])
        rate, deceleration = self._remaining[-1][6:8]
        if last_speed < speed_before and rate != deceleration:
            return "a drive's last segment has one rate; final_deceleration must be its deceleration"
        return ""

    def _next(self, drive: Handshake, now_ns: int) -> None:
        """Send the next block, or zeros after the last one."""
        if not self._remaining:
            drive.out = array("h", bytes(2 * WORDS))
        elif self._parameters_crossed(drive, now_ns):
            drive.out = self._remaining.pop(0)
            self._parameters_sent_ns = None

    def _parameters_crossed(self, drive: Handshake, now_ns: int) -> bool:
        """With `parameters_first`, send a block without its transmit bit; return whether it has arrived."""
        if drive.parameters_first and self._parameters_sent_ns is None:
            drive.out = array("h", self._remaining[0])
            drive.out[1] = _PROGRAM
            self._parameters_sent_ns = now_ns
        return self._parameters_sent_ns is None or now_ns - self._parameters_sent_ns >= drive.trip_ns

    @override
    def attend(self, drive: Handshake, now_ns: int) -> None:
        """After each acknowledgment, clear the transmit bit, then send the next block; zeros end it."""
        if not drive.under_way:
            self._zeros_since_ns = None
            return
        acknowledged = drive.lsw & _ACKNOWLEDGED != 0
        if drive.out[1] == PROGRAM_AND_TRANSMIT and acknowledged:
            drive.out[1] = _PROGRAM
        if drive.out[1] == _PROGRAM and not acknowledged:
            self._next(drive, now_ns)
        if drive.out[1] == 0:
            if self._zeros_since_ns is None:
                self._zeros_since_ns = now_ns
            self.handshake_over = now_ns - self._zeros_since_ns >= drive.trip_ns
