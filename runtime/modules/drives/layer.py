"""The command layer of a drive: modes, rising bits, refusals and latched status.

The unit calls it when its words change, when an input may have changed, and at the exact end of a motion.
A tick does the following, in this order:

1. sample the inputs; 2. obey the words: configuration mode, the enable bit, bits that fell, and the one
command bit that rose; 3. obey the inputs that stop a motion, and the input that starts an armed move; 4. pass
the tick to the running motion, which checks its inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.bits import CommandBit, Modifier, StatusBit
from scanrack.io_images.drives.command import DriveCommand
from scanrack.io_images.drives.configuration import (
    INDEXED,
    broken_rules,
    configuration_of,
    stored_words,
)
from scanrack.io_images.drives.models import WORDS, Layout, Model
from scanrack.io_images.drives.rules import RULES
from scanrack.io_images.number_formats import NumberFormat

from ...kinematics import PICO, stopping_distance
from ...loop.events import Event, JsonValue
from ...machine import EncoderSpec
from ..amci3601.state import HeldMove
from ..amci3601.step_generator import StepGenerator
from .drive_options import DriveOptions
from .motions import (
    STOP_JOG,
    BlendMove,
    DriveEncoderMove,
    DriveMotion,
    DriveRegistrationMove,
    DwellMove,
    HomeSearch,
    Jog,
    Move,
    blend_program,
    profile_of,
)
from .nonvolatile import DriveMemory
from .state import DriveState, StatusLatches

ESTOP = InputBit.ESTOP.value
LIMITS = (InputBit.CW_LIMIT | InputBit.CCW_LIMIT).value
LIMIT_OF = {1: InputBit.CW_LIMIT.value, -1: InputBit.CCW_LIMIT.value}
CAPTURE = InputBit.CAPTURE.value
HOME = InputBit.HOME.value

STOPPED, MOVING_CW, MOVING_CCW = (
    StatusBit.STOPPED.value,
    StatusBit.MOVING_CW.value,
    StatusBit.MOVING_CCW.value,
)
ACCELERATING, DECELERATING = StatusBit.ACCELERATING.value, StatusBit.DECELERATING.value
ASSEMBLED_MODE, WAITING_FOR_SEGMENT = StatusBit.ASSEMBLED_MODE.value, StatusBit.WAITING_FOR_SEGMENT.value
DRIVE_ENABLED, INPUT_1, INPUT_2 = (
    StatusBit.DRIVE_ENABLED.value,
    StatusBit.INPUT_1.value,
    StatusBit.INPUT_2.value,
)

SEGMENTS_MAX = 16
"""Maximum number of segments of an assembled move [17 p. 80]."""

MOVES = (
    CommandBit.ABSOLUTE_MOVE
    | CommandBit.RELATIVE_MOVE
    | CommandBit.RESUME_MOVE
    | CommandBit.FIND_HOME_CW
    | CommandBit.FIND_HOME_CCW
    | CommandBit.JOG_CW
    | CommandBit.JOG_CCW
    | CommandBit.RUN_ASSEMBLED_MOVE
)
SYNCHROSTEP = 1 << 12 | 1 << 14
"""Modifier bits of SynchroStep, which are reserved on a model without SynchroStep."""
RESULTS = StatusBit.HOLD_STATE | StatusBit.AT_HOME | StatusBit.MOVE_COMPLETE
"""Status bits that show the end of a motion."""
RESETTABLE = (
    StatusBit.COMMAND_ERROR
    | StatusBit.INPUT_ERROR
    | StatusBit.INVALID_JOG_CHANGE
    | StatusBit.LIMIT_CONDITION
    | StatusBit.CONNECTION_LOST
    | StatusBit.STALL_DETECTED
)
"""Bits that Reset Errors clears [17 p. 82, p. 84]."""


@dataclass(slots=True)
class AssembledSession:
    """The programming of an assembled move."""

    segments: list[DriveCommand] = field(default_factory=list)
    waiting: bool = True  # for the next segment


class DriveLayer:
    """Rules, modes and memory of one axis of a model.

    Attributes:
        memory: the content of the flash.
        build: the unit's interpretation of its configuration words.
        status: the latched status bits.
        operation: the running motion.
        held: the held move, which Resume continues.
        armed: function that starts the move waiting for its input; called with the instant.
        session: the programming of an assembled move.
        in_configuration: whether the unit is in configuration mode.
        enabled: whether the driver is enabled.
        faulty: whether the driver is too hot.
        frozen: whether the unit has written its flash and ignores all words until a power cycle [SMD p. 72].
        current: motor current in force, 0.1 A.
        jerk: jerk of the last motion.
        command: the output words in force.
        segments: the stored assembled move.
    """

    def __init__(
        self,
        axis: StepGenerator,
        model: Model,
        options: DriveOptions,
        memory: DriveMemory,
        events: list[Event],
        now_ns: int,
    ) -> None:
        self.axis, self.model, self.options, self.memory = axis, model, options, memory
        self.build = options.build
        self.status = StatusLatches()
        self.state = DriveState(self.status)
        self.operation: DriveMotion | None = None
        self.held: HeldMove | None = None
        self.armed: Callable[[int], None] | None = None
        self.session: AssembledSession | None = None
        self.in_configuration = False
        self.enabled = self.faulty = self.frozen = False
        self.current = self.jerk = 0
        self._events = events
        self._levels = 0  # electrical, at the last tick
        self._written: tuple[int, ...] | None = None  # words written in the present configuration mode
        self._mirror: tuple[int, ...] = (0,) * WORDS  # input words of configuration mode
        self.command = DriveCommand((0,) * WORDS, model, self._output_format)
        # those that the host reads and writes by default; after a power cycle they are reported again
        self._reported_formats = (NumberFormat.THOUSANDS, NumberFormat.THOUSANDS) if now_ns == 0 else None
        self.fire(now_ns, "POS-01")
        if memory.configuration is None:
            self.fire(now_ns, "CFG-20")
        else:
            self._adopt(memory.configuration)
        if memory.encoder_offset is not None and axis.counting:
            axis.preset_encoder(axis.machine.encoder_counts(now_ns) + memory.encoder_offset)
        # after `_adopt`, which removes all segments
        self.segments = [DriveCommand(words, model, self._output_format) for words in memory.segments]
        self._note_formats(now_ns)

    # -- present state ------------------------------------------------------------------------

    @property
    def start_sps(self) -> int:
        """Starting speed of the configuration, steps/s."""
        return 1 if self.state.configuration is None else self.state.configuration.starting_speed

    @property
    def busy(self) -> bool:
        """Whether a motion is running."""
        return self.operation is not None and not self.operation.over

    @property
    def _output_format(self) -> NumberFormat:
        """Format of the numbers that the host writes."""
        if self.model.number_format is not None:
            return self.model.number_format
        configuration = self.state.configuration
        return NumberFormat.THOUSANDS if configuration is None else configuration.output_format

    @property
    def input_format(self) -> NumberFormat:
        """Format of the numbers that the host reads."""
        if self.model.number_format is not None:
            return self.model.number_format
        configuration = self.state.configuration
        return NumberFormat.THOUSANDS if configuration is None else configuration.input_format

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the instant of the next tick if no words or inputs change, or None."""
        return None if self.operation is None else self.operation.next_wake_ns(now_ns)

    def report(self, unit_bits: int) -> tuple[int, ...]:
        """Return the ten input words, signed or unsigned.

        Args:
            unit_bits: status bits that the axis does not have.
        """
        if self.in_configuration:
            return self._mirror
        axis = self.axis
        split_number = self.input_format.split
        return (
            *self.model.status_words(int(self.status.bits) | unit_bits | self._present_bits()),
            *split_number(axis.position),
            *split_number(axis.encoder),
            *split_number(self.state.captured),
            self.current,
            self.jerk,
        )

    def _present_bits(self) -> int:
        """Return the status bits that are not latched."""
        motion, session = self.operation, self.session
        bits = self._shown_inputs()
        if motion is None or motion.direction == 0:
            bits |= STOPPED
        else:
            bits |= MOVING_CW if motion.direction > 0 else MOVING_CCW
            ramp = motion.ramp
            if ramp:
                bits |= ACCELERATING if ramp > 0 else DECELERATING
        if session is not None:
            bits |= ASSEMBLED_MODE | WAITING_FOR_SEGMENT if session.waiting else ASSEMBLED_MODE
        return bits | DRIVE_ENABLED if self.enabled else bits

    def _shown_inputs(self) -> int:
        """Return the status bits of the inputs; on the ANF2, these are the active end limits."""
        if self.model.layout is Layout.ANF2:
            cw, ccw = self.state.active & LIMIT_OF[1], self.state.active & LIMIT_OF[-1]
            return (INPUT_1 if cw else 0) | (INPUT_2 if ccw else 0)
        return self.state.shown << 16

    # -- events -------------------------------------------------------------------------------

    def fire(self, now_ns: int, rule_id: str) -> None:
        """Set the bits of a rule, and record the rule."""
        rule = RULES[rule_id]
        self.status.bits |= rule.sets
        fields: dict[str, JsonValue] = {
            "bits": [str(bit.name) for bit in rule.sets],
            "section": rule.section,
        }
        self._events.append(Event(now_ns, "rule", rule_id, rule.text, fields))

    def _note_formats(self, now_ns: int) -> None:
        """Report the number formats if the configuration has changed them."""
        formats = self.input_format, self._output_format
        if formats != self._reported_formats and self.model.number_format is None:
            self._reported_formats = formats
            reads, writes = (number_format.value for number_format in formats)
            text = f"The host reads numbers as {reads}, and writes them as {writes}."
            fields: dict[str, JsonValue] = {"reads": reads, "writes": writes}
            self._events.append(Event(now_ns, "format", "numbers", text, fields))

    # -- the tick -----------------------------------------------------------------------------

    def tick(self, now_ns: int, words: tuple[int, ...], levels: int) -> None:
        """Carry out one tick.

        Args:
            now_ns: the instant; the axis has been advanced to it.
            words: ten output words, unsigned.
            levels: electrical levels of the inputs; bit n is input n + 1.
        """
        self._sample(levels)
        if not self.frozen and words != self.command.words:
            self._obey(now_ns, words)
        if not self.in_configuration:
            self._obey_inputs(now_ns)
        if self.operation is not None and not self.operation.over:
            self.operation.on_tick(now_ns)
        self.settle(now_ns)

    def settle(self, now_ns: int) -> None:
        """End a motion that has made its last step."""
        if self.operation is not None and self.operation.over:
            self.operation.on_end(now_ns)

    def _sample(self, levels: int) -> None:
        """Update the active inputs, their rising edges and the captured value; clear a limit once left."""
        state, configuration = self.state, self.state.configuration
        self._levels = levels
        active_before = state.active
        if configuration is None:
            state.shown, state.active = levels, 0
        else:
            state.shown, state.active = configuration.active(levels)
        state.risen = 0 if self.in_configuration else state.active & ~active_before
        if state.risen & CAPTURE:
            state.captured = self.axis.encoder if self.axis.counting else self.axis.position
        if not state.active & LIMITS:
            self.status.clear(StatusBit.LIMIT_CONDITION)

    # -- words --------------------------------------------------------------------------------

    def _obey(self, now_ns: int, words: tuple[int, ...]) -> None:
        """Obey new words: configuration mode, or the enable bit, fallen bits and the risen command bit."""
        previous = self.command
        if words[0] & CommandBit.MODE_CONFIG:
            self.command = DriveCommand(words, self.model, self._output_format)
            self._configure(now_ns, words, entering=not previous.configures)
            self._enable(now_ns)
            return
        if self.in_configuration:
            self._leave_configuration(now_ns)
        self.command = command = DriveCommand(words, self.model, self._output_format)
        self.state.proximity = bool(command.modifiers & Modifier.BACKPLANE_PROXIMITY)
        self._enable(now_ns)
        self._react_to_fallen_bits(now_ns, previous.bits & ~command.bits)
        if self.operation is not None and not self.operation.over:
            self.operation.on_words(now_ns, command)
        risen_bits = command.bits & ~previous.bits
        unknown_bits = self.model.unknown_commands(words[0]) & ~previous.words[0]
        if unknown_bits:
            self.fire(now_ns, "CMD-17")
        elif risen_bits:
            self._command(now_ns, command, risen_bits)

    def _enable(self, now_ns: int) -> None:
        """Obey the enable bit; without it, the current is off and a motion is cut [interpretation R-33]."""
        command = self.command
        self.enabled = self.state.configuration is not None and command.enables and not self.in_configuration
        if self.busy and not self.enabled:
            self.cut(now_ns, "DRV-02")

    def _react_to_fallen_bits(self, now_ns: int, fallen: CommandBit) -> None:
        """Clear the acknowledge bit, disarm a move or continue the programming when its bit falls."""
        if fallen & (CommandBit.PRESET_POSITION | CommandBit.PRESET_ENCODER | CommandBit.RESET_ERRORS):
            self.status.clear(StatusBit.ACKNOWLEDGE)
        if fallen & MOVES:
            self.armed = None
        if self.session is not None:
            if fallen & CommandBit.READ_ASSEMBLED_DATA:
                self.session.waiting = True
            if fallen & CommandBit.PROGRAM_ASSEMBLED:
                self._end_session(now_ns)

    def _command(self, now_ns: int, command: DriveCommand, risen: CommandBit) -> None:
        """Refuse or carry out the command whose bit has risen."""
        error = bool(self.status.bits & StatusBit.COMMAND_ERROR)
        if risen.bit_count() > 1:
            self.fire(now_ns, "CMD-01")
        elif risen & CommandBit.RESET_ERRORS:
            self.status.clear(RESETTABLE)
            self.status.bits |= StatusBit.ACKNOWLEDGE
        elif risen & CommandBit.IMMEDIATE_STOP and not (error and self.options.error_locks_stop):
            self._stop(now_ns)
        elif self.state.configuration is None:
            self.fire(now_ns, "CMD-09")
        elif command.words[1] & SYNCHROSTEP & command.reserved_modifiers:
            self.fire(now_ns, "CMD-14")
        elif command.reserved_modifiers:
            self.fire(now_ns, "CMD-02")
        elif error and risen & (MOVES | CommandBit.IMMEDIATE_STOP):
            self.fire(now_ns, "CMD-13")
        else:
            HANDLERS[risen](self, now_ns, command)

    def _refuse_if_broken(self, now_ns: int, *rules: tuple[str, bool]) -> bool:
        """Report the first broken rule; return whether a rule is broken.

        Args:
            rules: pairs of a rule's id and whether the rule is broken.
        """
        for rule_id, is_broken in rules:
            if is_broken:
                self.fire(now_ns, rule_id)
                return True
        return False

    # -- configuration mode -------------------------------------------------------------------

    def _configure(self, now_ns: int, words: tuple[int, ...], *, entering: bool) -> None:
        """Store the words of configuration mode; they act when the mode is left."""
        if entering:
            self.in_configuration = True
            self._written = self.armed = self.held = self.session = None
            if self.busy:
                self.cut(now_ns, "CFG-22")
        if words[1] >> self.build.read_back_bit & 1 and self.model.layout is Layout.SMD:
            present = self.state.configuration
            self._mirror = (words[0] & 0x8000, *(0,) * (WORDS - 1)) if present is None else present.words
            return
        self._mirror = self._written = words
        if self.model.leaves_configuration:
            self.in_configuration = True
            self._leave_configuration(now_ns)
            self.in_configuration = self.state.configuration is None

    def _leave_configuration(self, now_ns: int) -> None:
        """Adopt or refuse the words last written; if none were written, nothing changes."""
        self.in_configuration = False
        words, self._written = self._written, None
        if words is None:
            return
        self.status.clear(RESULTS)
        self.fire(now_ns, "CFG-21")
        rules = broken_rules(words, self.model, self.build)
        for rule in rules:
            self.fire(now_ns, rule.id)
        if rules:
            self.state.configuration = None
            self.axis.configure(None)
            self._note_formats(now_ns)
            return
        self._adopt(words)
        self._note_formats(now_ns)
        configuration = self.state.configuration
        if self.model.flash and configuration is not None and configuration.saves:
            self.memory = self.memory.written(configuration=stored_words(words, self.build))

    def _adopt(self, words: tuple[int, ...]) -> None:
        """Adopt a valid configuration; the encoder keeps its count."""
        configuration = configuration_of(words, self.model, self.build)
        self.status.clear(StatusBit.CONFIG_ERROR)
        encoder_count = self.axis.encoder
        self.state.configuration = configuration
        _, self.state.active = configuration.active(self._levels)  # no edge, as on a 3601
        if self.axis.machine.spec.encoder is None and configuration.counts_per_turn:
            ratio = Fraction(configuration.counts_per_turn, configuration.steps_per_turn)
            self.axis.machine.mount(EncoderSpec(ratio))
        self.axis.configure(configuration)
        self.axis.preset_encoder(encoder_count)
        self.current = configuration.current
        self.segments = []

    # -- commands -----------------------------------------------------------------------------

    def _stop(self, now_ns: int) -> None:
        """Cut the motion and end a hold; the rest of the status does not change, as on a 3601."""
        self.held = self.armed = None
        self.status.clear(StatusBit.HOLD_STATE)
        if self.busy:
            self.status.clear(RESULTS)
            self.cut(now_ns, "POS-02")

    def _may_move(self, now_ns: int, *further_rules: tuple[str, bool]) -> bool:
        """Return whether a move may begin; report the first broken rule (see `_refuse_if_broken`)."""
        return not self._refuse_if_broken(
            now_ns,
            ("CMD-04", self.busy),
            ("CMD-08", not self.enabled or self.faulty),
            ("INP-01", bool(self.state.active & ESTOP)),
            *further_rules,
        )

    def _limit_forbids(self, now_ns: int, heading: int, *, jog: bool = False) -> bool:
        """Return whether an active limit forbids a direction, and report it [interpretation R-39]."""
        limits = self.state.active & LIMITS
        only_jogs_leave_limits = self.model.layout is Layout.ANF2
        return self._refuse_if_broken(
            now_ns,
            ("CMD-19", only_jogs_leave_limits and not jog and bool(limits)),
            ("INP-03", bool(limits & LIMIT_OF.get(heading, 0))),
        )

    def _absolute(self, now_ns: int, command: DriveCommand) -> None:
        is_invalid = bool(self.status.bits & StatusBit.POSITION_INVALID)
        self._move(now_ns, command, "absolute", lambda: command.target, ("CMD-05", is_invalid))

    def _relative(self, now_ns: int, command: DriveCommand) -> None:
        """Start or arm a move by the target, from the position or the encoder's count at its start."""
        by_encoder = bool(command.modifiers & Modifier.ENCODER_MOVE)
        distance = command.target
        if distance is None:
            self.fire(now_ns, "CMD-03")
            return

        def target() -> int:
            return distance + (self.axis.encoder if by_encoder else self.axis.position)

        self._move(now_ns, command, "relative", target)

    def _move(
        self,
        now_ns: int,
        command: DriveCommand,
        name: str,
        target: Callable[[], int | None],
        *further_rules: tuple[str, bool],
    ) -> None:
        """Start or arm a move; `target` is called at the start and returns the target."""
        by_encoder = bool(command.modifiers & Modifier.ENCODER_MOVE)
        if not self._may_move(
            now_ns,
            *further_rules,
            ("CMD-12", by_encoder and not self.axis.counting),
            ("CMD-03", not self._ranges_hold(command) or target() is None),
        ):
            return
        profile = profile_of(command, self.start_sps)

        def start(now_ns: int) -> None:
            """Start the move to its target as of now, unless an active limit forbids its direction."""
            target_steps = target()
            assert target_steps is not None
            motion: Move | DriveEncoderMove
            if by_encoder:
                motion = DriveEncoderMove(self, now_ns, target_steps, profile)
                heading = motion.heading
            else:
                motion = Move(self, now_ns, name, target_steps, profile)
                steps_to_go = target_steps - self.axis.position
                heading = 0 if steps_to_go == 0 else 1 if steps_to_go > 0 else -1
            if not self._limit_forbids(now_ns, heading):
                self._begin(command, motion)
                motion.start(now_ns)

        self._start_or_arm(now_ns, command, start)

    def _start_or_arm(self, now_ns: int, command: DriveCommand, start: Callable[[int], None]) -> None:
        """Start a move, or with Indexed Command wait for its input's edge [interpretation R-18]."""
        if command.modifiers & Modifier.INDEXED_COMMAND:
            self.armed = start
            self.status.clear(RESULTS)
        else:
            start(now_ns)

    def _ranges_hold(self, command: DriveCommand) -> bool:
        return command.is_in_range(self.start_sps) and command.current_is_legal

    def _begin(self, command: DriveCommand, motion: DriveMotion) -> None:
        """Start a motion, and adopt the current and jerk of its command."""
        self.held = None
        self.status.clear(RESULTS)
        self.operation = motion
        self._adopt_current_and_jerk(command)

    def _adopt_current_and_jerk(self, command: DriveCommand) -> None:
        """Adopt a command's jerk, and its motor current or else the configured current.

        A registration move keeps the current in force, because that word contains its minimum distance.
        """
        configuration = self.state.configuration
        assert configuration is not None
        if not command.modifiers & Modifier.REGISTRATION_MOVE:
            self.current = command.current if command.selects_current else configuration.current
        self.jerk = command.jerk

    def _hold(self, now_ns: int, command: DriveCommand) -> None:
        if self.operation is not None and not self.operation.over:
            self.operation.on_hold(now_ns)
        elif self.options.hold_at_rest_refused:
            self.fire(now_ns, "CMD-06")

    def _resume(self, now_ns: int, command: DriveCommand) -> None:
        """Continue the held move with the command's speed and rates; refuse it without a held move."""
        held_move = self.held
        rules = ("CMD-07", held_move is None), ("CMD-03", not self._ranges_hold(command))
        if not self._may_move(now_ns, *rules) or held_move is None:
            return
        motion = Move(self, now_ns, held_move.name, held_move.target, profile_of(command, self.start_sps))
        heading = 1 if held_move.target > self.axis.position else -1
        if not self._limit_forbids(now_ns, heading):
            self._begin(command, motion)
            motion.start(now_ns)

    def _home(self, now_ns: int, command: DriveCommand, heading: int) -> None:
        """Start a home search, unless the drive has no home input."""
        configuration = self.state.configuration
        home_missing = configuration is not None and HOME not in configuration.roles
        if self._may_move(now_ns, ("CMD-21", home_missing), ("CMD-03", not self._ranges_hold(command))):
            motion = HomeSearch(self, now_ns, heading, profile_of(command, self.start_sps))
            self._begin(command, motion)
            motion.start(now_ns)

    def _jog(self, now_ns: int, command: DriveCommand, heading: int) -> None:
        """Start a jog or a registration move, or restart a jog that is decelerating."""
        registers = bool(command.modifiers & Modifier.REGISTRATION_MOVE)
        stopping_jog = self._stopping_jog(heading)
        if stopping_jog is not None and not registers and self._ranges_hold(command):
            stopping_jog.change(now_ns, command)  # interpretation R-38
            self._adopt_current_and_jerk(command)
            return
        is_allowed = self._ranges_hold(command) and (not registers or self._distances_hold(command))
        if not self._may_move(now_ns, ("CMD-03", not is_allowed)):
            return
        if self._limit_forbids(now_ns, heading, jog=True):
            return
        if registers and self._refuse_if_broken(
            now_ns,
            ("CMD-15", self._too_short(command)),
            ("CMD-20", bool(self.state.active & STOP_JOG)),
        ):
            return
        motion = (DriveRegistrationMove if registers else Jog)(self, now_ns, heading, command)
        self._begin(command, motion)
        motion.start(now_ns)

    def _stopping_jog(self, heading: int) -> Jog | None:
        """Return the jog that is decelerating in a direction, or None."""
        motion = self.operation
        if not isinstance(motion, Jog) or isinstance(motion, DriveRegistrationMove):
            return None
        decelerates = self.busy and self.enabled and motion.stopping and motion.heading == heading
        return motion if decelerates else None

    @staticmethod
    def _distances_hold(command: DriveCommand) -> bool:
        return command.target is not None and command.target > 0 and command.minimum_distance is not None

    def _too_short(self, command: DriveCommand) -> bool:
        """Return whether the ramp-down of a registration move is longer than its distance."""
        assert command.target is not None
        profile = profile_of(command, self.start_sps)
        ramp = stopping_distance(
            1000 * profile.speed_sps, profile.start_sps, profile.deceleration_spmss, profile.shape
        )
        return command.target * PICO < ramp

    def _preset_position(self, now_ns: int, command: DriveCommand) -> None:
        """Set the position to the target, or with a modifier bit to the encoder's count; end a hold."""
        copies = bool(command.modifiers & Modifier.ENCODER_TO_POSITION)
        value = self.axis.encoder if copies else command.target
        refusals = (
            ("CMD-04", self.busy),
            ("CMD-12", copies and not self.axis.counting),
            ("CMD-03", value is None),
        )
        if self._refuse_if_broken(now_ns, *refusals) or value is None:
            return
        self.axis.preset_position(value)
        self.held = None
        self.status.clear(StatusBit.POSITION_INVALID | StatusBit.HOLD_STATE)
        self.status.bits |= StatusBit.ACKNOWLEDGE

    def _preset_encoder(self, now_ns: int, command: DriveCommand) -> None:
        """Set the encoder's count to the target, and acknowledge; Save to Flash also stores its offset."""
        value = command.target
        refusals = ("CMD-04", self.busy), ("CMD-12", not self.axis.counting), ("CMD-03", value is None)
        if self._refuse_if_broken(now_ns, *refusals) or value is None:
            return
        self.axis.preset_encoder(value)
        self.status.bits |= StatusBit.ACKNOWLEDGE
        if command.modifiers & Modifier.SAVE_TO_FLASH and not command.selects_current:
            encoder_offset = value - self.axis.machine.encoder_counts(now_ns)
            self.memory = self.memory.written(encoder_offset=encoder_offset)

    # -- assembled moves ----------------------------------------------------------------------

    def _program_assembled(self, now_ns: int, command: DriveCommand) -> None:
        if not self._refuse_if_broken(now_ns, ("CMD-04", self.busy)):
            self.session = AssembledSession()

    def _read_segment(self, now_ns: int, command: DriveCommand) -> None:
        """Store a segment; an invalid segment ends the programming with no profile [interpretation R-30]."""
        session = self.session
        if session is None:
            self.fire(now_ns, "CMD-16")
            return
        session.waiting = False
        is_allowed = bool(command.target) and command.is_in_range(self.start_sps)
        if not is_allowed or len(session.segments) == SEGMENTS_MAX:
            self.fire(now_ns, "CMD-11")
            self.session, self.segments = None, []
        else:
            session.segments.append(command)

    def _end_session(self, now_ns: int) -> None:
        """Store the profile; Save to Flash also writes the flash and freezes the unit [SMD p. 72]."""
        session, self.session = self.session, None
        assert session is not None
        self.segments = session.segments
        if self.command.modifiers & Modifier.SAVE_TO_FLASH and self.model.flash:
            self.memory = self.memory.written(segments=tuple(segment.words for segment in self.segments))
            self.frozen = True

    def _run_assembled(self, now_ns: int, command: DriveCommand) -> None:
        """Start or arm the stored segments: with Dwell Move as moves with pauses, otherwise as one blend."""
        if not self._may_move(
            now_ns, ("CMD-10", not self.segments), ("CMD-03", not command.current_is_legal)
        ):
            return
        dwells = bool(command.modifiers & Modifier.DWELL_MOVE)
        segments = list(self.segments)
        blend_heading = -1 if command.modifiers & Modifier.REVERSE_BLEND else 1
        if not dwells and self._refuse_if_broken(now_ns, ("CMD-18", not self._segments_fit(segments))):
            return

        def start(now_ns: int) -> None:
            """Start the motion with the jerk of its last segment, unless an active limit forbids it."""
            motion: BlendMove | DwellMove
            if dwells:
                motion = DwellMove(self, now_ns, segments, pause_ns=1_000_000 * command.words[9])
                heading = 1 if (segments[0].target or 0) > 0 else -1
            else:
                motion, heading = BlendMove(self, now_ns, blend_heading, segments), blend_heading
            if not self._limit_forbids(now_ns, heading):
                self._begin(command, motion)
                self.jerk = segments[-1].jerk
                motion.start(now_ns)

        self._start_or_arm(now_ns, command, start)

    def _segments_fit(self, segments: Sequence[DriveCommand]) -> bool:
        """Return whether each segment of a blend is at least as long as its ramps."""
        try:
            blend_program(segments, self.start_sps)
        except ValueError:
            return False
        return True

    # -- inputs -------------------------------------------------------------------------------

    def _obey_inputs(self, now_ns: int) -> None:
        """Obey emergency stop, end limits and the input of an armed move."""
        risen_bits, motion = self.state.risen, self.operation
        if risen_bits & ESTOP or (self.busy and self.state.active & ESTOP):
            self.fire(now_ns, "INP-01")
            self.held = self.armed = None
            self.status.clear(StatusBit.HOLD_STATE)
            if self.busy:
                self.cut(now_ns, "POS-03")
        elif risen_bits & LIMITS and motion is not None and self.busy and motion.stops_at_limits:
            self.fire(now_ns, "INP-02")
            self.cut(now_ns, "POS-04")
        if risen_bits & INDEXED and self.armed is not None:
            start, self.armed = self.armed, None
            if self._may_move(now_ns):
                start(now_ns)

    # -- the driver and the link --------------------------------------------------------------

    def overheat(self, now_ns: int, faulty: bool) -> None:
        """Begin or end a driver fault; it is shown only while the driver is enabled [17 p. 84]."""
        self.faulty = faulty and self.enabled
        if not self.faulty:
            self.status.clear(StatusBit.DRIVER_FAULT)
        elif not self.status.bits & StatusBit.DRIVER_FAULT:
            self.fire(now_ns, "DRV-01")
            if self.busy:
                self.cut(now_ns, "DRV-04")

    def stall(self, now_ns: int) -> None:
        """Cut a motion because the motor has stalled."""
        if self.busy:
            self.cut(now_ns, "DRV-03")

    def regain_connection(self, now_ns: int) -> None:
        """Obey the enable bit again; a command bit that is still on does not start a command."""
        self._enable(now_ns)

    def lose_connection(self, now_ns: int) -> None:
        """React to a time-out of the controlling connection [interpretation R-22]."""
        if self.options.timeout_stops:
            if self.busy:
                self.cut(now_ns, "POS-06")
            self.enabled = False

    # -- ends ---------------------------------------------------------------------------------

    def cut(self, now_ns: int, rule_id: str) -> None:
        """End the motion without a ramp, and report the rule that requires it."""
        self.axis.cut(now_ns)
        self.fire(now_ns, rule_id)
        if self.operation is not None:
            self.finish(now_ns, 0, "cut short")

    def abort_homing(self, now_ns: int, rule_id: str) -> None:
        """End a home search that end limits have stopped; the 3601's `rule_id` does not apply."""
        self.cut(now_ns, "INP-04")

    def finish(self, now_ns: int, result: int, outcome: str) -> None:
        """End the running motion, set the status bit of its result (0 for none), and report the motion."""
        motion, self.operation = self.operation, None
        assert motion is not None
        self.status.clear(RESULTS)
        self.status.bits |= StatusBit(result)
        fields: dict[str, JsonValue] = {
            "from": motion.started_at,
            "to": self.axis.position,
            "started_ns": motion.started_ns,
            "outcome": outcome,
        }
        text = f"{motion.name} move from {motion.started_at}: {outcome} at {self.axis.position}"
        self._events.append(Event(now_ns, "move", motion.name, text, fields))


