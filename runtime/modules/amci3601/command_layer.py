"""The 3601's command layer: modes, edges, refusals, latched errors.

It is called at the ticks of the module's own 250 µs scan at which anything
relevant may have changed, with the words in force and the inputs as sampled,
and once more at the exact instant at which a motion ends. A tick does, in this
order [chapters 3 to 6]:

1. take over the sampled inputs, capture on an inactive-to-active transition;
2. unless the PLC is out of run mode, obey the output words: mode bit first,
   then errors that lock the module, follower and blend bits, the command whose
   bit has risen, and what the running operation makes of the new words;
3. look at the inputs that stop motion: emergency stop, end limits, external;
4. let the running operation look at what it checks by level.

What each motion makes of Hold, limits and the external input is written in
the operations; why a command is refused in `refusals`; what a bit does in
`commands`; configuration mode in `configuring`.
"""

from __future__ import annotations

from collections.abc import Iterable

from ....io_images.amci3601 import ALL_INPUTS, CommandLsw, CommandMsw, Configuration, Firmware, InputBit
from ...loop.events import Event, JsonValue
from . import configuring, refusals
from .axis import Axis, BlendProgram
from .blending import BlendProgramming, obey_programming
from .capabilities import Feature, Refusal, Request
from .command_words import COMMAND_BITS, CommandWords
from .commands import COMMANDS, obey_store_minimum
from .follower import EncoderFollower, obey_follower
from .latches import (
    CLEARED_BY_A_MOVE,
    COMMAND_ERROR,
    INVALID_PROFILE,
    MODE_CONFIG,
    MOVE_COMPLETE,
    POSITION_INVALID,
    STOPPED,
    Fault,
    Latches,
)
from .operation import CCW_LIMIT, CW_LIMIT, EITHER_LIMIT, Limits, Operation, limit_in
from .options import Amci3601Options
from .profile_move import Held

CAPTURE = InputBit.CAPTURE.value
EXTERNAL = InputBit.EXTERNAL.value
ESTOP = InputBit.ESTOP.value
PROXIMITY = CommandLsw.HOME_PROXIMITY.value
RESET = CommandMsw.RESET_ERRORS.value
HOLD_OR_STOP = (CommandMsw.HOLD_MOVE | CommandMsw.IMMEDIATE_STOP).value
HOLD_OR_RESUME = (CommandMsw.HOLD_MOVE.value, CommandMsw.RESUME_MOVE.value)

NO_ORDER = CommandWords((0,) * 8)


