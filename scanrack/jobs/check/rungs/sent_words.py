"""Commands that a ladder program sends as words: their kinds, speeds, and refused values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType

from scanrack.io_images.amci3601 import Firmware, Limits, Parameters
from scanrack.io_images.amci3601.configuration import check
from scanrack.io_images.thousands import PARAMETER_MAX, PARAMETER_MIN, is_legal_pair, join_thousands
from scanrack.ladder.state.lowered import AddOnCall, LoweredLine, LoweredStep
from scanrack.runtime.config.rackspec import profile_in

from ..facts import Command, FileLine, SentCommand, Violation
from ..groups import grouped
from ..module_kinds import MODE_CONFIG, MOVES, NEWEST, SEARCHES, kinds_of
from ..ranges import Range, exactly
from .output_writes import COPIES, Write, WriteReader, output_word
from .view import LadderView

BLEND = 0x0100
"""The bit of output word 1 that programs a blend."""

NONE: Mapping[str, Range] = MappingProxyType({})

_NEUTRAL = (0, 0, 0, 0, 1, 0, 1, 1)
"""Legal parameters that replace unknown words."""


class SentWords:
    """The commands in a program's writes and copies."""

    def __init__(self, view: LadderView, reader: WriteReader, writes: Sequence[Write]) -> None:
        self._view, self._slots = view, view.steppers
        self._reader, self._writes = reader, writes
        self._copies = [copy for line, place in view.lines for copy in self._copies_in(line, place)]

    def configurations(self) -> Iterator[SentCommand]:
        """Yield the configurations that are sent."""
        yield from (copy for copy in self._copies if copy.words[0] & MODE_CONFIG)
        for write in self._writes:
            if write.word == 0 and write.known and write.sets & MODE_CONFIG:
                yield SentCommand(write.place, write.slot, (write.sets,))

    def searches(self) -> Iterator[SentCommand]:
        """Yield the commands that start a home search."""
        for write in self._writes:
            if write.commands & SEARCHES:
                yield SentCommand(write.place, write.slot)

    def commands(self) -> Iterator[Command]:
        """Yield the commands that are sent in copied constants, command words, and words of speeds."""
        for copy in self._copies:
            yield from _commands_of(copy)
        copied = {(copy.place, copy.slot) for copy in self._copies}
        for write in self._writes:
            if (write.place, write.slot) not in copied:
                for kind in kinds_of(write.commands):
                    yield _command(kind, write, f"output word 0, {kind}")
            if write.word == 1 and (write.sets & BLEND or not write.known):
                yield _command("program_blend", write, "output word 1")
        by_slot = grouped(self._writes, lambda write: write.slot)
        for slot in self._slots:
            yield from _speeds_in_words(by_slot.get(slot, ()))

    def at_once(self) -> Iterator[Violation]:
        """Yield writes of a command together with its parameters, except by CPS, which is uninterruptible."""
        for line, place in self._view.lines:
            words_by_slot: dict[int, set[int]] = {}
            for step in line.all_steps:
                # the target is the last operand; a COP has its length after it
                operand = step.operands[-2 if step.name == "COP" else -1] if step.operands else None
                slot, word = output_word(operand) or (-1, 0)
                if slot not in self._slots:
                    continue
                if step.name == "COP":
                    yield Violation(place, f"COP writes command and parameters of slot {slot} at once")
                elif step.name in ("MOV", "OTE", "OTL", ":="):
                    words_by_slot.setdefault(slot, set()).add(word)
            for slot, words in sorted(words_by_slot.items()):
                if 0 in words and max(words) > 1:
                    text = f"the rung writes command and parameters of slot {slot} at once"
                    yield Violation(place, text)

    def out_of_range(self) -> Iterator[Violation]:
        """Yield constants copied to a 3601 that the module refuses."""
        for copy in self._copies:
            profile = profile_in(self._slots.values(), copy.slot)
            problems: Iterable[str] = ()
            if copy.words[0] & MODE_CONFIG:
                slot = None if copy.slot is None else self._slots.get(copy.slot)
                firmware = Firmware.parse(NEWEST if slot is None else slot.firmware)
                broken = check(copy.words, firmware, profile.limits)
                problems = (f"the configuration is invalid: {profile.rules[rule].clause}" for rule in broken)
            elif copy.words[0] & MOVES:
                problems = _illegal_parameters(copy.words, profile.limits)
            yield from (Violation(copy.place, text) for text in problems)

    def _copies_in(self, line: LoweredLine, place: FileLine) -> Iterator[SentCommand]:
        """Yield constants that are copied to all words of a 3601, or passed to a block as a configuration."""
        for step in line.all_steps:
            target = self._reader.target(step.operands[1]) if step.name in COPIES else None
            if target is not None and target[0] in self._slots and target[1] == 0:
                words = self._reader.words_of(step.operands[0])
                if words is not None and words[0] is not None:
                    yield SentCommand(place, target[0], _filled(words), _speed(words))
            yield from self._configured_by(step, place)

    def _configured_by(self, step: LoweredStep, place: FileLine) -> Iterator[SentCommand]:
        """Yield the configurations that the blocks of an instruction send."""
        for call in step.operands:
            if isinstance(call, AddOnCall) and call.name == "CONFIGURE3601":
                yield from self._configured(call, place)

    def _configured(self, call: AddOnCall, place: FileLine) -> Iterator[SentCommand]:
        """Yield the configuration that a block sends to a 3601."""
        words = self._reader.words_of(call.handed["CONFIGURATION"])
        slot = self._view.axes.get(call.handed["AXIS"].text.upper())
        if words is not None and words[0] is not None and slot not in self._view.drives:
            yield SentCommand(place, slot, _filled(words))