HANDLERS: dict[CommandBit, Callable[[DriveLayer, int, DriveCommand], None]] = {
    CommandBit.ABSOLUTE_MOVE: DriveLayer._absolute,
    CommandBit.RELATIVE_MOVE: DriveLayer._relative,
    CommandBit.HOLD_MOVE: DriveLayer._hold,
    CommandBit.RESUME_MOVE: DriveLayer._resume,
    CommandBit.FIND_HOME_CW: lambda layer, now_ns, command: layer._home(now_ns, command, 1),
    CommandBit.FIND_HOME_CCW: lambda layer, now_ns, command: layer._home(now_ns, command, -1),
    CommandBit.JOG_CW: lambda layer, now_ns, command: layer._jog(now_ns, command, 1),
    CommandBit.JOG_CCW: lambda layer, now_ns, command: layer._jog(now_ns, command, -1),
    CommandBit.PRESET_POSITION: DriveLayer._preset_position,
    CommandBit.PROGRAM_ASSEMBLED: DriveLayer._program_assembled,
    CommandBit.READ_ASSEMBLED_DATA: DriveLayer._read_segment,
    CommandBit.RUN_ASSEMBLED_MOVE: DriveLayer._run_assembled,
    CommandBit.PRESET_ENCODER: DriveLayer._preset_encoder,
}
"""The handlers of commands by bit; `_command` handles Reset Errors and Immediate Stop itself."""
