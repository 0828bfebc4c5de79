"""The moments of a scene: words sent and images read, each with a time window."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from scanrack.io_images.amci3601 import ALL_INPUTS
from scanrack.io_images.image import WORD_MAX, WORD_MIN, WORDS

ImageWords: TypeAlias = tuple[int, ...]
"""Eight signed words."""

MOMENTS_MAX = 2_000_000
"""Maximum number of moments in a file."""


def words_text(words: ImageWords) -> str:
    """Return words as in the manual, with status and command words in hexadecimal.

    >>> words_text((-31684, 60, 0, 500, 0, 0, 0, 0))
    '843Ch 003Ch 0 500 0 0 0 0'
    """
    return " ".join([f"{word & 0xFFFF:04X}h" for word in words[:2]] + [str(word) for word in words[2:]])


class Window(NamedTuple):
    """The earliest and latest possible instant of an event, ns by the clock of the recording."""

    low_ns: int
    high_ns: int


class Transmission(NamedTuple):
    """Output words, or levels of wired inputs. They act at an instant in the window or later.

    Attributes:
        words: the eight output words; None if inputs were operated.
        inputs: mask of `InputBit` for the energized inputs.
    """

    window: Window
    words: ImageWords | None
    inputs: int = 0


class SeenImage(NamedTuple):
    """An input image that was read."""

    window: Window
    words: ImageWords


class KnownState(NamedTuple):
    """An image at rest in command mode, which shows the module's state. A scene can begin with one.

    Attributes:
        words: the input words.
        sent: the output words in effect, without command bits.
        configuration: the words of the accepted configuration; all zero if there is none.
        inputs: mask of `InputBit` for the energized inputs.
    """

    window: Window
    words: ImageWords
    sent: ImageWords
    configuration: ImageWords
    inputs: int


Moment: TypeAlias = Transmission | SeenImage | KnownState


@dataclass(frozen=True, slots=True)
class Timing:
    """The times of the path from a controller to the module and back.

    Attributes:
        rpi_ns: the module's RPI [3601 manual, chapter 1: 2 ms].
        scan_ns: longest time between scans of the controller, if its program copies the words.
        module_ns: the module's own scan.
        drift_ppm: largest difference between the rates of two clocks.
    """

    rpi_ns: int = 2_000_000
    scan_ns: int = 2_000_000
    module_ns: int = 250_000
    drift_ppm: int = 100

    @property
    def lag_ns(self) -> int:
        """Longest time from a word in the controller to its effect, or from an image to the controller."""
        return self.rpi_ns + self.scan_ns + self.module_ns


@dataclass(slots=True)
class PlayedScene:
    """A scene that was played.

    Attributes:
        name: name of the scene in the plan.
        moments: its moments in time order.
        note: the reason if the scene ended early; otherwise "".
    """

    name: str
    moments: list[Moment] = field(default_factory=list)
    note: str = ""

    @property
    def reads(self) -> int:
        """Number of images that were read."""
        return sum(1 for moment in self.moments if isinstance(moment, SeenImage))


def to_rows(moments: Iterable[Moment]) -> list[list[Any]]:
    """Return moments as rows of a JSON file: kind, window, words."""
    return [_row(moment) for moment in moments]


def _row(moment: Moment) -> list[Any]:
    """Return a moment as a row: kind, window, words or inputs."""
    if isinstance(moment, SeenImage):
        return ["read", *moment.window, *moment.words]
    if isinstance(moment, KnownState):
        words = (*moment.words, *moment.sent, *moment.configuration)
        return ["state", *moment.window, *words, moment.inputs]
    if moment.words is None:
        return ["inputs", *moment.window, moment.inputs]
    return ["write", *moment.window, *moment.words]


def from_rows(rows: Sequence[Any]) -> list[Moment]:
    """Return the moments in rows.

    Raises:
        ValueError: a row is not a moment; the message has its number.
    """
    if len(rows) > MOMENTS_MAX:
        raise ValueError(f"{len(rows):,} moments: must be at most {MOMENTS_MAX:,}")
    return [_moment(number, row) for number, row in enumerate(rows)]


def _moment(number: int, row: Any) -> Moment:
    """Return the moment in a row; raise ValueError with the moment's number for an invalid row."""
    count, make = _KINDS.get(str(row[0]) if isinstance(row, list) and row else "", (0, None))
    if make is None or len(row) != 3 + count or not all(type(cell) is int for cell in row[1:]):
        rule = "must be a read or write with two times and 8 words"
        raise ValueError(f"moment {number}: invalid moment ({str(row)[:60]}): {rule}")
    window, numbers = Window(row[1], row[2]), tuple(row[3:])
    if window.low_ns > window.high_ns:
        raise ValueError(f"moment {number}: window {window.low_ns} to {window.high_ns} ends before it begins")
    if not all(WORD_MIN <= word <= WORD_MAX for word in numbers):
        raise ValueError(f"moment {number}: words must be {WORD_MIN} to {WORD_MAX}")
    return make(window, numbers)


def _known_state(window: Window, numbers: tuple[int, ...]) -> KnownState:
    shown, sent, configuration = (numbers[start : start + WORDS] for start in range(0, 3 * WORDS, WORDS))
    return KnownState(window, shown, sent, configuration, numbers[-1] & ALL_INPUTS)


_KINDS: Mapping[str, tuple[int, Callable[[Window, tuple[int, ...]], Moment] | None]] = {
    "read": (WORDS, SeenImage),
    "write": (WORDS, Transmission),
    "inputs": (1, lambda window, numbers: Transmission(window, None, numbers[0] & ALL_INPUTS)),
    "state": (3 * WORDS + 1, _known_state),
}
"""By kind of moment, the count of numbers after its two times, and a function that makes the moment."""
