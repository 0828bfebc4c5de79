r"""Blend moves: the block handshake, the stored program, its run [chapter 5, Blend Move Programming].

LSW bit 8 PROGRAM   ____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\____
LSW bit 9 TRANSMIT  ____/‾‾‾‾\\____/‾‾‾‾\\____________
BLEND_ACK           _____/‾‾‾‾\\____/‾‾‾‾\\___________
words 2 to 7            | header | segment 1 | ...  ^ stored, if every block was good
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from ....io_images.amci3601 import CommandLsw, CommandMsw, rate_in_range, speed_in_range
from ....io_images.thousands import PARAMETER_MAX, is_legal_pair, join_thousands
from ...kinematics import MILLI, PICO, BlendLeg, Shape, check_blend, ramp_distance
from .axis import BlendProgram
from .capabilities import Feature
from .command_words import CommandWords
from .latches import COMMAND_ERROR, INVALID_PROFILE, STOPPED, Fault
from .operation import Operation

if TYPE_CHECKING:
    from .command_layer import CommandLayer

PROGRAM = CommandLsw.BLEND_PROGRAM.value
TRANSMIT = CommandLsw.BLEND_TRANSMIT.value
RUN_CW = CommandMsw.RUN_BLEND_CW.value

SEGMENTS_MIN, SEGMENTS_MAX = 2, 16

SHAPES = {
    0b00: Shape.CONSTANT,
    0b01: Shape.TRIANGULAR,
    0b10: Shape.CONSTANT,  # the low bit decides (reading A-60)
    0b11: Shape.TRAPEZOIDAL,
}


class BlendProgramming:
    """One session of the handshake, from the first block to the fall of the program bit.

    Args:
        layer: where faults go.
    """

    def __init__(self, layer: CommandLayer) -> None:
        self.layer = layer
        self.acknowledged = False
        self.good = True
        self.blocks = 0
        self.wanted = 0
        self.types: list[Shape] = []
        self.segments: list[BlendLeg] = []
        self.final_deceleration = 1
        self.final_shape = Shape.CONSTANT

    def read(self, now_ns: int, order: CommandWords) -> None:
        """Read the next block and acknowledge it; a faulty one spoils the profile (reading A-57)."""
        self.acknowledged = True
        self.blocks += 1
        if self.blocks == 1:
            self.good = not self.layer.unable(now_ns, Feature.BLEND, order)
            self._read_header(now_ns, order)
        elif self.good and len(self.segments) < self.wanted:
            self._read_segment(now_ns, order)

    def program(self) -> BlendProgram | None:
        """Return the profile if all of its blocks have come and were good, else None."""
        if not self.good or len(self.segments) < self.wanted:
            return None
        return BlendProgram(tuple(self.segments), self.final_deceleration, self.final_shape)

    def _spoil(self, now_ns: int, rule_id: str, *, bits: int | None = None) -> None:
        self.good = False
        self.layer.fire(now_ns, rule_id, bits=bits)

    # -- the first block ----------------------------------------------------------------------

    def _read_header(self, now_ns: int, order: CommandWords) -> None:
        self.wanted = order.words[2]
        if not SEGMENTS_MIN <= self.wanted <= SEGMENTS_MAX:
            self._spoil(now_ns, "PRF-04")
        types = order.words[4] & 0xFFFF | (order.words[3] & 0xFFFF) << 16
        codes = [types >> 2 * at & 0b11 for at in range(SEGMENTS_MAX)]
        self.types = [SHAPES[code] for code in codes]
        options = self.layer.options
        if options.blend_type_10_invalid and 0b10 in codes[: max(0, self.wanted)]:
            self._spoil(now_ns, "BLD-12", bits=INVALID_PROFILE)
        if options.blend_reserved_words_checked and any(order.words[6:]):
            self._spoil(now_ns, "PRF-02", bits=INVALID_PROFILE)
        self._read_final(now_ns, order.words[5] & 0xFFFF)

    def _read_final(self, now_ns: int, word: int) -> None:
        kind, self.final_deceleration = word >> 14, word & 0x3FFF
        if self.final_deceleration == 0:
            self._spoil(now_ns, "PRF-07", bits=INVALID_PROFILE | COMMAND_ERROR)
        elif kind == 0b10 or not rate_in_range(self.final_deceleration):
            self._spoil(now_ns, "BLD-13", bits=INVALID_PROFILE | COMMAND_ERROR)
        self.final_shape = SHAPES[kind]

    # -- segment blocks -----------------------------------------------------------------------

    def _read_segment(self, now_ns: int, order: CommandWords) -> None:
        faults = self._segment_faults(order)
        if faults:
            self.good = False
            self.layer.fire_all(now_ns, faults)
            return
        if self.layer.unable(now_ns, Feature.BLEND_SEGMENT, order):
            self.good = False
            return
        speed, rate = order.parameters.speed, order.words[6]
        assert speed is not None
        length = join_thousands(order.words[2], order.words[3])
        self.segments.append((length, speed, rate, self.types[len(self.segments)]))
        if not self._fits():
            self._spoil(now_ns, "PRF-05")

    def _segment_faults(self, order: CommandWords) -> list[Fault]:
        """Return every rule that the block breaks on its own (reading A-110)."""
        speed = order.parameters.speed
        length_msw, length_lsw = order.words[2], order.words[3]
        negative = length_msw < 0 or length_lsw < 0
        a_value = is_legal_pair(length_msw, length_lsw) and (length_msw, length_lsw) != (0, 0)
        reserved = self.layer.options.blend_reserved_words_checked and order.words[7] != 0
        rows = (
            (reserved, Fault("PRF-02", INVALID_PROFILE)),
            (negative, Fault("BLD-21")),
            (not a_value, Fault("BLD-22")),
            (not speed_in_range(speed), Fault("PRF-02")),
            (speed is not None and speed < self.layer.start_sps, Fault("CMD-05")),
            (bool(self.segments) and speed == self.segments[-1][1], Fault("PRF-06")),
            (not rate_in_range(order.words[6]), Fault("BLD-18")),
            (a_value and not negative and self._too_long(length_msw, length_lsw), Fault("BLD-19")),
        )
        return [fault for broken, fault in rows if broken]

    def _too_long(self, length_msw: int, length_lsw: int) -> bool:
        """Whether the lengths so far and this one exceed what all segments may have together."""
        total = sum(segment[0] for segment in self.segments) + join_thousands(length_msw, length_lsw)
        return total > PARAMETER_MAX

    def _fits(self) -> bool:
        """Whether the newest segment contains its ramp, and the last one also the final ramp (A-58)."""
        start = self.layer.start_sps
        if len(self.segments) == self.wanted:
            try:
                check_blend(start, self.segments, self.final_deceleration, self.final_shape)
            except ValueError:
                return False
            return True
        length, speed, rate, shape = self.segments[-1]
        before = self.segments[-2][1] if len(self.segments) > 1 else start
        return ramp_distance(MILLI * before, MILLI * speed, rate, shape) <= length * PICO


class BlendRun(Operation):
    """A stored blend profile, run in one direction; ends in MOVE_COMPLETE."""

    name: ClassVar[str] = "blend"

    def __init__(self, layer: CommandLayer, now_ns: int, direction: int, program: BlendProgram) -> None:
        super().__init__(layer, now_ns)
        self.direction = direction
        self.program = program
        self.stopping = False

    def start(self, now_ns: int) -> None:
        """Set the axis going."""
        self.layer.axis.blend(now_ns, self.direction, self.program)

    def on_hold(self, now_ns: int) -> None:
        """Refuse; the error clears itself when the profile is complete [chapter 6, Command Error 19]."""
        self.layer.fire(now_ns, "CMD-19")

    def on_programming(self, now_ns: int) -> None:
        """A new profile is sent meanwhile: stop with the final deceleration (reading A-62)."""
        self.layer.fire(now_ns, "CMD-18")
        if not self.stopping:
            self.stopping = True
            self.layer.axis.stop(now_ns, self.program.final_deceleration, self.program.final_shape)

    def on_end(self, now_ns: int) -> None:
        """Show MOVE_COMPLETE and forgive a Hold; or show STOPPED after CMD-18."""
        if self.stopping:
            self.layer.finish(now_ns, STOPPED, "stopped by a new profile")
            return
        latches = self.layer.latches
        if latches.causes.get(COMMAND_ERROR) == "CMD-19":
            latches.clear(COMMAND_ERROR)
            self.layer.error_since_start = False
        self.layer.complete(now_ns)


def obey_programming(
    layer: CommandLayer, now_ns: int, order: CommandWords, previous: CommandWords, *, reads: bool = True
) -> None:
    """Follow the handshake bits of the command LSW [chapter 5, blend routine steps 1 to 6].

    Args:
        layer: the module.
        now_ns: the instant.
        order: the words.
        previous: those before.
        reads: whether words 2 to 7 can be a block; in follower mode they are the follower's (A-112).
    """
    session = layer.blending
    if not order.lsw & PROGRAM:
        if session is not None:
            layer.blend = session.program()
            layer.blending = None
        return
    transmit = order.lsw & TRANSMIT
    risen = transmit and not (previous.lsw & TRANSMIT and previous.lsw & PROGRAM and not previous.configures)
    if session is not None and not transmit:
        session.acknowledged = False
    if not reads:
        return
    if risen and session is not None:
        session.read(now_ns, order)
    elif risen and not layer.locked:
        _begin(layer, now_ns, order)


def _begin(layer: CommandLayer, now_ns: int, order: CommandWords) -> None:
    """The first block: programming starts unless a motion is under way."""
    if isinstance(layer.operation, BlendRun):
        layer.blend = None
        layer.operation.on_programming(now_ns)
    elif layer.busy:
        layer.fire(now_ns, "LSW-08", bits=COMMAND_ERROR)
    else:
        layer.blend = layer.held = None  # Resume has to be the first command after a hold (reading A-83)
        layer.blending = BlendProgramming(layer)
        layer.blending.read(now_ns, order)
