"""The rules of `scanrack check`, one row each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from ...io_images.amci3601 import ALL_INPUTS, InputBit
from ...io_images.amci3601.words import is_stepper
from ...io_images.module_words import BitPlace
from ...ladder import LadderLogic
from ...ladder.python.sequences import Logic
from ...runtime.config.rackfile import load_rack_file
from ...runtime.config.rackspec import SlotSpec
from ...runtime.config.tomllines import KeyLines, KeyPath
from ...runtime.loop.rack import SLOT_BYTES
from ..load.loading import Job, rack_form
from ..load.program import Form
from ..record.tag_source import tags_of
from ..run.hints import not_configured, wired_inputs
from .facts import Facts, FileLine, Remark, SentCommand
from .ladder_facts import ladder_facts
from .python_facts import python_facts
from .sequence_facts import sequence_facts

SIGN_BIT = 15


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that a rack breaks."""

    rule: str
    place: FileLine
    text: str

    def __str__(self) -> str:
        return f"{self.place.file}:{self.place.line}: {self.rule}: {self.text}"


@dataclass(frozen=True, slots=True)
class CheckReport:
    """The result of a check."""

    findings: tuple[Finding, ...]
    not_seen: tuple[str, ...]  # sentences about unknown facts


@dataclass(frozen=True, slots=True)
class Subject:
    """A rack with the facts of its program."""

    job: Job
    facts: Facts
    lines: KeyLines | None  # of the rack file; None for a rack in Python

    def place(self, *path: str | int) -> FileLine:
        """Return file and line of a key of the rack file; line 1 for a rack in Python."""
        key: KeyPath = path
        return FileLine(str(self.job.rack_file), 1 if self.lines is None else self.lines.line(key))

    @property
    def steppers(self) -> Iterator[tuple[int, SlotSpec]]:
        """The slots with the words of a 3601 and a simulated machine, by index in the rack file."""
        for index, slot in enumerate(self.job.spec.slot):
            if is_stepper(slot.words) and not slot.is_live:
                yield index, slot

    def sent_to(self, slot: int, sent: list[SentCommand]) -> list[SentCommand]:
        """Return the words sent to a slot; without any, those of an unknown slot."""
        own = [each for each in sent if each.slot == slot]
        return own or [each for each in sent if each.slot is None]


class Violation(NamedTuple):
    """A finding without its rule."""

    place: FileLine
    text: str


def _not_configured(subject: Subject) -> Iterator[Violation]:
    for index, slot in subject.steppers:
        sent = subject.sent_to(slot.number, subject.facts.configurations)
        used = 0
        for each in sent:
            used |= each.words[0] & ALL_INPUTS
        for bit in InputBit if sent else ():
            if bit.value & wired_inputs(slot.machine) & ~used:
                yield Violation(_wiring(subject, index, slot, bit), not_configured(slot.number, bit))


def _wiring(subject: Subject, index: int, slot: SlotSpec, bit: InputBit) -> FileLine:
    """Return the line of the first part of the machine that acts on an input."""
    machine = slot.machine
    for key in ("switches", "stations", "timeline"):
        for at, part in enumerate(getattr(machine, key)):
            if part.input == bit:
                return subject.place("slot", index, "machine", key, at)
    return subject.place("slot", index, "machine")


def _search_without_switch(subject: Subject) -> Iterator[Violation]:
    without = [
        slot.number
        for _, slot in subject.steppers
        if not wired_inputs(slot.machine) & InputBit.HOME.value and slot.machine.encoder is None
    ]
    numbers = [slot.number for _, slot in subject.steppers]
    for search in subject.facts.searches:
        if search.slot in without or (search.slot is None and without and without == numbers):
            where = f"slot {search.slot}" if search.slot is not None else "the machine"
            yield Violation(
                search.place, f"a home search starts here, but {where} has neither home switch nor encoder"
            )


def _unused_terminals(subject: Subject) -> Iterator[Violation]:
    uses = subject.facts.uses_bit
    for index, slot in enumerate(subject.job.spec.slot if uses is not None else ()):
        for group, verb, name, at in _terminals(slot):
            if uses is not None and not uses(slot.number, at.image, name, at.word, at.bit):
                place = subject.place("slot", index, "options", f"{group}s", name)
                yield Violation(place, f"slot {slot.number}: the program never {verb} {group} {name}")


