"""Capabilities of a PCL601."""

from __future__ import annotations

from fractions import Fraction

from scanrack.io_images.amci3601 import Configuration, HomingKind, InputBit
from typing_extensions import override

from ....kinematics import MILLI, PICO, Shape, stopping_distance
from ...amci3601 import AxisHoming, AxisRequest, Feature
from ..capabilities import (
    PROFILE,
    RAMPED,
    TIMED,
    CommandRow,
    ConfigurationRow,
    RowCapabilities,
    SubstitutionRow,
    has_ramps,
    no_blend,
    no_feedback,
    no_follower,
    no_marker,
    no_speed_change,
    profile_of,
    speed_of,
    too_fast,
    unless,
)
from .pcl601_options import Pcl601Options
from .units import BASE_MAX, SPEED_MAX, STEPS_MAX, drive_for

EITHER_LIMIT = (InputBit.CW_LIMIT | InputBit.CCW_LIMIT).value
GROUNDED = (InputBit.HOME | InputBit.ESTOP).value
POLL_DELAY_S = Fraction(3, 100)
"""Longest delay before a polled ramp-down begins, s."""


def _captures(configuration: Configuration) -> bool:
    return bool(configuration.inputs_used & InputBit.CAPTURE.value)


def _used_low(configuration: Configuration, mask: int) -> bool:
    return bool(configuration.inputs_used & ~configuration.active_high & mask)


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
CONFIGURATION_ROWS: tuple[ConfigurationRow[Pcl601Options], ...] = (
    ConfigurationRow("starting speed", lambda configuration, _: configuration.starting_speed > BASE_MAX,
        f"the PCL601's base speed goes up to {BASE_MAX} steps/s"),
    ConfigurationRow("capture input",
        lambda configuration, options: _captures(configuration) and options.capture == "reject",
        "the PCL601 has no capture input; option capture = polled reads an input by polling"),
    ConfigurationRow("capture input",
        lambda configuration, options: _captures(configuration) and options.limit_sense == "inputs",
        "option limit_sense = inputs wires the CCW limit to input 5, and leaves no input for captures"),
    ConfigurationRow("backplane home proximity",
        lambda configuration, options: configuration.backplane_proximity and options.proximity != "jumper",
        "the PCL601 has no home proximity bit; option proximity = jumper wires an output to the soft limits"),
    no_feedback("PCL601"),
    ConfigurationRow("CW/CCW pulses", lambda configuration, _: not configuration.step_and_direction,
        "the PCL601 has clock and direction outputs"),
    no_marker("PCL601"),
    ConfigurationRow("normally closed end limit",
        lambda configuration, options:
            _used_low(configuration, EITHER_LIMIT) and options.limit_sense != "inputs",
        "the PCL601's hard limits act when grounded; option limit_sense = inputs reads inputs instead"),
    ConfigurationRow("normally closed home switch or emergency stop",
        lambda configuration, _: _used_low(configuration, GROUNDED),
        "home and emergency stop are wired to inputs that act when grounded"),
)
# fmt: on


def _rates_differ(request: AxisRequest, options: Pcl601Options) -> bool:
    parameters = request.command.parameters
    return has_ramps(request) and parameters.acceleration != parameters.deceleration


def external_sets_mark(configuration: Configuration, options: Pcl601Options) -> bool:
    """Return whether the external input feeds input 2, the mark of a registration move."""
    used_high = configuration.inputs_used & configuration.active_high
    return options.registration == "default" and bool(used_high & InputBit.EXTERNAL.value)


def counts_too_early(configuration: Configuration, minimum: int, options: Pcl601Options) -> bool:
    """Return whether the device would also count from an input before the minimum distance."""
    return minimum > 0 and external_sets_mark(configuration, options)


def _registers_too_early(request: AxisRequest, options: Pcl601Options) -> bool:
    registers = request.feature is Feature.REGISTRATION
    return registers and counts_too_early(request.configuration, request.minimum_registration, options)


def polls_mark(configuration: Configuration, minimum: int, options: Pcl601Options) -> bool:
    """Return whether a registration move counts its steps from a polled mark."""
    return options.registration == "polled" or counts_too_early(configuration, minimum, options)


def _too_short_to_stop(request: AxisRequest, options: Pcl601Options) -> bool:
    """Return whether the ramp-down and the delay of a polled mark need more than the distance."""
    target = request.command.parameters.target or 0
    drive = drive_for(profile_of(request))
    ramp = stopping_distance(MILLI * drive.max_sps, drive.base_sps, drive.rate_spmss, drive.profile.shape)
    polled = polls_mark(request.configuration, request.minimum_registration, options)
    delay = PICO * drive.max_sps * POLL_DELAY_S if polled else 0
    return target * PICO < ramp + delay


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
COMMAND_ROWS: tuple[CommandRow[Pcl601Options], ...] = (
    CommandRow(Feature.ENCODER_MOVE, "encoder move", unless("encoder_move", "polled"), PROFILE,
        "the PCL601 can't end a move by its encoder; option encoder_move = polled stops after a read of it"),
    no_follower("PCL601"),
    no_blend("PCL601"),
    no_speed_change("PCL601"),
    too_fast("PCL601", SPEED_MAX),
    CommandRow(TIMED, "speed", lambda request, _: speed_of(request) == 1, PROFILE,  # base speed is below it
        "the PCL601's lowest speed is 2 steps/s"),
    CommandRow(RAMPED, "different rates",
        lambda request, options: options.strict and _rates_differ(request, options), PROFILE,
        "the PCL601 has one rate for both ramps, and option strict refuses to use the lower rate for both"),
    CommandRow(Feature.MOVE, "distance", lambda request, _: abs(request.distance) > STEPS_MAX, PROFILE,
        f"the PCL601's longest move is {STEPS_MAX} steps"),
    CommandRow(Feature.REGISTRATION, "registration distance", _too_short_to_stop, PROFILE,
        "the distance is shorter than the ramp down at the lower rate, plus the delay of a polled mark"),
)
# fmt: on


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
SUBSTITUTION_ROWS: tuple[SubstitutionRow[Pcl601Options], ...] = (
    SubstitutionRow("different rates", _rates_differ,
        "the PCL601 has one rate for both ramps: it uses the lower rate, so one ramp is longer"),
    SubstitutionRow("S-curve",
        lambda request, _: has_ramps(request) and request.command.shape is not Shape.CONSTANT,
        "the PCL601 has no S-curve: the ramp has a constant rate and the same duration"),
    SubstitutionRow("minimum registration distance", _registers_too_early,
        "input 2 would count from the external input before the minimum distance: the move stops at the "
        "input and then makes the remaining steps; option registration = jumper avoids the stop"),
)
# fmt: on


class Pcl601Capabilities(RowCapabilities[Pcl601Options]):
    """Capabilities of a PCL601, defined by the rows above."""

    configuration_rows = CONFIGURATION_ROWS
    command_rows = COMMAND_ROWS
    substitution_rows = SUBSTITUTION_ROWS

    def __init__(self, options: Pcl601Options) -> None:
        super().__init__(options)
        self.shared_limit = options.limit_sense != "inputs"

    @override
    def homing_for(self, kind: HomingKind) -> AxisHoming:
        """Return how the axis homes; `CONFIGURATION_ROWS` refuses the kinds with a marker."""
        if kind is HomingKind.HOME_SWITCH_PROXIMITY:
            return AxisHoming.MEETS_SWITCH_SLOWLY  # home type 0: soft limit, then home switch
        return AxisHoming.LEAVES_SWITCH  # home type 1: home switch only
