"""Capabilities of a networked drive with the adapter."""

from __future__ import annotations

from scanrack.io_images.amci3601 import Configuration, InputBit
from scanrack.io_images.drives.command import TARGET_MAX

from ...amci3601 import AxisHoming, AxisRequest, Feature
from ..capabilities import (
    BLOCK,
    HOMING,
    PROFILE,
    RAMPED,
    TIMED,
    CommandRow,
    ConfigurationRow,
    RowCapabilities,
    SubstitutionRow,
    has_ramps,
    no_feedback,
    no_follower,
    no_marker,
    speed_of,
    unless,
)
from .amci_drive_options import AmciDriveOptions
from .units import exact_jerk, jerk_is_exact

SEGMENTS_MAX = 16

HOME = InputBit.HOME.value


def _not_wired(configuration: Configuration, options: AmciDriveOptions) -> bool:
    first_input, second_input = options.wired
    return options.unwired == "reject" and bool(configuration.inputs_used & ~(first_input | second_input))


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
CONFIGURATION_ROWS: tuple[ConfigurationRow[AmciDriveOptions], ...] = (
    ConfigurationRow("inputs", _not_wired,
        "the drive has two inputs, options in1 and in2; option unwired = inactive takes others as inactive"),
    ConfigurationRow("one input twice", lambda _, options: options.wired[0] == options.wired[1] != 0,
        "options in1 and in2 are the same, and the drive has no two inputs of one function"),
    ConfigurationRow("encoder",
        lambda configuration, options: configuration.quadrature_encoder and options.counts_per_turn == 0,
        "option counts_per_turn is 0: the drive has no encoder"),
    ConfigurationRow("backplane home proximity", lambda configuration, _: configuration.backplane_proximity,
        "the adapter passes no home proximity to the drive"),
    no_feedback("drive"),
    no_marker("drive"),
)
# fmt: on


def _too_slow(request: AxisRequest, options: AmciDriveOptions) -> bool:
    return 0 < speed_of(request) < request.configuration.starting_speed


def _no_jerk(request: AxisRequest, options: AmciDriveOptions) -> bool:
    """Whether the drive has no jerk that is as gentle as the S-curve, or, if strict, equal to it."""
    if not has_ramps(request):
        return False
    profile = request.command.profile(request.configuration.starting_speed)
    jerk = exact_jerk(profile)
    return 0 < jerk < 1 or (options.strict and not jerk_is_exact(profile))


def _rounds_jerk(request: AxisRequest, options: AmciDriveOptions) -> bool:
    return has_ramps(request) and not jerk_is_exact(
        request.command.profile(request.configuration.starting_speed)
    )


def _registers_with_jerk(request: AxisRequest, options: AmciDriveOptions) -> bool:
    return (
        has_ramps(request) and exact_jerk(request.command.profile(request.configuration.starting_speed)) != 0
    )


def _curved_blend(request: AxisRequest, options: AmciDriveOptions) -> bool:
    """Whether the first block of a blend program has an S-curve."""
    words = request.command.words
    types = words[4] & 0xFFFF | (words[3] & 0xFFFF) << 16
    odd = types & 0x5555_5555 & (1 << 2 * max(0, min(SEGMENTS_MAX, words[2]))) - 1
    return bool(odd or words[5] & 0x4000)


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
COMMAND_ROWS: tuple[CommandRow[AmciDriveOptions], ...] = (
    CommandRow(Feature.ENCODER_MOVE, "encoder move", unless(encoder_move="polled"), PROFILE,
        "the adapter ends no move by the encoder; option encoder_move = polled stops when it is read"),
    no_follower("drive"),
    CommandRow(Feature.HOME, "home input",
        lambda request, options: HOME not in options.wired or not request.configuration.inputs_used & HOME,
        HOMING, "the drive homes to an input with the function home only"),
    CommandRow(TIMED, "speed", _too_slow, PROFILE,
        "no motion of the drive is slower than its starting speed"),
    CommandRow(Feature.BLEND, "S-curve in a blend move", _curved_blend, BLOCK,
        "the drive's jerk makes ramps of another length, and segments would not fit"),
    CommandRow(Feature.REGISTRATION, "S-curve in a registration move", _registers_with_jerk, PROFILE,
        "a registration move of the drive has no jerk: its word is the minimum distance"),
    CommandRow(RAMPED, "S-curve", _no_jerk, PROFILE,
        "no jerk of the drive makes this S-curve; option strict rejects a gentler one"),
    CommandRow(Feature.MOVE, "distance", lambda request, _: abs(request.distance) > TARGET_MAX, PROFILE,
        f"the drive moves by up to {TARGET_MAX} steps"),
)
# fmt: on

SUBSTITUTION_ROWS: tuple[SubstitutionRow[AmciDriveOptions], ...] = (
    SubstitutionRow(
        "S-curve",
        _rounds_jerk,
        "the drive has one jerk for both ramps, a whole number up to 5000: the next lower one is taken",
    ),
)


class AmciDriveCapabilities(RowCapabilities[AmciDriveOptions]):
    """The rows above."""

    configuration_rows = CONFIGURATION_ROWS
    command_rows = COMMAND_ROWS
    substitution_rows = SUBSTITUTION_ROWS
    homing = AxisHoming.WHOLE
