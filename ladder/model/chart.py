"""Sequential function charts in the tree: steps with actions, and transitions between the steps.

A chart is a net: a transition leaves its `sources` and enters its `targets`. Several transitions from one
step are a selection in order of priority; several targets start simultaneous branches, and several
sources end them. Steps are in order of execution.

Sources: Logix 5000 Controllers Sequential Function Charts, 1756-PM006; IEC 61131-3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from enum import Enum

from scanrack.io_images.dataclass import dataclass

from .statements import INDENT, Assignment, Invocation, block_lines
from .tree import Address, Block, Instruction, MemberStep, Operand, Origin, Statement

STEP_TYPE, ACTION_TYPE, STOP_TYPE = "SFC_STEP", "SFC_ACTION", "SFC_STOP"
"""Types of the tags of steps, actions and stops."""


class Qualifier(Enum):
    """When an action starts and ends [1756-PM006, choose a qualifier for an action]."""

    N = "N"  # while its step is active
    P1 = "P1"  # once, when the step is activated
    L = "L"  # while its step is active, for PRE at most
    S = "S"  # from the step's activation until R
    SL = "SL"  # from the step's activation, until R or for PRE
    D = "D"  # from PRE after the step's activation, while the step is active
    DS = "DS"  # from PRE after the activation if the step is still active, until R
    SD = "SD"  # from PRE after the activation, until R
    P = "P"  # once when the step is activated, once when it is deactivated
    P0 = "P0"  # once, when the step is deactivated
    R = "R"  # resets a stored action

    @property
    def is_stored(self) -> bool:
        """Whether the action continues after its step, until an R action resets it."""
        return self.value in ("S", "SL", "DS", "SD")

    @property
    def is_pulse(self) -> bool:
        """Whether the action runs for one scan."""
        return self.value in ("P", "P1", "P0")


class ExecutionControl(Enum):
    """Extent of a chart that one scan executes [1756-PM006, execution control]."""

    CURRENT = "CURRENT"  # execute current active steps only
    UNTIL_FALSE = "UNTIL_FALSE"  # execute until FALSE transition


class RestartPosition(Enum):
    """Step at which a chart restarts after program mode [1756-PM006, restart position]."""

    MOST_RECENT = "MOST_RECENT"
    INITIAL = "INITIAL"


class LastScan(Enum):
    """Effect of the last scan of an action [1756-PM006, choose a last scan option]."""

    AUTOMATIC = "AUTOMATIC"  # postscan
    PROGRAMMATIC = "PROGRAMMATIC"  # one more scan, with Q off
    DONT_SCAN = "DONT_SCAN"


@dataclass(frozen=True, slots=True)
class ChartOptions:
    """Options for all charts of a controller; the defaults match a new project."""

    control: ExecutionControl = ExecutionControl.CURRENT
    restart: RestartPosition = RestartPosition.MOST_RECENT
    last_scan: LastScan = LastScan.DONT_SCAN


DEFAULT_OPTIONS = ChartOptions()


@dataclass(frozen=True, slots=True)
class Action:
    """An action of a step. Without a body (None), it is a Boolean action or resets another action."""

    name: str  # its tag, an SFC_ACTION
    qualifier: Qualifier = Qualifier.N
    body: Block | None = None
    preset: Operand | None = None  # expression of PRE; None leaves the tag's value
    indicator: str = ""  # a tag that is shown next to the action
    number: int = field(default=0, compare=False)  # of the element in its chart
    origin: Origin = field(default=Origin(), compare=False)

    @property
    def is_boolean(self) -> bool:
        """Whether the action only sets its Q bit, for use by other logic."""
        return self.body is None and self.qualifier is not Qualifier.R

    @property
    def head(self) -> str:
        """The action's text without its body."""
        shown = f" INDICATOR {self.indicator}" if self.indicator else ""
        preset = "" if self.preset is None else f" PRE := {self.preset}"
        return f"ACTION {self.name} {self.qualifier.value}{shown}{preset}"

    def lines(self) -> Iterator[str]:
        """Yield its text, line by line."""
        if self.body is None:
            yield f"{self.head};"
            return
        yield self.head
        yield from (INDENT + line for line in block_lines(self.body))
        yield "END_ACTION"


PRESETS = ("PRE", "LimitHigh", "LimitLow")
"""Members of a step that an expression can set."""


@dataclass(frozen=True, slots=True)
class ChartStep:
    """A step. A `stop` ends its path, so it has no actions and no transition leaves it."""

    name: str  # its tag, an SFC_STEP or SFC_STOP
    actions: tuple[Action, ...] = ()
    initial: bool = False
    stop: bool = False
    presets: tuple[tuple[str, Operand], ...] = ()  # expressions, by member
    number: int = field(default=0, compare=False)
    origin: Origin = field(default=Origin(), compare=False)

    @property
    def head(self) -> str:
        """The step's text without its presets and actions."""
        return f"{'STOP' if self.stop else 'INITIAL_STEP' if self.initial else 'STEP'} {self.name}"

    def lines(self) -> Iterator[str]:
        """Yield its text, line by line."""
        yield self.head
        if self.stop:
            return
        for member, value in self.presets:
            yield f"{INDENT}{member} := {value};"
        for action in self.actions:
            yield from (INDENT + line for line in action.lines())
        yield "END_STEP"


