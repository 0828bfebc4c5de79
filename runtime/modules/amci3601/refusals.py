"""Why a command is refused: for each, the rules that it can break.

Every broken rule sets its bits; no row hides another [chapter 6, the lists of
Status & Error Bit Functions; reading A-110]. Each row names the rule of the
manual and the predicate that is true when the rule is broken. The order is
that of the event log only: the axis is busy, then parameter ranges, then what
is special to the command, last the inputs that block motion [readings A-16,
A-17].
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ....io_images.amci3601 import (
    CommandLsw,
    CommandMsw,
    InputBit,
    rate_in_range,
    speed_in_range,
    target_in_range,
)
from ...kinematics import MILLI, PICO, stopping_distance
from .command_words import COMMAND_BITS, S_CURVE, CommandWords
from .latches import COMMAND_ERROR, POSITION_INVALID, Fault
from .operation import CW_LIMIT, EITHER_LIMIT, limit_in, limit_of

if TYPE_CHECKING:
    from .command_layer import CommandLayer

Check = Callable[["CommandLayer", CommandWords], bool]


class RefusalRule(NamedTuple):
    """One reason to refuse a command.

    Attributes:
        rule: the rule of the manual that is broken.
        broken: tells whether it is.
        bits: what is set, where the manual names the rule but not its consequence.
        alone: the rule fires without the rows that usually share its cause.
    """

    rule: str
    broken: Check
    bits: int | None = None
    alone: bool = False

    @property
    def fault(self) -> Fault:
        """What fires if it is broken."""
        return Fault(self.rule, self.bits, self.alone)


Refusals = tuple[RefusalRule, ...]

ESTOP = InputBit.ESTOP.value
FIND_HOME_CW = CommandMsw.FIND_HOME_CW.value
ENCODER_MOVE = CommandLsw.ENCODER_MOVE.value
MANUAL_BITS = (CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW).value
OTHER_THAN_MANUAL = COMMAND_BITS & ~MANUAL_BITS
MANUAL_CW = CommandMsw.MANUAL_CW.value


def busy(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the previous move is still under way."""
    return layer.busy


