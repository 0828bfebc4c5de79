"""Options of a discrete card in a rack file: the wiring of its terminals, and a timeline of its inputs.

[slot.options]
inputs = { start = 0, stop = 1 }
outputs = { lamp = 0 }
normally_closed = ["stop"]
timeline = [{ at_ms = 100, input = "start", for_ms = 50 }]
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from typing import Annotated, ClassVar, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from ....io_images.image import WORDS
from ....io_images.module_words import BitPlace, ModuleWords
from ...loop.options import Options

TERMINALS = 16
WORD_NAMES = ("data", *(f"word{index}" for index in range(1, WORDS)))


def _exact(value: object) -> object:
    """Return a number as it was written: 0.1 is a tenth."""
    return Decimal(str(value)) if isinstance(value, int | float) and not isinstance(value, bool) else value


Terminal = Annotated[int, Field(ge=0, lt=TERMINALS)]
Milliseconds = Annotated[Decimal, BeforeValidator(_exact), Field(ge=0, le=10**9, decimal_places=6)]


class Press(BaseModel):
    """An input is operated; it is released after `for_ms`, or stays operated.

    Attributes:
        at_ms: when, ms since power-up.
        input: which, by its name.
        for_ms: how long, ms.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    at_ms: Milliseconds
    input: str
    for_ms: Annotated[Milliseconds, Field(gt=0)] | None = None

    @property
    def begin_ns(self) -> int:
        """When it begins, ns since power-up."""
        return int(self.at_ms * 1_000_000)

    @property
    def end_ns(self) -> int | None:
        """When it ends, ns since power-up; None = never."""
        return None if self.for_ms is None else self.begin_ns + int(self.for_ms * 1_000_000)


class DiscreteOptions(Options):
    """The wiring of a card.

    Attributes:
        inputs: names of inputs by terminal, 0 to 15.
        outputs: names of outputs by terminal.
        normally_closed: inputs whose contacts are closed at rest: acting on one de-energises it.
        timeline: what happens to the inputs.
    """

    owner: ClassVar[str] = "discrete card"

    inputs: Mapping[str, Terminal] = Field(default_factory=dict)
    outputs: Mapping[str, Terminal] = Field(default_factory=dict)
    normally_closed: Annotated[tuple[str, ...], Field(strict=False)] = ()
    timeline: Annotated[tuple[Press, ...], Field(strict=False)] = ()

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        for field in ("inputs", "outputs"):
            _check_names(field, getattr(self, field))
        known = ", ".join(self.inputs) or "none"
        for name in (*self.normally_closed, *(press.input for press in self.timeline)):
            if name not in self.inputs:
                raise ValueError(f"there is no input {name!r}: inputs are {known}")
        return self

    @property
    def at_rest(self) -> int:
        """Mask of the inputs that are energised at rest."""
        return sum(1 << self.inputs[name] for name in set(self.normally_closed))

    @property
    def words(self) -> ModuleWords:
        """What the card's words and bits are called."""
        return ModuleWords(
            "Discrete",
            WORD_NAMES,
            WORD_NAMES,
            groups={
                "input": {name: BitPlace("I", 0, bit) for name, bit in self.inputs.items()},
                "output": {name: BitPlace("O", 0, bit) for name, bit in self.outputs.items()},
            },
            one_word=True,
        )


def _check_names(field: str, names: Mapping[str, int]) -> None:
    for name in names:
        if not (name.isascii() and name.isidentifier() and name == name.lower()):
            raise ValueError(f"{field}: {name!r} is not a name: small letters, digits and _ only")
        if name in WORD_NAMES:
            raise ValueError(f"{field}: {name!r} is the name of a word: choose another one")
    terminals = list(names.values())
    for name, terminal in names.items():
        if terminals.count(terminal) > 1:
            raise ValueError(f"{field}: terminal {terminal} of {name!r} is used twice")
