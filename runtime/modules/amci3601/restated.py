"""A module of the family whose images have another form; see `io_images.amci3601.image_form`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scanrack.io_images.amci3601.image_form import ImageForm
from scanrack.io_images.image import Image
from scanrack.io_images.number_formats import NumberFormat
from typing_extensions import override

from .module import Amci3601

if TYPE_CHECKING:
    from ...loop.module import Words


class Restated3601(Amci3601):
    """A 3601 whose images have another form; see `Amci3601` for the other arguments."""

    def __init__(self, form: ImageForm, *arguments: Any, **options: Any) -> None:
        self._form, self._word_places = form, form.places
        self._outputs_3601, self._shown = Image(), Image(size=len(form.inputs))
        super().__init__(*arguments, **options)

    @override
    def update(self, now_ns: int, outputs: Image) -> Image:
        image = super().update(now_ns, self._restated_outputs(outputs))
        for word, value in enumerate(self._form.from_3601(image.words.tolist())):
            self._shown.words[word] = value
        return self._shown

    @override
    def calm_until_ns(self, outputs: Image) -> int:
        if self._form.numbers is not NumberFormat.THOUSANDS:
            return 0
        return super().calm_until_ns(self._restated_outputs(outputs))

    @override
    def foretell(self, first_ns: int, every_ns: int, count: int) -> Words:
        """Return the predicted words at their places in this image; omit words that the image lacks."""
        words_3601 = super().foretell(first_ns, every_ns, count)
        return {
            self._word_places[word]: values
            for word, values in words_3601.items()
            if word in self._word_places
        }

    def _restated_outputs(self, outputs: Image) -> Image:
        for word, value in enumerate(self._form.to_3601(outputs.words.tolist())):
            self._outputs_3601.words[word] = value
        return self._outputs_3601
