"""A program ready to run: resolved addresses, checked operands, numbered instructions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import chain
from typing import Any, Protocol

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.records import record
from scanrack.io_images.site import Site

from ..model.chart import DEFAULT_OPTIONS, ChartOptions, Qualifier
from ..model.operands import Constant, Group, Place, Resolved
from ..model.schedule import Schedule
from ..model.spec import InstructionKind, Spec, Use
from ..model.stubs import Stub
from ..model.tags import FrameLayout, Layout, Presets, program_of
from ..model.tree import Address, Operand, Origin


@dataclass(frozen=True, slots=True)
class Call:
    """Operands of a JSR: the routine in capitals, its arguments, and the tags for its results."""

    routine: str
    inputs: tuple[Resolved, ...]  # a structure or an array is a `Group`, passed by value as bytes
    returns: tuple[Place | Group, ...]


class _BreakResult(tuple[Any, ...]):
    """Return value of a routine left by BRK; FOR recognizes it by identity."""

    __slots__ = ()


BROKEN = _BreakResult()
"""Returned by a routine that ends its FOR."""


class OperandResolver(Protocol):
    """Resolves operands for `Spec.resolve`; raises an OperandError for an operand that does not fit."""

    def named(self, routine: str) -> str:
        """Return the full name in capitals of a callable routine."""

    def memory(self, address: Address, *, written: bool) -> Place | Group:
        """Return a tag that is stored in bytes; for the first member of a structure, return the structure."""

    def value(self, operand: Operand) -> Resolved:
        """Return an operand that is a single value."""

    def target(self, operand: Operand) -> Place:
        """Return a writable tag, not an input."""

    @property
    def stubs(self) -> Mapping[str, Stub]:
        """Stubs of instructions and results of messages, by name in capitals."""

    def checked(self, use: Use, operand: Operand) -> Any:
        """Return an operand that a use accepts."""

    def any_operand(self, operand: Operand) -> Resolved:
        """Return an operand of any kind without checking it."""

    def hidden(self, name: str) -> Place:
        """Return a new hidden LINT whose name has this prefix; not available in add-on instructions."""

    def kept(self, path: str, initial: int) -> None:
        """Declare a LINT at a hidden path, with its initial value."""

    def function(self, name: str, function: Callable[..., Any]) -> str:
        """Register a Python function that an instruction calls; return its full name."""


ADD_ON = "add-on"
"""Name of the step that calls an add-on instruction; its operand is an `AddOnCall`."""


@dataclass(frozen=True, slots=True)
class AddOnCall:
    """A call of an add-on instruction."""

    name: str  # the add-on, in capitals
    instance: Group  # the instance's tag
    handed: Mapping[str, Place | Group]  # arguments of the InOuts, by name in capitals
    enable_in: Place  # bit of the rung condition before the call
    enable_out: Place  # bit of the rung condition after the call
    inputs: tuple[tuple[Node, ...], ...]  # rungs that copy the arguments in
    outputs: tuple[tuple[Node, ...], ...]  # rungs that copy the results out
    logic: str  # the routine for a true rung, in capitals
    otherwise: str | None  # the routine for a false rung, or None
    prescan: str | None  # the routine for prescan, or None
    postscan: str | None  # the routine for postscan, or None

    @property
    def routines(self) -> tuple[str, ...]:
        """Its existing routines."""
        return tuple(
            routine for routine in (self.logic, self.otherwise, self.prescan, self.postscan) if routine
        )


@record
class LoweredStep:
    """An instruction, ready to run."""

    spec: Spec
    operands: tuple[Any, ...]  # resolved, without presets; a label or a mode is a str
    site: int  # its number in `LoweredProgram.sites`

    @property
    def uses(self) -> tuple[Use, ...]:
        """The use of each operand."""
        return self.spec.uses

    @property
    def name(self) -> str:
        """Name of the instruction; `ADD_ON` for a call of an add-on instruction."""
        return self.spec.name

    @property
    def kind(self) -> InstructionKind:
        """Rung condition under which it acts."""
        return self.spec.kind


@dataclass(frozen=True, slots=True)
class Parallel:
    """A branch, ready to run."""

    legs: tuple[tuple[Node, ...], ...]


Node = LoweredStep | Parallel


@dataclass(frozen=True)
class LoweredLine:
    """A rung, or a line of structured text without inner blocks, ready to run."""

    number: int
    nodes: tuple[Node, ...]
    origin: Origin
    text: str
    comment: str

    @cached_property
    def steps(self) -> tuple[LoweredStep, ...]:
        """Its instructions in order of execution."""
        return tuple(steps_of(self.nodes, copies=False))

    @cached_property
    def all_steps(self) -> tuple[LoweredStep, ...]:
        """Its instructions in order of execution, with the copies of add-on parameters."""
        return tuple(steps_of(self.nodes))


@dataclass(frozen=True, slots=True)
class Act:
    """A statement without inner blocks: an assignment, an instruction, EXIT, RETURN."""

    line: LoweredLine


@dataclass(frozen=True, slots=True)
class Arms:
    """IF: the body of the first true line of `arms`, else `otherwise`."""

    arms: tuple[tuple[LoweredLine, Body], ...]
    otherwise: Body


@dataclass(frozen=True, slots=True)
class Selection:
    """CASE: the body of the first choice that includes the selector's value."""

    line: LoweredLine  # the selector
    width: int  # of selector and labels in comparisons, see `operands.width_of`
    choices: tuple[tuple[tuple[tuple[Constant, Constant], ...], Body], ...]  # ranges of values with bodies
    otherwise: Body


