"""Capabilities of a PMC006x3s."""

from __future__ import annotations

from fractions import Fraction

from scanrack.io_images.amci3601 import CommandMsw, Configuration, InputBit

from ....controllers.pmc006.ramps import ramp_steps
from ...amci3601 import AxisHoming, AxisRequest, Feature
from ..capabilities import (
    FUNCTION,
    HOMING,
    PROFILE,
    RAMPED,
    TIMED,
    CommandRow,
    ConfigurationRow,
    RowCapabilities,
    SubstitutionRow,
    always,
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
from .pmc006_options import Pmc006Options
from .units import RATE_MIN, SPEED_MAX, START_MAX, START_MIN, speeds_for

FSET_INPUTS = (InputBit.CAPTURE, InputBit.EXTERNAL, InputBit.ESTOP)
"""Inputs of the 3601, one of which may be wired to FSET."""

SHARED = (InputBit.HOME | InputBit.CCW_LIMIT).value
"""The two inputs of the 3601 that are wired to EXT1."""
POLL_S = Fraction(1, 20)
"""Duration of a poll in s, and the longest delay before a ramp-down begins."""

RATE_TOO_LOW = f"the PMC006's lowest rate is 5.21 steps/ms/s; program {RATE_MIN} or more"

FIND_HOME_CW = CommandMsw.FIND_HOME_CW.value


def _uses(configuration: Configuration, bit: InputBit) -> bool:
    return bool(configuration.inputs_used & bit.value)


def _levels_of_ext1_differ(configuration: Configuration, options: Pmc006Options) -> bool:
    uses_both = configuration.inputs_used & SHARED == SHARED
    return uses_both and configuration.active_high & SHARED not in (0, SHARED)


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
CONFIGURATION_ROWS: tuple[ConfigurationRow[Pmc006Options], ...] = (
    ConfigurationRow("home_stroke", lambda configuration, options: options.home_stroke is None,
        "option home_stroke is missing; set it to the longest way to the home switch, in steps"),
    ConfigurationRow("starting speed",
        lambda configuration, _: not START_MIN <= configuration.starting_speed <= START_MAX,
        f"the PMC006's start speed is {START_MIN} to {START_MAX} steps/s"),
    ConfigurationRow("capture input",
        lambda configuration, options: _uses(configuration, InputBit.CAPTURE) and options.capture != "fset",
        "the PMC006 has no capture input; option capture = fset uses FSET"),
    ConfigurationRow("external input",
        lambda configuration, options:
            _uses(configuration, InputBit.EXTERNAL) and options.hold != "immediate",
        "the PMC006 can't slow down in a move; option hold = immediate stops without a ramp"),
    ConfigurationRow("FSET",
        lambda configuration, _: sum(_uses(configuration, bit) for bit in FSET_INPUTS) > 1,
        "FSET has one use: choose capture, external input or emergency stop"),
    ConfigurationRow("backplane home proximity", lambda configuration, _: configuration.backplane_proximity,
        "the PMC006 has no home proximity bit"),
    ConfigurationRow("encoder", lambda configuration, _: configuration.quadrature_encoder,
        "the PMC006 does not report an encoder position"),
    no_feedback("PMC006"),
    no_marker("PMC006"),
    ConfigurationRow("levels of home switch and CCW limit", _levels_of_ext1_differ,
        "home switch and CCW limit share EXT1, so both must have the same active level"),
)
# fmt: on


def _rate_too_low(request: AxisRequest, options: Pmc006Options) -> bool:
    parameters = request.command.parameters
    gentler = options.accel_rounding == "gentler"
    return gentler and has_ramps(request) and min(parameters.acceleration, parameters.deceleration) < RATE_MIN


def _segment_rate_too_low(request: AxisRequest, options: Pmc006Options) -> bool:
    gentler = options.accel_rounding == "gentler"
    return gentler and has_ramps(request) and request.command.parameters.acceleration < RATE_MIN


def _final_rate_too_low(request: AxisRequest, options: Pmc006Options) -> bool:
    return options.accel_rounding == "gentler" and 0 < request.command.words[5] & 0x3FFF < RATE_MIN


def _too_short_to_stop(request: AxisRequest, options: Pmc006Options) -> bool:
    """Return whether a poll and the ramp-down need more steps than the registration distance."""
    speeds = speeds_for(profile_of(request), nearest=options.accel_rounding == "nearest")
    ramp = ramp_steps(speeds.stop_sps, speeds.max_sps, speeds.deceleration)
    return (request.command.parameters.target or 0) < ramp + speeds.max_sps * POLL_S


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
COMMAND_ROWS: tuple[CommandRow[Pmc006Options], ...] = (
    CommandRow(Feature.ENCODER_MOVE, "encoder move", always, PROFILE,
        "the PMC006 can't end a move by an encoder"),
    no_follower("PMC006"),
    CommandRow(Feature.PRESET_ENCODER, "preset encoder", always, FUNCTION,
        "the PMC006 does not report an encoder position"),
    no_blend("PMC006"),
    CommandRow(Feature.REGISTRATION, "registration move", unless("registration", "polled"), PROFILE,
        "the PMC006 can't count steps from an input; option registration = polled stops at the input"),
    no_speed_change("PMC006"),
    CommandRow(Feature.HOLD, "hold", unless("hold", "immediate"), FUNCTION,
        "the PMC006 can't slow down in a move; option hold = immediate stops without a ramp"),
    CommandRow(Feature.HOME, "find home CW",
        lambda request, _: bool(request.command.msw & FIND_HOME_CW), HOMING,
        "the PMC006 homes backward (CCW) only"),
    too_fast("PMC006", SPEED_MAX),
    CommandRow(TIMED, "speed", lambda request, _: 0 < speed_of(request) < START_MIN, PROFILE,
        f"the PMC006's lowest speed is {START_MIN} steps/s"),
    CommandRow(Feature.BLEND_SEGMENT, "acceleration", _segment_rate_too_low, PROFILE, RATE_TOO_LOW),
    CommandRow(Feature.BLEND, "final deceleration", _final_rate_too_low, PROFILE, RATE_TOO_LOW),
    CommandRow(RAMPED, "rate", _rate_too_low, PROFILE, RATE_TOO_LOW),
    CommandRow(Feature.REGISTRATION, "registration distance", _too_short_to_stop, PROFILE,
        "the distance is shorter than the ramp down plus the delay of a poll"),
    CommandRow(RAMPED, "ramps", lambda request, options: options.strict and has_ramps(request), PROFILE,
        "the PMC006 has eight S-shaped ramps, and option strict refuses to use a gentler ramp"),
)
# fmt: on


SUBSTITUTION_ROWS: tuple[SubstitutionRow[Pmc006Options], ...] = (
    SubstitutionRow(
        "ramps",
        lambda request, options: has_ramps(request) and options.accel_rounding == "gentler",
        "the PMC006 has eight S-shaped ramps: the nearest one that is not steeper is taken, for each",
    ),
)


class Pmc006Capabilities(RowCapabilities[Pmc006Options]):
    """Capabilities of a PMC006x3s, defined by the rows above."""

    configuration_rows = CONFIGURATION_ROWS
    command_rows = COMMAND_ROWS
    substitution_rows = SUBSTITUTION_ROWS
    homing = AxisHoming.MEETS_SWITCH
    home_is_ccw_limit = True
