"""The 3601's command layer: modes, edges, refusals, latched errors.

The module calls it at the ticks of its 250 µs scan at which words or inputs may have changed, and at the
exact instant at which a motion ends. A tick does the following, in this order [chapters 3 to 6]:

1. sample the inputs, and capture on an inactive-to-active transition (`inputs`);
2. in run mode, obey the output words: the mode bit (`configuring`), errors that lock the module, follower and
   blend bits, the command bit that rose (`commands`, refused by `refusals`), the running operation's bits;
3. obey the inputs that stop motion: emergency stop, end limits, external;
4. pass the tick to the running operation, which checks its levels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, Firmware
from scanrack.io_images.amci3601.words import WORDS_3601, Profile
from typing_extensions import override

from ...loop.events import Event, JsonValue
from . import configuring
from .amci3601_capabilities import AxisRequest, Feature, Refusal
from .amci3601_options import Amci3601Options
from .axis_protocol import Axis
from .command_words import COMMAND_BITS, CommandWords
from .commands import COMMANDS, obey_store_minimum
from .inputs import InputWatch
from .latches import (
    CLEARED_BY_A_MOVE,
    COMMAND_ERROR,
    MOVE_COMPLETE,
    POSITION_INVALID,
    STOPPED,
    BrokenRule,
    Latches,
)
from .operation import Host, Operation
from .operations.blending import obey_programming
from .operations.cut_short import CutShort
from .operations.follower import EncoderFollower, obey_follower
from .refusals import faults_of_several
from .state import ModuleState

RESET = CommandMsw.RESET_ERRORS.value
MOVES = (CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE).value
HOLD_OR_STOP = (CommandMsw.HOLD_MOVE | CommandMsw.IMMEDIATE_STOP).value
_BITS: Mapping[str, int] = {
    **{str(bit.name): bit.value for bit in CommandMsw},
    **{str(bit.name): bit.value << 16 for bit in CommandLsw},
}
"""The command bits of both words, by name."""

HOLD_OR_RESUME = (CommandMsw.HOLD_MOVE.value, CommandMsw.RESUME_MOVE.value)


class CommandLayer(Host):
    """The rules, modes and memory of a 3601, for any axis.

    Args:
        firmware: the module's firmware revision, which determines its functions.
        events: list to which rules that fire and moves that end are appended.
    """

    def __init__(
        self,
        axis: Axis,
        firmware: Firmware,
        options: Amci3601Options,
        events: list[Event],
        now_ns: int = 0,
        profile: Profile = WORDS_3601,
    ) -> None:
        self.profile = profile
        self.axis = axis
        self.firmware = firmware
        self.options = options
        self.state = ModuleState(Latches(events, profile))
        self.operation: Operation | None = None
        self._events = events
        self._inputs = InputWatch(self)
        self.state.latches.fire(now_ns, "CER-01")
        self.state.latches.bits |= POSITION_INVALID  # until a preset or a search for home (reading A-04)

    # -- present activity ---------------------------------------------------------------------

    @property
    @override
    def busy(self) -> bool:
        return self.operation is not None and self.operation.busy

    @property
    @override
    def cuttable(self) -> bool:
        return self.busy and not isinstance(self.operation, CutShort)

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the instant of the next tick if no words or inputs change, or None."""
        if self.operation is not None:
            return self.operation.next_wake_ns(now_ns)
        is_waiting = self.state.command.configures and not self.state.in_configuration_mode
        return now_ns + 1 if is_waiting and self.state.running else None

    # -- the tick -----------------------------------------------------------------------------

    def tick(self, now_ns: int, words: tuple[int, ...], levels: int) -> None:
        """Carry out one tick of the module's scan.

        Args:
            now_ns: the instant; the axis has been advanced to it.
            levels: electrical levels of the discrete inputs, as a mask of `InputBit`.
        """
        self._inputs.sample(levels)
        if self.state.running:
            self._obey(now_ns, words)
        if not self.state.in_configuration_mode:
            self._inputs.obey(now_ns)
        if self.operation is not None and not self.operation.over:
            self.operation.on_tick(now_ns, self.state.command)
        self.settle(now_ns)

    def counts_from_ns(self, now_ns: int, turns_ns: int | None) -> int | None:
        """Return the instant from which calls of `counted` are required; see `Operation.counts_from_ns`."""
        operation = self.operation
        if operation is None or operation.over:
            return None
        return operation.counts_from_ns(now_ns, turns_ns)

    def counted(self, now_ns: int) -> None:
        """Process the counts of a scan at its end, with the words and inputs of its start."""
        if self.operation is not None and not self.operation.over:
            self.operation.on_counts(now_ns, self.state.command)
        self.settle(now_ns)

    @override
    def settle(self, now_ns: int) -> None:
        if self.operation is not None and self.operation.over:
            self.operation.on_end(now_ns)

    def leave_run_mode(self, now_ns: int) -> None:
        """Leave run mode; this stops a motion and invalidates the position [chapter 5 note 9]."""
        self.state.running = False
        if self.cuttable:
            if self.options.invalid_after_program_mode:
                self.state.latches.fire(now_ns, "PRG-01")
            else:
                self.state.latches.note(now_ns, "PRG-01")
            self.cut(now_ns, stopped=self.options.stopped_after_program_mode)
        elif self.operation is not None:
            self.operation.on_release(now_ns)

    def enter_run_mode(self) -> None:
        """Return to run mode; a bit that is still set does not cause an edge (reading A-78)."""
        self.state.running = True

    def overlook(self, words: tuple[int, ...]) -> None:
        """Store words without obeying them, so that their bits do not cause an edge later."""
        self.state.command = CommandWords(words)

    # -- output words -------------------------------------------------------------------------

    def _obey(self, now_ns: int, words: tuple[int, ...]) -> None:
        """Obey the output words: the mode bit first, and other words only with a valid configuration."""
        previous = self.state.command
        self.state.command = command = previous if previous.words == words else CommandWords(words)
        if command.configures:
            configuring.obey_mode_bit(self, now_ns, command, previous)
            return
        if self.state.in_configuration_mode:
            configuring.leave(self, now_ns)
        if self.state.configuration is None:
            return  # no operation before a valid configuration [chapter 3; reading A-05]
        if command is not previous:
            self._obey_new_words(now_ns, command, previous)

    def _obey_new_words(self, now_ns: int, command: CommandWords, previous: CommandWords) -> None:
        """Obey words that have changed: follower and blocks, then a command bit that has risen.

        Words that stop a motion can only continue an open programming session. An undescribed bit causes all
        words to be refused.
        """
        if self.profile.undescribed and self._refuses_undescribed_bits(now_ns, command, previous):
            return
        risen_bits = command.msw & ~previous.msw & COMMAND_BITS
        is_following = False
        if not self._stops(command, risen_bits):
            is_following = obey_follower(self, now_ns, command, previous)
            reads_blocks = not is_following and not isinstance(self.operation, EncoderFollower)
            obey_programming(self, now_ns, command, previous, reads_blocks=reads_blocks)
            if reads_blocks:
                obey_store_minimum(self, now_ns, command, previous)
        elif self.state.blending is not None:  # a running session continues
            obey_programming(self, now_ns, command, previous)
        if risen_bits and not is_following:
            self._command(now_ns, command, risen_bits)
        if self.operation is not None and not self.operation.over:
            self.operation.on_words(now_ns, command)

    def _refuses_undescribed_bits(self, now_ns: int, command: CommandWords, previous: CommandWords) -> bool:
        """Refuse bits that the module's manual does not describe; return whether one is set."""
        undescribed_bits = {name: bit for name, bit in _BITS.items() if name in self.profile.undescribed}
        bits_before = previous.msw | previous.lsw << 16
        bits_now = command.msw | command.lsw << 16
        for name, bit in undescribed_bits.items():
            if bits_now & ~bits_before & bit:
                reason = f"the manual of a {self.profile.message} does not describe {name}"
                self.refuse(now_ns, Refusal(name, COMMAND_ERROR, reason))
        return any(bits_now & bit for bit in undescribed_bits.values())

    def _stops(self, command: CommandWords, risen_bits: int) -> bool:
        """Return whether the command holds or stops a motion, regardless of the LSW (reading A-30).

        In follower mode, Hold and Immediate Stop have no effect [chapter 6, Command Error 34].
        """
        stop_bits = risen_bits & HOLD_OR_STOP
        is_stoppable = self.busy and not isinstance(self.operation, EncoderFollower)
        return bool(stop_bits) and command.msw == stop_bits and is_stoppable

    def _command(self, now_ns: int, command: CommandWords, risen_bits: int) -> None:
        """Refuse or carry out the command whose bit has risen [chapter 4, general notes 1 to 3]."""
        if self.state.locked:
            if command.msw == RESET and command.lsw == 0:
                self._forfeit()
                COMMANDS[RESET](self, now_ns, command)
        elif command.many_bits:
            self._refuse_several(now_ns, command, risen_bits)
        else:
            if command.msw not in HOLD_OR_RESUME:
                self._forfeit()
            COMMANDS[command.msw](self, now_ns, command)

    def _refuse_several(self, now_ns: int, command: CommandWords, risen_bits: int) -> None:
        """Refuse several command bits that are set together; a running motion reacts to them."""
        self.fire_all(now_ns, faults_of_several(self, command, risen_bits))
        if self.operation is not None:
            self.operation.on_many_bits(now_ns)

    @override
    def refuse_if_unable(
        self, now_ns: int, feature: Feature, command: CommandWords, distance: int = 0
    ) -> bool:
        state = self.state
        if state.configuration is None:
            return False
        request = AxisRequest(feature, command, state.configuration, distance, state.minimum_registration)
        refusal = self.axis.capabilities.lacking_for(request)
        if refusal is not None:
            self.refuse(now_ns, refusal)
        return refusal is not None

    @override
    def noticed(self, command: CommandWords, faults: list[BrokenRule]) -> list[BrokenRule]:
        """Return the faults, and for a move also the broken rules that a 3601 lacks."""
        if not command.msw & MOVES or command.configures:
            return faults
        return faults + [
            BrokenRule(rule)
            for rule, is_broken in self.profile.further_refusals
            if is_broken(command.words, command.parameters)
        ]

    @override
    def refuse(self, now_ns: int, refusal: Refusal) -> None:
        latches = self.state.latches
        self._note_error(latches.show(now_ns, "refusal", refusal.name, refusal.bits, refusal.reason))

    @override
    def fire(self, now_ns: int, rule_id: str, *, alone: bool = False) -> None:
        self._note_error(self.state.latches.fire(now_ns, rule_id, alone=alone))

    @override
    def fire_all(self, now_ns: int, faults: Iterable[BrokenRule]) -> None:
        """Set the bits of all rules that a command breaks (reading A-110).

        A rule that does not add a bit is not reported.
        """
        shown_bits = 0
        for fault in faults:
            bits = fault.all_bits(self.profile)
            if bits & ~shown_bits:
                self.fire(now_ns, fault.rule, alone=fault.alone)
                shown_bits |= bits

    def _note_error(self, bits: int) -> None:
        """Note a command error and end a resumable hold [chapter 4, Resume Move]."""
        if bits & COMMAND_ERROR:
            self.state.error_since_start = True
            self._forfeit()

    def _forfeit(self) -> None:
        """End a resumable hold; Resume must be the first command after a hold [chapter 4; reading A-83]."""
        self.state.held = None
        if self.operation is not None:
            self.operation.on_forfeit()

    @property
    def under_way(self) -> str | None:
        """The kind of the running motion, or None."""
        return None if self.operation is None or self.operation.over else self.operation.name

    # -- motions ------------------------------------------------------------------------------

    @override
    def accept(self, operation: Operation) -> None:
        """Start an operation, and clear the bits that a new move clears."""
        if self.operation is not None:  # a one-shot with its bit still set
            self.operation.on_end(operation.started_ns)
        self.state.latches.clear(CLEARED_BY_A_MOVE)
        self.state.begin_move()
        self.operation = operation

    @override
    def complete(self, now_ns: int) -> None:
        if self.options.complete_after_error or not self.state.error_since_start:
            self.finish(now_ns, MOVE_COMPLETE, "complete")
        else:
            self.finish(now_ns, 0, "ended after a command error")

    @override
    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        """End the running operation, set its completion bit (0 for none), and report the move."""
        operation = self.operation
        assert operation is not None
        self.operation = None
        if completion:
            self.state.latches.complete(completion)
        fields: dict[str, JsonValue] = {
            "from": operation.started_at,
            "to": self.axis.position,
            "started_ns": operation.started_ns,
            "outcome": outcome,
        }
        if operation.cut_ns is not None:
            fields["cut_ns"] = operation.cut_ns
        text = f"{operation.name} move from {operation.started_at}: {outcome} at {self.axis.position}"
        self._events.append(Event(now_ns, "move", operation.name, text, fields))

    @override
    def cut(self, now_ns: int, *, stopped: bool = True) -> None:
        """End a motion without a ramp; Resume can't continue it."""
        self.axis.cut(now_ns)
        self._finish_at_rest(now_ns, STOPPED if stopped else 0, "cut short")

    @override
    def abort_homing(self, now_ns: int, rule_id: str) -> None:
        """End homing at end limits without setting STOPPED [chapter 6, Stopped 4]."""
        self.axis.cut(now_ns)
        self.fire(now_ns, rule_id)
        self._finish_at_rest(now_ns, 0, "found no home")

    def _finish_at_rest(self, now_ns: int, completion: int, outcome: str) -> None:
        """End the running operation now, or when the axis is at rest if its stop takes time."""
        if self.operation is None or isinstance(self.operation, CutShort):
            return
        if self.axis.moving:
            self.operation = CutShort(self, now_ns, self.operation, completion, outcome)
        else:
            self.finish(now_ns, completion, outcome)

    def abandon(self, now_ns: int) -> None:
        """End the running operation without a completion bit; the state of the axis is unknown."""
        if self.operation is not None:
            self.finish(now_ns, 0, "cut short")
