"""A device's limits and substitutions, row by row, with the 3601 bits that report them.

The first row that applies decides:

    refused                               bits
    configuration                         CONFIG_ERROR
    value outside the device's range      INVALID_PROFILE, COMMAND_ERROR
    missing function                      COMMAND_ERROR
    search for home                       HOME_INVALID, COMMAND_ERROR

A motion that reaches the same target with different ramps is allowed. An event reports the first such motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from scanrack.io_images.amci3601 import Configuration, StatusMsw
from typing_extensions import override

from ...kinematics import Profile
from ..amci3601 import AxisRequest, Capabilities, Feature, Refusal

CONFIG_ERROR = StatusMsw.CONFIG_ERROR.value
FUNCTION = StatusMsw.COMMAND_ERROR.value
PROFILE = (StatusMsw.INVALID_PROFILE | StatusMsw.COMMAND_ERROR).value
HOMING = (StatusMsw.HOME_INVALID | StatusMsw.COMMAND_ERROR).value
BLOCK = StatusMsw.INVALID_PROFILE.value

RAMPED = frozenset({Feature.MOVE, Feature.MANUAL, Feature.REGISTRATION, Feature.HOME, Feature.SPEED_CHANGE})
"""Commands that have a speed and rates."""

TIMED = RAMPED | {Feature.BLEND_SEGMENT, Feature.ENCODER_MOVE}
"""Commands that have a speed."""

AdapterOptions = TypeVar("AdapterOptions")


@dataclass(frozen=True, slots=True)
class ConfigurationRow(Generic[AdapterOptions]):
    """The reason to refuse a configuration."""

    name: str  # short name for events
    applies: Callable[[Configuration, AdapterOptions], bool]  # returns whether the row refuses
    reason: str  # a sentence for the user


@dataclass(frozen=True, slots=True)
class CommandRow(Generic[AdapterOptions]):
    """The reason to refuse a command."""

    features: Feature | frozenset[Feature]  # requested by the command; any of them is enough
    name: str  # short name for events
    applies: Callable[[AxisRequest, AdapterOptions], bool]  # returns whether the row refuses
    bits: int  # error bits of input word 0
    reason: str  # a sentence for the user

    def covers(self, feature: Feature) -> bool:
        """Return whether the row applies to commands that request a feature."""
        return feature is self.features if isinstance(self.features, Feature) else feature in self.features


@dataclass(frozen=True, slots=True)
class SubstitutionRow(Generic[AdapterOptions]):
    """A difference between the device and a 3601."""

    name: str  # short name for events
    applies: Callable[[AxisRequest, AdapterOptions], bool]  # whether a command is executed differently
    how: str  # a sentence for the user


class RowCapabilities(Capabilities, Generic[AdapterOptions]):
    """Capabilities defined by rows.

    Attributes:
        configuration_rows: reasons to refuse configurations.
        command_rows: reasons to refuse commands.
        substitution_rows: differences from a 3601 that an adapter reports once.
        new_substitutions: substitutions made for the first time; the adapter reports and removes them.
    """

    configuration_rows: Sequence[ConfigurationRow[AdapterOptions]]
    command_rows: Sequence[CommandRow[AdapterOptions]]
    substitution_rows: Sequence[SubstitutionRow[AdapterOptions]]

    def __init__(self, options: AdapterOptions) -> None:
        self.new_substitutions: list[SubstitutionRow[AdapterOptions]] = []
        self._unreported = list(self.substitution_rows)
        self._options = options

    @override
    def lacking_for_configuration(self, configuration: Configuration) -> Refusal | None:
        for row in self.configuration_rows:
            if row.applies(configuration, self._options):
                return Refusal(row.name, CONFIG_ERROR, row.reason)
        return None

    @override
    def lacking_for(self, request: AxisRequest) -> Refusal | None:
        """Return the reason to refuse a command, or record its substitutions and return None."""
        for row in self.command_rows:
            if row.covers(request.feature) and row.applies(request, self._options):
                return Refusal(row.name, row.bits, row.reason)
        if request.feature in RAMPED:
            self._note_substitutions(request)
        return None

    def _note_substitutions(self, request: AxisRequest) -> None:
        new_rows = [row for row in self._unreported if row.applies(request, self._options)]
        self._unreported = [row for row in self._unreported if row not in new_rows]
        self.new_substitutions += new_rows


def always(request: AxisRequest, options: object) -> bool:
    """Return True: the device lacks the function under all options."""
    return True


def unless(option: str, value: str) -> Callable[[object, object], bool]:
    """Return a condition that is true unless an option has the given value.

    >>> from types import SimpleNamespace
    >>> unless("blend", "segmented")(None, SimpleNamespace(blend="refuse"))
    True
    """
    return lambda _, options: getattr(options, option) != value


def speed_of(request: AxisRequest) -> int:
    """Return the programmed speed, steps/s."""
    return request.command.parameters.speed or 0


def has_ramps(request: AxisRequest) -> bool:
    """Return whether the programmed speed is above the starting speed."""
    return speed_of(request) > request.configuration.starting_speed


def profile_of(request: AxisRequest) -> Profile:
    """Return the programmed profile."""
    return request.command.profile(request.configuration.starting_speed)


# -- rows that several devices share -----------------------------------------------------------


def no_marker(controller: str) -> ConfigurationRow[Any]:
    """Refuse marker home."""
    reason = f"the {controller} has no marker input"
    return ConfigurationRow("marker home", lambda configuration, _: configuration.marker_home, reason)


def no_feedback(controller: str) -> ConfigurationRow[Any]:
    """Refuse diagnostic feedback, unless the position is mirrored."""
    return ConfigurationRow(
        "diagnostic feedback",
        lambda configuration, options: configuration.diagnostic_feedback and options.diagnostic != "mirror",
        f"the {controller} can't count its own pulses; option diagnostic = mirror copies the position",
    )


def no_follower(controller: str) -> CommandRow[Any]:
    """Refuse the encoder follower."""
    reason = f"the {controller} can't follow an encoder"
    return CommandRow(Feature.FOLLOWER, "encoder follower", always, FUNCTION, reason)


def no_blend(controller: str) -> CommandRow[Any]:
    """Refuse blend moves, unless an option runs them segment by segment."""
    reason = f"the {controller} can't change speed in motion; option blend = segmented stops between segments"
    return CommandRow(Feature.BLEND, "blend move", unless("blend", "segmented"), BLOCK, reason)


def no_speed_change(controller: str) -> CommandRow[Any]:
    """Refuse changes of speed, unless an option stops and restarts the motion."""
    reason = f"the {controller} can't change speed in motion; option respeed = restart stops and restarts"
    return CommandRow(Feature.SPEED_CHANGE, "speed change", unless("respeed", "restart"), PROFILE, reason)


def too_fast(controller: str, speed_max: int) -> CommandRow[Any]:
    """Refuse speeds above `speed_max`, steps/s."""
    reason = f"the {controller}'s highest speed is {speed_max} steps/s"
    return CommandRow(TIMED, "speed", lambda request, _: speed_of(request) > speed_max, PROFILE, reason)
