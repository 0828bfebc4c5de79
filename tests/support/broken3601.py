"""Modules with one deliberate mistake each: what a search has to find, or it is not a search.

    for mistake in MISTAKES:
        with mistake.made():
            ...  # every Amci3601 has it now

A mistake replaces one attribute of one class or module of `runtime.modules.amci3601`; its docstring says in a
sentence what is wrong. Each stands for a class of mistakes that people make in firmware and simulators.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from inspect import getattr_static
from typing import Any
from unittest import mock

from scanrack.io_images.amci3601 import CommandMsw, Parameters, parameters
from scanrack.io_images.image import Image
from scanrack.io_images.thousands import split_reported
from scanrack.runtime.kinematics import Shape
from scanrack.runtime.modules.amci3601 import command_words as order
from scanrack.runtime.modules.amci3601 import commands, configuring, module, refusals, report
from scanrack.runtime.modules.amci3601.blend_session import BlendSession
from scanrack.runtime.modules.amci3601.command_layer import CommandLayer
from scanrack.runtime.modules.amci3601.command_words import CommandWords
from scanrack.runtime.modules.amci3601.commands import COMMANDS
from scanrack.runtime.modules.amci3601.inputs import CAPTURE, ESTOP, InputWatch
from scanrack.runtime.modules.amci3601.latches import (
    COMMAND_ERROR,
    CONFIG_ERROR,
    HOLD_STATE,
    INPUT_ERROR,
    MOVE_COMPLETE,
    POSITION_INVALID,
    STOPPED,
    Latches,
)
from scanrack.runtime.modules.amci3601.module import Amci3601
from scanrack.runtime.modules.amci3601.operation import CCW_LIMIT, CW_LIMIT, Limits
from scanrack.runtime.modules.amci3601.operations import blending
from scanrack.runtime.modules.amci3601.operations.blending import BlendRun
from scanrack.runtime.modules.amci3601.operations.encoder_move import EncoderMove
from scanrack.runtime.modules.amci3601.operations.follower import EncoderFollower
from scanrack.runtime.modules.amci3601.operations.homing import Homing
from scanrack.runtime.modules.amci3601.operations.manual_move import ManualMove, OneShot
from scanrack.runtime.modules.amci3601.operations.profile_move import ProfileMove
from scanrack.runtime.modules.amci3601.operations.registration_move import RegistrationMove
from scanrack.runtime.modules.amci3601.state import EXTERNAL, HeldMove, ModuleState
from scanrack.runtime.modules.amci3601.step_generator import StepGenerator

BLEND_ACK = 0x0200


@dataclass(frozen=True)
class Mistake:
    """A mistake that can be made.

    Attributes:
        name: a short name.
        sentence: what is wrong.
        theme: of the scripts that it is looked for with, see `stories3601`.
        owner: class or module of which an attribute is replaced, or dictionary of which an entry is.
        attribute: which.
        wrong: makes what is put there from what is right.
    """

    name: str
    sentence: str
    theme: str
    owner: Any
    attribute: Any
    wrong: Callable[[Any], Any]

    @contextmanager
    def made(self) -> Iterator[None]:
        """Make the mistake, and undo it."""
        if isinstance(self.owner, dict):
            patch: AbstractContextManager[Any] = mock.patch.dict(
                self.owner, {self.attribute: self.wrong(self.owner[self.attribute])}
            )
        else:
            patch = mock.patch.object(
                self.owner, self.attribute, self.wrong(getattr_static(self.owner, self.attribute))
            )
        with patch:
            yield


MISTAKES: list[Mistake] = []


def mistake(owner: Any, attribute: Any, theme: str) -> Callable[[Callable[[Any], Any]], Callable[[Any], Any]]:
    """Add a mistake: the function takes what is right and returns what is wrong."""

    def add(wrong: Callable[[Any], Any]) -> Callable[[Any], Any]:
        assert wrong.__doc__
        MISTAKES.append(Mistake(wrong.__name__, wrong.__doc__, theme, owner, attribute, wrong))
        return wrong

    return add


def judged(check: refusals.Check, instead: refusals.Check) -> Callable[[Any], Any]:
    """Return what lets every refusal that asks one question ask another one."""

    def of(right):
        def wrong(host, given, reasons):
            rows = tuple(
                reason._replace(broken=instead) if reason.broken is check else reason for reason in reasons
            )
            return right(host, given, rows)

        return wrong

    return of


def overlooked(check: refusals.Check) -> Callable[[Any], Any]:
    """Return what lets no refusal ask a question."""
    return judged(check, lambda layer, given: False)


# ---- edges and levels


@mistake(CommandLayer, "_obey_new_words", "moves")
def missing_edge_check(right):
    """A command bit that stays set starts its command anew whenever any word changes."""

    def wrong(self, now_ns, given, previous):
        right(self, now_ns, given, CommandWords((0, *previous.words[1:])))

    return wrong


@mistake(CommandLayer, "_obey_new_words", "moves")
def edge_of_the_whole_word(right):
    """A command is seen only if the command word was zero before, not when its own bit rises."""

    def wrong(self, now_ns, given, previous):
        right(self, now_ns, given, CommandWords((0x7FFF, *previous.words[1:])) if previous.msw else previous)

    return wrong


@mistake(InputWatch, "sample", "states")
def capture_by_level(right):
    """The position is captured as long as the capture input is active, not when it becomes so."""

    def wrong(self, levels):
        right(self, levels)
        if self.state.active & CAPTURE and not self.state.in_configuration_mode:
            self._capture()

    return wrong


@mistake(CommandLayer, "enter_run_mode", "states")
def edge_after_program_mode(right):
    """A command bit that is still set when the PLC returns to run mode counts as a new edge."""

    def wrong(self):
        right(self)
        self.state.command = CommandWords((0, *self.state.command.words[1:]))

    return wrong


@mistake(OneShot, "on_words", "manual")
def one_shot_never_ends(right):
    """A one-shot manual move is not over when its bit is released."""

    def wrong(self, now_ns, given):
        self.released = False

    return wrong


# ---- errors and how they are reset


@mistake(CommandLayer, "_obey", "states")
def error_clears_itself(right):
    """A command error goes off by itself when the command word returns to zero."""

    def wrong(self, now_ns, words):
        right(self, now_ns, words)
        if words[0] == 0 and self.state.latches.causes.get(COMMAND_ERROR):
            self.state.latches.clear(COMMAND_ERROR)

    return wrong


@mistake(ModuleState, "locked", "moves")
def error_does_not_lock(right):
    """With a command error set, the next command is carried out."""
    return property(lambda self: bool(self.latches.bits & 0x0200))


@mistake(commands, "RESETTABLE", "moves")
def reset_makes_the_position_valid(right):
    """Reset Errors clears the position invalid bit, too."""
    return right | POSITION_INVALID


@mistake(commands, "RESETTABLE", "moves")
def reset_keeps_the_input_error(right):
    """Reset Errors leaves the input error set."""
    return right & ~INPUT_ERROR


@mistake(CommandLayer, "_command", "states")
def reset_overlooks_the_lsw(right):
    """Reset Errors is accepted with a command LSW that is not zero."""

    def wrong(self, now_ns, given):
        if self.state.locked and given.msw == 0x0800:
            given = CommandWords((given.words[0], 0, *given.words[2:]))
        right(self, now_ns, given)

    return wrong


@mistake(Latches, "fire", "registration")
def partner_bit_forgotten(right):
    """A rule sets its own bit only: a command error comes without its invalid profile."""

    def wrong(self, now_ns, rule_id, *, alone=False):
        return right(self, now_ns, rule_id, alone=True)

    return wrong


@mistake(CommandLayer, "_command", "states")
def lowest_of_two_bits(right):
    """Of two command bits the lower one is carried out, and nothing is refused."""

    def wrong(self, now_ns, given):
        lowest = given.msw & -given.msw
        right(self, now_ns, CommandWords((lowest, *given.words[1:])))

    return wrong


@mistake(BlendRun, "on_end", "blend")
def hold_in_a_blend_is_not_forgiven(right):
    """The command error of a Hold during a blend move stays when the move is complete."""

    def wrong(self, now_ns):
        self.host.complete(now_ns)

    return wrong


# ---- numbers


@mistake(module, "split_reported", "moves")
def sign_lost_in_the_thousands(right):
    """A negative position is reported with its thousands positive."""

    def wrong(value):
        msw, lsw = split_reported(value)
        return abs(msw), lsw

    return wrong


@mistake(module, "split_reported", "moves")
def floor_division(right):
    """A negative position is split by a division that rounds down: -345 becomes (-1, 655)."""
    return lambda value: divmod(value, 1000)


@mistake(Parameters, "read", "moves")
def sign_lost_in_a_parameter(right):
    """The LSW of a target counts as positive, whatever its sign."""

    def wrong(cls, words):
        return right.__func__(cls, (*words[:3], abs(words[3]), *words[4:]))

    return classmethod(wrong)


@mistake(Parameters, "read", "moves")
def lsw_beyond_999(right):
    """Words whose LSW is above 999 count as a value."""

    def wrong(cls, words):
        made = right.__func__(cls, words)
        target = 1000 * words[2] + words[3] if made.target is None else made.target
        return replace(made, target=target)

    return classmethod(wrong)


@mistake(parameters.Limits, "takes_rate", "manual")
def rate_of_zero(right):
    """An acceleration or deceleration of zero passes as if it were one."""
    return lambda limits, rate: 0 <= rate <= limits.rate


@mistake(refusals, "faults_of", "moves")
def starting_speed_itself(right):
    """A programmed speed equal to the starting speed is refused."""

    def too_slow(layer, given):
        return given.parameters.speed is not None and given.parameters.speed <= layer.state.start_sps

    return judged(refusals.slower_than_start, too_slow)(right)


@mistake(CommandWords, "profile", "moves")
def rates_swapped(right):
    """Acceleration and deceleration are taken for each other."""

    def wrong(self, start_sps):
        made = right(self, start_sps)
        return replace(
            made, acceleration_spmss=made.deceleration_spmss, deceleration_spmss=made.acceleration_spmss
        )

    return wrong


@mistake(order, "shape_of", "moves")
def s_curve_ignored(right):
    """Every ramp has a constant acceleration."""
    return lambda lsw: Shape.CONSTANT


# ---- limits and inputs


@mistake(InputWatch, "_end_limit", "manual")
def limit_ignored_in_one_direction(right):
    """The CCW end limit stops nothing."""

    def wrong(self, now_ns):
        if self.state.active & CW_LIMIT:
            right(self, now_ns)

    return wrong


@mistake(ManualMove, "limits", "manual")
def manual_move_caught(right):
    """A manual move away from an active end limit is stopped, too."""
    return Limits.EITHER


@mistake(ProfileMove, "limits", "moves")
def limit_behind_overlooked(right):
    """A relative move is stopped by the limit ahead only."""
    return Limits.SAME_DIRECTION


@mistake(refusals, "faults_of", "moves")
def start_on_a_limit(right):
    """A move starts although an end limit is active."""
    return overlooked(refusals.any_limit_active)(right)


@mistake(InputWatch, "_emergency_stop", "moves")
def estop_keeps_the_position(right):
    """After an emergency stop of a motion the position is still valid."""

    def wrong(self, now_ns):
        valid = not self.state.latches.bits & POSITION_INVALID
        right(self, now_ns)
        if valid:
            self.state.latches.clear(POSITION_INVALID)

    return wrong


@mistake(InputWatch, "obey", "moves")
def estop_decelerates(right):
    """The emergency stop makes a ramp instead of cutting the steps."""

    def wrong(self, now_ns):
        if self.state.active & ESTOP and self.host.axis.moving:
            self.host.axis.stop(now_ns, 2000, Shape.CONSTANT)
        else:
            right(self, now_ns)

    return wrong


@mistake(InputWatch, "_active", "states")
def active_low_ignored(right):
    """Every input is active when it is energized, whatever the configuration says."""

    def wrong(self, levels):
        configuration = self.state.configuration
        return 0 if configuration is None else levels & configuration.inputs_used

    return wrong


@mistake(InputWatch, "_active", "states")
def unused_input_counts(right):
    """An input that is not configured to be used acts all the same."""

    def wrong(self, levels):
        configuration = self.state.configuration
        if configuration is None:
            return 0
        return right(self, levels) | levels & ~configuration.inputs_used & (EXTERNAL | ESTOP)

    return wrong


@mistake(InputWatch, "_capture", "encoder")
def wrong_value_captured(right):
    """With an encoder the position is captured instead of the encoder value."""

    def wrong(self):
        self.state.captured = self.host.axis.position

    return wrong


@mistake(ProfileMove, "on_external", "moves")
def external_input_ignored(right):
    """The external input does not hold a move."""
    return lambda self, now_ns: None


# ---- moves


@mistake(CommandLayer, "busy", "moves")
def second_move_accepted(right):
    """A move that is started while another one runs replaces it."""
    return property(lambda self: False)


@mistake(refusals, "faults_of", "moves")
def absolute_without_a_position(right):
    """An absolute move starts although the position is not valid."""
    return overlooked(refusals.position_invalid)(right)


@mistake(ProfileMove, "_hold", "moves")
def hold_cuts(right):
    """Hold ends a move without a ramp."""

    def wrong(self, now_ns):
        if not self.holding:
            self.holding = True
            self.axis.cut(now_ns)

    return wrong


@mistake(COMMANDS, CommandMsw.RESUME_MOVE.value, "moves")
def resume_starts_over(right):
    """Resume makes the whole distance again, not the rest of it."""

    def wrong(layer, now_ns, given):
        held = layer.state.held
        if held is not None:
            layer.state.held = HeldMove(held.target + 1000, held.name)
        right(layer, now_ns, given)

    return wrong


@mistake(CommandLayer, "_forfeit", "moves")
def resume_after_a_preset(right):
    """A held move can be resumed though another command came in between."""
    return lambda self: None


@mistake(CommandLayer, "accept", "moves")
def complete_while_moving(right):
    """Move Complete of the last move stays set while the next one runs."""

    def wrong(self, operation):
        complete = self.state.latches.bits & MOVE_COMPLETE
        right(self, operation)
        self.state.latches.bits |= complete

    return wrong


@mistake(COMMANDS, CommandMsw.IMMEDIATE_STOP.value, "moves")
def stop_keeps_the_position(right):
    """After an Immediate Stop of a motion the position is still valid."""

    def wrong(layer, now_ns, given):
        if layer.busy:
            layer.cut(now_ns)

    return wrong


@mistake(CommandLayer, "leave_run_mode", "states")
def motion_outlives_run_mode(right):
    """A move goes on when the PLC leaves run mode."""

    def wrong(self, now_ns):
        self.state.running = False

    return wrong


@mistake(ManualMove, "_change_speed", "manual")
def speed_of_a_manual_move_is_fixed(right):
    """A change of the programmed speed of a running manual move is overlooked."""
    return lambda self, now_ns, given: None


@mistake(OneShot, "start", "manual")
def one_shot_of_ten(right):
    """A one-shot manual move makes ten steps."""

    def wrong(self, now_ns):
        self.axis.pulse(now_ns, self.direction, 10)

    return wrong


@mistake(EncoderMove, "_stop", "encoder")
def encoder_move_never_arrives(right):
    """An encoder move does not look at what the encoder has counted, only at the external input."""

    def wrong(self, now_ns):
        if self.state.external_active:
            right(self, now_ns)

    return wrong


# ---- registration moves


@mistake(RegistrationMove, "_register", "registration")
def minimum_distance_ignored(right):
    """The registration input counts before the minimum distance has been made."""

    def wrong(self, now_ns):
        stored, self.state.minimum_registration = self.state.minimum_registration, 0
        right(self, now_ns)
        self.state.minimum_registration = stored

    return wrong


@mistake(StepGenerator, "register", "registration")
def distance_after_the_ramp(right):
    """A registration move makes a thousand steps more than its target says."""

    def wrong(self, now_ns, steps, deceleration_spmss, shape):
        right(self, now_ns, steps + 1000, deceleration_spmss, shape)

    return wrong


@mistake(RegistrationMove, "on_hold", "registration")
def hold_during_registration(right):
    """Hold stops a registration move without an error."""
    return lambda self, now_ns: self._stop(now_ns)


# ---- homing


@mistake(Homing, "on_end", "homing")
def home_is_not_zero(right):
    """At home the position is made valid, but not zero."""

    def wrong(self, now_ns):
        position = self.axis.position
        right(self, now_ns)
        self.axis.preset_position(position)

    return wrong


@mistake(Homing, "_seek", "homing")
def home_at_full_speed(right):
    """Home is taken where the switch comes on first, at the programmed speed."""

    def wrong(self, now_ns):
        if self._signal:
            self.axis.cut(now_ns)
            self.found = True

    return wrong


@mistake(Homing, "_dwell", "homing")
def no_dwell_at_the_limit(right):
    """Homing turns round at an end limit without waiting for two seconds."""

    def wrong(self, now_ns):
        right(self, now_ns)
        self._dwell_until_ns = now_ns

    return wrong


@mistake(refusals, "faults_of", "homing")
def home_without_a_limit(right):
    """Find Home goes in a direction that has no end limit."""
    return overlooked(refusals.direction_without_limit)(right)


# ---- blend moves and the handshake


@mistake(Amci3601, "update", "blend")
def handshake_a_scan_late(right):
    """The blend acknowledge bit comes one scan late."""

    def wrong(self, now_ns, outputs):
        image = right(self, now_ns, outputs).copy()
        late, self.late_ack = getattr(self, "late_ack", 0), image[1] & BLEND_ACK
        image[1] = image[1] & ~BLEND_ACK | late
        return image

    return wrong


@mistake(BlendSession, "program", "blend")
def missing_block_overlooked(right):
    """A blend profile is stored without its last segment."""

    def wrong(self):
        return blending.BlendProgram(tuple(self.segments), self.final_deceleration, self.final_shape)

    return wrong


@mistake(blending, "SEGMENTS_MIN", "blend")
def profile_of_one_segment(right):
    """A blend profile may have a single segment."""
    return 1


@mistake(BlendRun, "start", "blend")
def blend_in_one_direction(right):
    """A blend move runs clockwise, whichever way it is commanded."""

    def wrong(self, now_ns):
        self.axis.blend(now_ns, 1, self.program)

    return wrong


# ---- encoder follower


@mistake(EncoderFollower, "_divide_by", "follower")
def fraction_lost(right):
    """The follower forgets the fraction of a step at every tick."""

    def wrong(self, divisor):
        right(self, divisor)
        self._owed = 0

    return wrong


@mistake(EncoderFollower, "on_words", "follower")
def follower_in_one_sense(right):
    """The follower goes with the encoder when it should go against it."""

    def wrong(self, now_ns, given):
        right(self, now_ns, given)
        self.sense = abs(self.sense)

    return wrong


@mistake(EncoderFollower, "on_end", "follower")
def follower_ends_silently(right):
    """Leaving the follower mode does not set Stopped."""
    return lambda self, now_ns: self.host.finish(now_ns, 0, "left")


# ---- configuration, versions, images


@mistake(configuring, "_axis_free", "states")
def configured_in_motion(right):
    """Configuration mode is entered while a move runs."""
    return lambda layer, now_ns, previous: True


@mistake(configuring, "leave", "states")
def configuration_keeps_the_position(right):
    """Leaving configuration mode does not zero the position."""

    def wrong(layer, now_ns):
        position = layer.axis.position
        right(layer, now_ns)
        layer.axis.preset_position(position)

    return wrong


@mistake(Latches, "clear", "states")
def configuration_error_for_ever(right):
    """A configuration error stays when a valid configuration is sent after it."""

    def wrong(self, bits):
        after_power_up = self.causes.get(CONFIG_ERROR) == "CER-01"
        right(self, bits if after_power_up else bits & ~CONFIG_ERROR)

    return wrong


@mistake(Amci3601, "power_cycle", "states")
def memory_over_a_power_cycle(right):
    """The configuration survives a power cycle."""
    return lambda self: None


@mistake(refusals, "faults_of", "registration")
def registration_before_its_time(right):
    """Firmware without registration moves takes a manual move with a target for a plain one."""
    return overlooked(refusals.target_given_to_old_firmware)(right)


@mistake(Amci3601, "update", "moves")
def torn_image(right):
    """The position's thousands are of this scan, its units of the scan before."""

    def wrong(self, now_ns, outputs):
        image = right(self, now_ns, outputs).copy()
        late, self.late_units = getattr(self, "late_units", 0), image[3]
        image[3] = late
        return image

    return wrong


