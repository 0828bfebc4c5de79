"""Refusals of commands, with the rules that each command can break.

Every broken rule sets its bits [chapter 6, the lists of Status & Error Bit Functions; reading A-110]. Each
row has a rule of the manual and a predicate that is true when the rule is broken. The order (busy axis,
parameter ranges, rules of the command, inputs that block motion) affects only the event log [readings A-16,
A-17].
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from scanrack.io_images.amci3601 import (
    CommandLsw,
    CommandMsw,
    InputBit,
    target_in_range,
)

from ...kinematics import MILLI, PICO, stopping_distance
from .command_words import COMMAND_BITS, S_CURVE, CommandWords
from .latches import POSITION_INVALID, BrokenRule
from .operation import CW_LIMIT, EITHER_LIMIT, Host, limit_in, limit_of

Check = Callable[[Host, CommandWords], bool]


class RefusalRule(NamedTuple):
    """A reason to refuse a command."""

    rule: str  # the rule of the manual; its row of `RULES` has its bits
    broken: Check
    alone: bool = False  # the rule fires without the rows that usually fire together with it

    @property
    def fault(self) -> BrokenRule:
        """The rule as a `BrokenRule`."""
        return BrokenRule(self.rule, self.alone)


Refusals = tuple[RefusalRule, ...]

ESTOP = InputBit.ESTOP.value
FIND_HOME_CW = CommandMsw.FIND_HOME_CW.value
ENCODER_MOVE = CommandLsw.ENCODER_MOVE.value
MANUAL_BITS = (CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW).value
OTHER_THAN_MANUAL = COMMAND_BITS & ~MANUAL_BITS
MANUAL_CW = CommandMsw.MANUAL_CW.value


def busy(host: Host, command: CommandWords) -> bool:
    """Whether the previous move is still running."""
    return host.busy


def external_still_on(host: Host, command: CommandWords) -> bool:
    """Whether the external input that held a move is still on and forbids a new move (A-47)."""
    still_on = host.state.held_by_external and host.state.external_active
    return still_on and not host.options.one_step_under_external


def speed_or_rates_out_of_range(host: Host, command: CommandWords) -> bool:
    """Whether speed, acceleration or deceleration is outside its range."""
    parameters, limits = command.parameters, host.profile.limits
    return not (limits.takes_speed(parameters.speed) and parameters.rates_in_range(limits))


def parameters_out_of_range(host: Host, command: CommandWords) -> bool:
    """Whether target, speed, acceleration or deceleration is outside its range."""
    return not target_in_range(command.parameters.target) or speed_or_rates_out_of_range(host, command)


def slower_than_start(host: Host, command: CommandWords) -> bool:
    """Whether the programmed speed is below the starting speed."""
    return command.parameters.speed is not None and command.parameters.speed < host.state.start_sps


def position_invalid(host: Host, command: CommandWords) -> bool:
    """Whether the current position is not valid."""
    return bool(host.state.latches.bits & POSITION_INVALID)


def estop_active(host: Host, command: CommandWords) -> bool:
    """Whether the emergency stop input is active."""
    return bool(host.state.active & ESTOP)


def any_limit_active(host: Host, command: CommandWords) -> bool:
    """Whether an end limit is active while the axis is at rest, so that no move can begin (A-17).

    A running move handles limits itself. A limit that is also the home switch blocks only its direction.
    """
    if host.busy:
        return False
    if host.axis.capabilities.home_is_ccw_limit and heads_cw(host, command):
        return bool(host.state.active & CW_LIMIT)
    return bool(host.state.active & EITHER_LIMIT)


def heads_cw(host: Host, command: CommandWords) -> bool:
    """Whether an absolute, relative or resumed move runs CW."""
    target = command.parameters.target or 0
    if command.msw & CommandMsw.ABSOLUTE_MOVE.value:
        return target > host.axis.position
    if command.msw & CommandMsw.RESUME_MOVE.value:
        return host.state.held is not None and host.state.held.target > host.axis.position
    return target > 0


def same_limit_active(host: Host, command: CommandWords) -> bool:
    """Whether the end limit in the direction of a manual command is known to be active."""
    return limit_in(host, 1 if command.msw & MANUAL_CW else -1)


def not_held(host: Host, command: CommandWords) -> bool:
    """Whether Resume has no held move to continue."""
    return host.state.held is None


def target_given_to_old_firmware(host: Host, command: CommandWords) -> bool:
    """Whether a manual move has target data although the firmware does not support registration."""
    return not host.firmware.registration and command.target_words != (0, 0)


def manual_parameters_illegal(host: Host, command: CommandWords) -> bool:
    """Whether the speed or target of a manual move is invalid, or the rates that it uses are out of range.

    Speed 0 is a one-shot. Up to the starting speed, the rates are not used (readings A-44, A-81).
    """
    speed = command.parameters.speed
    if speed is None or target_illegal(host, command):
        return True
    if speed != 0 and not host.profile.limits.takes_speed(speed):
        return True
    return speed > host.state.start_sps and speed_or_rates_out_of_range(host, command)


def lsw_not_zero(host: Host, command: CommandWords) -> bool:
    """Whether the command LSW is not zero."""
    return command.lsw != 0


def profile_words_given(host: Host, command: CommandWords) -> bool:
    """Whether words 4 to 7 (speed and rates) are not zero."""
    return any(command.words[4:])


def target_illegal(host: Host, command: CommandWords) -> bool:
    """Whether the target words are invalid or out of range."""
    return not target_in_range(command.parameters.target)


def no_encoder(host: Host, command: CommandWords) -> bool:
    """Whether no quadrature encoder is configured."""
    return host.state.configuration is None or not host.state.configuration.quadrature_encoder


def target_not_zero(host: Host, command: CommandWords) -> bool:
    """Whether the target words are not zero."""
    return command.target_words != (0, 0)


def target_negative(host: Host, command: CommandWords) -> bool:
    """Whether the target is negative; words of opposite signs are not a target."""
    target = command.parameters.target
    return target is not None and target < 0


def too_short_to_stop(host: Host, command: CommandWords) -> bool:
    """Whether a registration distance is shorter than its deceleration; other rules check invalid values."""
    parameters, start_sps = command.parameters, host.state.start_sps
    target, speed, deceleration = parameters.target, parameters.speed, parameters.deceleration
    if target is None or speed is None or not host.profile.limits.takes_rate(deceleration):
        return False
    if speed <= start_sps:
        return False
    return target * PICO < stopping_distance(MILLI * speed, start_sps, deceleration, command.shape)


def external_active(host: Host, command: CommandWords) -> bool:
    """Whether the external input is active."""
    return host.state.external_active


def registration_parameters_illegal(host: Host, command: CommandWords) -> bool:
    """Whether a registration move's words are out of range; speed 0 is invalid."""
    return not command.parameters.speed or manual_parameters_illegal(host, command)