def external_still_on(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the external input that has held a move is still on, and that forbids a new one (A-47)."""
    return layer.held_by_external and layer.external_active and not layer.options.one_step_under_external


def speed_or_rates_out_of_range(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether speed, acceleration or deceleration is outside its range."""
    given = order.parameters
    return not (
        speed_in_range(given.speed)
        and rate_in_range(given.acceleration)
        and rate_in_range(given.deceleration)
    )


def parameters_out_of_range(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether target, speed, acceleration or deceleration is outside its range."""
    return not target_in_range(order.parameters.target) or speed_or_rates_out_of_range(layer, order)


def slower_than_start(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the programmed speed is below the starting speed."""
    return order.parameters.speed is not None and order.parameters.speed < layer.start_sps


def position_invalid(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the current position is not valid."""
    return bool(layer.latches.bits & POSITION_INVALID)


def estop_active(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the emergency stop input is active."""
    return bool(layer.active & ESTOP)


def any_limit_active(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether either end limit is active while the axis is at rest, so that no move can begin (A-17).

    What limits do to a move under way is that move's matter. A limit that is also the home switch
    counts only where it is in the way.
    """
    if layer.busy:
        return False
    if layer.axis.capabilities.home_is_ccw_limit and heads_cw(layer, order):
        return bool(layer.active & CW_LIMIT)
    return bool(layer.active & EITHER_LIMIT)


def heads_cw(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether an absolute or relative move, or a resumed one, goes CW."""
    target = order.parameters.target or 0
    if order.msw & CommandMsw.ABSOLUTE_MOVE.value:
        return target > layer.axis.position
    if order.msw & CommandMsw.RESUME_MOVE.value:
        return layer.held is not None and layer.held.target > layer.axis.position
    return target > 0


def same_limit_active(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the end limit in the direction of a manual command is active, as far as that is known."""
    return limit_in(layer, 1 if order.msw & MANUAL_CW else -1)


def not_held(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether there is nothing that Resume could go on with."""
    return layer.held is None


def target_given_to_old_firmware(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a manual move carries target data that this firmware has no use for."""
    return not layer.firmware.registration and order.target_words != (0, 0)


def manual_parameters_illegal(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a manual speed is no value, or rates that will be used are out of range.

    Speed 0 is a one-shot; up to the starting speed the rates are not looked at
    (readings A-44, A-81).
    """
    speed = order.parameters.speed
    if (
        speed is None
        or not (speed == 0 or speed_in_range(speed))
        or not target_in_range(order.parameters.target)
    ):
        return True
    return speed > layer.start_sps and speed_or_rates_out_of_range(layer, order)


def lsw_not_zero(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the command LSW is not zero."""
    return order.lsw != 0


def profile_words_given(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether speed, acceleration or deceleration words carry data."""
    return any(order.words[4:])


def target_illegal(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the target words are no value or out of range."""
    return not target_in_range(order.parameters.target)


def no_encoder(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether no quadrature encoder is configured."""
    return layer.configuration is None or not layer.configuration.quadrature_encoder


def target_not_zero(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the target words carry data."""
    return order.target_words != (0, 0)


def target_negative(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the target is negative; words of opposite signs are no value at all."""
    target = order.parameters.target
    return target is not None and target < 0


def too_short_to_stop(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a registration distance is less than the deceleration needs, as far as both are values."""
    target, speed, deceleration = (
        order.parameters.target,
        order.parameters.speed,
        order.parameters.deceleration,
    )
    if target is None or speed is None or speed <= layer.start_sps or not rate_in_range(deceleration):
        return False
    return target * PICO < stopping_distance(MILLI * speed, layer.start_sps, deceleration, order.shape)


def external_active(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the external input is active."""
    return layer.external_active


def registration_parameters_illegal(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a registration move's words are out of range; it has no one-shot."""
    return not order.parameters.speed or manual_parameters_illegal(layer, order)


def s_curve_selected(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether an S-curve is selected."""
    return bool(order.lsw & S_CURVE)


def direction_without_limit(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the end limit in the direction of a Find Home is not configured."""
    limit = limit_of(1 if order.msw & FIND_HOME_CW else -1)
    return layer.configuration is None or not layer.configuration.inputs_used & limit


def data_given(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether target, speed or rate words carry data."""
    return any(order.words[2:])


def not_programmed(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether no blend profile is stored."""
    return layer.blend is None


def command_or_rates_given(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a command bit is set or words 4 to 7 carry data."""
    return bool(order.msw) or any(order.words[4:])


def distance_illegal(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a minimum registration distance is no value, negative or out of range."""
    return not target_in_range(order.parameters.target) or target_negative(layer, order)


def several_commands(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether more than one command bit is set."""
    return order.many_bits


def other_than_manual(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a command bit is set that is none of the two manual moves."""
    return bool(order.msw & OTHER_THAN_MANUAL)


def ratio_illegal(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether multiplier or divisor is outside 1 to 32,767, the greatest signed word."""
    return order.words[2] < 1 or order.words[3] < 1


def speed_words_given(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether the programmed speed words carry data."""
    return order.speed_words != (0, 0)


def follower_rates_illegal(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a rate of the follower is outside 0 to 2000; 0 is no limit."""
    return not all(rate == 0 or rate_in_range(rate) for rate in order.words[6:8])


STILL_HELD = RefusalRule("HLD-11", external_still_on, bits=COMMAND_ERROR)

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
    RefusalRule("REG-10", command_or_rates_given, bits=COMMAND_ERROR),
    RefusalRule("REG-10", busy, bits=COMMAND_ERROR),
    RefusalRule("CMD-20", distance_illegal),
)

RUN_BLEND: Refusals = (
    RefusalRule("CMD-03", busy),
    RefusalRule("IOM-20", lsw_not_zero, bits=COMMAND_ERROR),
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
    RefusalRule("PST-01", busy, bits=COMMAND_ERROR),
    RefusalRule("PST-08", lsw_not_zero, bits=COMMAND_ERROR),
    RefusalRule("CMD-09", profile_words_given),
    RefusalRule("CMD-04", target_illegal, alone=True),
)

PRESET_ENCODER: Refusals = (
    RefusalRule("PST-06", busy, bits=COMMAND_ERROR),
    RefusalRule("PST-08", lsw_not_zero, bits=COMMAND_ERROR),
    RefusalRule("CMD-11", no_encoder),
    RefusalRule("CMD-09", profile_words_given),
    RefusalRule("CMD-04", target_illegal, alone=True),
)

RESET_ERRORS: Refusals = (RefusalRule("RST-02", lsw_not_zero, bits=COMMAND_ERROR),)

FOLLOWER_WORDS: Refusals = (
    RefusalRule("CMD-29", no_encoder),
    RefusalRule("CMD-34", other_than_manual),
    RefusalRule("CMD-02", several_commands),
    RefusalRule("CMD-31", ratio_illegal),
    RefusalRule("CMD-32", speed_words_given),
    RefusalRule("CMD-36", s_curve_selected),
    RefusalRule("FOL-02", follower_rates_illegal, bits=COMMAND_ERROR),  # no outcome is stated
)
"""What is looked at as long as encoder follower mode is on."""

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
"""Commands whose rules depend on nothing else; Hold and Immediate Stop are never refused by their words."""


def refusals_of(layer: CommandLayer, order: CommandWords) -> Refusals:
    """Return the rules that an order with a single command bit can break."""
    if order.msw & CommandMsw.ABSOLUTE_MOVE.value:
        return ENCODER_ABSOLUTE if order.lsw & ENCODER_MOVE else ABSOLUTE
    if order.msw & CommandMsw.RELATIVE_MOVE.value:
        return ENCODER_RELATIVE if order.lsw & ENCODER_MOVE else RELATIVE
    if order.msw & MANUAL_BITS:
        return REGISTRATION if registers(layer, order) else MANUAL
    return _OF_BIT.get(order.msw, ())


def registers(layer: CommandLayer, order: CommandWords) -> bool:
    """Whether a manual move is a registration move: it has a target, and the firmware knows them."""
    return layer.firmware.registration and target_not_zero(layer, order)
