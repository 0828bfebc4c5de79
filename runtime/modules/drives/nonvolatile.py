"""The flash contents of a drive [SMD p. 59, p. 72], and the number of writes."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from scanrack.io_images.drives.models import WORDS

_Word = Annotated[int, Field(ge=0, le=0xFFFF)]
_Words = Annotated[tuple[_Word, ...], Field(strict=False, min_length=WORDS, max_length=WORDS)]


class DriveMemory(BaseModel):
    """The flash of one axis.

    Attributes:
        configuration: ten configuration words, or None.
        segments: output words for each segment of the stored assembled move, in order; empty without a move.
        encoder_offset: count of the absolute encoder minus the shaft's count, x4 counts; None if not saved.
        writes: number of writes to the flash.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    configuration: _Words | None = None
    segments: Annotated[tuple[_Words, ...], Field(strict=False, max_length=16)] = ()
    encoder_offset: int | None = None
    writes: Annotated[int, Field(ge=0)] = 0

    def written(self, **changes: object) -> DriveMemory:
        """Return a copy with changed fields; the copy counts one more write."""
        return self.model_copy(update={"writes": self.writes + 1, **changes})