def s_curve_selected(host: Host, command: CommandWords) -> bool:
    """Whether an S-curve is selected."""
    return bool(command.lsw & S_CURVE)


def direction_without_limit(host: Host, command: CommandWords) -> bool:
    """Whether the end limit in the direction of a Find Home is not configured."""
    limit = limit_of(1 if command.msw & FIND_HOME_CW else -1)
    return host.state.configuration is None or not host.state.configuration.inputs_used & limit


def data_given(host: Host, command: CommandWords) -> bool:
    """Whether target, speed or rate words are not zero."""
    return any(command.words[2:])


def not_programmed(host: Host, command: CommandWords) -> bool:
    """Whether no blend profile is stored."""
    return host.state.blend is None


def command_or_rates_given(host: Host, command: CommandWords) -> bool:
    """Whether a command bit is set or words 4 to 7 are not zero."""
    return bool(command.msw) or any(command.words[4:])


def distance_illegal(host: Host, command: CommandWords) -> bool:
    """Whether a minimum registration distance is invalid, negative or out of range."""
    return target_illegal(host, command) or target_negative(host, command)


def several_commands(host: Host, command: CommandWords) -> bool:
    """Whether more than one command bit is set."""
    return command.many_bits


def other_than_manual(host: Host, command: CommandWords) -> bool:
    """Whether a command bit other than the two manual move bits is set."""
    return bool(command.msw & OTHER_THAN_MANUAL)


