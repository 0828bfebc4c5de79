"""Writes of a ladder program to the output words of 3601s.

A write of output word 0 sets some bits and clears others:

    instruction              sets            clears
    OTE(bit), bit := tag     the bit         the bit
    OTL(bit), bit := 1       the bit         none
    OTU(bit), bit := 0       none            the bit
    MOV, FLL, := a constant  its bits        the others
    CLR                      none            all
    COP, CPS of constants    their bits      the others
    anything else            unknown: none   all

Constants are the initial values of words that no instruction writes.

Words are staged if a COP or CPS copies them to all output words of a 3601 and the program writes the first
word (the command). A write to a staged word counts as a write to the module.

    COP(Setup[0],Words[0],8);  ...  CPS(Words[0],Local:1:O.Data[0],8);
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.image import UNSIGNED_MAX, WORDS, signed_word
from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Constant, Group, Place, first_leaf
from scanrack.ladder.model.types import count_of
from scanrack.ladder.state.lowered import AddOnCall, LoweredLine, LoweredStep, Node

from ..choices import UNKNOWN_CHOICES, Choices
from ..module_kinds import MODE_CONFIG
from ..written import WordWrite
from .number_options import OperandOptions
from .number_ranges import target_of, written_value
from .operands import first_of, path_of, steps_in, written_by
from .view import LadderView

COPIES = ("COP", "CPS")
NOT_IN_OPERATION = (
    StatusMsw.MODE_CONFIG | StatusMsw.CONFIG_ERROR | StatusMsw.COMMAND_ERROR | StatusMsw.POSITION_INVALID
).value
"""Status bits of start-up and faults. A rung that requires one does not clear a command in operation."""


@dataclass(frozen=True, slots=True)
class Write(WordWrite):
    """An instruction that writes to an output word of a 3601.

    Attributes:
        known: whether the set bits are known.
        first_scan: whether its rung requires the first scan.
        status: bits of input word 0 that its rung requires.
        command: bits of output word 0 that its rung requires.
        site: number of the instruction in `LoweredProgram.sites`.
    """

    known: bool = True
    first_scan: bool = False
    status: int = 0
    command: int = 0
    site: int = -1

    @property
    def commands(self) -> int:
        """Command bits that it is known to set; none for a configuration."""
        return self.sets if self.known and self.word == 0 and not self.sets & MODE_CONFIG else 0

    def clears_in_operation(self, bit: int) -> bool:
        """Whether it clears a command bit after the command was sent."""
        is_elsewhere = self.first_scan or self.status & NOT_IN_OPERATION or self.command & ~bit
        return bool(self.clears & bit) and not is_elsewhere


class WriteReader:
    """Reads the writes of a program."""

    def __init__(self, view: LadderView) -> None:
        self._view, self._slots, self._values = view, view.steppers, view.values
        self._constants = _constants(view)
        self._options = OperandOptions(view.values)
        self._staged = dict(self._stages())

    @property
    def staged(self) -> set[int]:
        """Slots with output words that are copied from a tag. The tag's initial values may also be sent."""
        return {slot for slot, _ in self._staged.values()}

    def _stages(self) -> Iterator[tuple[str, tuple[int, int]]]:
        """Yield the paths of tags that are copied to all output words, each with slot and first word."""
        for step in steps_in(*self._view.lowered.routines.values()):
            source = first_of(step, COPIES)
            is_tag = isinstance(source, Place | Group) and output_word(source) is None
            slot = self._whole_image(step) if is_tag else None
            if slot is not None and self._is_written(source):
                yield path_of(source), (slot, _start_of(source) or 0)

    def _whole_image(self, copy: LoweredStep) -> int | None:
        """Return the slot of a 3601 if a copy writes all of its output words; otherwise None."""
        slot, word = output_word(copy.operands[1]) or (0, 0)
        length = copy.operands[2]
        is_whole = isinstance(length, Constant) and length.value >= WORDS and not word
        return slot if is_whole and slot in self._slots else None

    def _is_written(self, source: Place | Group) -> bool:
        """Whether the program writes the first word of an operand, which is the command."""
        words = self.words_of(source)
        return words is None or words[0] is None

    def target(self, operand: object) -> tuple[int, int] | None:
        """Return the slot and first word that a write to an operand or staged word changes, or None."""
        direct = output_word(operand)
        if direct is not None or not isinstance(operand, Place | Group):
            return direct
        slot, first = self._staged.get(path_of(operand), (0, 0))
        index = operand.fixed_index if isinstance(operand, Place) else 0
        word = (index or 0) - first
        return (slot, word) if slot and 0 <= word < WORDS else None

    def words_of(self, operand: object) -> tuple[int | None, ...] | None:
        """Return the eight words of an array that is sent as a command, with None for words that rungs write.

        Return None if the operand is not an array of constants.
        """
        return self.constants_at(operand, WORDS)

    def constants_at(self, operand: object, length: int) -> tuple[int | None, ...] | None:
        """Return `length` constant words starting at an operand; None if there are fewer."""
        if not isinstance(operand, Place | Group):
            return None
        start, words = _start_of(operand), self._constants.get(path_of(operand), ())
        return words[start : start + length] if start is not None and len(words) >= start + length else None

    def writes(self) -> Iterator[Write]:
        """Yield the writes of all rungs and statements."""
        for routine in self._view.own:
            for line in routine.lines:
                yield from self._line_writes(line, is_rung=routine.body is None)

    def _line_writes(self, line: LoweredLine, *, is_rung: bool) -> Iterator[Write]:
        """Yield the writes of a rung or statement.

        An operand that is passed to an add-on instruction by reference may clear the command word.
        """
        place = self._view.place(line)
        for step in line.all_steps:
            for operand in written_by(step):
                slot, word = self.target(operand) or (0, 0)
                if slot in self._slots and not self._is_staged_copy(step, operand):
                    plain = Write(place, slot, word, site=step.site)
                    base = _in_series(line, plain) if is_rung else plain
                    yield from self._operand_writes(step, operand, plain, base)
            for operand in _reference_arguments(step):
                target = self.target(operand)
                if target is not None:
                    slot, _ = target
                    yield Write(place, slot, word=0, clears=UNSIGNED_MAX, known=False)

    def _is_staged_copy(self, step: LoweredStep, operand: object) -> bool:
        """Whether an instruction copies staged words to the module."""
        source = first_of(step, COPIES)
        is_copy = isinstance(source, Place | Group) and output_word(operand) is not None
        return is_copy and path_of(source) in self._staged

    def _operand_writes(
        self, step: LoweredStep, operand: Place | Group, plain: Write, base: Write
    ) -> Iterator[Write]:
        """Yield the writes of an instruction to an operand.

        Args:
            plain: a write of the first word that changes nothing.
            base: the same write, with the conditions of the rung.
        """
        bit = operand.bit if isinstance(operand, Place) else None
        if isinstance(bit, Constant):
            mask = 1 << int(bit.value)
            may_set, may_clear = _bit_effects(step)
            write = base if step.name in ("OTL", "OTU") else plain  # other instructions act on a false rung
            yield replace(write, sets=mask if may_set else 0, clears=mask if may_clear else 0)
            return
        values = self._word_values(step)
        words = self._computed_words(step, operand)
        if words:
            written = [(word, values[0]) for word in words] if values else []
        else:
            written = list(enumerate(values, plain.word))
        options = self._options.word(written_value(step)) if target_of(step) is not None else UNKNOWN_CHOICES
        for word, value in written:
            if value is None:
                yield replace(base, word=word, sets=0, clears=UNSIGNED_MAX, known=False, value=options)
            else:
                bits = value & UNSIGNED_MAX
                choices = Choices((signed_word(bits),))
                yield replace(base, word=word, sets=bits, clears=~bits & UNSIGNED_MAX, value=choices)

    def _computed_words(self, step: LoweredStep, operand: Place | Group) -> Sequence[int]:
        """Return the words that a computed subscript may select; empty if it is constant or unknown."""
        if not isinstance(operand, Place) or operand.fixed_index is not None or output_word(operand) is None:
            return ()
        index = operand.indices[-1]
        counts = self._view.counts.get(step.site, {})
        index_range = counts.get(path_of(index)) if isinstance(index, Place) else None
        index_range = index_range or self._values.range_of(index)
        if not index_range.is_known:
            return ()
        return range(max(0, int(index_range.least)), min(WORDS - 1, int(index_range.most)) + 1)

    def _word_values(self, step: LoweredStep) -> Sequence[int | None]:
        """Return the values of the words that an instruction writes, with None for unknown values."""
        source = first_of(step, ("FLL", *COPIES))
        if source is not None and isinstance(step.operands[2], Constant):
            length = min(int(step.operands[2].value), WORDS)
            if step.name == "FLL":
                return [int(source.value) if isinstance(source, Constant) else None] * length
            return self.constants_at(source, length) or (None,) * length
        written = written_value(step)
        if target_of(step) is None or written is None:
            return [None] * WORDS
        value = self._values.range_of(written)
        return [int(value.least) if value.is_constant and value.whole else None]


