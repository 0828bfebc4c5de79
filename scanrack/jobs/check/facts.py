"""The table of facts about a program, which a collector of each language fills and the rules read.

| fact | rungs | structured text | Python |
|---|---|---|---|
| `Variable` | a tag, a bit of an image | the same | a field, an output, an input |
| `Access` | an operand | a side of an assignment | `self.name`, read or assigned |
| `Command` | a motion block | the same | a method of an axis |
| `StepAction` | `EQU(Step,20)MOV(30,Step)` | `CASE Step OF` | `if self.step == "feed":` |
| `SentCommand` | eight constant words | the same | `Configuration(...)` |
| `WordWrite` | `MOV(4,axis.O.Data[2])` | the same | `outputs[2] = 4` |

A mistake that shows in one place is a `Violation` at once: `facts.remark("recursion", place, text)`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import NamedTuple

from scanrack.io_images.site import Site

from .logic import TRUE, UNKNOWN, Bit, Condition
from .ranges import ANY, Range
from .written import FileLine as FileLine
from .written import Step as Step
from .written import WordWrite


class Violation(NamedTuple):
    """A finding without its rule."""

    place: FileLine
    text: str


@dataclass(frozen=True, slots=True)
class SentCommand:
    """Output words, or a command, that the program sends to a 3601."""

    place: FileLine
    slot: int | None  # None if it is unknown
    words: tuple[int, ...] = ()  # the eight output words; empty without effect on the rules
    speed: int | None = None  # the speed in them, steps/s; None if it is unknown


class Role(Enum):
    """What a variable is."""

    PLAIN = auto()  # memory of the program
    INPUT = auto()  # the module writes it
    OUTPUT = auto()  # the module reads it
    BLOCK = auto()  # an instance of a block, a timer, a counter


@dataclass(frozen=True, slots=True)
class Variable:
    """A tag, a field, or a terminal.

    Attributes:
        name: as the user writes it.
        place: its declaration.
        type: such as "BOOL", "DINT", "TIMER".
        set: whether its declaration gives it a value.
        shown: whether people read or write it: it is recorded, or its name says so.
    """

    name: str
    place: FileLine
    role: Role
    type: str
    set: bool = False
    shown: bool = False


class Touch(Enum):
    """What an instruction or a statement does with a variable."""

    READ = auto()
    COIL = auto()  # writes a bit whatever its condition is
    LATCH = auto()  # sets a bit if its condition holds
    UNLATCH = auto()  # clears a bit if its condition holds
    WRITE = auto()  # writes another value, or several words
    BOTH = auto()  # reads and writes: a timer, a block, an argument by reference


@dataclass(frozen=True, slots=True)
class Access:
    """A use of a variable.

    Attributes:
        variable: its key in `Facts.variables`.
        part: what of the variable: "" all of it, such as ".DN", "[3].5"; "[?]" is any element.
        unit: the routine, or the function.
        needs: bits that hold whenever it acts.
        owner: the task of the program, or the sequence; "" for a single task, and for `every_scan`.
        once: whether it acts at start-up only.
        default: whether it is a statement that every scan executes, and that a later one may override.
        steady: whether its condition, and what it assigns to a bit, holds from the second scan on.
        parameter: whether it takes an argument of a routine.
        zero: whether it writes 0: CLR, RES, MOV(0,...), an assignment of 0.
        text: as written; "" if it is the variable itself.
    """

    variable: str
    part: str
    use: Touch
    place: FileLine
    unit: str = ""
    needs: frozenset[Bit] = frozenset()
    owner: str = ""
    once: bool = False
    default: bool = False
    steady: bool = False
    parameter: bool = False
    zero: bool = False
    text: str = ""

    @property
    def task(self) -> bool:
        """Whether the owner is a task of a ladder program, not a sequence."""
        return self.unit.startswith("\\")

    @property
    def reads(self) -> bool:
        """Whether the value is read."""
        return self.use in (Touch.READ, Touch.BOTH)

    @property
    def writes(self) -> bool:
        """Whether the value is written."""
        return self.use is not Touch.READ


@dataclass(frozen=True, slots=True)
class Command:
    """A command to an axis: the call of a block, or of a method.

    Attributes:
        kind: name of the method of `Axis3601`: "move_to", "run", "home".
        axis: the axis, as the user calls it.
        slot: its slot; None if it is unknown.
        values: ranges of its arguments by their names in `Axis3601`.
        choices: the values that an argument gets one after the other.
        text: the call in words, such as "MC_Home(Home)" or "home".
        order: place in the scan, or in its sequence.
        unit: the routine, or the function.
        owner: the task, or the sequence.
        sure: whether its sequence always reaches it.
        locks: what the program holds there.
        words: whether it is given as words.
        execute: the bit that starts it, in capitals; "1" if it is always on, "" if there is none.
        starts: the condition of the bit that starts it, as a text; "" if it is not of bits and steps alone.
        on: the condition of its Execute; UNKNOWN if it is not known.
        implies: what holds whenever its Execute is on, with the conditions of coils.
        segments: of a blend: length, speed and rate of each, as far as they are known.
    """

    kind: str
    axis: str
    slot: int | None
    place: FileLine
    text: str
    values: Mapping[str, Range] = field(default_factory=dict)
    choices: Mapping[str, tuple[Range, ...]] = field(default_factory=dict)
    order: int = 0
    unit: str = ""
    owner: str = ""
    sure: bool = False
    locks: frozenset[str] = frozenset()
    words: bool = False
    execute: str = ""
    starts: str = ""
    on: Condition = UNKNOWN
    implies: Condition = TRUE
    segments: tuple[tuple[Range, Range, Range], ...] | None = None

    def value(self, name: str) -> Range:
        """Return the range of an argument."""
        return self.values.get(name, ANY)


@dataclass(frozen=True, slots=True)
class StepAction:
    """What a program that goes from step to step does in some of them.

    Attributes:
        machine: the number, or the text, that says the step.
        steps: in which it may happen; None for all.
        goes: the step that follows; None if it is not this action that continues.
        ends: whether its condition says that a motion has ended, or that time has passed.
        moves: whether its condition needs that an axis moves.
        axis: the axis that it commands; "" if it commands none.
        kind: the command, as in `Command`; "" for a write that gives none.
        text: the command in words.
        sets: bits of the command word that it sets; 0 for a block.
        clears: bits of the command word that it clears.
        when: the condition under which it happens.
    """

    machine: str
    steps: frozenset[Step] | None
    place: FileLine
    goes: Step | None = None
    ends: bool = False
    moves: bool = False
    axis: str = ""
    kind: str = ""
    text: str = ""
    sets: int = 0
    clears: int = 0
    when: Condition = TRUE

    def happens_in(self, step: Step) -> bool:
        """Whether it may happen in a step."""
        return self.steps is None or step in self.steps


class StepUse(NamedTuple):
    """What a program does in one step only.

    Attributes:
        tested: whether anything asks for this step.
        works: whether something in it depends on other conditions than the step.
        chosen: whether a CASE, or a text in Python, asks for it, not the comparison of a rung.
    """

    tested: bool = False
    works: bool = False
    chosen: bool = False


class OutputWrite(NamedTuple):
    """What switches an output on.

    Attributes:
        name: as the user writes it; the bit's name for a command of a 3601.
        key: the same in conditions.
        free: the condition, without coils and local names; inputs of cards begin with `INPUT`.
        commands: the 3601 of which it is a command; "" for another output.
    """

    place: FileLine
    name: str
    key: str
    free: Condition
    commands: str = ""


UsesBit = Callable[[int, str, str, int, int], bool]
"""Whether a program uses a bit of a card: slot, image "I" or "O", name, word, bit."""


@dataclass(slots=True)
class Facts:
    """Facts of a program.

    Attributes:
        remarks: mistakes that show in one place, by rule.
        variables: by key.
        computed: slots whose output words the program computes.
        escaped: axes that parts of the program get which are not followed.
        actions: what the program does in its steps.
        first_steps: returns the steps in which a machine may begin.
        step_use: returns what the program does in a step of a machine; None if that is unknown.
        writes: to output words of 3601s.
        outputs: what switches outputs on.
        at_once: commands that are sent together with their parameters.
        uses_bit: tests whether it uses a bit of a card; None if that is unknown.
        reads_all: whether parts that are not read here may use any variable.
        not_seen: sentences about facts that the reader can't determine.
        sites: routines and rungs, by their line in the file.
    """

    remarks: defaultdict[str, list[Violation]] = field(default_factory=lambda: defaultdict(list))
    variables: dict[str, Variable] = field(default_factory=dict)
    accesses: list[Access] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    configurations: list[SentCommand] = field(default_factory=list)
    searches: list[SentCommand] = field(default_factory=list)
    computed: set[int] = field(default_factory=set)
    escaped: set[str] = field(default_factory=set)
    actions: list[StepAction] = field(default_factory=list)
    first_steps: Callable[[str], frozenset[Step]] = lambda _machine: frozenset()
    step_use: Callable[[str, Step], StepUse | None] | None = None
    writes: list[WordWrite] = field(default_factory=list)
    outputs: list[OutputWrite] = field(default_factory=list)
    at_once: list[Violation] = field(default_factory=list)
    uses_bit: UsesBit | None = None
    reads_all: bool = False
    not_seen: list[str] = field(default_factory=list)
    sites: dict[FileLine, Site] = field(default_factory=dict)

    def remark(self, rule: str, place: FileLine, text: str) -> None:
        """Add a mistake that shows in one place."""
        self.remarks[rule].append(Violation(place, text))

    def by_variable(self) -> Iterator[tuple[Variable, list[Access]]]:
        """Yield each variable with its accesses."""
        found: dict[str, list[Access]] = {key: [] for key in self.variables}
        for each in self.accesses:
            if each.variable in found:
                found[each.variable].append(each)
        for key, accesses in found.items():
            yield self.variables[key], accesses


def overlap(one: str, other: str) -> bool:
    """Whether two parts of a variable share memory.

    >>> overlap("", ".DN"), overlap("[3].5", "[3].6"), overlap("[?]", "[3].5"), overlap(".A", ".AB")
    (True, False, True, False)
    """
    if "?" in one + other:
        return True
    short, long = sorted((one, other), key=len)
    return long.startswith(short) and long[len(short) : len(short) + 1] in ("", ".", "[")
