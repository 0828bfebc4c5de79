"""What a PCL601 can't do."""

from __future__ import annotations

from ....io_images.amci3601 import Configuration, InputBit
from ...amci3601 import AxisHoming, Feature, Wish
from ...kinematics import MILLI, PICO, stopping_distance
from ..capabilities import (
    BLOCK,
    FUNCTION,
    PROFILE,
    RAMPED,
    TIMED,
    CommandRow,
    ConfigurationRow,
    RowCapabilities,
    always,
    has_ramps,
    speed_of,
)
from .options import Options
from .units import BASE_MAX, SPEED_MAX, STEPS_MAX, drive_for

EITHER_LIMIT = (InputBit.CW_LIMIT | InputBit.CCW_LIMIT).value
GROUNDED = (InputBit.HOME | InputBit.ESTOP).value


def _used_low(configuration: Configuration, mask: int) -> bool:
    return bool(configuration.inputs_used & ~configuration.active_high & mask)


CONFIGURATION_ROWS: tuple[ConfigurationRow[Options], ...] = (
    ConfigurationRow(
        "starting speed",
        lambda it, _: it.starting_speed > BASE_MAX,
        f"the PCL601's base speed goes up to {BASE_MAX} steps/s",
    ),
    ConfigurationRow(
        "capture input",
        lambda it, options: bool(it.inputs_used & InputBit.CAPTURE.value) and options.capture == "reject",
        "captures are polled, and option capture rejects that",
    ),
    ConfigurationRow(
        "backplane home proximity",
        lambda it, _: it.backplane_proximity,
        "the PCL601 has no home proximity that a PLC could set",
    ),
    ConfigurationRow(
        "diagnostic feedback",
        lambda it, options: it.diagnostic_feedback and options.diagnostic != "mirror",
        "the PCL601 can't count its own pulses; option diagnostic = mirror copies the position",
    ),
    ConfigurationRow(
        "CW/CCW pulses",
        lambda it, _: not it.step_and_direction,
        "the PCL601 has clock and direction outputs",
    ),
    ConfigurationRow("marker home", lambda it, _: it.marker_home, "the PCL601 has no marker input"),
    ConfigurationRow(
        "normally closed end limit",
        lambda it, _: _used_low(it, EITHER_LIMIT),
        "the PCL601's hard limits act when grounded: normally open switches are needed",
    ),
    ConfigurationRow(
        "normally closed home switch or emergency stop",
        lambda it, _: _used_low(it, GROUNDED),
        "home and emergency stop are wired to inputs that act when grounded",
    ),
)


def _too_fast(wish: Wish, options: Options) -> bool:
    return speed_of(wish) > SPEED_MAX


def _one_step_per_second(wish: Wish, options: Options) -> bool:
    """Whether the speed is 1 step/s; the base speed has to be below it."""
    return speed_of(wish) == 1


def _rates_differ(wish: Wish, options: Options) -> bool:
    given = wish.order.parameters
    return options.strict and has_ramps(wish) and given.acceleration != given.deceleration


def _too_far(wish: Wish, options: Options) -> bool:
    return abs(wish.distance) > STEPS_MAX


def _too_short_to_stop(wish: Wish, options: Options) -> bool:
    target = wish.order.parameters.target or 0
    drive = drive_for(wish.order.profile(wish.configuration.starting_speed))
    stop = stopping_distance(MILLI * drive.speed_sps, drive.base_sps, drive.rate_spmss, drive.profile.shape)
    return target * PICO < stop


def _no_restart(wish: Wish, options: Options) -> bool:
    return options.respeed != "restart"


COMMAND_ROWS: tuple[CommandRow[Options], ...] = (
    CommandRow(
        frozenset({Feature.ENCODER_MOVE}),
        "encoder move",
        lambda wish, options: options.encoder_move != "polled",
        PROFILE,
        "the PCL601 can't end a move by its encoder; option encoder_move = polled stops when it is read",
    ),
    CommandRow(
        frozenset({Feature.FOLLOWER}),
        "encoder follower",
        always,
        FUNCTION,
        "the PCL601 can't follow an encoder",
    ),
    CommandRow(
        frozenset({Feature.BLEND}),
        "blend move",
        lambda wish, options: options.blend != "segmented",
        BLOCK,
        "the PCL601 can't change speed in motion; option blend = segmented stops in between",
    ),
    CommandRow(
        frozenset({Feature.SPEED_CHANGE}),
        "speed change",
        _no_restart,
        PROFILE,
        "the PCL601 can't change speed in motion; option respeed = restart stops in between",
    ),
    CommandRow(
        TIMED,
        "speed",
        _too_fast,
        PROFILE,
        f"the PCL601 goes up to {SPEED_MAX} steps/s",
    ),
    CommandRow(
        TIMED,
        "speed",
        _one_step_per_second,
        PROFILE,
        "the PCL601's slowest motion is 2 steps/s",
    ),
    CommandRow(
        RAMPED,
        "different rates",
        _rates_differ,
        PROFILE,
        "the PCL601 has one rate for both ramps, and option strict rejects the lower one for both",
    ),
    CommandRow(
        frozenset({Feature.MOVE}),
        "distance",
        _too_far,
        PROFILE,
        f"the PCL601 indexes by up to {STEPS_MAX} steps",
    ),
    CommandRow(
        frozenset({Feature.REGISTRATION}),
        "registration distance",
        _too_short_to_stop,
        PROFILE,
        "the distance is shorter than the ramp down at the lower of the two rates",
    ),
)


class Pcl601Capabilities(RowCapabilities[Options]):
    """The rows above.

    Args:
        options: of the adapter.
    """

    homing = AxisHoming.LEAVES_SWITCH
    shared_limit = True

    def __init__(self, options: Options) -> None:
        super().__init__(CONFIGURATION_ROWS, COMMAND_ROWS, options)
