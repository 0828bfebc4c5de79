"""Facts of a ladder program: its writes to the 3601s, and the tags and terminals that it names."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from pathlib import Path

from ...io_images.amci3601 import CommandMsw, Firmware, Parameters
from ...io_images.amci3601.configuration import check
from ...io_images.amci3601.parameters import RATE_MAX, SPEED_MAX
from ...io_images.amci3601.rules import RULES
from ...io_images.amci3601.words import is_stepper
from ...io_images.thousands import PARAMETER_MAX, PARAMETER_MIN
from ...ladder import LadderLogic
from ...ladder.debug import cross_reference
from ...ladder.debug.crossref import Mention
from ...ladder.model.chart_checks import unreached
from ...ladder.model.operands import Constant, Group, Place, first_leaf
from ...ladder.model.tags import tag_in
from ...ladder.state.lowered import AddOnCall, LoweredLine, LoweredProgram, LoweredStep, steps_of
from ...runtime.config.rackspec import RackSpec
from .facts import Facts, FileLine, Remark, SentCommand, UsesBit
from .output_writes import MODE_CONFIG, Write, WriteReader, computed, held, path_of, words_out_of_range

_SEARCHES = (CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW).value
_MOVES = (CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE).value

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
"""Blocks of `USE axis3601` with these parameters."""


_NEUTRAL = (0, 0, 0, 0, 1, 0, 1, 1)
"""Legal parameters, in place of unknown words."""


def ladder_facts(program: LadderLogic, path: Path, spec: RackSpec) -> Facts:
    """Read the facts of a ladder program; LadderError if it can't be built.

    Args:
        path: its file, for messages.
    """
    return _Reader(program, path, spec).facts()


class _Reader:
    def __init__(self, program: LadderLogic, path: Path, spec: RackSpec) -> None:
        self.program, self.path, self.spec = program, path, spec
        self.lowered: LoweredProgram = program.build()
        self.mentions = cross_reference(self.lowered).mentions
        self.cards = {slot.number: slot.words for slot in spec.slot}
        self.slots = {slot.number: slot for slot in spec.slot if is_stepper(slot.words)}
        self.writes = WriteReader(self.lowered, self.mentions, self.slots, self._place)
        self.lines = [
            (routine.body is None, line)
            for routine in self.lowered.routines.values()
            if not routine.frame
            for line in routine.lines
        ]
        self.axes = dict(self._axes())

    def facts(self) -> Facts:
        writes = [each for rungs, line in self.lines for each in self.writes.writes(rungs, line)]
        copies = [each for _, line in self.lines for each in self._copied(line)]
        facts = Facts(
            configurations=[each for each in copies if each.words[0] & MODE_CONFIG],
            searches=[*self._searches(writes), *self._block_searches()],
            repeated=[
                Remark(
                    FileLine(each.site.file or str(self.path), each.site.line or 1),
                    f"{each.text}; {each.remedy}",
                )
                for each in self.program.warnings
            ],
            held=list(held(writes)),
            unreached=list(self._unreached()),
            misplaced=list(self._misplaced()),
            out_of_range=[*self._copies_out_of_range(copies), *self._parameters_out_of_range()],
        )
        reported = {each.place for each in facts.out_of_range}
        facts.out_of_range += [each for each in words_out_of_range(writes) if each.place not in reported]
        facts.configurations += [
            SentCommand(each.place, each.slot, (each.sets,))
            for each in writes
            if each.word == 0 and each.known and each.sets & MODE_CONFIG
        ]
        facts.not_seen += computed(writes)
        self._tags(facts)
        return facts

    def _unreached(self) -> Iterator[Remark]:
        for routine in self.program.routines:
            origins = {each.number: each.origin for each in routine.chart.steps} if routine.chart else {}
            for each in unreached(routine.chart) if routine.chart else ():
                origin = origins[each.number]
                text = f"{each.text}, in chart {routine.name}; only SFR can reach it"
                yield Remark(FileLine(origin.file or str(self.path), origin.line or 1), text)

    # --- tags and terminals

    def _misplaced(self) -> Iterator[Remark]:
        """Yield the instructions with a bit of a card that is not a terminal."""
        for _, line in self.lines:
            for step in steps_of(line.nodes):
                for operand in step.operands:
                    text = self._no_terminal(operand) if isinstance(operand, Place) else ""
                    if text:
                        yield Remark(self._place(line), text)

    def _no_terminal(self, operand: Place) -> str:
        """Return that a bit is no terminal of its card; empty if it is one, or if that is unknown."""
        leaf, bit, word = operand.leaf, operand.bit, operand.fixed_index
        slot = leaf.slot
        if slot is None or slot not in self.cards or not leaf.is_image:
            return ""
        if word is None or not isinstance(bit, Constant):
            return ""
        there = self.cards[slot].terminals_instead("O" if leaf.output else "I", word, int(bit.value))
        return f"{operand.text}: the card in slot {slot} has {there}" if there else ""

    def _tags(self, facts: Facts) -> None:
        if self.lowered.functions:
            names = ", ".join(self.lowered.functions)
            facts.not_seen.append(f"routines in Python ({names}) may use any tag and any terminal")
            return
        facts.uses_bit = self._uses_bit()
        used = {tag_in(path_of(each.where, as_written=True)).upper() for each in self.mentions}
        for name, tag in self.lowered.layout.tags().items():
            recorded = any(fnmatch(name, pattern.upper()) for pattern in self.spec.tags)
            if name not in used and not recorded:
                text = f"tag {tag.name} is declared, and no instruction names it"
                facts.unused.append(Remark(self._declared(tag.name), text))

    def _declared(self, name: str) -> FileLine:
        """Return the first line that names a tag: its declaration."""
        word = re.compile(rf"(?<!\w){re.escape(name.rpartition('.')[2])}(?!\w)", re.IGNORECASE)
        text = self.path.read_text("utf-8", errors="replace").splitlines()
        found = (number for number, line in enumerate(text, 1) if word.search(line.partition("//")[0]))
        return FileLine(str(self.path), next(found, 1))

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

    # --- writes to the 3601s

    def _axes(self) -> Iterator[tuple[str, int]]:
        """Yield the axes of motion blocks with their slots: Amci3601 joins the two."""
        for _, _, call in self._calls():
            outputs = call.handed.get("OUTPUTS")
            if call.name == "AMCI3601" and outputs is not None:
                slot = first_leaf(outputs).slot
                if slot is not None:
                    yield call.handed["AXIS"].text.upper(), slot

    def _calls(self) -> Iterator[tuple[FileLine, LoweredStep, AddOnCall]]:
        for _, line in self.lines:
            for step in steps_of(line.nodes):
                for operand in step.operands:
                    if isinstance(operand, AddOnCall):
                        yield self._place(line), step, operand

    def _place(self, line: LoweredLine) -> FileLine:
        return FileLine(line.origin.file or str(self.path), line.origin.line or 1)

    def _block_searches(self) -> Iterator[SentCommand]:
        for place, _, call in self._calls():
            if call.name == "MC_HOME":
                yield SentCommand(place, self.axes.get(call.handed["AXIS"].text.upper()))

    def _searches(self, writes: Sequence[Write]) -> Iterator[SentCommand]:
        for each in writes:
            if each.word == 0 and each.sets & _SEARCHES and not each.sets & MODE_CONFIG:
                yield SentCommand(each.place, each.slot)

    def _copied(self, line: LoweredLine) -> Iterator[SentCommand]:
        """Yield constants that are copied to all words of a 3601, or passed to a block as configuration."""
        for step in steps_of(line.nodes):
            target = self.writes.target(step.operands[1]) if step.name in ("COP", "CPS") else None
            if target is not None and target[0] in self.slots and target[1] == 0:
                words = self.writes.words_of(step.operands[0])
                if words is not None and words[0] is not None:
                    yield SentCommand(self._place(line), target[0], _filled(words))
            for call in step.operands:
                if isinstance(call, AddOnCall) and call.name == "CONFIGURE3601":
                    words = self.writes.words_of(call.handed["CONFIGURATION"])
                    if words is not None and words[0] is not None:
                        slot = self.axes.get(call.handed["AXIS"].text.upper())
                        yield SentCommand(self._place(line), slot, _filled(words))

    # --- ranges

    def _copies_out_of_range(self, copies: Sequence[SentCommand]) -> Iterator[Remark]:
        for each in copies:
            if each.words[0] & MODE_CONFIG:
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


def _filled(words: Sequence[int | None]) -> tuple[int, ...]:
    """Replace unknown words, and the other half of their number, by legal values."""
    filled = [neutral if word is None else word for word, neutral in zip(words, _NEUTRAL, strict=True)]
    for msw in (2, 4):
        if words[msw] is None or words[msw + 1] is None:
            filled[msw : msw + 2] = 0, 1
    return tuple(filled)


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