class CommandLayer:
    """Rules, modes and memory of a 3601 over any axis.

    Attributes:
        configuration: the accepted configuration; None before there is one.
        operation: the motion that runs.
        held: what Resume would go on with.
        blend: the stored blend profile.
        minimum_registration: steps that a registration move makes before its input counts.
        active: inputs that are active, as a mask of `InputBit`; `risen` those that became so,
            `reported_inputs` those that are shown.
        captured: the captured value.
        order: the output words acted on last.

    Args:
        axis: what makes the steps.
        firmware: which revision of the module this is; it decides what exists.
        options: switches of the model.
        events: where rules that fire and moves that end are written down.
        now_ns: the instant of power-up.
    """

    def __init__(
        self, axis: Axis, firmware: Firmware, options: Amci3601Options, events: list[Event], now_ns: int = 0
    ) -> None:
        self.axis = axis
        self.firmware = firmware
        self.options = options
        self.latches = Latches(events)
        self.configuration: Configuration | None = None
        self.mirror: tuple[int, ...] = (0, 0, 0, 0)
        self.operation: Operation | None = None
        self.held: Held | None = None
        self.blend: BlendProgram | None = None
        self.blending: BlendProgramming | None = None
        self.minimum_registration = 0
        self.active = 0
        self.risen = 0
        self.captured = 0
        self.running = True
        self.error_since_start = False
        self.held_by_external = False
        self.reported_inputs = 0
        self._events = events
        self.order = NO_ORDER
        self.latches.fire(now_ns, "CER-01")
        self.latches.bits |= POSITION_INVALID  # nothing has made it valid yet (reading A-04)

    # -- what it is doing ---------------------------------------------------------------------

    @property
    def start_sps(self) -> int:
        """Starting speed of the accepted configuration."""
        return 1 if self.configuration is None else self.configuration.starting_speed

    @property
    def busy(self) -> bool:
        """Whether a move is under way that a new one has to wait for."""
        return self.operation is not None and self.operation.busy

    @property
    def in_configuration_mode(self) -> bool:
        """Whether the module is in configuration mode."""
        return bool(self.latches.bits & MODE_CONFIG)

    @property
    def locked(self) -> bool:
        """Whether only Reset Errors is accepted [chapter 6, bit 12; chapter 5, blend routine 2]."""
        return bool(self.latches.bits & (COMMAND_ERROR | INVALID_PROFILE))

    @property
    def external_active(self) -> bool:
        """Whether the external input is active."""
        return bool(self.active & EXTERNAL)

    @property
    def proximity(self) -> bool:
        """Whether the backplane home proximity bit is set; in a configuration word it is another bit."""
        return bool(self.order.lsw & PROXIMITY) and not self.order.configures

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return when a tick is wanted though neither words nor inputs change; None = it is not."""
        if self.operation is not None:
            return self.operation.next_wake_ns(now_ns)
        waiting = self.order.configures and not self.in_configuration_mode
        return now_ns + 1 if waiting and self.running else None

    # -- the tick -----------------------------------------------------------------------------

    def tick(self, now_ns: int, words: tuple[int, ...], levels: int) -> None:
        """Do one tick of the module's own scan.

        Args:
            now_ns: the instant; the axis has been advanced to it.
            words: the eight output words in force.
            levels: electrical levels of the discrete inputs, as a mask of `InputBit`.
        """
        self._sample(levels)
        if self.running:
            self._obey(now_ns, words)
        if not self.in_configuration_mode:
            self._watch_inputs(now_ns)
        if self.operation is not None and not self.operation.over:
            self.operation.on_tick(now_ns, self.order)
        self.settle(now_ns)

    def wants_counts(self, *, turning: bool) -> bool:
        """Return whether counts of the scan that begins now are to be acted on at its end."""
        operation = self.operation
        return operation is not None and not operation.over and operation.wants_counts(turning=turning)

    def counted(self, now_ns: int) -> None:
        """The scan ends to which `wants_counts` said yes; no new word or input has been looked at."""
        if self.operation is not None and not self.operation.over:
            self.operation.on_counts(now_ns, self.order)
        self.settle(now_ns)

    def settle(self, now_ns: int) -> None:
        """Let an operation that has come to its end say so."""
        if self.operation is not None and self.operation.over:
            self.operation.on_end(now_ns)

    def leave_run_mode(self, now_ns: int) -> None:
        """The PLC has left run mode: any motion stops, the position becomes invalid [chapter 5 note 9]."""
        self.running = False
        if self.busy:
            bits = POSITION_INVALID if self.options.invalid_after_program_mode else 0
            self.latches.fire(now_ns, "PRG-01", bits=bits)
            self.cut(now_ns, stopped=self.options.stopped_after_program_mode)
        elif self.operation is not None:
            self.operation.on_release(now_ns)

    def enter_run_mode(self) -> None:
        """The PLC is back in run mode; a bit that is still set is no new edge (reading A-78)."""
        self.running = True

    def overlook(self, words: tuple[int, ...]) -> None:
        """Take note of words without acting on them: what is set in them makes no edge later."""
        self.order = CommandWords(words)

    # -- inputs -------------------------------------------------------------------------------

    def _sample(self, levels: int) -> None:
        before, self.active = self.active, self._active(levels)
        self.reported_inputs = self.active
        if self.configuration is not None and self.options.report_unused_inputs:
            self.reported_inputs |= levels & ALL_INPUTS & ~self.configuration.inputs_used
        # an input that is active when it is configured has made no transition (reading A-69)
        self.risen = 0 if self.in_configuration_mode else self.active & ~before
        if self.risen & CAPTURE:
            self._capture()

    def _active(self, levels: int) -> int:
        """Return which inputs are active; unused ones are not (reading A-13)."""
        if self.configuration is None:
            return 0
        return ~(levels ^ self.configuration.active_high) & self.configuration.inputs_used

    def _capture(self) -> None:
        """Keep the encoder value, or without an encoder the position [chapter 3, MSW bit 0]."""
        with_encoder = self.configuration is not None and self.configuration.quadrature_encoder
        self.captured = self.axis.encoder if with_encoder else self.axis.position

    def _watch_inputs(self, now_ns: int) -> None:
        if self.active & ESTOP:
            self._emergency_stop(now_ns)
        elif self.active & EITHER_LIMIT:
            self._end_limit(now_ns)
        if self.external_active and self.operation is not None and not self.operation.over:
            self.operation.on_external(now_ns)

    def _emergency_stop(self, now_ns: int) -> None:
        """The emergency stop input is active [chapter 6, Emergency Stop Input; reading A-15]."""
        if self.busy:
            self.latches.fire(now_ns, "INP-01")
            self.latches.fire(now_ns, "POS-03", alone=True)
            self.cut(now_ns)
        elif self.risen & ESTOP:
            self.latches.fire(now_ns, "INP-01")
            self.held = None

    def _end_limit(self, now_ns: int) -> None:
        """An end limit is active [chapter 4, general note 4]."""
        if self.risen & EITHER_LIMIT:
            self.held = None
        operation = self.operation
        if operation is None or operation.over or operation.limits is Limits.OWN or self._leaves_home():
            return
        if operation.limits is Limits.EITHER or limit_in(self, self.axis.direction):
            self.latches.fire(now_ns, "INP-02")
            self.latches.fire(now_ns, "POS-04", alone=True)
            self.cut(now_ns)

    def _leaves_home(self) -> bool:
        """Whether the only limit active is the home switch, and is being left as it was at the start."""
        return (
            self.axis.capabilities.home_is_ccw_limit
            and self.axis.direction > 0
            and not self.active & CW_LIMIT
            and not self.risen & CCW_LIMIT
        )

    # -- output words -------------------------------------------------------------------------

    def _obey(self, now_ns: int, words: tuple[int, ...]) -> None:
        previous = self.order
        self.order = order = previous if previous.words == words else CommandWords(words)
        if order.configures:
            configuring.obey_mode_bit(self, now_ns, order, previous)
            return
        if self.in_configuration_mode:
            configuring.leave(self, now_ns)
        if self.configuration is None:
            return  # no operation before a valid configuration [chapter 3; reading A-05]
        if order is not previous:
            self._obey_new_words(now_ns, order, previous)

    def _obey_new_words(self, now_ns: int, order: CommandWords, previous: CommandWords) -> None:
        edges = order.msw & ~previous.msw & COMMAND_BITS
        following = False
        if not self._stops(order, edges):
            following = obey_follower(self, now_ns, order, previous)
            reads = not following and not isinstance(self.operation, EncoderFollower)
            obey_programming(self, now_ns, order, previous, reads=reads)
            if reads:
                obey_store_minimum(self, now_ns, order, previous)
        elif self.blending is not None:  # what has begun goes on
            obey_programming(self, now_ns, order, previous)
        if edges and not following:
            self._command(now_ns, order, edges)
        if self.operation is not None and not self.operation.over:
            self.operation.on_order(now_ns, order)

    def _stops(self, order: CommandWords, edges: int) -> bool:
        """Whether this holds or stops a motion, which no bit of the LSW prevents (reading A-30).

        In follower mode there is nothing that either could stop [chapter 6, Command Error 34].
        """
        stop = edges & HOLD_OR_STOP
        return (
            bool(stop) and order.msw == stop and self.busy and not isinstance(self.operation, EncoderFollower)
        )

    def _command(self, now_ns: int, order: CommandWords, edges: int) -> None:
        """A command bit has risen: refuse or carry it out [chapter 4, general notes 1 to 3]."""
        if self.locked:
            if order.msw == RESET and order.lsw == 0:
                self._forfeit()
                COMMANDS[RESET](self, now_ns, order)
        elif order.many_bits:
            self._refuse_several(now_ns, order, edges)
        else:
            if order.msw not in HOLD_OR_RESUME:
                self._forfeit()
            COMMANDS[order.msw](self, now_ns, order)

    def _refuse_several(self, now_ns: int, order: CommandWords, edges: int) -> None:
        """Several command bits are set: that, and what each new command breaks by itself (A-110)."""
        faults = [Fault("CMD-02")]
        for bit in (1 << at for at in range(edges.bit_length()) if edges >> at & 1):
            single = order.single(bit)
            faults += self._faults(single, refusals.refusals_of(self, single))
        self.fire_all(now_ns, faults)
        if self.operation is not None:
            self.operation.on_many_bits(now_ns)

    def refused(self, now_ns: int, order: CommandWords, reasons: refusals.Refusals | None = None) -> bool:
        """Fire every broken rule, and return whether there is one.

        Args:
            now_ns: the instant.
            order: the words.
            reasons: the rules to look at; None = those of the order's single command bit.
        """
        faults = self._faults(order, refusals.refusals_of(self, order) if reasons is None else reasons)
        self.fire_all(now_ns, faults)
        return bool(faults)

    def _faults(self, order: CommandWords, reasons: refusals.Refusals) -> list[Fault]:
        return [reason.fault for reason in reasons if reason.broken(self, order)]

    def unable(self, now_ns: int, feature: Feature, order: CommandWords, distance: int = 0) -> bool:
        """Refuse what the axis can't do, and return True; to be asked after the manual's own rules."""
        if self.configuration is None:
            return False
        request = Request(feature, order, self.configuration, distance, self.minimum_registration)
        refusal = self.axis.capabilities.lacking_for(request)
        if refusal is not None:
            self.refuse(now_ns, refusal)
        return refusal is not None

    def refuse(self, now_ns: int, refusal: Refusal) -> None:
        """Show what the axis can't do."""
        shown = self.latches.show(now_ns, "refusal", refusal.name, refusal.bits, refusal.reason)
        self._suffer(shown)

    def fire(self, now_ns: int, rule_id: str, *, bits: int | None = None, alone: bool = False) -> None:
        """Let a rule set its bits."""
        self._suffer(self.latches.fire(now_ns, rule_id, bits=bits, alone=alone))

    def fire_all(self, now_ns: int, faults: Iterable[Fault]) -> None:
        """Let all rules that one command breaks set their bits (reading A-110).

        The event log names a rule for each bit: one that adds no bit to those before it is left out.
        """
        shown = 0
        for fault in faults:
            if fault.all_bits & ~shown:
                self.fire(now_ns, fault.rule, bits=fault.bits, alone=fault.alone)
                shown |= fault.all_bits

    def _suffer(self, bits: int) -> None:
        """A command error ends a resumable hold [chapter 4, Resume Move]."""
        if bits & COMMAND_ERROR:
            self.error_since_start = True
            self._forfeit()

    def _forfeit(self) -> None:
        """Resume has to be the first command after a hold, without an error [chapter 4; reading A-83]."""
        self.held = None
        if self.operation is not None:
            self.operation.on_forfeit()

    @property
    def under_way(self) -> str | None:
        """The kind of the motion that runs, None while there is none."""
        return None if self.operation is None or self.operation.over else self.operation.name

    # -- motions ------------------------------------------------------------------------------

    def accept(self, operation: Operation) -> None:
        """Make `operation` the one that runs; its start clears what the next move clears."""
        if self.operation is not None:  # a one-shot whose bit is only now released: its step is made
            self.operation.on_end(operation.started_ns)
        self.latches.clear(CLEARED_BY_A_MOVE)
        self.held = None
        self.operation = operation
        self.error_since_start = False
        self.held_by_external = False

    def complete(self, now_ns: int) -> None:
        """End the running operation successfully, unless an error arose meanwhile (reading A-27)."""
        if self.options.complete_after_error or not self.error_since_start:
            self.finish(now_ns, MOVE_COMPLETE, "complete")
        else:
            self.finish(now_ns, 0, "ended after a command error")

    def finish(self, now_ns: int, completion: int, how: str) -> None:
        """End the running operation with a completion bit (or 0) and write the move down."""
        operation = self.operation
        assert operation is not None
        self.operation = None
        if completion:
            self.latches.complete(completion)
        fields: dict[str, JsonValue] = {
            "from": operation.started_at,
            "to": self.axis.position,
            "started_ns": operation.started_ns,
            "outcome": how,
        }
        text = f"{operation.name} move from {operation.started_at}: {how} at {self.axis.position}"
        self._events.append(Event(now_ns, "move", operation.name, text, fields))

    def cut(self, now_ns: int, *, stopped: bool = True) -> None:
        """End any motion without a ramp; what is left of a move is lost."""
        self.axis.cut(now_ns)
        if self.operation is not None:
            self.finish(now_ns, STOPPED if stopped else 0, "cut short")

    def abort_homing(self, now_ns: int, rule_id: str) -> None:
        """End limits have ended a search for home; STOPPED is not for homing [chapter 6, Stopped 4]."""
        self.axis.cut(now_ns)
        self.fire(now_ns, rule_id)
        self.finish(now_ns, 0, "found no home")