@dataclass(frozen=True, slots=True)
class Loop:
    """FOR, WHILE or REPEAT."""

    start: LoweredLine | None  # runs once before
    test: LoweredLine | None  # condition before each pass; None = true
    body: Body
    advance: LoweredLine | None  # runs after a pass
    until: LoweredLine | None  # condition after each pass that ends the loop; None = false

    @property
    def condition(self) -> LoweredLine:
        """The line with the condition."""
        line = self.test or self.until
        assert line is not None
        return line

    @property
    def site(self) -> int:
        """Number of the instruction that an endless-loop fault reports."""
        return steps_of(self.condition.nodes)[0].site


Body = tuple[Act | Arms | Selection | Loop, ...]
"""Statements, ready to run."""


@dataclass(eq=False, slots=True)
class ChartNode:
    """A step or stop of a chart; `bits` contains the members of its tag, including hidden ones."""

    index: int  # a number above 0 for its name
    number: int  # of the element
    name: str
    bits: Mapping[str, Place]
    tag: Group
    stop: bool
    actions: tuple[ChartAction, ...] = ()


@dataclass(eq=False, slots=True)
class ChartAction:
    """An action of a step, with the members of its tag."""

    index: int  # a number above 0 for the names of step and action
    number: int  # of the element
    name: str
    qualifier: Qualifier
    bits: Mapping[str, Place]
    tag: Group
    body: str | None  # the routine of its body in capitals, None for a Boolean action or R
    node: ChartNode
    resets: tuple[ChartAction, ...] = ()  # for R: the other actions with its tag, which it ends

    @property
    def outlives(self) -> bool:
        """Whether it may be on while its step is inactive."""
        return self.qualifier.is_stored or self.qualifier.is_pulse


@dataclass(eq=False, slots=True)
class ChartTransition:
    """A transition of a chart; `place` is its tag."""

    number: int  # of the element
    name: str
    sources: tuple[ChartNode, ...]
    targets: tuple[ChartNode, ...]
    place: Place
    condition: Resolved | None = None  # the value of its tag
    text: str = ""  # its condition as written


@dataclass(eq=False, slots=True)
class LoweredChart:
    """A chart, ready to run; `instructions.charts` describes its places."""

    name: str  # full name of the routine
    options: ChartOptions
    nodes: tuple[ChartNode, ...]
    actions: tuple[ChartAction, ...]
    transitions: tuple[ChartTransition, ...]
    initial: ChartNode
    state: Place
    reset: Place
    last: Place
    seen: Place
    delta: Place
    rest: Place
    first: Place  # whether this is the first pass of a scan
    moved: Place  # whether a transition was true in this pass

    def node_of(self, tag: Group) -> ChartNode | None:
        """Return the step or stop of a tag; None if it is in another chart."""
        return next((node for node in self.nodes if node.tag.path == tag.path), None)


@dataclass(frozen=True, slots=True)
class LoweredRoutine:
    """A routine, ready to run."""

    name: str
    lines: tuple[LoweredLine, ...]  # its rungs; for structured text, all lines in text order
    labels: Mapping[str, int]  # rung number by label in capitals
    parameters: tuple[Place | Group, ...] | None  # tags of SBR, None without SBR
    body: Body | None = None  # its statements; None in a routine of rungs
    frame: str = ""  # its add-on instruction, in capitals; "" in a program
    chart: LoweredChart | None = None  # the chart that its statements execute

    @property
    def unit(self) -> str:
        """Unit of its line numbers: rung, line, or element of a chart."""
        return "element" if self.chart else "rung" if self.body is None else "line"

    def numbered(self, number: int) -> LoweredLine:
        """Return a rung, or the first statement of a line, by number."""
        if self.body is None:
            return self.lines[number]
        return next(line for line in self.lines if line.number == number)


@dataclass(slots=True)
class AddOnFrame:
    """An add-on instruction, ready to run; there is one for all instances."""

    name: str
    layout: FrameLayout  # of its routines
    written: set[str] = field(default_factory=set)  # InOuts that its routines write, in capitals
    bits: set[str] = field(default_factory=set)  # InOuts whose argument may be a bit, in capitals
    calls: list[AddOnCall] = field(default_factory=list)  # calls of other add-on instructions in its routines
    presets: dict[tuple[str, int], int | float] = field(default_factory=dict)  # PRE and ACC by path and index


