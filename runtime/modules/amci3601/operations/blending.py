r"""Blend moves: block handshake, stored program and run [chapter 5, Blend Move Programming].

LSW bit 8 PROGRAM   ____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\____
LSW bit 9 TRANSMIT  ______/‾‾‾‾\____/‾‾‾‾\____________
BLEND_ACK           _______/‾‾‾‾\____/‾‾‾‾\___________
words 2 to 7              | header  | segment 1 | ...  ^ stored, if every block was good
"""

from __future__ import annotations

from typing import ClassVar

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, StatusLsw
from scanrack.io_images.thousands import is_legal_pair, join_thousands
from typing_extensions import override

from ....kinematics import Shape
from ..amci3601_capabilities import Feature
from ..axis_protocol import BlendProgram
from ..blend_session import BlendSession
from ..command_words import CommandWords
from ..latches import COMMAND_ERROR, STOPPED, BrokenRule
from ..operation import Host, Operation

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


class BlendBlock:
    """One block of the handshake, words 2 to 7, in its programming session."""

    def __init__(self, host: Host, session: BlendSession, now_ns: int, command: CommandWords) -> None:
        self.host = host
        self.session = session
        self.now_ns = now_ns
        self.command = command

    def read(self) -> None:
        """Read and acknowledge the block; a faulty block prevents storing the profile (reading A-57)."""
        session = self.session
        session.acknowledged = True
        session.blocks += 1
        if session.blocks == 1:
            session.is_good = not self.host.refuse_if_unable(self.now_ns, Feature.BLEND, self.command)
            self._read_header()
        elif session.is_good and not session.complete:
            self._read_segment()

    def _refuse(self, rule_id: str, *, alone: bool = False) -> None:
        self.session.is_good = False
        self.host.fire(self.now_ns, rule_id, alone=alone)

    # -- the first block ----------------------------------------------------------------------

    def _read_header(self) -> None:
        """Read the number of segments, their shapes and the final ramp; refuse values that break a rule."""
        words, session, options = self.command.words, self.session, self.host.options
        session.announced = words[2]
        if not SEGMENTS_MIN <= session.announced <= SEGMENTS_MAX:
            self._refuse("PRF-04")
        # two bits per segment, beginning with the lowest bits of word 4
        type_bits = words[4] & 0xFFFF | (words[3] & 0xFFFF) << 16
        codes = [type_bits >> 2 * index & 0b11 for index in range(SEGMENTS_MAX)]
        session.types = [SHAPES[code] for code in codes]
        if options.blend_type_10_invalid and 0b10 in codes[: max(0, session.announced)]:
            self._refuse("BLD-12")
        if options.blend_reserved_words_checked and any(words[6:]):
            self._refuse("PRF-02", alone=True)
        self._read_final_deceleration(words[5] & 0xFFFF)

    def _read_final_deceleration(self, word: int) -> None:
        """Read the shape (bits 14 and 15) and the rate of the final ramp; refuse values that break a rule."""
        code, deceleration = word >> 14, word & 0x3FFF
        if deceleration == 0:
            self._refuse("PRF-07")
        elif code == 0b10 or not self.host.profile.limits.takes_rate(deceleration):
            self._refuse("BLD-13")
        self.session.final_deceleration = deceleration
        self.session.final_shape = SHAPES[code]

    # -- segment blocks -----------------------------------------------------------------------

    def _read_segment(self) -> None:
        """Add a segment to the profile; refuse it if it breaks a rule or is shorter than its ramps."""
        command, session = self.command, self.session
        faults = self._segment_faults()
        if faults:
            session.is_good = False
            self.host.fire_all(self.now_ns, faults)
            return
        if self.host.refuse_if_unable(self.now_ns, Feature.BLEND_SEGMENT, command):
            session.is_good = False
            return
        speed, rate = command.parameters.speed, command.words[6]
        assert speed is not None
        length = join_thousands(command.words[2], command.words[3])
        session.segments.append((length, speed, rate, session.types[len(session.segments)]))
        if not session.newest_segment_fits(self.host.state.start_sps):
            self._refuse("PRF-05")

    def _segment_faults(self) -> list[BrokenRule]:
        """Return the broken rules that do not depend on the ramps of the profile (reading A-110)."""
        command, segments, limits = self.command, self.session.segments, self.host.profile.limits
        speed = command.parameters.speed
        length_msw, length_lsw = command.words[2], command.words[3]
        is_negative = length_msw < 0 or length_lsw < 0
        is_length = is_legal_pair(length_msw, length_lsw) and (length_msw, length_lsw) != (0, 0)
        length = join_thousands(length_msw, length_lsw) if is_length and not is_negative else 0
        uses_reserved_word = self.host.options.blend_reserved_words_checked and command.words[7] != 0
        _, speed_before, _, _ = segments[-1] if segments else (0, None, 0, None)
        rows = (
            (uses_reserved_word, BrokenRule("PRF-02", alone=True)),
            (is_negative, BrokenRule("BLD-21")),
            (not is_length, BrokenRule("BLD-22")),
            (not limits.takes_speed(speed), BrokenRule("PRF-02")),
            (speed is not None and speed < self.host.state.start_sps, BrokenRule("CMD-05")),
            (speed_before is not None and speed == speed_before, BrokenRule("PRF-06")),
            (not limits.takes_rate(command.words[6]), BrokenRule("BLD-18")),
            (length > 0 and self.session.too_long_with(length), BrokenRule("BLD-19")),
        )
        return [fault for is_broken, fault in rows if is_broken]