@mistake(Amci3601, "update", "states")
def image_a_scan_late(right):
    """The whole input image is the one of the scan before."""

    def wrong(self, now_ns, outputs):
        image = right(self, now_ns, outputs).copy()
        late, self.late_image = getattr(self, "late_image", Image()), image
        return late

    return wrong


@mistake(report, "_status_lsw", "homing")
def echo_while_homing_only(right):
    """The backplane proximity bit is echoed only while the axis homes."""

    def wrong(layer):
        bits = right(layer)
        return bits if isinstance(layer.operation, Homing) else bits & ~report.HOME_PROX_ECHO

    return wrong


@mistake(CommandLayer, "finish", "moves")
def stopped_after_a_hold(right):
    """A held move shows Stopped, too."""

    def wrong(self, now_ns, completion, how):
        right(self, now_ns, completion, how)
        if completion == HOLD_STATE:
            self.state.latches.bits |= STOPPED

    return wrong


@mistake(InputWatch, "_end_limit", "manual")
def limits_taken_for_each_other(right):
    """The CW and the CCW end limit are taken for each other by a motion that one of them stops."""

    def wrong(self, now_ns):
        kept = self.state.active
        swapped = (CCW_LIMIT if kept & CW_LIMIT else 0) | (CW_LIMIT if kept & CCW_LIMIT else 0)
        self.state.active = kept & ~(CW_LIMIT | CCW_LIMIT) | swapped
        right(self, now_ns)
        self.state.active = kept

    return wrong