def ratio_illegal(host: Host, command: CommandWords) -> bool:
    """Whether multiplier or divisor is outside 1 to 32,767."""
    return command.words[2] < 1 or command.words[3] < 1


def speed_words_given(host: Host, command: CommandWords) -> bool:
    """Whether the programmed speed words are not zero."""
    return command.speed_words != (0, 0)


def follower_rates_illegal(host: Host, command: CommandWords) -> bool:
    """Whether a rate of the follower is out of range; 0 means unlimited."""
    return not all(rate == 0 or host.profile.limits.takes_rate(rate) for rate in command.words[6:8])


STILL_HELD = RefusalRule("HLD-11", external_still_on)

PROFILE_START: Refusals = (
    RefusalRule("CMD-03", busy),
    STILL_HELD,
    RefusalRule("CMD-04", parameters_out_of_range),
    RefusalRule("CMD-05", slower_than_start),
)

BLOCKED_BY_INPUTS: Refusals = (
    RefusalRule("INP-01", estop_active),
    RefusalRule("INP-02", any_limit_active),
)

RELATIVE: Refusals = (*PROFILE_START, *BLOCKED_BY_INPUTS)

ABSOLUTE: Refusals = (*PROFILE_START, RefusalRule("CMD-06", position_invalid), *BLOCKED_BY_INPUTS)

ENCODER_ABSOLUTE: Refusals = (
    *PROFILE_START,
    RefusalRule("ENC-05", no_encoder),
    RefusalRule("CMD-06", position_invalid),
    *BLOCKED_BY_INPUTS,
)

ENCODER_RELATIVE: Refusals = (*PROFILE_START, RefusalRule("ENC-05", no_encoder), *BLOCKED_BY_INPUTS)

FIND_HOME: Refusals = (
    RefusalRule("CMD-03", busy),
    RefusalRule("HOM-02", target_not_zero),
    RefusalRule("HOM-03", direction_without_limit),
    RefusalRule("CMD-10", s_curve_selected),
    RefusalRule("HOM-01", slower_than_start),
    RefusalRule("CMD-04", parameters_out_of_range),
    RefusalRule("INP-01", estop_active),
)

REGISTRATION: Refusals = (
    RefusalRule("CMD-03", busy),
    RefusalRule("CMD-24", target_negative),
    RefusalRule("CMD-04", registration_parameters_illegal),
    RefusalRule("CMD-23", too_short_to_stop),
    RefusalRule("CMD-22", external_active),
    RefusalRule("INP-01", estop_active),
    RefusalRule("INP-03", same_limit_active),
)

STORE_MINIMUM: Refusals = (
    RefusalRule("REG-10", command_or_rates_given),
    RefusalRule("REG-10", busy),
    RefusalRule("CMD-20", distance_illegal),
)

RUN_BLEND: Refusals = (
    RefusalRule("CMD-03", busy),
    RefusalRule("IOM-20", lsw_not_zero),
    RefusalRule("CMD-17", data_given),
    RefusalRule("CMD-16", not_programmed),
    *BLOCKED_BY_INPUTS,
)

RESUME: Refusals = (
    RefusalRule("CMD-08", not_held),
    STILL_HELD,
    RefusalRule("CMD-04", speed_or_rates_out_of_range),
    RefusalRule("CMD-05", slower_than_start),
    *BLOCKED_BY_INPUTS,
)

MANUAL: Refusals = (
    RefusalRule("CMD-03", busy),
    STILL_HELD,
    RefusalRule("CMD-12", target_given_to_old_firmware),
    RefusalRule("CMD-04", manual_parameters_illegal),
    RefusalRule("INP-01", estop_active),
    RefusalRule("INP-03", same_limit_active),
)

