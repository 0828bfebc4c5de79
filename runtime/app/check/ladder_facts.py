"""Facts of a ladder program: what its rungs write to the 3601s, and which tags and terminals they name.

A write of output word 0 sets bits and clears bits:

    instruction              sets            clears
    OTE(bit), bit := tag     the bit         the bit
    OTL(bit), bit := 1       the bit         none
    OTU(bit), bit := 0       none            the bit
    MOV, FLL, := a constant  its bits        the others
    CLR                      none            all
    COP, CPS of constants    their bits      the others
    anything else            not known: none all

Constants are the initial values of words that no instruction writes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from pathlib import Path

from ....io_images.amci3601 import CommandMsw, Firmware, Parameters, StatusMsw
from ....io_images.amci3601.configuration import check
from ....io_images.amci3601.parameters import RATE_MAX, SPEED_MAX
from ....io_images.amci3601.rules import RULES
from ....io_images.amci3601.words import is_stepper
from ....io_images.thousands import PARAMETER_MAX, PARAMETER_MIN
from ....ladder import LadderLogic
from ....ladder.debug import cross_reference
from ....ladder.debug.crossref import TARGETS, Mention
from ....ladder.lowered import AddOnCall, Line, Lowered, Step, steps_of
from ....ladder.operands import Constant, Group, first_leaf
from ....ladder.operands import Place as Operand
from ....ladder.tags import tag_in
from ....ladder.types import count_of
from ...config.rackspec import RackSpec
from .facts import Facts, Place, Remark, Sent, UsesBit

_WORD = 0xFFFF
_MODE_CONFIG = CommandMsw.MODE_CONFIG.value
_SEARCHES = (CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW).value
_MOVES = (CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE).value
_COMMANDS = [bit for bit in CommandMsw if bit not in (CommandMsw.MODE_CONFIG, CommandMsw.RESERVED_14)]

ELSEWHERE = (
    StatusMsw.MODE_CONFIG | StatusMsw.CONFIG_ERROR | StatusMsw.COMMAND_ERROR | StatusMsw.POSITION_INVALID
).value
"""Status bits of start-up and trouble: a rung that needs one of them takes no command back in between."""

WORD_RANGES = {
    2: (-8388, 8388),
    3: (-999, 999),
    4: (0, 1000),
    5: (0, 999),
    6: (0, RATE_MAX),
    7: (0, RATE_MAX),
}
"""Output words 2 to 7: what a single word may be in any command, 0 included [chapter 5, notes 4 to 8]."""

PARAMETER_RANGES = {
    "POSITION": (PARAMETER_MIN, PARAMETER_MAX),
    "DISTANCE": (PARAMETER_MIN, PARAMETER_MAX),
    "VELOCITY": (-SPEED_MAX, SPEED_MAX),
    "ACCELERATION": (1, RATE_MAX),
    "DECELERATION": (1, RATE_MAX),
}
"""Parameters of the motion blocks by name."""

BLOCKS = frozenset(
    {
        "MC_MOVEABSOLUTE",
        "MC_MOVERELATIVE",
        "MC_MOVEVELOCITY",
        "MC_HOME",
        "MC_SETPOSITION",
        "MC_GEARIN",
        "MOVEREGISTRATION3601",
    }
)
"""The blocks of `USE axis3601` that have them."""

_NEUTRAL = (0, 0, 0, 0, 1, 0, 1, 1)
"""Legal parameters, in place of words that are not known."""


@dataclass(frozen=True, slots=True)
class Write:
    """An instruction that writes an output word of a 3601.

    Attributes:
        place: where.
        slot: the slot.
        word: 0 to 7.
        sets: bits that it may set.
        clears: bits that it may clear.
        known: whether the bits that it sets are known.
        first_scan: whether its rung needs the first scan.
        status: bits of input word 0 that its rung needs.
        command: bits of output word 0 that its rung needs.
    """

    place: Place
    slot: int
    word: int
    sets: int
    clears: int
    known: bool = True
    first_scan: bool = False
    status: int = 0
    command: int = 0

    def takes_back(self, bit: int) -> bool:
        """Whether this clears a command bit after the command has been given."""
        return bool(self.clears & bit) and not (
            self.first_scan or self.status & ELSEWHERE or self.command & ~bit
        )


def ladder_facts(program: LadderLogic, path: Path, spec: RackSpec) -> Facts:
    """Read the facts of a ladder program.

    Args:
        program: the program.
        path: its file, for messages.
        spec: the rack.

    Raises:
        LadderError: it can't be built.
    """
    return _Reader(program, path, spec).facts()


class _Reader:
    def __init__(self, program: LadderLogic, path: Path, spec: RackSpec) -> None:
        self.program, self.path, self.spec = program, path, spec
        self.lowered: Lowered = program.build()
        self.mentions = cross_reference(self.lowered).mentions
        self.slots = {slot.number: slot for slot in spec.slot if is_stepper(slot.words)}
        self.constants = _constants(self.lowered, self.mentions)
        self.lines = [
            (routine.body is None, line)
            for routine in self.lowered.routines.values()
            if not routine.frame
            for line in routine.lines
        ]
        self.axes = dict(self._axes())

    def facts(self) -> Facts:
        writes = [each for rungs, line in self.lines for each in self._writes(rungs, line)]
        copies = [each for _, line in self.lines for each in self._copied(line)]
        facts = Facts(
            configurations=[each for each in copies if each.words[0] & _MODE_CONFIG],
            searches=[*self._searches(writes), *self._block_searches()],
            repeated=[
                Remark(_place_in(each.where, self.path), f"{each.text}; {each.remedy}")
                for each in self.program.warnings
            ],
            held=list(_held(writes)),
            out_of_range=[*self._copies_out_of_range(copies), *self._parameters_out_of_range()],
        )
        reported = {each.place for each in facts.out_of_range}
        facts.out_of_range += [each for each in _words_out_of_range(writes) if each.place not in reported]
        facts.configurations += [
            Sent(each.place, each.slot, (each.sets,))
            for each in writes
            if each.word == 0 and each.known and each.sets & _MODE_CONFIG
        ]
        facts.not_seen += _computed(writes)
        self._tags(facts)
        return facts

    # --- tags and terminals

    def _tags(self, facts: Facts) -> None:
        if self.lowered.functions:
            names = ", ".join(self.lowered.functions)
            facts.not_seen.append(f"routines in Python ({names}) may use any tag and any terminal")
            return
        facts.uses_bit = self._uses_bit()
        used = {tag_in(_path(each)).upper() for each in self.mentions}
        for name, tag in self.lowered.layout.tags().items():
            recorded = any(fnmatch(name, pattern.upper()) for pattern in self.spec.tags)
            if name not in used and not recorded:
                text = f"tag {tag.name} is declared, and no instruction names it"
                facts.unused.append(Remark(self._declared(tag.name), text))

    def _declared(self, name: str) -> Place:
        """Return the first line that names a tag: its declaration."""
        word = re.compile(rf"(?<!\w){re.escape(name.rpartition('.')[2])}(?!\w)", re.IGNORECASE)
        text = self.path.read_text("utf-8", errors="replace").splitlines()
        found = (number for number, line in enumerate(text, 1) if word.search(line.partition("//")[0]))
        return Place(str(self.path), next(found, 1))

    def _uses_bit(self) -> UsesBit:
        seen = [(first_leaf(each.where), each) for each in self.mentions]

        def uses(slot: int, image: str, _name: str, word: int, bit: int) -> bool:
            return any(
                leaf.slot == slot
                and leaf.is_image
                and leaf.output is (image == "O")
                and (each.reads if image == "I" else each.writes)
                and _reaches(each, word, bit)
                for leaf, each in seen
            )

        return uses

    # --- what goes to the 3601s

    def _axes(self) -> Iterator[tuple[str, int]]:
        """Yield the axes of motion blocks with their slots: Amci3601 joins the two."""
        for _, _, call in self._calls():
            outputs = call.handed.get("OUTPUTS")
            if call.name == "AMCI3601" and outputs is not None:
                slot = first_leaf(outputs).slot
                if slot is not None:
                    yield call.handed["AXIS"].text.upper(), slot

    def _calls(self) -> Iterator[tuple[Place, Step, AddOnCall]]:
        for _, line in self.lines:
            for step in steps_of(line.nodes):
                for operand in step.operands:
                    if isinstance(operand, AddOnCall):
                        yield self._place(line), step, operand

    def _place(self, line: Line) -> Place:
        return Place(line.origin.file or str(self.path), line.origin.line or 1)

    def _block_searches(self) -> Iterator[Sent]:
        for place, _, call in self._calls():
            if call.name == "MC_HOME":
                yield Sent(place, self.axes.get(call.handed["AXIS"].text.upper()))

    def _searches(self, writes: Sequence[Write]) -> Iterator[Sent]:
        for each in writes:
            if each.word == 0 and each.sets & _SEARCHES and not each.sets & _MODE_CONFIG:
                yield Sent(each.place, each.slot)

    def _copied(self, line: Line) -> Iterator[Sent]:
        """Yield constants that are copied to all words of a 3601, or handed to a block as configuration."""
        for step in steps_of(line.nodes):
            target = _output_word(step.operands[1]) if step.name in ("COP", "CPS") else None
            if target is not None and target[0] in self.slots and target[1] == 0:
                words = self._words_of(step.operands[0])
                if words is not None and words[0] is not None:
                    yield Sent(self._place(line), target[0], _filled(words))
            for call in step.operands:
                if isinstance(call, AddOnCall) and call.name == "CONFIGURE3601":
                    words = self._words_of(call.handed["CONFIGURATION"])
                    if words is not None and words[0] is not None:
                        slot = self.axes.get(call.handed["AXIS"].text.upper())
                        yield Sent(self._place(line), slot, _filled(words))

    def _words_of(self, operand: object) -> tuple[int | None, ...] | None:
        """Return eight constant words from an operand on, None for each that is written; None if unknown."""
        if not isinstance(operand, (Operand, Group)):
            return None
        start = operand.fixed_index if isinstance(operand, Operand) else 0
        words = self.constants.get(_where(operand))
        if words is None or start is None or (isinstance(operand, Group) and operand.indices):
            return None
        return words[start : start + 8] if len(words) >= start + 8 else None

    def _writes(self, is_rung: bool, line: Line) -> Iterator[Write]:
        needs = _needs(line) if is_rung else {}
        for step in steps_of(line.nodes):
            for use, operand in zip(step.uses, step.operands, strict=False):
                target = _output_word(operand) if use in TARGETS else None
                if target is not None and target[0] in self.slots:
                    yield from self._written(step, operand, *target, self._place(line), needs.get(target[0]))
            for call in step.operands:
                for operand in call.handed.values() if isinstance(call, AddOnCall) else ():
                    target = _output_word(operand)
                    if target is not None:
                        yield Write(self._place(line), target[0], 0, 0, _WORD, known=False)

    def _written(
        self, step: Step, operand: Operand | Group, slot: int, word: int, place: Place, needs: Write | None
    ) -> Iterator[Write]:
        base = replace(needs, place=place) if needs else Write(place, slot, 0, 0, 0)
        bit = operand.bit if isinstance(operand, Operand) else None
        if isinstance(bit, Constant):
            mask = 1 << int(bit.value)
            sets, clears = (mask * each for each in _of_bit(step))
            rung = (
                base if step.name in ("OTL", "OTU") else Write(place, slot, 0, 0, 0)
            )  # a false rung acts, too
            yield replace(rung, word=word, sets=sets, clears=clears)
            return
        for at, value in enumerate(self._values(step), word):
            if value is None:
                yield replace(base, word=at, sets=0, clears=_WORD, known=False)
            else:
                yield replace(base, word=at, sets=value & _WORD, clears=~value & _WORD)

    def _values(self, step: Step) -> Sequence[int | None]:
        """Return the values of the words that an instruction writes; None for an unknown one."""
        source = step.operands[0]
        if step.name == "CLR":
            return [0]
        if step.name == "MOV" and isinstance(source, Constant):
            return [int(source.value)]
        if step.name == ":=" and isinstance(step.operands[1], Constant):
            return [int(step.operands[1].value)]
        if step.name in ("FLL", "COP", "CPS") and isinstance(step.operands[2], Constant):
            length = min(int(step.operands[2].value), 8)
            if step.name == "FLL":
                return [int(source.value) if isinstance(source, Constant) else None] * length
            return (self._words_of(source) or (None,) * 8)[:length]
        return [None] * 8

    # --- ranges

    def _copies_out_of_range(self, copies: Sequence[Sent]) -> Iterator[Remark]:
        for each in copies:
            if each.words[0] & _MODE_CONFIG:
                version = self.slots[each.slot].firmware if each.slot in self.slots else "4.1"
                for rule in check(each.words, Firmware.parse(version)):
                    yield Remark(each.place, f"the configuration is invalid: {RULES[rule].clause}")
            elif each.words[0] & _MOVES:
                yield from (Remark(each.place, text) for text in _illegal(Parameters.read(each.words)))

    def _parameters_out_of_range(self) -> Iterator[Remark]:
        tags = self.lowered.layout.tags()
        for _, line in self.lines:
            for step in steps_of(line.nodes):
                if step.name != "MOV" or not isinstance(step.operands[0], Constant):
                    continue
                path = step.operands[1].leaf.path.upper()
                tag = tags.get(tag_in(path))
                if tag is None or getattr(tag.type, "name", "").upper() not in BLOCKS:
                    continue
                least, most = PARAMETER_RANGES.get(path.rpartition(".")[2], (None, None))
                value = step.operands[0].value
                if least is not None and most is not None and not least <= value <= most:
                    text = f"{step.operands[1].text} is {value}: allowed are {least} to {most}"
                    yield Remark(self._place(line), text)


def _constants(lowered: Lowered, mentions: Sequence[Mention]) -> Mapping[str, tuple[int | None, ...]]:
    """Return the initial values of arrays of integers by path; None for words that are written."""
    found: dict[str, list[int | None]] = {
        name: [*tag.initial, *[0] * (count_of(tag.dims) - len(tag.initial))]  # the rest is zeros
        for name, tag in lowered.layout.tags().items()
        if isinstance(tag.initial, list) and all(isinstance(each, int) for each in tag.initial)
    }
    for each in mentions:
        name = _path(each).upper()
        if each.writes and name in found:
            at = each.where.fixed_index if isinstance(each.where, Operand) else None
            whole = at is None or each.stretch
            for index in range(at or 0, len(found[name])) if whole else (at or 0,):
                found[name][index] = None
    return {name: tuple(words) for name, words in found.items()}


def _filled(words: Sequence[int | None]) -> tuple[int, ...]:
    """Return words with legal values in place of unknown ones, and of the other half of their number."""
    filled = [neutral if word is None else word for word, neutral in zip(words, _NEUTRAL, strict=True)]
    for msw in (2, 4):
        if words[msw] is None or words[msw + 1] is None:
            filled[msw : msw + 2] = 0, 1
    return tuple(filled)


def _needs(line: Line) -> dict[int, Write]:
    """Return by slot what the contacts in series with the whole rung need."""
    status: dict[int, int] = {}
    command: dict[int, int] = {}
    first = False
    for step in line.nodes:
        if not isinstance(step, Step) or step.name != "XIC" or not isinstance(step.operands[0], Operand):
            continue
        place = step.operands[0]
        first = first or place.leaf.path == "S:FS"
        slot = place.leaf.slot
        if slot is not None and place.fixed_index == 0 and isinstance(place.bit, Constant):
            bits = command if place.leaf.output else status
            bits[slot] = bits.get(slot, 0) | 1 << int(place.bit.value)
    slots = range(1, 256) if first else {*status, *command}
    return {
        slot: Write(Place("", 0), slot, 0, 0, 0, True, first, status.get(slot, 0), command.get(slot, 0))
        for slot in slots
    }


def _of_bit(step: Step) -> tuple[bool, bool]:
    """Return whether an instruction that writes a bit may set it, and whether it may clear it."""
    if step.name == ":=" and isinstance(step.operands[1], Constant):
        return bool(step.operands[1].value), not step.operands[1].value
    return step.name != "OTU", step.name != "OTL"


def _output_word(operand: object) -> tuple[int, int] | None:
    """Return slot and first word of an operand in an output image; None if it is in none."""
    if not isinstance(operand, (Operand, Group)):
        return None
    leaf = first_leaf(operand)
    if leaf.slot is None or not leaf.output or not leaf.is_image:
        return None
    at = operand.fixed_index if isinstance(operand, Operand) else 0
    return leaf.slot, at or 0


def _held(writes: Sequence[Write]) -> Iterator[Remark]:
    """Yield the first instruction that sets a command bit which nothing takes back."""
    for slot in dict.fromkeys(each.slot for each in writes):
        own = [each for each in writes if each.slot == slot and each.word == 0]
        for bit in _COMMANDS:
            setting = [e for e in own if e.known and e.sets & bit.value and not e.sets & _MODE_CONFIG]
            if setting and not any(each.takes_back(bit.value) for each in own):
                text = f"slot {slot}: {bit.name} is set here, and nothing takes it back after the command"
                yield Remark(setting[0].place, text)


def _computed(writes: Sequence[Write]) -> Iterator[str]:
    """Yield for each slot the first instruction whose words are not constants."""
    slots = set()
    for each in writes:
        if not each.known and each.slot not in slots:
            slots.add(each.slot)
            where = f"{each.place.file}:{each.place.line}"
            yield f"slot {each.slot}: output words that the program computes or a block writes, as in {where}"


def _words_out_of_range(writes: Sequence[Write]) -> Iterator[Remark]:
    for each in writes:
        if not each.known or each.word not in WORD_RANGES:
            continue
        value = each.sets - (1 << 16) * (each.sets >> 15)
        least, most = WORD_RANGES[each.word]
        if not least <= value <= most:
            text = f"slot {each.slot}: output word {each.word} is {value}: allowed are {least} to {most}"
            yield Remark(each.place, text)


def _illegal(parameters: Parameters) -> Iterator[str]:
    if not parameters.target_in_range:
        yield f"the move's target is {parameters.target}: allowed are {PARAMETER_MIN} to {PARAMETER_MAX}"
    if not parameters.speed_in_range:
        yield f"the move's speed is {parameters.speed}: allowed are 1 to {SPEED_MAX}"
    if not parameters.rates_in_range:
        rates = f"{parameters.acceleration} and {parameters.deceleration}"
        yield f"the move's acceleration and deceleration are {rates}: allowed are 1 to {RATE_MAX}"


def _reaches(mention: Mention, word: int, bit: int) -> bool:
    where = mention.where
    if isinstance(where, Group):
        return True
    at = where.fixed_index
    if at is None or (mention.stretch and at <= word):
        return True
    return at == word and (not isinstance(where.bit, Constant) or where.bit.value == bit)


def _path(mention: Mention) -> str:
    return _where(mention.where, as_written=True)


def _where(operand: Operand | Group, *, as_written: bool = False) -> str:
    path = operand.leaf.path if isinstance(operand, Operand) else operand.path
    return path if as_written else path.upper()


def _place_in(where: str, path: Path) -> Place:
    """Return file and line of a problem, which begins with them."""
    found = re.match(r"(.+?):(\d+): ", where)
    return Place(found[1], int(found[2])) if found else Place(str(path), 1)