@dataclass(frozen=True, slots=True)
class Transition:
    """A transition from all active `sources` to all `targets`. It fires when its condition is true."""

    name: str  # its tag, a BOOL
    sources: tuple[str, ...]
    targets: tuple[str, ...]
    condition: Operand | Instruction  # an expression, or JSR of a routine with EOT
    number: int = field(default=0, compare=False)
    origin: Origin = field(default=Origin(), compare=False)

    @property
    def head(self) -> str:
        """The transition's text without its condition."""
        return f"TRANSITION {self.name} FROM {', '.join(self.sources)} TO {', '.join(self.targets)}"

    @property
    def statement(self) -> Statement:
        """The condition as a statement, either an assignment to the transition's tag or a call."""
        if isinstance(self.condition, Instruction):
            return Invocation(self.condition, line=self.number, origin=self.origin)
        return Assignment(Address(self.name), self.condition, line=self.number, origin=self.origin)


@dataclass(frozen=True, slots=True)
class Chart:
    """A sequential function chart."""

    steps: tuple[ChartStep, ...]  # in order of execution
    transitions: tuple[Transition, ...]  # in order of evaluation
    inputs: tuple[Address, ...] = ()  # tags that receive the inputs of a call
    returns: tuple[Operand, ...] = ()  # operands that a call returns
    notes: tuple[str, ...] = ()  # text boxes

    @property
    def initial(self) -> ChartStep | None:
        """The initial step; None if the chart has none."""
        return next((step for step in self.steps if step.initial), None)

    @property
    def steps_by_name(self) -> Mapping[str, ChartStep]:
        """The chart's steps and stops by name in capitals."""
        return {step.name.upper(): step for step in self.steps}

    @property
    def elements(self) -> Mapping[int, str]:
        """The text of each step, action and transition, by number."""
        heads: dict[int, str] = {}
        for step in self.steps:
            heads[step.number] = step.head
            heads.update((action.number, f"step {step.name}: {action.head}") for action in step.actions)
        heads.update(
            (transition.number, f"{transition.head} WHEN {transition.condition}")
            for transition in self.transitions
        )
        return heads

    def lines(self) -> Iterator[str]:
        """Yield its text, line by line."""
        for word, listed in (("INPUTS", self.inputs), ("RETURNS", self.returns)):
            if listed:
                yield f"{word} {', '.join(map(str, listed))}"
        for note in self.notes:
            yield from (f"NOTE {line}" for line in note.splitlines())
        for step in self.steps:
            yield from step.lines()
        for transition in self.transitions:
            yield from (transition.head, f"{INDENT}{transition.condition}", "END_TRANSITION")

    @property
    def leaving(self) -> Mapping[str, list[int]]:
        """The numbers of the transitions that leave each step, in order of priority, by name in capitals."""
        by_step: dict[str, list[int]] = {name: [] for name in self.steps_by_name}
        for number, transition in enumerate(self.transitions):
            for name in transition.sources:
                by_step.setdefault(name.upper(), []).append(number)
        return by_step

    def transitions_after(self, name: str) -> Iterator[Transition]:
        """Yield the transitions that leave a step, in order of priority."""
        return (self.transitions[number] for number in self.leaving.get(name.upper(), ()))

    def bodies(self) -> Iterator[tuple[ChartStep, Action, Block]]:
        """Yield each action with a body."""
        for step in self.steps:
            for action in step.actions:
                if action.body is not None:
                    yield step, action, action.body

    def tags(self) -> Iterator[tuple[str, str]]:
        """Yield the tags of the chart's elements with the names of their types."""
        for step in self.steps:
            yield step.name, STOP_TYPE if step.stop else STEP_TYPE
            yield from ((action.name, ACTION_TYPE) for action in step.actions)
        yield from ((transition.name, "BOOL") for transition in self.transitions)

    def statements(self) -> Iterator[Statement]:
        """Yield the chart's presets, bodies and conditions as statements."""
        for step in self.steps:
            yield from presets_of(step)
            for action in step.actions:
                yield from action.body or ()
        yield from (transition.statement for transition in self.transitions)


def presets_of(step: ChartStep) -> Iterator[Assignment]:
    """Yield the expressions in a step and its actions as assignments to members."""
    for member, value in step.presets:
        yield _set(step.name, member, value, step.number, step.origin)
    for action in step.actions:
        if action.preset is not None:
            yield _set(action.name, "PRE", action.preset, action.number, action.origin)


def _set(name: str, member: str, value: Operand, number: int, origin: Origin) -> Assignment:
    return Assignment(Address(name, (MemberStep(member),)), value, line=number, origin=origin)


def body_name(routine: str, step: ChartStep, action: Action) -> str:
    """Return the routine name of an action's body, such as `Sequence.Fill.Open`."""
    return f"{routine}.{step.name}.{action.name}"