PRESET_POSITION: Refusals = (
    RefusalRule("PST-01", busy),
    RefusalRule("PST-08", lsw_not_zero),
    RefusalRule("CMD-09", profile_words_given),
    RefusalRule("CMD-04", target_illegal, alone=True),
)

PRESET_ENCODER: Refusals = (
    RefusalRule("PST-06", busy),
    RefusalRule("PST-08", lsw_not_zero),
    RefusalRule("CMD-11", no_encoder),
    RefusalRule("CMD-09", profile_words_given),
    RefusalRule("CMD-04", target_illegal, alone=True),
)

RESET_ERRORS: Refusals = (RefusalRule("RST-02", lsw_not_zero),)

FOLLOWER_WORDS: Refusals = (
    RefusalRule("CMD-29", no_encoder),
    RefusalRule("CMD-34", other_than_manual),
    RefusalRule("CMD-02", several_commands),
    RefusalRule("CMD-31", ratio_illegal),
    RefusalRule("CMD-32", speed_words_given),
    RefusalRule("CMD-36", s_curve_selected),
    RefusalRule("FOL-02", follower_rates_illegal),  # the manual states no outcome
)
"""Checks while encoder follower mode is on."""

FOLLOWER: Refusals = (RefusalRule("CMD-30", busy), *FOLLOWER_WORDS, *BLOCKED_BY_INPUTS)

_OF_BIT: dict[int, Refusals] = {
    CommandMsw.RESUME_MOVE.value: RESUME,
    CommandMsw.FIND_HOME_CW.value: FIND_HOME,
    CommandMsw.FIND_HOME_CCW.value: FIND_HOME,
    CommandMsw.PRESET_POSITION.value: PRESET_POSITION,
    CommandMsw.PRESET_ENCODER.value: PRESET_ENCODER,
    CommandMsw.RESET_ERRORS.value: RESET_ERRORS,
    CommandMsw.RUN_BLEND_CW.value: RUN_BLEND,
    CommandMsw.RUN_BLEND_CCW.value: RUN_BLEND,
}
"""Rules of the commands with fixed rules; Hold and Immediate Stop have no rules."""


def refuse_if_broken(host: Host, now_ns: int, command: CommandWords, reasons: Refusals | None = None) -> bool:
    """Fire every broken rule; return whether a rule is broken.

    Args:
        reasons: the rules to check, by default the rules of the single command bit.
    """
    faults = faults_of(host, command, refusals_of(host, command) if reasons is None else reasons)
    host.fire_all(now_ns, faults)
    return bool(faults)


def faults_of(host: Host, command: CommandWords, reasons: Refusals) -> list[BrokenRule]:
    """Return the broken rules that the module notices."""
    return host.noticed(command, [reason.fault for reason in reasons if reason.broken(host, command)])


def faults_of_several(host: Host, command: CommandWords, risen_bits: int) -> list[BrokenRule]:
    """Return the faults of several command bits: CMD-02, and the faults of each new command (A-110)."""
    faults = [BrokenRule("CMD-02")]
    for index in range(risen_bits.bit_length()):
        bit = 1 << index
        if risen_bits & bit:
            single_command = command.single(bit)
            faults += faults_of(host, single_command, refusals_of(host, single_command))
    return faults


def refusals_of(host: Host, command: CommandWords) -> Refusals:
    """Return the rules that words with a single command bit can break."""
    if command.msw & CommandMsw.ABSOLUTE_MOVE.value:
        return ENCODER_ABSOLUTE if command.lsw & ENCODER_MOVE else ABSOLUTE
    if command.msw & CommandMsw.RELATIVE_MOVE.value:
        return ENCODER_RELATIVE if command.lsw & ENCODER_MOVE else RELATIVE
    if command.msw & MANUAL_BITS:
        return REGISTRATION if registers(host, command) else MANUAL
    return _OF_BIT.get(command.msw, ())


def registers(host: Host, command: CommandWords) -> bool:
    """Return whether a manual move is a registration move: it has a target, and the firmware supports it."""
    return host.firmware.registration and target_not_zero(host, command)