@dataclass(slots=True)
class LoweredProgram:
    """A program, ready to run."""

    name: str
    layout: Layout
    main: str  # the routine of a scan, in capitals; "" with a schedule
    routines: dict[str, LoweredRoutine] = field(default_factory=dict)  # of rungs, by name in capitals
    functions: dict[str, Callable[..., Any]] = field(default_factory=dict)  # in Python, by name in capitals
    sites: list[Site] = field(default_factory=list)  # every instruction, for messages
    presets: dict[tuple[str, int], int | float] = field(default_factory=dict)  # PRE and ACC by path and index
    frames: dict[str, AddOnFrame] = field(default_factory=dict)  # add-on instructions, by name in capitals
    flags: bool = False  # whether it uses S:V, S:Z, S:N or S:C
    override: bool = False  # whether it uses MCR
    schedule: Schedule | None = None
    recursive: frozenset[str] = frozenset()  # directly or indirectly recursive routines, in capitals
    stubs: dict[str, Stub] = field(default_factory=dict)  # results of messages, by name in capitals
    axes: Mapping[str, Any] = field(default_factory=dict)  # `BoundAxis` by tag in capitals
    connections: list[Any] = field(default_factory=list)  # `Connection` of consumed tags
    replies: dict[str, Any] = field(
        default_factory=dict
    )  # tag and `Sampler` of messages, by name in capitals
    ideal: Any = None  # `Ideal`: the other axes; None without motion instructions
    opening: tuple[Callable[[Any, bool], None], ...] = ()  # called before each scan: engine, first?
    closing: tuple[Callable[[Any], None], ...] = ()  # called with the engine after each scan
    charts: dict[str, LoweredChart] = field(default_factory=dict)  # by routine in capitals
    chart_options: ChartOptions = DEFAULT_OPTIONS
    written_inputs: set[str] = field(default_factory=set)  # identifiers of the inputs that it writes
    outputs: Mapping[int, bytes] = field(default_factory=dict)  # initial values of output images, by slot
    resume: Callable[[Any], None] | None = None  # sets hidden state of an engine instead of prescan
    monitors: tuple[str, ...] = ()  # routines that run after each scan of a proof, in capitals

    @property
    def ideal_names(self) -> tuple[str, ...]:
        """Names of its ideal axes and coordinate systems."""
        parts = (*self.ideal.axes, *self.ideal.systems) if self.ideal else ()
        return tuple(part.name for part, _ in parts)

    @property
    def all_steps(self) -> Iterator[LoweredStep]:
        """Yield all instructions, with the copies of add-on parameters."""
        lines = (line for routine in self.routines.values() for line in routine.lines)
        return chain.from_iterable(line.all_steps for line in lines)

    @property
    def roots(self) -> frozenset[str]:
        """Routines called by a scan or a fault, in capitals."""
        return frozenset((self.main,)) if self.schedule is None else self.schedule.roots

    def is_preempted(self, routine: str) -> bool:
        """Return whether another task may run after each rung of a routine, given by its full name."""
        if self.schedule is None:
            return False
        return program_of(routine).upper() in self.schedule.preempted

    @property
    def defaults(self) -> Mapping[str, Presets]:
        """Initial values from rungs in add-on instructions, by add-on (in capitals), path and index."""
        return {name: frame.presets for name, frame in self.frames.items() if frame.presets}


def parameters_of(step: LoweredStep) -> tuple[Sequence[Resolved], Sequence[Place | Group]]:
    """Return the values that JSR, SBR or RET passes, and the tags that receive values."""
    if step.name == "JSR":
        call: Call = step.operands[0]
        return call.inputs, call.returns
    return ((), step.operands) if step.name == "SBR" else (step.operands, ())


def passes_groups(step: LoweredStep) -> bool:
    """Return whether an instruction passes or receives a structure or an array."""
    if step.name not in ("JSR", "SBR", "RET"):
        return False
    return any(isinstance(operand, Group) for part in parameters_of(step) for operand in part)


def steps_of(nodes: tuple[Node, ...], *, copies: bool = True) -> list[LoweredStep]:
    """Return instructions in order of execution; with `copies`, also the copies of add-on parameters."""
    steps: list[LoweredStep] = []
    _collect(nodes, copies, steps)
    return steps


def _collect(nodes: tuple[Node, ...], copies: bool, steps: list[LoweredStep]) -> None:
    """Append the instructions of nodes in order of execution, see `steps_of`."""
    for node in nodes:
        if isinstance(node, Parallel):
            for leg in node.legs:
                _collect(leg, copies, steps)
        elif copies and node.operands and isinstance(node.operands[0], AddOnCall):
            call = node.operands[0]
            for series in call.inputs:
                _collect(series, copies, steps)
            steps.append(node)
            for series in call.outputs:
                _collect(series, copies, steps)
        else:
            steps.append(node)