def _terminals(slot: SlotSpec) -> Iterator[tuple[str, str, str, BitPlace]]:
    """Yield the wired terminals of a card: group, use by a program, name and bit.

    The bit of an analog channel is one of its word: using the word uses the bit.
    """
    words = slot.words
    for group, verb, image, names in (
        ("input", "reads", "I", words.inputs),
        ("output", "writes", "O", words.outputs),
    ):
        for name, at in words.groups.get(group, {}).items():
            yield group, verb, name, at
        channels = [word for of, word in words.profile_words.values() if of == image]
        for word in channels:
            if names[word] != f"ch{word}_data":  # the rack file names it
                yield group, verb, names[word], BitPlace(image, word, SIGN_BIT)


def _unknown_tags(subject: Subject) -> Iterator[Violation]:
    for index, pattern in enumerate(subject.job.spec.tags):
        try:
            tags_of(subject.job.logic, [pattern], bytearray(SLOT_BYTES))
        except ValueError as error:
            yield Violation(subject.place("tags", index), str(error))


def _remarks(field: str) -> Callable[[Subject], Iterator[Violation]]:
    def found(subject: Subject) -> Iterator[Violation]:
        remarks: list[Remark] = getattr(subject.facts, field)
        yield from (Violation(each.place, each.text) for each in remarks)

    return found


class Rule(NamedTuple):
    """A rule."""

    id: str  # its name on the command line and in JSON
    words: str
    check: Callable[[Subject], Iterator[Violation]]


RULES = (
    Rule("not-configured", "an input is wired that no configuration uses", _not_configured),
    Rule("search-without-switch", "a home search on a machine without a home switch", _search_without_switch),
    Rule("unused-terminal", "a card's wired input or output that no program uses", _unused_terminals),
    Rule("repeated-coil", "a bit with two coils, or a timer with two rungs", _remarks("repeated")),
    Rule("unknown-tag", "a pattern of recorded tags that matches none", _unknown_tags),
    Rule("unused-tag", "a tag that no instruction names", _remarks("unused")),
    Rule("command-held", "a command bit that is set and never taken back", _remarks("held")),
    Rule("out-of-range", "a constant that the module refuses", _remarks("out_of_range")),
    Rule(
        "no-place",
        "an input, output or axis that the rack lacks, or that two own",
        _remarks("misplaced"),
    ),
    Rule("unreached-step", "a step of a chart that no path leads to", _remarks("unreached")),
    Rule("never-waits", "a loop of a sequence without an await", _remarks("endless")),
    Rule("bad-call", "a command or wait that fails when it is reached", _remarks("misused")),
)
"""The rules, in the order of the report."""

_STEPS_NOT_SEEN = "a list of steps is not read: only the rack file is checked"


def check_rack(job: Job) -> CheckReport:
    """Check a rack and its program without running it; LadderError if the ladder program can't be built."""
    facts = facts_of(job)
    is_toml = rack_form(job.rack_file) is Form.DATA
    lines = load_rack_file(job.rack_file).lines if is_toml else None
    subject = Subject(job, facts, lines)
    findings = (Finding(rule.id, *found) for rule in RULES for found in rule.check(subject))
    not_seen = (*facts.not_seen, *_unseen_configurations(subject), *(f"behind {each}" for each in job.stubs))
    return CheckReport(tuple(dict.fromkeys(findings)), not_seen)


def facts_of(job: Job) -> Facts:
    """Return the facts of a rack's program."""
    if isinstance(job.logic, LadderLogic):
        return ladder_facts(job.logic, job.program, job.spec)
    if job.program.suffix == ".py":
        if isinstance(job.logic, Logic):
            return sequence_facts(job.program, job.logic, job.spec)
        terminals = {name for slot in job.spec.slot for _, _, name, _ in _terminals(slot)}
        return python_facts(job.program, getattr(job.logic, "__globals__", {}), terminals)
    return Facts(not_seen=[_STEPS_NOT_SEEN])


def _unseen_configurations(subject: Subject) -> Iterator[str]:
    for _, slot in subject.steppers:
        if not subject.sent_to(slot.number, subject.facts.configurations):
            yield f"slot {slot.number}: no configuration in constants, so its inputs are not checked"
