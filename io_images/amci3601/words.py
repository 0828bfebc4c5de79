"""The profile of a stepper module in the 3601 family: words, bits, errors, limits, rules.

Code that names words or bits, checks numbers, or quotes rules uses the `Profile` of the slot.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from typing import Any, TypeGuard

from ..dataclass import dataclass
from ..module_words import (
    PLAIN_WORDS,
    BitPlace,
    Groups,
    Modes,
    ModuleWords,
    Quantity,
    flag_places,
    numbers_of,
)
from .bits import (
    ERROR_BITS,
    LIVE_BITS,
    PROFILE_BITS,
    CommandLsw,
    CommandMsw,
    StatusLsw,
    StatusMsw,
    status_names,
)
from .parameters import LIMITS_3601, Limits, Parameters
from .rules import RULES, Rule
from .status import StatusView, view_with

Broken = Callable[[Sequence[int], Parameters], bool]
"""Returns whether a move with these eight signed output words and these parameters breaks a rule."""

_PLACES_3601 = flag_places("I", StatusMsw, StatusLsw)
_WORD = 0xFFFF
_REFUSED = (StatusMsw.COMMAND_ERROR | StatusMsw.INVALID_PROFILE | StatusMsw.HOME_INVALID).value


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile(ModuleWords):
    """A module of the family: a 3601's words, possibly with more bits, different limits and more rules.

    Attributes:
        limits: the largest values in its commands.
        rules: its rules by id, including the rules of a 3601.
        further_refusals: rules for absolute and relative moves that a 3601 lacks: the id and a function that
            tests a move.
        undescribed: names of the command bits that its manual does not explain; the module refuses each.
        further: places of additional status bits, which a 3601 lacks, by name.
        further_errors: the errors among these bits, as a mask of `StatusBits`; Reset Errors clears them.
        refusals: ids of the rules that refuse a command; unrelated rules can fire in the same scan.
        masks: masks (`StatusBits`) of the status bits by name.
        view: the class that reads an input image by the names of these bits.

    Raises:
        ValueError: a status bit is outside words 0 and 1, a 3601's bit is in a different place, a bit has
            two names, an error has no bit, or a refusal has no rule that sets a named bit.
    """

    limits: Limits = field(default=LIMITS_3601, compare=False)
    rules: Mapping[str, Rule] = field(default_factory=lambda: RULES, compare=False, repr=False)
    further_refusals: tuple[tuple[str, Broken], ...] = field(default=(), compare=False, repr=False)
    undescribed: frozenset[str] = field(default=frozenset(), compare=False)
    further: Mapping[str, BitPlace] = field(init=False, compare=False)
    further_errors: int = field(init=False, compare=False)
    refusals: frozenset[str] = field(init=False, compare=False, repr=False)
    masks: Mapping[str, int] = field(init=False, compare=False, repr=False)
    view: type[StatusView] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Compute the fields without a parameter; refuse a profile that contradicts itself."""
        ModuleWords.__post_init__(self)
        status = self.groups["status"]
        self._check_status(status)
        for name in self.undescribed:
            if name not in self.groups["command"]:
                raise ValueError(f"{self.message}: undescribed: no command bit {name!r}")
        further_places = {name: place for name, place in status.items() if name not in _PLACES_3601}
        masks = {name: 1 << 16 * place.word + place.bit for name, place in status.items()}
        errors = sum(masks[name] for name in self.errors if name in further_places)
        refusals = {rule for rule, _ in self.further_refusals}
        refusals.update(row.id for row in self.rules.values() if (row.list_of or 0) & _REFUSED)
        for name, value in (  # `object.__setattr__`, because the class is frozen
            ("further", further_places),
            ("further_errors", errors),
            ("refusals", frozenset(refusals)),
            ("masks", masks),
            ("view", view_with(further_places)),
        ):
            object.__setattr__(self, name, value)
        self._check_refusals()

    def _check_status(self, status: Mapping[str, BitPlace]) -> None:
        """Raise a ValueError if a status bit is in a wrong place, or an error has no status bit."""
        for name, place in status.items():
            if place.image != "I" or place.word not in (0, 1) or _PLACES_3601.get(name, place) != place:
                allowed = _PLACES_3601.get(name, "in word 0 or 1 of image I")
                raise ValueError(f"{self.message}: status.{name}: {place}: must be {allowed}")
        for name in self.errors:
            if name not in status:
                raise ValueError(f"{self.message}: errors: no status bit {name!r}")

    def _check_refusals(self) -> None:
        """Raise a ValueError if a refusal sets no status bit, or sets an unnamed bit."""
        named_bits = sum(self.masks.values())
        for rule, _ in self.further_refusals:
            if rule not in self.rules:
                raise ValueError(f"{self.message}: further_refusals: no rule {rule!r} in rules")
            sets = int(self.rules[rule].if_broken or self.rules[rule].sets)
            unnamed = sets & ~named_bits
            if not sets or unnamed:
                bits = numbers_of([unnamed & _WORD, unnamed >> 16]) or "none"
                raise ValueError(
                    f"{self.message}: rule {rule}: sets must be named status bits; without a name: {bits}"
                )

    def __deepcopy__(self, _memo: object) -> Profile:
        return self

    @property
    def error_bits(self) -> int:
        """The bits that report an error, as a mask of `StatusBits`."""
        return ERROR_BITS.value | self.further_errors

    def status_names(self, word0: int, word1: int) -> list[str]:
        """Return the names of the set status bits; see `bits.status_names`."""
        names = status_names(word0, word1)
        if self.further and not word0 & StatusMsw.MODE_CONFIG.value:
            status = word0 & _WORD | (word1 & _WORD) << 16
            names += [name for name in self.further if status & self.masks[name]]
        return names


