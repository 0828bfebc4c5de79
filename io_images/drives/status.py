"""The status of a drive, with the drive's own bit names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NoReturn

from typing_extensions import override

from ..amci3601.status import StatusView
from ..image import Image
from ..module_words import BitPlace
from .models import MODELS, Model

NumberReader = Callable[[Sequence[int], int], int]
"""Returns the number in two words of an image, given the index of the first word."""


class DriveStatusView(StatusView):
    """The status bits and values of a drive's ten input words, read at each access."""

    __slots__ = ("_number",)

    def __init__(self, image: Image, number: NumberReader) -> None:
        super().__init__(image)
        self._number = number

    @property
    @override
    def position(self) -> int:
        """Current position, steps."""
        return self._number(self._words, 2)

    @property
    @override
    def encoder(self) -> int:
        """Encoder counts."""
        return self._number(self._words, 4)

    @property
    @override
    def captured(self) -> int:
        """The value stored by the capture input."""
        return self._number(self._words, 6)


def status_view(image: Image, model: Model, number: NumberReader) -> DriveStatusView:
    """Return the view of a drive's input image.

    Args:
        number: reads position, encoder and captured value, in the format of the configuration.
    """
    return _view_of(model.name)(image, number)


@cache
def _view_of(model_name: str) -> type[DriveStatusView]:
    """Return the view class with a model's bits; bits of a 3601 that the model lacks raise an error."""
    model = MODELS[model_name]
    properties = {name: _bit(place) for name, place in model.words.groups["status"].items()}
    missing = {name: _missing(name, model) for name in StatusView._names if name not in properties}
    names = {"__slots__": (), "_names": tuple(properties)}
    return type("DriveStatusView", (DriveStatusView,), {**missing, **properties, **names})


def _bit(place: BitPlace) -> property:
    """Return a property for a status bit; in configuration mode all bits but the mode bit are off.

    In that mode the words mirror the configuration, except for the mode bit, which is bit 15 of word 0.
    """
    is_mode_bit = place.word == 0 and place.bit == 15

    def is_on(view: StatusView) -> bool:
        return (is_mode_bit or view._words[0] >= 0) and bool(view._words[place.word] >> place.bit & 1)

    return property(is_on)


def _missing(name: str, model: Model) -> property:
    """Return a property that raises an AttributeError listing the model's bits."""

    def refuse(_view: StatusView) -> NoReturn:
        bits = ", ".join(model.words.groups["status"])
        raise AttributeError(f"{name} is not a status bit of the {model.title}; choose from {bits}")

    return property(refuse)