class BlendRun(Operation):
    """A run of the stored blend profile in one direction; it ends with MOVE_COMPLETE."""

    name: ClassVar[str] = "blend"
    status_lsw: ClassVar[int] = StatusLsw.BLEND_RUNNING.value

    def __init__(self, host: Host, now_ns: int, direction: int, program: BlendProgram) -> None:
        super().__init__(host, now_ns)
        self.direction = direction
        self.program = program
        self.stopping = False

    def start(self, now_ns: int) -> None:
        """Start the axis."""
        self.axis.blend(now_ns, self.direction, self.program)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Refuse Hold; the error clears itself when the profile completes [chapter 6, Command Error 19]."""
        self.host.fire(now_ns, "CMD-19")

    def on_programming(self, now_ns: int) -> None:
        """Stop with the final deceleration, because a new profile is being programmed (reading A-62)."""
        self.host.fire(now_ns, "CMD-18")
        if not self.stopping:
            self.stopping = True
            self.axis.stop(now_ns, self.program.final_deceleration, self.program.final_shape)

    @override
    def on_end(self, now_ns: int) -> None:
        """Show MOVE_COMPLETE and clear the error from a Hold, or show STOPPED after CMD-18."""
        if self.stopping:
            self.host.finish(now_ns, STOPPED, "stopped by a new profile")
            return
        latches = self.state.latches
        if latches.causes.get(COMMAND_ERROR) == "CMD-19":
            latches.clear(COMMAND_ERROR)
            self.state.error_since_start = False
        self.host.complete(now_ns)


def obey_programming(
    host: Host, now_ns: int, command: CommandWords, previous: CommandWords, *, reads_blocks: bool = True
) -> None:
    """Obey the handshake bits of the command LSW [chapter 5, blend routine steps 1 to 6].

    Args:
        reads_blocks: whether words 2 to 7 can be a block; in follower mode they can't (A-112).
    """
    session = host.state.blending
    if not command.lsw & PROGRAM:
        host.state.end_blend()
        return
    transmit = command.lsw & TRANSMIT
    was_transmitting = previous.lsw & TRANSMIT and previous.lsw & PROGRAM and not previous.configures
    if session is not None and not transmit:
        session.acknowledged = False
    if not reads_blocks or not transmit or was_transmitting:
        return
    if session is not None:
        BlendBlock(host, session, now_ns, command).read()
    elif not host.state.locked:
        _begin_programming(host, now_ns, command)


def _begin_programming(host: Host, now_ns: int, command: CommandWords) -> None:
    """Read the first block of a new profile, unless a motion is in progress."""
    if isinstance(host.operation, BlendRun):
        host.state.blend = None
        host.operation.on_programming(now_ns)
    elif host.busy:
        host.fire(now_ns, "LSW-08")
    else:
        BlendBlock(host, host.state.begin_blend(), now_ns, command).read()
