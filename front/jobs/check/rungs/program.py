"""Facts of a ladder program: its writes to the 3601s, its tags and terminals, its conditions and routines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from pathlib import Path

from ....io_images.amci3601 import CommandMsw, Firmware, Parameters
from ....io_images.amci3601.configuration import check
from ....io_images.amci3601.parameters import RATE_MAX, SPEED_MAX
from ....io_images.amci3601.rules import RULES
from ....io_images.amci3601.words import is_stepper
from ....io_images.site import Site
from ....io_images.thousands import PARAMETER_MAX, PARAMETER_MIN, join_thousands
from ....ladder import LadderLogic
from ....ladder.debug import cross_reference
from ....ladder.debug.crossref import Mention, mentions_of
from ....ladder.model.chart_checks import unreached
from ....ladder.model.operands import Constant, Group, Place, first_leaf
from ....ladder.model.spec import Use
from ....ladder.model.tags import SlotAlias, tag_in
from ....ladder.state.lowered import AddOnCall, LoweredLine, LoweredProgram, steps_of
from ....runtime.config.rackspec import RackSpec
from ...load.program import EXPORT_SUFFIXES
from ..facts import Command, Facts, FileLine, Remark, SentCommand, UsesBit
from ..logic import AllOf, never
from ..ranges import exactly
from .accesses import Variables, accesses_of, declaration_lines
from .blocks import OWNER, BlockCall, block_calls, commands_of, slots_of
from .mistakes import Mistakes
from .output_writes import (
    MODE_CONFIG,
    Write,
    WriteReader,
    computed,
    held,
    output_word,
    path_of,
    words_out_of_range,
)
from .structure import Structure, own_routines
from .values import Values
from .walk import Point, Walker

_SEARCHES = (CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW).value
_MOVES = (CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE).value

_KINDS = {
    CommandMsw.ABSOLUTE_MOVE.value: "move_to",
    CommandMsw.RELATIVE_MOVE.value: "move_by",
    CommandMsw.FIND_HOME_CW.value: "home",
    CommandMsw.FIND_HOME_CCW.value: "home",
    CommandMsw.RUN_BLEND_CW.value: "run_blend",
    CommandMsw.RUN_BLEND_CCW.value: "run_blend",
    CommandMsw.PRESET_POSITION.value: "set_position",
    CommandMsw.MANUAL_CW.value: "run",
    CommandMsw.MANUAL_CCW.value: "run",
}
"""Commands by their bit of output word 0."""

BLOCK_RANGES = {
    "POSITION": (PARAMETER_MIN, PARAMETER_MAX),
    "DISTANCE": (PARAMETER_MIN, PARAMETER_MAX),
    "VELOCITY": (-SPEED_MAX, SPEED_MAX),
    "ACCELERATION": (0, RATE_MAX),
    "DECELERATION": (0, RATE_MAX),
}
"""Parameters of the motion blocks that a program may also write itself, by name."""

_NEUTRAL = (0, 0, 0, 0, 1, 0, 1, 1)
"""Legal parameters, in place of unknown words."""


def ladder_facts(program: LadderLogic, path: Path, spec: RackSpec) -> Facts:
    """Read the facts of a ladder program; LadderError if it can't be built.

    Args:
        path: its file, for messages.
    """
    return _ProgramReader(program, path, spec).facts()


class _ProgramReader:
    def __init__(self, program: LadderLogic, path: Path, spec: RackSpec) -> None:
        self.program, self.path, self.spec = program, path, spec
        self.lowered: LoweredProgram = program.build()
        self.mentions = cross_reference(self.lowered).mentions
        self.declared = declaration_lines(path)
        self.cards = {slot.number: slot.words for slot in spec.slot}
        self.slots = {slot.number: slot for slot in spec.slot if is_stepper(slot.words)}
        self.writes = WriteReader(self.lowered, self.mentions, self.slots, self._place)
        self.tags = self.lowered.layout.tags()
        every = [step for routine in self.lowered.routines.values() for line in routine.lines
                 for step in steps_of(line.nodes)]  # fmt: skip
        self.values = Values(every, self.mentions, self.tags, self.lowered.presets)
        self.walker = Walker(self.values)
        self.routines = own_routines(program, self.lowered)
        self.points = [
            (each, self._place(each.line)) for own in self.routines for each in self.walker.points(own)
        ]
        self.main = [each for each in self.points if not each[0].routine.frame]
        self.lines = [
            (routine.body is None, line)
            for routine in self.lowered.routines.values()
            if not routine.frame
            for line in routine.lines
        ]
        self.calls = list(block_calls(self.main))
        self.axes = slots_of(self.calls)
        self.owners = self._owners()
        self.stubbed = {str(getattr(each, "to", "")).upper() for each in spec.stubs.values()}

    def facts(self) -> Facts:
        facts = Facts(reads_all=bool(self.lowered.functions))
        writes = [each for rungs, line in self.lines for each in self.writes.writes(rungs, line)]
        copies = [each for _, line in self.lines for each in self._copied(line)]
        facts.configurations = [
            *(each for each in copies if each.words[0] & MODE_CONFIG),
            *(
                SentCommand(each.place, each.slot, (each.sets,))
                for each in writes
                if each.word == 0 and each.known and each.sets & MODE_CONFIG
            ),
        ]
        facts.searches = [*self._searches(writes), *self._block_searches()]
        for each in self.program.warnings:
            place = FileLine(each.site.file or str(self.path), each.site.line or 1)
            facts.remark(each.rule or "repeated-coil", place, each.text)
        facts.remarks["unreached-step"] += self._unreached()
        facts.remarks["command-held"] += held(writes)
        facts.remarks["no-place"] += self._misplaced()
        out_of_range = [*self._copies_out_of_range(copies), *self._parameters_out_of_range()]
        reported = {each.place for each in out_of_range}
        out_of_range += [each for each in words_out_of_range(writes) if each.place not in reported]
        facts.remarks["out-of-range"] += out_of_range
        facts.not_seen += computed(writes)
        facts.computed = {
            each.slot for each in writes if not each.known and each.word < 2
        } | self.writes.staged
        facts.at_once = list(self._at_once())
        facts.commands = [
            *commands_of(self.calls, self.axes, self.values, self.owners),
            *self._sent(writes, copies),
        ]
        for routine in self.routines:
            for line in routine.lines:
                place = self._place(line)
                site = Site(
                    self.lowered.name,
                    routine.name,
                    line.number,
                    unit=routine.unit,
                    file=place.file,
                    line=place.line,
                )
                facts.sites.setdefault(place, site)
        self._tags(facts)
        self._text(facts)
        self._blocks(facts)
        self._instances(facts)
        return facts

    def _unreached(self) -> Iterator[Remark]:
        for routine in self.program.routines:
            origins = {each.number: each.origin for each in routine.chart.steps} if routine.chart else {}
            for each in unreached(routine.chart) if routine.chart else ():
                origin = origins[each.number]
                text = f"{each.text}, in chart {routine.name}; only SFR can reach it"
                yield Remark(FileLine(origin.file or str(self.path), origin.line or 1), text)

    # --- the text

    def _owners(self) -> dict[str, str]:
        """Return the task of each program, in capitals; none if there is one task."""
        schedule = self.lowered.schedule
        tasks = [each for each in schedule.tasks if each.programs] if schedule is not None else []
        if len(tasks) < 2:
            return {}
        return {program.name.upper(): each.task.name for each in tasks for program in each.programs}

    def _text(self, facts: Facts) -> None:
        """Note accesses, and the mistakes of instructions and routines."""
        outside = frozenset(
            path_of(each.where).partition(".")[2]
            for point, _ in self.main
            for each in mentions_of(self.lowered.sites[point.step.site], point.step)
            if each.writes
        )
        variables = Variables(self.lowered, self.path, self._is_recorded, outside)
        facts.variables = variables.found
        for point, place in self.points:
            facts.accesses += accesses_of(point, self.lowered, variables, place, self.owners)
        read = frozenset(
            path_of(each.where) for each in self.mentions if each.reads and isinstance(each.where, Place)
        )
        mistakes = Mistakes(self.lowered, self.values, facts, read)
        for point, place in self.points:
            mistakes.note(point, place)
        for routine in self.routines:
            for line in routine.lines if routine.body is None else ():
                mistakes.branches(line, self.walker, self._place(line))
        Structure(self.program, self.lowered, facts, str(self.path), self.declared).note(self.routines)

    def _is_recorded(self, tag: str) -> bool:
        if tag.upper() in self.stubbed:
            return True
        return any(
            fnmatch(f"{tag}.".upper(), f"{pattern.upper().partition('.')[0]}.") for pattern in self.spec.tags
        )

    # --- tags and terminals

    def _misplaced(self) -> Iterator[Remark]:
        """Yield the instructions with a bit of a card that is not a terminal, or with a slot that is none."""
        if not self.cards:
            return
        for _, line in self.lines:
            for step in steps_of(line.nodes):
                for operand in step.operands:
                    text = self._no_terminal(operand) if isinstance(operand, Place | Group) else ""
                    if text:
                        yield Remark(self._place(line), text)
        for each in self.lowered.layout.declarations.values():
            if isinstance(each, SlotAlias) and each.slot not in self.cards:
                text = f"SLOT {each.name} : {each.slot}: the rack has modules in {self._there()} only"
                yield Remark(FileLine(str(self.path), self.declared(each.name)), text)
        yield from map(self._wrong_module, self._named_bits())

    def _named_bits(self) -> Iterator[tuple[str, int, FileLine]]:
        """Yield the first use of status, command or configuration bits of a module that has none."""
        seen = set()
        aliases = {name: each.slot for name, each in self.lowered.layout.declarations.items()
                   if isinstance(each, SlotAlias)}  # fmt: skip
        for each in self.mentions:
            name, _, rest = each.text.partition(".")
            slot = aliases.get(name.upper())
            is_named = rest.lower().startswith(("status.", "command.", "config."))
            if slot in self.cards and slot not in self.slots and is_named and slot not in seen:
                seen.add(slot)
                yield each.text, slot, FileLine(str(self.path), self.declared(name))
        for call in self.calls:
            for name, operand in call.call.handed.items() if call.call.name == OWNER else ():
                slot = first_leaf(operand).slot
                if slot is not None and slot in self.cards and slot not in self.slots and slot not in seen:
                    seen.add(slot)
                    yield f"{operand.text} as {name.capitalize()} of Amci3601", slot, call.place

    def _wrong_module(self, use: tuple[str, int, FileLine]) -> Remark:
        text, slot, place = use
        steppers = ", ".join(map(str, self.slots)) or "no slot"
        module = next(each.module for each in self.spec.slot if each.number == slot)
        return Remark(place, f"{text}: slot {slot} has a {module}; a 3601 is in {steppers}")

    def _there(self) -> str:
        return ", ".join(map(str, self.cards))

    def _no_terminal(self, operand: Place | Group) -> str:
        """Return that a bit is no terminal of its card; empty if it is one, or if that is unknown."""
        leaf = first_leaf(operand)
        slot = leaf.slot
        if slot is None or not leaf.is_image:
            return ""
        image = "O" if leaf.output else "I"
        if slot not in self.cards and self.path.suffix in EXPORT_SUFFIXES:
            return ""
        if slot not in self.cards:
            return f"{operand.text}: the rack has modules in slots {self._there()} only"
        bit = operand.bit if isinstance(operand, Place) else None
        word = operand.fixed_index if isinstance(operand, Place) else 0
        if word is None or (bit is not None and not isinstance(bit, Constant)):
            return ""
        there = self.cards[slot].terminals_instead(image, word, 0 if bit is None else int(bit.value))
        if bit is None and not there.startswith("no "):
            return ""
        return f"{operand.text}: the card in slot {slot} has {there}" if there else ""

    def _tags(self, facts: Facts) -> None:
        if self.lowered.functions:
            names = ", ".join(self.lowered.functions)
            facts.not_seen.append(f"routines in Python ({names}) may use any tag and any terminal")
            return
        facts.uses_bit = self._uses_bit()
        used = {tag_in(path_of(each.where, as_written=True)).upper() for each in self.mentions}
        for name, tag in self.tags.items():
            recorded = any(fnmatch(name, pattern.upper()) for pattern in self.spec.tags)
            if name not in used and not recorded:
                place = FileLine(str(self.path), self.declared(tag.name))
                facts.remark("unused-tag", place, f"tag {tag.name} is declared, and no instruction names it")

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

    def _blocks(self, facts: Facts) -> None:
        """Note the calls of motion blocks behind the block that owns their axis."""
        owned: dict[str, BlockCall] = {}
        for each in self.calls:
            before = owned.get(each.axis)
            if before is not None and each.call.name != OWNER:
                text = (
                    f"{each.call.name} asks axis {each.axis} behind Amci3601 of line {before.place.line}: "
                    "what it asks is sent in the next scan"
                )
                if before.point.routine is each.point.routine:
                    facts.remark("block-order", before.place, text)
            if each.call.name == OWNER:
                owned.setdefault(each.axis, each)
        by_slot: dict[int, str] = {}
        for each in self.calls:
            slot = self.axes.get(each.axis)
            if (
                each.call.name == OWNER
                and slot is not None
                and by_slot.setdefault(slot, each.axis) != each.axis
            ):
                text = f"axis {each.axis} gets slot {slot}, which axis {by_slot[slot]} has already"
                facts.remark("no-place", each.place, text)
        for each in self.calls:
            if each.call.name != OWNER and each.axis and each.axis not in owned and not self.lowered.axes:
                text = f"no Amci3601 joins axis {each.axis} with a module: {each.call.name} moves nothing"
                facts.remark("block-order", each.place, text)

    def _instances(self, facts: Facts) -> None:
        """Note the instances of blocks that are called twice in a scan."""
        first: dict[str, tuple[Point, FileLine]] = {}
        for point, place in self.main:
            name = _instance(point)
            before, at = first.setdefault(name, (point, place)) if name else (point, place)
            both = AllOf((before.condition, point.condition))
            if before is not point and (point.is_rung or before.is_rung or not never(both)):
                text = f"{name.capitalize()} is called in line {at.line} already: it runs twice in a scan"
                facts.remark("block-twice", place, text)

    def _sent(self, writes: Sequence[Write], copies: Sequence[SentCommand]) -> Iterator[Command]:
        """Yield the commands that the program writes as words."""
        for each in copies:
            for bit, kind in _KINDS.items():
                if each.words[0] & bit and not each.words[0] & MODE_CONFIG:
                    is_move = each.words[0] & (_MOVES | _SEARCHES) and each.speed is not None
                    values = {"speed": exactly(each.speed or 0)} if is_move else {}
                    yield Command(
                        kind,
                        f"slot {each.slot}",
                        each.slot,
                        each.place,
                        f"the words of {kind}",
                        values,
                        words=True,
                    )
            if len(each.words) > 1 and each.words[1] & 0x0100:
                yield Command(
                    "program_blend",
                    f"slot {each.slot}",
                    each.slot,
                    each.place,
                    "the words of a blend",
                    words=True,
                )
        copied = {(each.place, each.slot) for each in copies}
        for write in writes:
            if write.word == 0 and write.known and (write.place, write.slot) not in copied:
                for bit, kind in _KINDS.items():
                    if write.sets & bit and not write.sets & MODE_CONFIG:
                        yield Command(
                            kind,
                            f"slot {write.slot}",
                            write.slot,
                            write.place,
                            f"output word 0, {kind}",
                            words=True,
                        )
            if write.word == 1 and (write.sets & 0x0100 or not write.known):
                yield Command(
                    "program_blend",
                    f"slot {write.slot}",
                    write.slot,
                    write.place,
                    "output word 1",
                    words=True,
                )
        yield from self._slow_words(writes)

    def _at_once(self) -> Iterator[Remark]:
        """Yield the copies of a command with its parameters that an update may interrupt: CPS is not."""
        for _, line in self.lines:
            written = set()
            for step in steps_of(line.nodes):
                target = (
                    self.writes.target(step.operands[-2 if step.name == "COP" else -1])
                    if step.operands
                    else None
                )
                if (
                    target is None
                    or target[0] not in self.slots
                    or output_word(step.operands[-2 if step.name == "COP" else -1]) is None
                ):
                    continue
                if step.name == "COP":
                    yield Remark(
                        self._place(line), f"COP writes command and parameters of slot {target[0]} at once"
                    )
                elif step.name in ("MOV", "OTE", "OTL", ":="):
                    written.add(target)
            for slot in {slot for slot, word in written if word == 0}:
                if any(other == slot and word > 1 for other, word in written):
                    yield Remark(
                        self._place(line), f"the rung writes command and parameters of slot {slot} at once"
                    )

    def _slow_words(self, writes: Sequence[Write]) -> Iterator[Command]:
        """Yield the speeds that the program writes word by word."""
        for slot in self.slots:
            moves = [
                each
                for each in writes
                if each.slot == slot and each.word == 0 and each.sets & (_MOVES | _SEARCHES)
            ]
            thousands = [each for each in writes if each.slot == slot and each.word == 4]
            units = [each for each in writes if each.slot == slot and each.word == 5]
            if not moves or not units or not all(each.known for each in (*thousands, *units)):
                continue
            high = max((each.sets for each in thousands), default=0)
            for each in units:
                if each.sets or high:
                    speed = {"speed": exactly(1000 * high + each.sets)}
                    yield Command(
                        "move_by", f"slot {slot}", slot, each.place, "output words 4 and 5", speed, words=True
                    )

    def _place(self, line: LoweredLine) -> FileLine:
        return FileLine(line.origin.file or str(self.path), line.origin.line or 1)

    def _block_searches(self) -> Iterator[SentCommand]:
        for each in self.calls:
            if each.call.name == "MC_HOME":
                yield SentCommand(each.place, self.axes.get(each.axis))

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
                    yield SentCommand(self._place(line), target[0], _filled(words), _speed(words))
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
        """Yield the numbers that the program itself writes to parameters of motion blocks."""
        for point, place in self.main:
            step = point.step
            if step.name not in ("MOV", ":=") or point.argument:
                continue
            source, target = step.operands[:2] if step.name == "MOV" else reversed(step.operands[:2])
            if not isinstance(target, Place) or not self._is_block(target):
                continue
            least, most = BLOCK_RANGES.get(target.leaf.path.upper().rpartition(".")[2], (None, None))
            found = self.values.of(source)
            if least is not None and most is not None and found.outside(least, most):
                yield Remark(place, f"{target.text} is {found}: allowed are {least} to {most}")

    def _is_block(self, target: Place) -> bool:
        tag = self.tags.get(tag_in(target.leaf.path).upper())
        return tag is not None and getattr(tag.type, "name", "").upper().startswith(("MC_", "MOVEREG"))


def _speed(words: Sequence[int | None]) -> int | None:
    """Return the speed in words; None if the program writes it elsewhere, or if the words are none."""
    high, low = words[4:6]
    return None if high is None or low is None or abs(low) > 999 else join_thousands(high, low)


def _instance(point: Point) -> str:
    """Return the instance that an instruction runs, in capitals; "" if it runs none."""
    first = point.step.operands[0] if point.step.operands else None
    group = first.instance if isinstance(first, AddOnCall) else first
    if not isinstance(group, Group) or not (isinstance(first, AddOnCall) or Use.BLOCK in point.step.uses):
        return ""
    return "" if any(not isinstance(each, Constant) for each in group.indices) else group.text.upper()


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
