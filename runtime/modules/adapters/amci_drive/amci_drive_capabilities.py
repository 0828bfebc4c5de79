"""The capabilities of a networked drive through the adapter."""

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
    profile_of,
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
        "the drive has two inputs, options in1 and in2; option unwired = inactive reads others as inactive"),
    ConfigurationRow("one input twice", lambda _, options: options.wired[0] == options.wired[1] != 0,
        "options in1 and in2 are the same; the drive's two inputs need different functions"),
    ConfigurationRow("encoder",
        lambda configuration, options: configuration.quadrature_encoder and options.counts_per_turn == 0,
        "the drive has no encoder, since option counts_per_turn is 0"),
    ConfigurationRow("backplane home proximity", lambda configuration, _: configuration.backplane_proximity,
        "the adapter can't pass the home proximity to the drive"),
    no_feedback("drive"),
    no_marker("drive"),
)
# fmt: on


def _too_slow(request: AxisRequest, options: AmciDriveOptions) -> bool:
    return 0 < speed_of(request) < request.configuration.starting_speed


def _no_jerk(request: AxisRequest, options: AmciDriveOptions) -> bool:
    """Return whether no jerk of the drive is as gentle as the S-curve (option strict: equal to it)."""
    if not has_ramps(request):
        return False
    profile = profile_of(request)
    is_too_gentle = 0 < exact_jerk(profile) < 1  # the drive's lowest jerk is 1
    return is_too_gentle or (options.strict and not jerk_is_exact(profile))


def _rounds_jerk(request: AxisRequest, options: AmciDriveOptions) -> bool:
    return has_ramps(request) and not jerk_is_exact(profile_of(request))


def _has_jerk(request: AxisRequest, options: AmciDriveOptions) -> bool:
    return has_ramps(request) and exact_jerk(profile_of(request)) != 0


def _has_curved_segment(request: AxisRequest, options: AmciDriveOptions) -> bool:
    """Return whether the first block of a blend program has an S-curve.

    Words 3 and 4 have two bits per segment, with the first segment in the lowest bits; the lower bit selects
    an S-curve.
    """
    words = request.command.words
    segment_types = words[4] & 0xFFFF | (words[3] & 0xFFFF) << 16
    segment_count = max(0, min(SEGMENTS_MAX, words[2]))
    curved_segments = segment_types & 0x5555_5555 & (1 << 2 * segment_count) - 1
    return bool(curved_segments or words[5] & 0x4000)


# One row of the table is one row here; the formatter would spread each over many lines.
# fmt: off
COMMAND_ROWS: tuple[CommandRow[AmciDriveOptions], ...] = (
    CommandRow(Feature.ENCODER_MOVE, "encoder move", unless("encoder_move", "polled"), PROFILE,
        "the drive can't end a move by its encoder; option encoder_move = polled stops after a read of it"),
    no_follower("drive"),
    CommandRow(Feature.HOME, "home input",
        lambda request, options: HOME not in options.wired or not request.configuration.inputs_used & HOME,
        HOMING, "the drive needs an input with the function home; set option in1 or in2"),
    CommandRow(TIMED, "speed", _too_slow, PROFILE,
        "the drive can't move slower than its starting speed"),
    CommandRow(Feature.BLEND, "S-curve in a blend move", _has_curved_segment, BLOCK,
        "the drive's jerk changes the length of the ramps, so the segments would not fit"),
    CommandRow(Feature.REGISTRATION, "S-curve in a registration move", _has_jerk, PROFILE,
        "a registration move of the drive has no jerk; its word is the minimum distance"),
    CommandRow(RAMPED, "S-curve", _no_jerk, PROFILE,
        "no jerk of the drive makes this S-curve; option strict refuses a gentler one"),
    CommandRow(Feature.MOVE, "distance", lambda request, _: abs(request.distance) > TARGET_MAX, PROFILE,
        f"the drive's longest move is {TARGET_MAX} steps"),
)
# fmt: on

SUBSTITUTION_ROWS: tuple[SubstitutionRow[AmciDriveOptions], ...] = (
    SubstitutionRow(
        "S-curve",
        _rounds_jerk,
        "the drive has one jerk for both ramps, a whole number up to 5000: it uses the next lower one",
    ),
)


class AmciDriveCapabilities(RowCapabilities[AmciDriveOptions]):
    """Capabilities of a networked drive, defined by the rows above."""

    configuration_rows = CONFIGURATION_ROWS
    command_rows = COMMAND_ROWS
    substitution_rows = SUBSTITUTION_ROWS
    homing = AxisHoming.WHOLE
