"""An axis on a networked drive: its configuration, and the commands that it lacks."""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.amci3601.bits import CommandLsw
from scanrack.io_images.amci3601.configuration import Configuration
from scanrack.io_images.drives.bits import Modifier
from scanrack.io_images.drives.configuration import broken_rules
from scanrack.io_images.drives.models import WORDS, Model

from .blending import BlendProgramming
from .command import Command
from .kinds import GEAR, MINIMUM, PROGRAM_BLEND, REGISTRATION, RUN_BLEND

_SHAPE = (CommandLsw.S_CURVE | CommandLsw.TRAPEZOIDAL).value
_MODE = 0x8000

AxisConfiguration = Configuration | tuple[int, ...]
"""The configuration of a 3601, or the ten words of a networked drive, unsigned."""


def checked_configuration(configuration: object) -> AxisConfiguration:
    """Return a configuration as an axis stores it; raise a ValueError for an invalid configuration."""
    if isinstance(configuration, Configuration):
        return configuration
    if (
        isinstance(configuration, Sequence)
        and len(configuration) == WORDS
        and all(map(_is_word, configuration))
    ):
        words = tuple(word & 0xFFFF for word in configuration)
        if not words[0] & _MODE:
            raise ValueError(
                f"configuration word 0 is {words[0]:04X}h; bit 15 (configuration mode) must be on"
            )
        return words
    raise ValueError(
        f"configuration {configuration!r} is not a Configuration; for a networked drive, pass {WORDS} words"
    )


def _is_word(value: object) -> bool:
    return type(value) is int and -0x8000 <= value <= 0xFFFF


def configuration_mistake(configuration: AxisConfiguration, model: Model | None) -> str:
    """Return why a module can't have a configuration; "" if it can.

    Args:
        model: model of the drive, or None for a module with a 3601's words.
    """
    if model is None:
        is_3601 = isinstance(configuration, Configuration)
        return "" if is_3601 else "its configuration must be a Configuration, not ten words"
    if isinstance(configuration, Configuration):
        return f"its configuration must be {WORDS} words, not a 3601's Configuration; see docs/drives.md"
    broken = broken_rules(configuration, model)
    return "; ".join(f"configuration: {rule.text} [{rule.id}, {rule.section}]" for rule in broken)


def missing_function(model: Model, command: Command) -> str:
    """Return the function that a model lacks for a command, as text; "" if it can run the command."""
    kind, title = command.kind, model.title
    curved = bool(command.words[1] & _SHAPE)
    if kind is GEAR:
        return f"the {title} can't follow an encoder"
    if kind in (REGISTRATION, MINIMUM) and not model.modifiers & Modifier.REGISTRATION_MOVE:
        return f"registration moves of the {title} are not supported"
    if kind in (PROGRAM_BLEND, RUN_BLEND) and not model.runs_blends:
        return f"blends of the {title} are not supported"
    if isinstance(command, BlendProgramming):
        return command.unfit_for_drives
    if kind is REGISTRATION and curved:
        return "a drive's registration move has no S-curve"
    return f"the {title} has no S-curve" if curved and not model.jerk else ""
