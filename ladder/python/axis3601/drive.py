"""The drive, which is the only writer of a module's eight output words; it sends one command at a time.

    step          words                                   ends
    REST          zeros                                   with the next command
    PARAMETERS    the command without its command bits    when they have crossed the backplane (option)
    SENT          the command                             when the module moves, or has had time to answer
    UNDER_WAY     the command; 0 in word 0 where the      at its end, or with a newer command
                  module continues by itself
    YIELDING      what stops the axis                     at rest
    RESETTING     RESET_ERRORS                            when COMMAND_ERROR is off
    ZEROS         zeros, so that the next command is      when they have crossed the backplane
                  a transition from 0 to 1

A step has settled after the round trip and two scans with a good link, when words have crossed the backplane
both ways. The steps are the same as in the add-on instruction Amci3601 in `ladder/blocks/axis3601.rung`.

`judge` reads the inputs at the start of a scan. `send` writes the words at the end of the scan.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from enum import IntEnum
from typing import NoReturn

from scanrack.io_images.amci3601.bits import CommandLsw, CommandMsw, StatusMsw, status_names
from scanrack.io_images.drives.translation import DriveTranslation
from scanrack.io_images.image import WORDS, Image

from ..sequences.parts import Clock, Idle
from .command import Command, Outcome
from .errors import ErrorId
from .evidence import Evidence
from .kinds import ABSOLUTE, CONFIGURE, NOTHING_TO_SEND, RESET, VELOCITY, CommandKind, State, Yielding
from .link import Link
from .stop import Stop


class HandshakeStep(IntEnum):
    """A step of the handshake."""

    REST = 0
    SENT = 1
    UNDER_WAY = 2
    YIELDING = 3
    ZEROS = 4
    RESETTING = 5
    PARAMETERS = 6


_REST, _SENT, _UNDER_WAY = HandshakeStep.REST, HandshakeStep.SENT, HandshakeStep.UNDER_WAY
_IN_FORCE = (_SENT, _UNDER_WAY)

_MOVING = (StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW).value
_COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
_INPUT_ERROR = StatusMsw.INPUT_ERROR.value
_CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
_MODULE_OK = StatusMsw.MODULE_OK.value
_NO_POSITION = StatusMsw.POSITION_INVALID.value
_RAMPS = (StatusMsw.ACCELERATING | StatusMsw.DECELERATING).value
_ALIVE = _CONFIG_ERROR | _MODULE_OK

_FOLLOWER = CommandLsw.ENC_FOLLOWER.value
_COMMAND_BITS = ~(
    CommandLsw.STORE_MIN_REG | CommandLsw.ENC_FOLLOWER | CommandLsw.BLEND_PROGRAM | CommandLsw.BLEND_TRANSMIT
).value
_RESET_ERRORS = CommandMsw.RESET_ERRORS.value

FAULTS = (
    (_COMMAND_ERROR, ErrorId.COMMAND_ERROR.value),
    (StatusMsw.INVALID_PROFILE.value, ErrorId.INVALID_PROFILE.value),
    (StatusMsw.HOME_INVALID.value, ErrorId.HOME_INVALID.value),
    (StatusMsw.INPUT_ERROR.value, ErrorId.INPUT_ERROR.value),
)
"""Status bits of command mode, and their bits in ErrorID."""

ZEROS = array("h", bytes(2 * WORDS))


class Drive:
    """Sends commands to a module and evaluates its responses.

    Attributes:
        kind: kind of the latest command sent.
        out: the eight words that are sent.
        running: the command whose words are sent; None at rest.
        pending: the next command.
        newest: the most recently requested command.
        error_stop: whether a command has failed since the last reset.
        msw: judged status word 0.
        lsw: judged status word 1.

    Args:
        trip_ns: time for words to cross the backplane both ways.
        owner: the name of the axis, for messages.
        parameters_first: send the command bit a round trip after the parameters.
        late: judge the inputs after the logic, as rungs do; only for comparisons with rungs.
    """

    def __init__(
        self, trip_ns: int, owner: str = "the axis", *, parameters_first: bool = False, late: bool = False
    ) -> None:
        self.trip_ns = trip_ns
        self.owner = owner
        self.parameters_first = parameters_first
        self.late = late
        self.attach(Image(), Image(), Clock(), Link())

    def attach(
        self,
        inputs: Image,
        outputs: Image,
        clock: Clock,
        link: Link,
        translation: DriveTranslation | None = None,
    ) -> None:
        """Attach to a slot's images and link, and reset.

        Args:
            translation: translation of a networked drive's words.
        """
        self._clock, self.link = clock, link
        self._translation, self._slot_words = translation, inputs.words
        self.inputs = inputs if translation is None else Image()
        self._inputs = self.inputs.words
        self._words, self._raw = outputs.words, outputs.raw
        self.reset()

    def reset(self) -> None:
        """Reset to rest without a command."""
        self._sent = self._raw.tobytes()  # the slot's output image as last written
        self.step, self.kind = _REST, RESET
        self.out = array("h", ZEROS)
        self.running: Command | None = None
        self.pending: Command | None = None
        self.newest: Command | None = None
        self.error_stop = False
        self.msw = self.lsw = 0
        self._stops: list[Stop] = []  # stops that hold the axis or still run
        self._locked = False  # with `late`: whether a stop held the axis at the end of the last scan
        self._last_step = _REST  # the step at the last judgment
        self._since_ns: int | None = None  # when the step began with a good link
        self._settled = self._stuck = False
        self._quiet = False  # whether only a change of status word 0 or a command needs a call
        self._evidence = Evidence(self._inputs, 2 * self.trip_ns)
        self._cleared: Command | None = None  # the command that an INPUT_ERROR was reset for
        if self._translation is not None:
            self._translation.reset()

    # -- state, and requests

    @property
    def state(self) -> State:
        """The PLCopen state of the axis."""
        if _is_lost(self.msw):
            return State.DISABLED
        if self.error_stop:
            return State.ERROR_STOP
        if self.locked:
            return State.STOPPING
        if self.step == HandshakeStep.YIELDING:
            return State.DISCRETE_MOTION
        has_command = self.step in (_SENT, _UNDER_WAY, HandshakeStep.PARAMETERS)
        return self.kind.state if has_command else State.STANDSTILL

    @property
    def locked(self) -> bool:
        """Whether a `stop` is holding the axis."""
        return self._locked if self.late else any(stop.holds for stop in self._stops)

    @property
    def moving(self) -> bool:
        """Whether the module reports motion."""
        return self.msw >= 0 and self.msw & _MOVING != 0

    @property
    def position_valid(self) -> bool:
        """Whether the module's position is valid."""
        return not self.msw & _NO_POSITION

    @property
    def under_way(self) -> bool:
        """Whether the module executes the words of a command."""
        return self.step == _UNDER_WAY

    def runs_evenly(self, since_ns: int) -> bool:
        """Return whether the axis moves at constant speed, at least a round trip after `since_ns`."""
        late_enough = self._clock.now_ns - since_ns >= self.trip_ns
        return late_enough and self.under_way and self.moving and not self.msw & _RAMPS

    def request(self, command: Command) -> None:
        """Request a command, and abort the previous one."""
        if self.newest is not None:
            self.newest.end(Outcome.ABORTED)
        self.newest = self.pending = command
        command.follow(self.link)
        self._quiet = False

    def hold(self, stop: Stop) -> None:
        """Hold the axis with a `stop`."""
        self._stops = [active for active in self._stops if active.holds or active.busy]
        self._stops.append(stop)

    # -- for the scan

    def judge(self, now_ns: int) -> None:
        """Judge the inputs, before the logic."""
        link = self.link
        if self._translation is not None:
            self._inputs[:] = array("h", self._translation.status(self._slot_words))
        if self._quiet and self._inputs[0] == self.msw and link.module.linked is not link.down:
            return  # most scans: without a call
        if not self.late:
            link.update(now_ns)
            self._judge(now_ns)

    def idle(self) -> Idle | None:
        """Return when `judge` and `send` do nothing, see `Device.idle`; None for a networked drive."""
        if self._translation is not None:
            return None
        unchanged = "{words}[0] == {drive}.msw and {module}.linked is not {link}.down"
        names = {"drive": self, "words": self._inputs, "link": self.link, "module": self.link.module}
        return Idle(
            before=f"{{drive}}._quiet and {unchanged}",
            after="{drive}._quiet and {bytes}() == {drive}._sent",
            names={**names, "bytes": self._raw.tobytes},
        )

    def send(self, now_ns: int) -> None:
        """Write the words, after the logic; raise a RuntimeError if another writer has changed them."""
        if self._raw.tobytes() != self._sent:
            self._refuse_other_writer()
        if self._quiet:
            return
        running = self.running
        if running is not None and running.attended and running.active:
            running.attend(self, now_ns)
        if self.late:
            self._locked = any(stop.holds for stop in self._stops)
            self.link.update(now_ns)
            self._judge(now_ns)
        self._send_newest(now_ns)
        self._quiet = self._is_quiet()
        translation = self._translation
        self._words[:] = self.out if translation is None else array("h", translation.command(self.out))
        self._sent = self._raw.tobytes()

    def _refuse_other_writer(self) -> NoReturn:
        sent, words = Image(buffer=bytearray(self._sent)), self._words.tolist()
        raise RuntimeError(
            f"{self.owner} must be the only writer of its module's output words; "
            f"other logic changed {list(sent)} to {words}"
        )

    def _is_quiet(self) -> bool:
        """Return whether the drive is idle until status word 0 changes or a command arrives."""
        if self.late or self.pending is not None or self.step != self._last_step:
            return False
        attended = self.running is not None and self.running.attended
        return self.step == _REST or (self.step == _UNDER_WAY and self.moving and not attended)

    # -- judging the inputs

    def _judge(self, now_ns: int) -> None:
        """Evaluate the inputs of a scan: the running command begins, continues, or ends."""
        self._quiet = False
        self.msw = self._inputs[0]
        self.lsw = self._inputs[1]
        self._settle(now_ns)
        moving = self.moving
        if self.step in _IN_FORCE:
            self._evidence.observe(self.kind, self.out, moving=moving, down=self.link.down)
        if self.step == _SENT and self._has_begun(moving):
            self._begin()
        if self.step == _UNDER_WAY and self.kind.runs_on:
            self.out[0] = 0
        self._end_command(moving=moving, stuck=self._update_stuck(now_ns))

    def _end_command(self, *, moving: bool, stuck: bool) -> None:
        """End the running command if it has failed, is done, or is stuck."""
        under_way = self.step == _UNDER_WAY
        if faults := self._command_faults():
            self._fail(faults)
        elif under_way and not moving and self._is_done(self.msw):
            self.error_stop = self.error_stop and self.kind not in (RESET, CONFIGURE)
            self._finish(Outcome.DONE, 0)
        elif stuck and (under_way or (self.step == _SENT and self.kind is CONFIGURE)):
            self._fail(faults_of(self.msw) | ErrorId.NOT_DONE)

    def _command_faults(self) -> int:
        """Return the ErrorID if the running command has failed, else 0."""
        commanded = _SENT <= self.step <= HandshakeStep.YIELDING
        lost = commanded and self.kind is not CONFIGURE and _is_lost(self.msw)
        if not lost and self.step != _UNDER_WAY:
            return 0
        faults = faults_of(self.msw) | self._drive_fault()
        return int(ErrorId.CONFIG_ERROR) if lost and not faults else faults

    def _drive_fault(self) -> int:
        """Return the ErrorID of a networked drive that can't move; a 3601 has no bits for this."""
        drive = self._translation
        if drive is None or self.msw < 0:
            return 0
        moves = self.kind.state is not State.STANDSTILL
        return ErrorId.DRIVE_FAULT if drive.unfit or (moves and not drive.enabled) else 0

    def _settle(self, now_ns: int) -> None:
        """Measure how long the step has lasted with a good link, and whether it is at least a round trip."""
        if self.step != self._last_step or self.link.down:
            self._since_ns = None
        elif self._since_ns is None:
            self._since_ns = now_ns
        self._settled = self._since_ns is not None and now_ns - self._since_ns >= self.trip_ns
        self._last_step = self.step

    def _has_begun(self, moving: bool) -> bool:
        """Return whether a command has begun, after a round trip or by motion; CONFIGURE also by its mode."""
        if self.kind is CONFIGURE:
            return self._settled and self.msw < 0
        return moving or self._settled

    def _begin(self) -> None:
        """Mark the command as under way; send zeros if it is an accepted configuration."""
        self.step = _UNDER_WAY
        if self.kind is CONFIGURE and not self.msw & _CONFIG_ERROR:
            self._write(ZEROS)  # accepted: zeros change to command mode

    def _is_done(self, msw: int) -> bool:
        """Return whether an axis at rest has completed the command: status, handshake and evidence agree."""
        if self.kind is CONFIGURE:
            return msw >= 0
        if self.running is not None and not self.running.handshake_over:
            return False
        done_bits = self.kind.done_bits
        if done_bits is None or (done_bits and not msw & done_bits):
            return False
        return self._evidence.may_have_ended(self.kind, self.out)

    def _update_stuck(self, now_ns: int) -> bool:
        """Store and return whether the axis has been at rest too long for the step to end normally."""
        expects_end = self.step in _IN_FORCE or self.step == HandshakeStep.RESETTING
        idle = expects_end and not self.moving and not self.link.down
        self._stuck = self._evidence.rests_too_long(self.kind, self.out[1], now_ns, idle=idle)
        return self._stuck

    def _fail(self, error_id: int) -> None:
        """End the running command with an error, and put the axis in the error state."""
        self.error_stop = True
        if self._evidence.broken:
            error_id |= ErrorId.LINK_LOST
        self._finish(Outcome.ERROR, error_id, self._failure_details(error_id))

    def _failure_details(self, error_id: int) -> str:
        """Describe the link with the times of its changes, and the status of an axis at rest."""
        sentences = [str(self.link)] if error_id & ErrorId.LINK_LOST else []
        if error_id & ErrorId.NOT_DONE:
            sentences.append(f"the status is {' '.join(self._status_names())}")
        return "; ".join(sentences)

    def _status_names(self) -> list[str]:
        """Return the names of the status bits that are on, as the module's family names them."""
        if self._translation is None:
            return status_names(self.msw, self.lsw)
        return self._translation.status_names(self._slot_words)

    def _finish(self, outcome: Outcome, error_id: int, detail: str = "") -> None:
        """End the running command, if there is one, and send zeros."""
        if self.running is not None:
            self.running.end(outcome, error_id, detail)
        self._send_zeros()

    # -- the newest command

    def _send_newest(self, now_ns: int) -> None:
        """Make way for the pending command, advance the step, and send the command once at rest.

        A step that has just begun is not settled, so it lasts at least a round trip.
        """
        settled = self._settled and self.step == self._last_step
        if self.pending is not None:
            self._interrupt(self.pending, now_ns)
        if settled and self.step == self._last_step:
            self._advance_step(now_ns)
        if self.step == _REST and self.pending is not None:
            self._send_pending(self.pending, now_ns)

    def _interrupt(self, newer: Command, now_ns: int) -> None:
        """Stop the command under way, or change its speed."""
        if self.step == HandshakeStep.PARAMETERS:
            self._send_zeros()  # no command bit was sent
        if self.step != _UNDER_WAY:
            return
        if self.kind is newer.kind is VELOCITY and newer.words[0] == self.out[0]:
            self._send_words(newer, now_ns)
            return
        yielding = self.kind.yielding
        if yielding is Yielding.WAIT:
            return
        if yielding is Yielding.RELEASE:
            self.out[0] = 0
            if not self.parameters_first:
                self.out[1] &= ~_FOLLOWER
        else:
            self._write(yielding.value)
        self.step = HandshakeStep.YIELDING

    def _advance_step(self, now_ns: int) -> None:
        """After a round trip, leave a step that waits for rest, for a reset, or for words to cross."""
        command_error = self.msw & _COMMAND_ERROR != 0
        if self.step == HandshakeStep.YIELDING and not self.moving:
            self._send_zeros()
            if command_error:  # a Hold that arrived just as a move ended
                self.out[0] = _RESET_ERRORS
                self.step = HandshakeStep.RESETTING
        elif self.step == HandshakeStep.RESETTING and (self._stuck or not command_error):
            self._send_zeros()
        elif self.step == HandshakeStep.ZEROS:
            self.step = _REST
        elif self.step == HandshakeStep.PARAMETERS and self.running is not None:
            self._send_command(self.running, now_ns)

    def _send_parameters(self, command: Command) -> None:
        """Send the parameters of a command without its command bits."""
        self.running = command
        self.out = array("h", command.words)
        self.out[0] = 0
        self.out[1] &= _COMMAND_BITS
        self.step = HandshakeStep.PARAMETERS

    def _send_command(self, command: Command, now_ns: int) -> None:
        """Send the command bits after the parameters; word 1 first if both words have command bits."""
        if command.words[0] and self.out[1] != command.words[1]:
            self.out[1] = command.words[1]
            self._since_ns = None  # word 1 must cross the backplane first
        else:
            self._send_words(command, now_ns)
            self.step = _SENT

    def _send_pending(self, command: Command, now_ns: int) -> None:
        """Send the pending command at rest; end it if there is nothing to send or an error prevents it."""
        self.pending = None
        refused = self._error_since_request(command.kind)
        if refused:
            command.end(Outcome.ERROR, refused, f"the axis is now in state {self.state.name}")
        elif command.kind in NOTHING_TO_SEND:
            command.end(Outcome.DONE)
        elif self._has_old_error(command):
            self.pending, self._cleared = command, command
            self.out[0] = _RESET_ERRORS
            self.step = HandshakeStep.RESETTING
        else:
            self.kind = command.kind
            if self.parameters_first:
                self._send_parameters(command)
            else:
                self._send_words(command, now_ns)
                self.step = _SENT

    def _has_old_error(self, command: Command) -> bool:
        """Return whether a motion of a networked drive needs Reset Errors first.

        The next move of a 3601 clears an INPUT_ERROR by itself.
        """
        is_motion = self._translation is not None and command.kind.state is not State.STANDSTILL
        return is_motion and self.msw & _INPUT_ERROR != 0 and self._cleared is not command

    def _error_since_request(self, kind: CommandKind) -> int:
        """Return the ErrorID if the axis has failed since a command was queued, else 0."""
        if kind in NOTHING_TO_SEND or kind is CONFIGURE:
            return 0
        if (self.error_stop and kind is not RESET) or _is_lost(self.msw):
            return ErrorId.WRONG_STATE
        return ErrorId.POSITION_INVALID if kind is ABSOLUTE and not self.position_valid else 0

    def _send_words(self, command: Command, now_ns: int) -> None:
        """Send a command's words and make it the running command; a speed change keeps the evidence."""
        if self.step != _UNDER_WAY:
            self._evidence.begin()
        self.out = array("h", command.words)
        self.running, self.pending = command, None
        command.activate(now_ns)

    def _send_zeros(self) -> None:
        """Send zeros instead of a command."""
        self.running = None
        self._write(ZEROS)
        self.step = HandshakeStep.ZEROS

    def _write(self, words: Sequence[int]) -> None:
        """Write words without parameters; with `parameters_first`, keep the last command's parameters."""
        if self.parameters_first:
            self.out[0] = words[0]
            self.out[1] &= _COMMAND_BITS
        else:
            self.out = array("h", words)


def faults_of(msw: int) -> int:
    """Return the ErrorID for status word 0; in configuration mode, only its live bits count."""
    error_id = ErrorId(0)
    if msw & _CONFIG_ERROR:
        error_id |= ErrorId.CONFIG_ERROR
    if not msw & _MODULE_OK:
        error_id |= ErrorId.MODULE_LOST
    if msw >= 0:
        error_id |= sum(fault for bit, fault in FAULTS if msw & bit)
    return int(error_id)


def _is_lost(msw: int) -> bool:
    return msw < 0 or msw & _ALIVE != _MODULE_OK
