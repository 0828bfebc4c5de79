"""Programs as a list of steps: words for a 3601, and the condition for advancing to the next step.

    SLOT 1                                            # the default
    words 843Eh 003Fh 1      until MODE_CONFIG -CONFIG_ERROR
    zero                     until -MODE_CONFIG
    RELATIVE_MOVE target 10000 speed 5000 acceleration 20 deceleration 10    until MOVE_COMPLETE
    idle                     for 20 ms

A step writes its words only in its first scan. It ends in the first later scan with the listed status bits (a
minus means clear), or when its time is up. The next step begins in the scan that ends the step. The last step
never ends.

    words A B ...            these words, then zeros; hexadecimal with an h
    zero                     all words 0
    idle                     command words 0; the other words do not change
    BIT ... target N ...     command bits by name, parameters with values
    same                     writes nothing
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Protocol

from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, StatusLsw, StatusMsw, status_names
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MIN, WORDS_MAX, Image, signed_word
from scanrack.io_images.site import Site, SiteError
from scanrack.io_images.text_limits import TextKind, TextLimitError, check_text
from scanrack.io_images.thousands import split_thousands
from scanrack.io_images.times import parse_time, time_text

from ..python.line_marks import WATCH

_LINE = re.compile(r"(?P<what>.*?)(?:\s+(?P<end>until|for)\s+(?P<when>.*))?")
_STATUS = frozenset(str(bit.name) for bit in (*StatusMsw, *StatusLsw))
_COMMANDS = {
    str(bit.name): (word, bit.value) for word, bits in enumerate((CommandMsw, CommandLsw)) for bit in bits
}
_PARAMETERS = {"target": 2, "speed": 4, "acceleration": 6, "deceleration": 7}


class StepsError(SiteError):
    """A line is invalid; the message has the file, the line and the allowed words."""


class _Slot(Protocol):
    inputs: Image
    outputs: Image


class _Slots(Protocol):
    def __getitem__(self, number: int, /) -> _Slot: ...


class StepsScan(Protocol):
    """The parts of a scan that a program of steps uses."""

    slot: _Slots
    now_ns: int
    first: bool


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a program."""

    line: int  # line in the file
    write: Callable[[Image], None]  # writes the step's words to an output image
    rise: frozenset[str] = frozenset()  # status bits that must be set for it to end
    fall: frozenset[str] = frozenset()  # status bits that must be clear for it to end
    for_ns: int | None = None  # duration if no bits are listed; None = forever

    @property
    def end(self) -> str:
        """The condition that ends the step, as text; "" if it does not end.

        >>> Step(1, Image.clear, rise=frozenset({"MOVE_COMPLETE"}), fall=frozenset({"INPUT_ERROR"})).end
        'MOVE_COMPLETE -INPUT_ERROR'
        >>> Step(1, Image.clear, for_ns=20_000_000).end
        '20 ms'
        """
        if self.rise or self.fall:
            return " ".join([*sorted(self.rise), *(f"-{name}" for name in sorted(self.fall))])
        return "" if self.for_ns is None else time_text(self.for_ns)

    def ends(self, inputs: Image, lasted_ns: int) -> bool:
        """Return whether the step ends in a scan with these inputs, `lasted_ns` after the step began."""
        if self.rise or self.fall:
            active = set(status_names(inputs[0] & UNSIGNED_MAX, inputs[1] & UNSIGNED_MAX))
            return self.rise <= active and self.fall.isdisjoint(active)
        return self.for_ns is not None and lasted_ns >= self.for_ns


class Steps:
    """A program of steps: the logic for the module in `slot`.

    Attributes:
        since_ns: virtual time when the current step began.
        resumed: number of steps that have begun so far.
    """

    name = "program"

    def __init__(self, steps: Sequence[Step], slot: int = 1, file: str = "") -> None:
        self.steps = tuple(steps)
        self.slot, self.file = slot, file
        self._watch = WATCH.get()
        self._index = -1
        self.since_ns = self.resumed = 0

    @property
    def line(self) -> int:
        """The line of the current step; 0 before the first step."""
        return self.steps[self._index].line if self._index >= 0 else 0

    @property
    def waits_for(self) -> str:
        """The condition that ends the current step, as text; "" before the first step."""
        if self._index < 0:
            return ""
        last = self._index + 1 == len(self.steps)
        return "nothing, as the last step" if last else self.steps[self._index].end

    def __call__(self, scan: StepsScan) -> None:
        """Run one scan; the first scan after power-up or program mode begins with the first step."""
        slot = scan.slot[self.slot]
        if scan.first:
            self._begin(0, scan.now_ns, slot.outputs)
        elif self._ends(slot.inputs, scan.now_ns):
            self._begin(self._index + 1, scan.now_ns, slot.outputs)

    def _ends(self, inputs: Image, now_ns: int) -> bool:
        last = self._index + 1 == len(self.steps)
        return not last and self.steps[self._index].ends(inputs, now_ns - self.since_ns)

    def _begin(self, index: int, now_ns: int, outputs: Image) -> None:
        """Begin a step and write its words."""
        self._index, self.since_ns = index, now_ns
        self.resumed += 1
        self._watch.begins(Path(self.file).name, self.line, None)
        self.steps[index].write(outputs)


