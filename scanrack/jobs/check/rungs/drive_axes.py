"""Motion blocks with configurations or commands that a networked drive does not support."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from scanrack.io_images.amci3601 import Limits
from scanrack.io_images.drives.bits import Modifier
from scanrack.io_images.drives.configuration import broken_rules
from scanrack.io_images.drives.models import WORDS, Model

from ..facts import Violation
from .blocks import BlockCall
from .view import LadderView


def fastest(limits: Limits, models: Iterable[Model]) -> Limits:
    """Return limits with the highest speed and rate among `limits` and the drive models."""
    drive_limits = [model.limits for model in models]
    return Limits(
        max([limits.speed, *(drive.speed for drive in drive_limits)]),
        max([limits.rate, *(drive.rate for drive in drive_limits)]),
    )


WordsOf = Callable[[object, int], Sequence[int | None] | None]
"""Returns a given number of constant words from an operand; None if it is too short or not constant."""


def note_drives(view: LadderView, words_of: WordsOf) -> Iterator[Violation]:
    """Yield the calls that can't work on their axis's drive."""
    for call in view.calls:
        model = view.drives.get(view.axes.get(call.axis, 0))
        if model is not None:
            yield from (Violation(call.place, text) for text in _problems(call, model, words_of))


def _problems(call: BlockCall, model: Model, words_of: WordsOf) -> Iterator[str]:
    """Yield messages about a call that can't work on a drive."""
    name = call.call.name
    if name == "CONFIGURE3601":
        yield from _configuration_problems(call.call.handed["CONFIGURATION"], model, words_of)
    if _lacks(name, model):
        yield f"{name}: an {model.title} has no such command: the block ends with ErrorID 4096"


def _configuration_problems(operand: object, model: Model, words_of: WordsOf) -> Iterator[str]:
    """Yield messages about a configuration that is too short or invalid; none if it is not constant."""
    words = words_of(operand, WORDS)
    if words is None and words_of(operand, 8) is not None:
        yield f"the configuration of an {model.title} has {WORDS} words: the array is shorter"
    elif words is not None and None not in words:
        unsigned = [word & 0xFFFF for word in words if word is not None]
        for rule in broken_rules(unsigned, model):
            yield f"the configuration is invalid: {rule.text.rstrip('.')} [{rule.id}, {rule.section}]"


def _lacks(block: str, model: Model) -> bool:
    """Whether a drive model has no command that corresponds to a motion block."""
    if block == "MC_GEARIN":
        return True
    if block in ("MOVEREGISTRATION3601", "STOREMINIMUM3601"):
        return not model.modifiers & Modifier.REGISTRATION_MOVE
    return block in ("PROGRAMBLEND3601", "RUNBLEND3601") and not model.runs_blends
