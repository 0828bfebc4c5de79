"""Writes of a ladder program to the output words of 3601s.

A write of output word 0 sets bits and clears bits:

    instruction              sets            clears
    OTE(bit), bit := tag     the bit         the bit
    OTL(bit), bit := 1       the bit         none
    OTU(bit), bit := 0       none            the bit
    MOV, FLL, := a constant  its bits        the others
    CLR                      none            all
    COP, CPS of constants    their bits      the others
    anything else            unknown: none   all

Constants are the initial values of words that no instruction writes.

Words that a COP or CPS copies to all output words of a 3601 are staged if the program writes the first of
them, the command: a write to them counts as a write to the module.

    COP(Setup[0],Words[0],8);  ...  CPS(Words[0],Local:1:O.Data[0],8);
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.image import WORDS, signed_word
from scanrack.ladder.debug.crossref import TARGETS, Mention
from scanrack.ladder.model.operands import Constant, Group, Place, first_leaf
from scanrack.ladder.model.types import count_of
from scanrack.ladder.state.lowered import AddOnCall, LoweredLine, LoweredProgram, LoweredStep, steps_of

from ..facts import FileLine
from ..ranges import ANY, Range
from ..written import UNKNOWN_WORD, WordValue
from .number_options import OperandOptions
from .number_ranges import Values, target_of, written_value

_WORD = 0xFFFF
ELSEWHERE = (
    StatusMsw.MODE_CONFIG | StatusMsw.CONFIG_ERROR | StatusMsw.COMMAND_ERROR | StatusMsw.POSITION_INVALID
).value
"""Status bits of start-up and faults: a rung that needs one of them does not clear a command in operation.
"""


@dataclass(frozen=True, slots=True)
class Write:
    """An instruction that writes an output word of a 3601."""

    place: FileLine
    slot: int
    word: int  # 0 to 7
    sets: int  # bits that it may set
    clears: int  # bits that it may clear
    known: bool = True  # whether the bits that it sets are known
    first_scan: bool = False  # whether its rung needs the first scan
    status: int = 0  # bits of input word 0 that its rung needs
    command: int = 0  # bits of output word 0 that its rung needs
    site: int = -1  # of the instruction, in `LoweredProgram.sites`
    value: WordValue | None = None  # of a whole word; None for bits

    def takes_back(self, bit: int) -> bool:
        """Whether this clears a command bit after the command has been given."""
        return bool(self.clears & bit) and not (
            self.first_scan or self.status & ELSEWHERE or self.command & ~bit
        )


class WriteReader:
    """Reads the writes of a program's lines.

    Args:
        slots: numbers of the 3601s.
        values: ranges of the program's numbers.
        counts: what FOR counts, by instruction in its body, and by path in capitals.
        place_of: returns file and line of a line.
    """

    def __init__(
        self,
        lowered: LoweredProgram,
        mentions: Sequence[Mention],
        slots: Mapping[int, object],
        values: Values,
        counts: Mapping[int, Mapping[str, Range]],
        place_of: Callable[[LoweredLine], FileLine],
    ) -> None:
        self._constants = _constants(lowered, mentions)
        self._slots, self._values, self._counts, self._place = slots, values, counts, place_of
        self._options = OperandOptions(values)
        self._staged = dict(self._stages(lowered))

    @property
    def staged(self) -> set[int]:
        """Slots whose output words the program copies from a tag; its initial values may be sent, too."""
        return {slot for slot, _ in self._staged.values()}

    def _stages(self, lowered: LoweredProgram) -> Iterator[tuple[str, tuple[int, int]]]:
        """Yield the paths of tags that are copied to all output words: slot, and first word."""
        lines = [line for routine in lowered.routines.values() for line in routine.lines]
        for step in (step for line in lines for step in steps_of(line.nodes)):
            if step.name not in ("COP", "CPS") or output_word(step.operands[0]) is not None:
                continue
            source, target, length = step.operands[0], output_word(step.operands[1]), step.operands[2]
            is_whole = isinstance(length, Constant) and length.value >= WORDS
            if target is None or target[0] not in self._slots or target[1] or not is_whole:
                continue
            if isinstance(source, (Place, Group)) and self._is_written(source):
                yield path_of(source), (target[0], _start_of(source))

    def _is_written(self, source: Place | Group) -> bool:
        """Return whether the program writes the first of the words at an operand, the command."""
        words = self.words_of(source)
        return words is None or words[0] is None

    def target(self, operand: object) -> tuple[int, int] | None:
        """Return slot and first word of a write to an operand, staged or not; None if it is neither."""
        direct = output_word(operand)
        if direct is not None or not isinstance(operand, (Place, Group)):
            return direct
        slot, first = self._staged.get(path_of(operand), (0, 0))
        word = _start_of(operand) - first
        return (slot, word) if slot and 0 <= word < WORDS else None

    def words_of(self, operand: object) -> tuple[int | None, ...] | None:
        """Return the eight words of an array that is sent as a command, None for each word that rungs write.

        None if the operand is no such array.
        """
        if not isinstance(operand, (Place, Group)):
            return None
        start = operand.fixed_index if isinstance(operand, Place) else 0
        words = self._constants.get(path_of(operand))
        if words is None or start is None or (isinstance(operand, Group) and operand.indices):
            return None
        return words[start : start + 8] if len(words) >= start + 8 else None

    def constants_at(self, operand: object, length: int) -> tuple[int | None, ...] | None:
        """Return constant words at an operand, of an array that may be shorter than an image."""
        if not isinstance(operand, (Place, Group)) or (isinstance(operand, Group) and operand.indices):
            return None
        start = operand.fixed_index if isinstance(operand, Place) else 0
        words = self._constants.get(path_of(operand))
        is_there = words is not None and start is not None and len(words) >= start + length
        return words[start : start + length] if is_there and words is not None and start is not None else None

    def writes(self, is_rung: bool, line: LoweredLine) -> Iterator[Write]:
        """Yield the writes of a rung, or of a statement."""
        needs = _needs(line) if is_rung else {}
        for step in steps_of(line.nodes):
            for use, operand in zip(step.uses, step.operands, strict=False):
                target = self.target(operand) if use in TARGETS else None
                if target is not None and target[0] in self._slots and not self._hands_on(step, operand):
                    yield from self._written(step, operand, *target, self._place(line), needs.get(target[0]))
            for call in step.operands:
                for operand in call.handed.values() if isinstance(call, AddOnCall) else ():
                    target = self.target(operand)
                    if target is not None:
                        yield Write(self._place(line), target[0], 0, 0, _WORD, known=False)

    def _hands_on(self, step: LoweredStep, operand: object) -> bool:
        """Return whether an instruction copies staged words to the module."""
        source = step.operands[0]
        is_copy = step.name in ("COP", "CPS") and isinstance(source, (Place, Group))
        return is_copy and output_word(operand) is not None and path_of(source) in self._staged

    def _written(
        self,
        step: LoweredStep,
        operand: Place | Group,
        slot: int,
        word: int,
        place: FileLine,
        needs: Write | None,
    ) -> Iterator[Write]:
        plain = Write(place, slot, 0, 0, 0, site=step.site)
        base = replace(needs, place=place, site=step.site) if needs else plain
        bit = operand.bit if isinstance(operand, Place) else None
        if isinstance(bit, Constant):
            mask = 1 << int(bit.value)
            sets, clears = (mask * each for each in _of_bit(step))
            rung = base if step.name in ("OTL", "OTU") else plain  # a false rung acts, too
            yield replace(rung, word=word, sets=sets, clears=clears)
            return
        words = [(at, value) for at in self._computed(step, operand) for value in self._words(step)[:1]]
        options = self._options.word(written_value(step)) if target_of(step) is not None else UNKNOWN_WORD
        for at, value in words or enumerate(self._words(step), word):
            if value is None:
                yield replace(base, word=at, sets=0, clears=_WORD, known=False, value=options)
            else:
                given = WordValue((signed_word(value & _WORD),))
                yield replace(base, word=at, sets=value & _WORD, clears=~value & _WORD, value=given)

    def _computed(self, step: LoweredStep, operand: Place | Group) -> Sequence[int]:
        """Return the words that a computed subscript may name; none if it is constant, or may be any."""
        if not isinstance(operand, Place) or operand.fixed_index is not None or output_word(operand) is None:
            return ()
        index = operand.indices[-1]
        path = index.leaf.path.upper() if isinstance(index, Place) else ""
        found = self._counts.get(step.site, {}).get(path) or self._values.of(index)
        return range(max(0, int(found.least)), min(WORDS - 1, int(found.most)) + 1) if found.is_known else ()

    def _words(self, step: LoweredStep) -> Sequence[int | None]:
        """Return the values of the words that an instruction writes; None for an unknown one."""
        source = step.operands[0]
        if step.name in ("FLL", "COP", "CPS") and isinstance(step.operands[2], Constant):
            length = min(int(step.operands[2].value), 8)
            if step.name == "FLL":
                return [int(source.value) if isinstance(source, Constant) else None] * length
            return (self.constants_at(source, length) or (None,) * 8)[:length]
        if target_of(step) is None:
            return [None] * 8
        written = written_value(step)
        found = ANY if written is None else self._values.of(written)
        return [int(found.least) if found.is_constant and found.whole else None]


def _constants(lowered: LoweredProgram, mentions: Sequence[Mention]) -> Mapping[str, tuple[int | None, ...]]:
    """Return the initial values of arrays of integers by path; None for written words."""
    found: dict[str, list[int | None]] = {
        name: [*tag.initial, *[0] * (count_of(tag.dims) - len(tag.initial))]  # the rest is zeros
        for name, tag in lowered.layout.tags().items()
        if isinstance(tag.initial, list) and all(isinstance(each, int) for each in tag.initial)
    }
    for each in mentions:
        name = path_of(each.where)
        if each.writes and name in found:
            at = each.where.fixed_index if isinstance(each.where, Place) else None
            whole = at is None or each.stretch
            for index in range(at or 0, len(found[name])) if whole else (at or 0,):
                found[name][index] = None
    return {name: tuple(words) for name, words in found.items()}


def _needs(line: LoweredLine) -> dict[int, Write]:
    """Return, by slot, the contacts in series with the whole rung."""
    status: dict[int, int] = {}
    command: dict[int, int] = {}
    first = False
    for step in line.nodes:
        if not isinstance(step, LoweredStep) or step.name != "XIC" or not isinstance(step.operands[0], Place):
            continue
        place = step.operands[0]
        first = first or place.leaf.path == "S:FS"
        slot = place.leaf.slot
        if slot is not None and place.fixed_index == 0 and isinstance(place.bit, Constant):
            bits = command if place.leaf.output else status
            bits[slot] = bits.get(slot, 0) | 1 << int(place.bit.value)
    slots = range(1, 256) if first else {*status, *command}
    return {
        slot: Write(FileLine("", 0), slot, 0, 0, 0, True, first, status.get(slot, 0), command.get(slot, 0))
        for slot in slots
    }


def _of_bit(step: LoweredStep) -> tuple[bool, bool]:
    """Return whether a bit instruction may set, and may clear, its bit."""
    if step.name == ":=" and isinstance(step.operands[1], Constant):
        return bool(step.operands[1].value), not step.operands[1].value
    return step.name != "OTU", step.name != "OTL"


def _start_of(operand: Place | Group) -> int:
    return (operand.fixed_index or 0) if isinstance(operand, Place) else 0


def output_word(operand: object) -> tuple[int, int] | None:
    """Return slot and first word of an operand in an output image, or None."""
    if not isinstance(operand, (Place, Group)):
        return None
    leaf = first_leaf(operand)
    if leaf.slot is None or not leaf.output or not leaf.is_image:
        return None
    at = operand.fixed_index if isinstance(operand, Place) else 0
    return leaf.slot, at or 0


def path_of(operand: Place | Group, *, as_written: bool = False) -> str:
    """Return the path of a tag, in capitals unless as written."""
    path = operand.leaf.path if isinstance(operand, Place) else operand.path
    return path if as_written else path.upper()
