"""Modules of the 3601 family whose words are in different places or use a different number format.

3601   status, status, position, position, encoder, encoder, captured, captured     thousands
3401   status, status, position, position                          [3401 manual 2.0, page 34]
3401   0, 0, status, status, position, position                    of a ControlLogix [page 34]
3502   as a 3601, numbers as sign and magnitude                     [3502 manual 1.0, page 1]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..dataclass import dataclass
from ..module_words import BitPlace, ModuleWords
from ..number_formats import NumberFormat, from_sign_magnitude, to_sign_magnitude
from ..thousands import join_reported
from .bits import CommandMsw, StatusMsw
from .words import WORDS_3601, Profile

_CONFIGURES = CommandMsw.MODE_CONFIG.value
_CONFIGURED = StatusMsw.MODE_CONFIG.value
_NUMBERS_OUT = ((2, 3), (4, 5))
"""Target and programmed speed; in configuration mode the starting speed is in words 2 and 3."""

_NUMBERS_IN = ((2, 3), (4, 5), (6, 7))
"""Position, encoder count and captured value, in command mode."""


@dataclass(frozen=True, slots=True)
class ImageForm:
    """The layout of a module's images, compared with a 3601's.

    Attributes:
        inputs: names of the input words, as on a 3601; a word with any other name is always 0.
        numbers: the format of two-word values.

    Raises:
        ValueError: a status word is missing, or a name occurs twice.
    """

    inputs: tuple[str, ...] = WORDS_3601.inputs
    numbers: NumberFormat = NumberFormat.THOUSANDS

    def __post_init__(self) -> None:
        for name in WORDS_3601.inputs[:2]:
            if name not in self.inputs:
                raise ValueError(f"inputs {list(self.inputs)}: {name} is missing; every module has it")
        if len(set(self.inputs)) < len(self.inputs):
            raise ValueError(f"inputs {list(self.inputs)}: a name occurs twice")

    @property
    def places(self) -> Mapping[int, int]:
        """The numbers of the module's input words, by the number of the same word in a 3601."""
        return {
            word: self.inputs.index(name)
            for word, name in enumerate(WORDS_3601.inputs)
            if name in self.inputs
        }

    def words(self, profile: Profile) -> ModuleWords:
        """Return the words of a module with this layout; bit names move with their words.

        >>> words = ImageForm(("zero0", "zero1", "status_msw", "status_lsw")).words(WORDS_3601)
        >>> words.groups["status"]["MODULE_OK"]
        BitPlace(image='I', word=2, bit=14)
        """
        places = self.places
        status = {
            name: BitPlace(place.image, places[place.word], place.bit)
            for name, place in profile.groups["status"].items()
        }
        groups = {**profile.groups, "status": status}
        # without the quantities whose words the module lacks
        quantities = tuple(
            replace(value, word=value.word if value.image == "O" else places[value.word], format=self.numbers)
            for value in profile.quantities
            if value.image == "O" or value.word in places
        )
        return ModuleWords(
            profile.message,
            profile.outputs,
            self.inputs,
            groups,
            errors=profile.errors,
            quantities=quantities,
            modes=replace(profile.modes, input=places[0]) if profile.modes else None,
        )

    def to_3601(self, outputs: Sequence[int]) -> list[int]:
        """Translate a module's signed output words to words of a 3601 with the same meaning."""
        words = list(outputs)
        if self.numbers is NumberFormat.SIGN_MAGNITUDE:
            for msw, lsw in _NUMBERS_OUT[: 1 if words[0] & _CONFIGURES else 2]:
                words[msw], words[lsw] = from_sign_magnitude(words[msw], words[lsw])
        return words

    def from_3601(self, inputs: Sequence[int]) -> list[int]:
        """Translate a 3601's signed input words to words of the module."""
        words = list(inputs)
        if self.numbers is NumberFormat.SIGN_MAGNITUDE and not words[0] & _CONFIGURED:
            for msw, lsw in _NUMBERS_IN:
                words[msw], words[lsw] = to_sign_magnitude(join_reported(words[msw], words[lsw]))
        values = dict(zip(WORDS_3601.inputs, words, strict=True))
        return [values.get(name, 0) for name in self.inputs]