# fmt: off
WORDS_3601 = Profile(
    message="Amci3601",
    # chapter 5, output data in command mode    chapter 6, input data in command mode
    outputs=("command_msw", "command_lsw",      "target_msw", "target_lsw",
             "speed_msw", "speed_lsw",          "acceleration", "deceleration"),
    inputs=("status_msw", "status_lsw",         "position_msw", "position_lsw",
            "encoder_msw", "encoder_lsw",       "captured_msw", "captured_lsw"),
    groups={"command": flag_places("O", CommandMsw, CommandLsw), "status": _PLACES_3601},
    profile=PROFILE_BITS,
    # chapter 6, Status Word MSW: bits 8, 9, 11, 12, 13
    errors=("HOME_INVALID", "INVALID_PROFILE", "INPUT_ERROR", "COMMAND_ERROR", "CONFIG_ERROR"),
    quantities=(
        Quantity("position", "I", 2, unit="steps", counts=True),
        Quantity("encoder", "I", 4, unit="counts", counts=True),
        Quantity("captured", "I", 6, unit="steps"),
        Quantity("target", "O", 2, unit="steps"),
        Quantity("programmed_speed", "O", 4, unit="steps/s"),
        Quantity("acceleration", "O", 6, 1, "steps/ms/s"),
        Quantity("deceleration", "O", 7, 1, "steps/ms/s"),
    ),
    modes=Modes(LIVE_BITS),
)
"""The profile of a 3601, and of the adapters."""
# fmt: on


def is_stepper(words: ModuleWords) -> TypeGuard[Profile]:
    """Return whether a module belongs to the 3601's family."""
    return isinstance(words, Profile)


def may_be_stepper(words: ModuleWords) -> bool:
    """Return whether a module belongs to the 3601's family, or has unnamed words.

    A user's own 3601-compatible module need not name its words.

    >>> may_be_stepper(PLAIN_WORDS), is_stepper(PLAIN_WORDS)
    (True, False)
    """
    return is_stepper(words) or words == PLAIN_WORDS


def profile_of(words: ModuleWords) -> Profile:
    """Return the profile of a module that may be a stepper; if its words are unnamed, the 3601's profile."""
    return words if is_stepper(words) else WORDS_3601


def family_facts(profile: Profile) -> dict[str, object]:
    """Return the facts about a profile that a trace stores besides words and bits."""
    return {"errors": list(profile.errors), "speed": profile.limits.speed, "rate": profile.limits.rate}


def recorded_profile(message: str, groups: Groups, facts: Mapping[str, Any]) -> Profile:
    """Return a recorded module's profile, with a 3601's rules; events have the texts of other rules.

    Raises:
        ValueError: the facts are not facts of `family_facts`.
    """
    try:
        limits = Limits(int(facts["speed"]), int(facts["rate"]))
        errors = tuple(str(name) for name in facts["errors"])
        return replace(WORDS_3601, message=message, groups=groups, errors=errors, limits=limits)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"family of a module: {error!r}") from None
