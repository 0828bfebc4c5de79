"""The table of facts about a program, filled by a collector for each language and read by the rules.

| fact | rungs | structured text | Python |
|---|---|---|---|
| `Variable` | a tag, a bit of an image | the same | a field, an output, an input |
| `Access` | an operand | a side of an assignment | `self.name`, read or assigned |
| `Command` | a motion block | the same | a method of an axis |
| `StepAction` | `EQU(Step,20)MOV(30,Step)` | `CASE Step OF` | `if self.step == "feed":` |
| `SentCommand` | eight constant words | the same | `Configuration(...)` |
| `WordWrite` | `MOV(4,axis.O.Data[2])` | the same | `outputs[2] = 4` |

A collector immediately notes a mistake that is visible in a single line: `facts.remark("recursion", place,
text)`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import NamedTuple

from scanrack.io_images.site import Site

from .groups import grouped
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
    words: tuple[int, ...] = ()  # the eight output words; empty if no rule reads them
    speed: int | None = None  # the speed in the words, steps/s; None if it is unknown


class Role(Enum):
    """The kind of a variable."""

    PLAIN = auto()  # memory of the program
    INPUT = auto()  # the module writes it
    OUTPUT = auto()  # the module reads it
    BLOCK = auto()  # an instance of a block, a timer, a counter


@dataclass(frozen=True, slots=True)
class Variable:
    """A tag, a field, or a terminal.

    Attributes:
        name: the name in the user's spelling.
        place: the line of its declaration.
        type: such as "BOOL", "DINT", "TIMER".
        set: whether its declaration sets an initial value.
        shown: whether people read or write it, because it is recorded or according to its name.
    """

    name: str
    place: FileLine
    role: Role
    type: str
    set: bool = False
    shown: bool = False


class Touch(Enum):
    """How an instruction or statement uses a variable."""

    READ = auto()
    COIL = auto()  # writes its condition to a bit
    LATCH = auto()  # sets a bit if its condition is true
    UNLATCH = auto()  # clears a bit if its condition is true
    WRITE = auto()  # writes another value, or several words
    BOTH = auto()  # reads and writes: a timer, a block, an argument by reference


@dataclass(frozen=True, slots=True)
class Access:
    """A use of a variable.

    Attributes:
        variable: its key in `Facts.variables`.
        part: the member, element or bit that is used, such as ".DN" or "[3].5"; "" for the whole variable.
            "[?]" is any element.
        unit: the routine, or the function.
        needs: bits that must be on, or off, for the access to happen.
        owner: the task of the program, or the sequence; "" if there is a single task, or for `every_scan`.
        once: whether it happens only at start-up.
        default: whether every scan executes the statement and a later statement can override it.
        steady: whether its condition and the bit value it writes stay true from the second scan on.
        parameter: whether the access passes an argument to a routine.
        zero: whether it writes 0, as CLR, RES, MOV(0,...) and assignments of 0 do.
        text: the variable as written in the code; "" if that is its name.
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
        """Whether a task of a ladder program, rather than a sequence, owns the access."""
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
    """A command to an axis, given by calling a block or a method.

    Attributes:
        kind: name of the method of `Axis3601`, such as "move_to", "run" or "home".
        axis: the axis, by the user's name.
        slot: slot of the axis; None if it is unknown.
        values: ranges of its arguments, by their names in `Axis3601`.
        choices: for each argument, the range of each of its possible values.
        text: the call in words, such as "MC_Home(Home)" or "home".
        order: position in the scan or in its sequence.
        unit: the routine or function.
        owner: the task or sequence.
        sure: whether its sequence always reaches it.
        locks: the locks that are held at the command.
        words: whether the program sends it as output words.
        execute: the bit that starts it, in capitals; "1" if it is always on, "" if no bit starts it.
        starts: the condition of that bit, as text; "" if it contains more than bits and steps.
        on: the condition of the block's Execute; UNKNOWN if it is unknown.
        implies: what is true whenever Execute is on, including the conditions of coils.
        segments: length, speed and rate of each blend segment, if known; None for other commands.
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
    """An action of a program that has steps.

    Attributes:
        machine: the variable that contains the step.
        steps: steps in which it may happen; None for all.
        goes: the next step; None if the action does not change the step.
        ends: whether its condition shows that a motion has ended or that time has passed.
        moves: whether its condition requires a moving axis.
        axis: the axis that it commands; "" if there is none.
        kind: the command, as in `Command`; "" for a write that sends no command.
        text: the command in words.
        sets: command word bits that it sets; 0 for a block.
        clears: command word bits that it clears.
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
    """How a program uses one step.

    Attributes:
        tested: whether anything tests for this step.
        works: whether anything in the step depends on conditions in addition to the step.
        chosen: whether a CASE or a Python statement, rather than a comparison in a rung, tests for the step.
    """

    tested: bool = False
    works: bool = False
    chosen: bool = False


class OutputWrite(NamedTuple):
    """A condition that switches an output on.

    Attributes:
        name: the name in the user's spelling; for a command of a 3601, the name of its bit.
        key: the name in conditions.
        free: the condition, without coils and local names. Names of card inputs begin with `INPUT`.
        commands: the 3601 that the bit commands; "" for any other output.
    """

    place: FileLine
    name: str
    key: str
    free: Condition
    commands: str = ""


UsesBit = Callable[[int, str, str, int, int], bool]
"""Returns whether a program uses a bit of a card. Arguments: slot, image "I" or "O", name, word and bit."""


@dataclass(slots=True)
class Facts:
    """The facts of a program.

    Attributes:
        remarks: mistakes that are visible in a single line, by rule.
        variables: the variables, by key.
        computed: slots with output words that the program computes.
        escaped: axes passed to code that the reader does not follow.
        actions: actions of the program in its steps.
        first_steps: returns the steps in which a machine may start.
        step_use: returns how the program uses a step of a machine; None if that is unknown.
        writes: writes to the output words of 3601s.
        outputs: conditions that switch outputs on.
        at_once: commands that are sent in the same scan as their parameters.
        uses_bit: returns whether the program uses a bit of a card; None if that is unknown.
        reads_all: whether unanalyzed code may use any variable.
        not_seen: facts that the reader can't determine, one text each.
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
        """Add a mistake that is visible in a single line."""
        self.remarks[rule].append(Violation(place, text))

    def by_key(self) -> dict[str, list[Access]]:
        """Return the accesses to each variable, by its key."""
        return grouped(self.accesses, lambda access: access.variable)

    def by_variable(self) -> list[tuple[Variable, list[Access]]]:
        """Return each variable with its accesses."""
        accesses = self.by_key()
        return [(variable, accesses.get(key, [])) for key, variable in self.variables.items()]


def overlap(first: str, second: str) -> bool:
    """Whether two parts of a variable share memory.

    >>> overlap("", ".DN"), overlap("[3].5", "[3].6"), overlap("[?]", "[3].5"), overlap(".A", ".AB")
    (True, False, True, False)
    """
    if "?" in first + second:
        return True
    short, long = sorted((first, second), key=len)
    return long.startswith(short) and long[len(short) : len(short) + 1] in ("", ".", "[")