def parse_steps(text: str, file: str = "") -> Steps:
    r"""Read a program of steps; raise a StepsError if it is invalid.

    >>> program = parse_steps("words 843Eh 003Fh 1 until MODE_CONFIG\nzero for 4 ms\nHOLD_MOVE")
    >>> [(step.line, sorted(step.rise), step.for_ns) for step in program.steps]
    [(1, ['MODE_CONFIG'], None), (2, [], 4000000), (3, [], None)]
    """
    try:
        check_text(text, TextKind.STEPS)
    except TextLimitError as error:
        raise StepsError.at(Site(file=file, line=error.line), str(error)) from None
    steps: list[Step] = []
    slot = 1
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].strip()
        try:
            if words.startswith("SLOT"):
                slot = _slot(words, first=not steps)
            elif words:
                steps.append(_step(number, words))
        except ValueError as error:
            raise StepsError.at(Site(file=file, line=number), str(error)) from None
    if not steps:
        raise StepsError(f"{file}: no step in the file")
    return Steps(steps, slot, file)


def _slot(text: str, *, first: bool) -> int:
    match = re.fullmatch(r"SLOT +([1-9]\d*)", text)
    if match is None or not first:
        raise ValueError(f"{text!r} is not allowed; write SLOT and a number from 1, before the first step")
    return int(match[1])


def _step(line: int, text: str) -> Step:
    """Return the step that a line describes."""
    match = _LINE.fullmatch(text)
    assert match is not None, "everything before the end is matched"
    write = _writer(match["what"].split())
    if match["end"] == "for":
        return Step(line, write, for_ns=parse_time(match["when"]))
    if match["end"] == "until":
        rise, fall = _bits(match["when"].split())
        return Step(line, write, rise, fall)
    return Step(line, write)


def _bits(names: Iterable[str]) -> tuple[frozenset[str], frozenset[str]]:
    """Return the status bits that must be set, and the bits with a minus, which must be clear."""
    rise = frozenset(name for name in names if not name.startswith("-"))
    fall = frozenset(name[1:] for name in names if name.startswith("-"))
    for name in sorted(rise | fall):
        _check_name(name, _STATUS, "status bit")
    return rise, fall


def _check_name(name: str, names: Iterable[str], description: str) -> None:
    if name not in names:
        near = difflib.get_close_matches(name.upper(), sorted(names), n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise ValueError(f"{name} is not a {description}{hint}")


def _writer(words: Sequence[str]) -> Callable[[Image], None]:
    """Return the function that writes the words of a step to the output image."""
    if words[0] == "words":
        if not 1 <= len(words) - 1 <= WORDS_MAX:
            raise ValueError(f"{len(words) - 1} words; must be 1 to {WORDS_MAX}")
        values = list(map(_word, words[1:]))
        return lambda outputs: _fill(outputs, values)
    if len(words) == 1 and words[0] in _PLAIN:
        return _PLAIN[words[0]]
    return _command(words)


def _command(words: Sequence[str]) -> Callable[[Image], None]:
    """Return the function that writes command bits and parameters; all other words become 0."""
    image = Image()
    remaining = iter(words)
    for word in remaining:
        if word in _PARAMETERS:
            _put_parameter(image, word, next(remaining, ""))
        else:
            _check_name(word, [*_COMMANDS, *_PARAMETERS, *_PLAIN, "words"], "command bit or parameter")
            word_index, mask = _COMMANDS[word]
            image[word_index] = signed_word(image[word_index] & UNSIGNED_MAX | mask)
    return lambda outputs: _fill(outputs, list(image))


def _fill(outputs: Image, values: Sequence[int]) -> None:
    """Write all words of an image: the values, then zeros."""
    if len(values) > len(outputs):
        raise ValueError(f"{len(values)} words; the module has {len(outputs)}")
    outputs.load(Image(values, size=len(outputs)))


def _put_parameter(image: Image, name: str, text: str) -> None:
    """Set a parameter in an image: a rate in one word, any other value as thousands in two."""
    if not re.fullmatch(r"[+-]?\d+", text):
        raise ValueError(f"{name} {text!r} is not a whole number")
    word_index, value = _PARAMETERS[name], int(text)
    if word_index >= 6:
        image[word_index] = _word(text)
        return
    image[word_index], image[word_index + 1] = split_thousands(value)


def _word(text: str) -> int:
    """Return a word, written as a decimal or hexadecimal number, as a signed number."""
    if re.fullmatch(r"[0-9A-Fa-f]+h", text):
        value = int(text[:-1], 16)
    elif re.fullmatch(r"[+-]?\d+", text):
        value = int(text)
    else:
        raise ValueError(f"{text!r} is not a word; write a decimal number, or a hexadecimal number with an h")
    if not WORD_MIN <= value <= UNSIGNED_MAX:
        raise ValueError(f"{text} does not fit a word; must be {WORD_MIN} to {UNSIGNED_MAX}")
    return signed_word(value)


def _idle(outputs: Image) -> None:
    outputs[0] = outputs[1] = 0


_PLAIN: dict[str, Callable[[Image], None]] = {
    "zero": lambda outputs: outputs.clear(),
    "idle": _idle,
    "same": lambda outputs: None,
}