def _commands_of(copy: SentCommand) -> Iterator[Command]:
    """Yield the commands in copied words."""
    is_move = copy.words[0] & (MOVES | SEARCHES) and copy.speed is not None
    values = {"speed": exactly(copy.speed or 0)} if is_move else {}
    for kind in kinds_of(copy.words[0]):
        yield _command(kind, copy, f"the words of {kind}", values)
    if len(copy.words) > 1 and copy.words[1] & BLEND:
        yield _command("program_blend", copy, "the words of a blend")


def _speeds_in_words(writes: Sequence[Write]) -> Iterator[Command]:
    """Yield a move for each speed that the program writes to a slot as separate words.

    The rules then report speeds below the starting speed. Each low word is combined with the highest high
    word, because the text does not show which words belong together. Slots with unknown words, and slots
    without a move or home search, are omitted.
    """
    by_word = grouped(writes, lambda write: write.word)
    high_writes, low_writes = by_word.get(SPEED_MSW, []), by_word.get(SPEED_LSW, [])
    has_motion = any(write.sets & (MOVES | SEARCHES) for write in by_word.get(0, ()))
    if not has_motion or not all(write.known for write in (*high_writes, *low_writes)):
        return
    thousands = max((write.sets for write in high_writes), default=0)
    for low_write in low_writes:
        speed = 1000 * thousands + low_write.sets
        if speed:
            yield _command("move_by", low_write, "output words 4 and 5", {"speed": exactly(speed)})


SPEED_MSW, SPEED_LSW = 4, 5
"""Output words for the thousands and the remainder of a speed."""


def _command(kind: str, sent: SentCommand | Write, text: str, values: Mapping[str, Range] = NONE) -> Command:
    return Command(kind, f"slot {sent.slot}", sent.slot, sent.place, text, values, words=True)


def _speed(words: Sequence[int | None]) -> int | None:
    """Return the speed in words; None if it is unknown or not a valid number."""
    high, low = words[SPEED_MSW], words[SPEED_LSW]
    if high is None or low is None or not is_legal_pair(high, low):
        return None
    return join_thousands(high, low)


def _filled(words: Sequence[int | None]) -> tuple[int, ...]:
    """Replace unknown words, and the other word of the same number, by legal values."""
    filled = [neutral if word is None else word for word, neutral in zip(words, _NEUTRAL, strict=True)]
    for msw in (2, 4):
        if words[msw] is None or words[msw + 1] is None:
            filled[msw : msw + 2] = 0, 1
    return tuple(filled)


def _illegal_parameters(words: tuple[int, ...], limits: Limits) -> Iterator[str]:
    """Yield messages about a move's illegal parameters, with both words of an illegal number."""
    parameters = Parameters.read(words)
    if not parameters.target_in_range:
        target = words[2:4] if parameters.target is None else parameters.target
        yield f"the move's target is {target}: must be {PARAMETER_MIN} to {PARAMETER_MAX}"
    if not limits.takes_speed(parameters.speed):
        speed = words[4:6] if parameters.speed is None else parameters.speed
        yield f"the move's speed is {speed}: must be 1 to {limits.speed}"
    if not parameters.rates_in_range(limits):
        rates = f"{parameters.acceleration} and {parameters.deceleration}"
        yield f"the move's acceleration and deceleration are {rates}: must be 1 to {limits.rate}"