def _constants(view: LadderView) -> Mapping[str, tuple[int | None, ...]]:
    """Return the initial values of integer arrays by path, with None for words that are written."""
    constants: dict[str, list[int | None]] = {
        name: [*tag.initial, *[0] * (count_of(tag.dims) - len(tag.initial))]  # the remaining words are zero
        for name, tag in view.tags.items()
        if isinstance(tag.initial, list) and all(isinstance(element, int) for element in tag.initial)
    }
    for mention in view.mentions:
        words = constants.get(path_of(mention.where), []) if mention.writes else []
        for index in _written_at(mention, len(words)):
            words[index] = None
    return {name: tuple(words) for name, words in constants.items()}


def _written_at(mention: Mention, length: int) -> Iterable[int]:
    """Return the elements of an array that an operand may write."""
    index = mention.where.fixed_index if isinstance(mention.where, Place) else None
    if index is None or mention.stretch:
        return range(index or 0, length)
    return (index,) if length else ()


def _reference_arguments(step: LoweredStep) -> Iterator[Place | Group]:
    """Yield the operands that are passed to an add-on instruction by reference."""
    for operand in step.operands:
        if isinstance(operand, AddOnCall):
            yield from operand.handed.values()


def _in_series(line: LoweredLine, write: Write) -> Write:
    """Return a write with the requirements of the contacts in series with the whole rung."""
    status = command = 0
    first_scan = False
    for contact in map(_contact, line.nodes):
        if contact is None:
            continue
        first_scan = first_scan or contact.leaf.path == "S:FS"
        is_word_0 = contact.leaf.slot == write.slot and contact.fixed_index == 0
        if is_word_0 and isinstance(contact.bit, Constant):
            mask = 1 << int(contact.bit.value)
            if contact.leaf.output:
                command |= mask
            else:
                status |= mask
    return replace(write, first_scan=first_scan, status=status, command=command)


def _contact(node: Node) -> Place | None:
    """Return the bit of an XIC that is not inside a branch; None for other nodes."""
    contact = first_of(node, ("XIC",)) if isinstance(node, LoweredStep) else None
    return contact if isinstance(contact, Place) else None


def _bit_effects(step: LoweredStep) -> tuple[bool, bool]:
    """Return whether a bit instruction may set, and may clear, its bit."""
    if step.name == ":=" and isinstance(step.operands[1], Constant):
        return bool(step.operands[1].value), not step.operands[1].value
    return step.name != "OTU", step.name != "OTL"


def _start_of(operand: Place | Group) -> int | None:
    """Return the index of the first element of an operand; None if it is computed."""
    if isinstance(operand, Place):
        return operand.fixed_index
    return None if operand.indices else 0


def output_word(operand: object) -> tuple[int, int] | None:
    """Return the slot and first word of an operand in an output image; None for other operands."""
    if not isinstance(operand, (Place, Group)):
        return None
    leaf = first_leaf(operand)
    if leaf.slot is None or not leaf.output or not leaf.is_image:
        return None
    index = operand.fixed_index if isinstance(operand, Place) else 0
    return leaf.slot, index or 0
