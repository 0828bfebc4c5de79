"""A program, ready to run: addresses resolved, operands checked, instructions numbered."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from ..model.errors import Site
from ..model.operands import Constant, Group, Place, Resolved
from ..model.schedule import Schedule
from ..model.spec import InstructionKind, Spec, Use
from ..model.stubs import Stub
from ..model.tags import FrameLayout, Layout, Presets, program_of
from ..model.tree import Address, Operand, Origin


@dataclass(frozen=True, slots=True)
class Call:
    """Operands of JSR: the routine, the values in, the tags for the values out.

    Attributes:
        routine: name in capitals.
        inputs: values in.
        returns: places for the values out.
    """

    routine: str
    inputs: tuple[Resolved, ...]
    returns: tuple[Place, ...]


class _BreakResult(tuple[Any, ...]):
    """Return value of a routine left by BRK; FOR compares the identity."""

    __slots__ = ()


BROKEN = _BreakResult()
"""Returned by a routine that ends its FOR."""


class OperandResolver(Protocol):
    """Resolves operands for an instruction that does it itself, see `Spec.resolve`."""

    def named(self, routine: str) -> str:
        """Return the full name in capitals of a routine that the present one may call."""

    def memory(self, address: Address, *, written: bool) -> Place | Group:
        """Return a tag with bytes; of the first member of a structure, the structure.

        Raises:
            OperandError: it has no bytes.
        """

    def value(self, operand: Operand) -> Resolved:
        """Return an operand with one value.

        Raises:
            OperandError: it is something else.
        """

    def target(self, operand: Operand) -> Place:
        """Return a tag that may be written.

        Raises:
            OperandError: it is something else, or an input.
        """

    @property
    def stubs(self) -> Mapping[str, Stub]:
        """Stubs of instructions and of the ends of messages, by name in capitals."""

    def checked(self, use: Use, operand: Operand) -> Any:
        """Return an operand of a use.

        Raises:
            OperandError: it is something else.
        """

    def any(self, operand: Operand) -> Resolved:
        """Return any operand.

        Raises:
            LadderError: it is neither a tag nor a value.
        """

    def hidden(self, name: str) -> Place:
        """Return a place of an instruction's own, a LINT, whose name begins so.

        Raises:
            OperandError: the instruction is in an add-on instruction, which has none.
        """

    def kept(self, path: str, initial: int) -> None:
        """Make sure that there is a LINT of an object at a hidden path; note what it begins as."""

    def function(self, name: str, function: Callable[..., Any]) -> str:
        """Make a Python function known that an instruction calls; return its full name."""


ADD_ON = "add-on"
"""Name of the step that calls an add-on instruction; its operand is one `AddOnCall`."""


@dataclass(frozen=True, slots=True)
class AddOnCall:
    """A call of an add-on instruction.

    Attributes:
        name: the add-on, in capitals.
        instance: the instance's tag.
        handed: what the InOuts stand for, by name in capitals.
        enable_in: bit that holds the rung before the call.
        enable_out: bit that holds the rung after the call.
        inputs: what copies the arguments in, each run as a rung of its own.
        outputs: what copies the results out.
        logic: the routine for a true rung, in capitals.
        otherwise: the one for a false rung, None without one.
        prescan: the one that runs in prescan, None without one.
    """

    name: str
    instance: Group
    handed: Mapping[str, Place | Group]
    enable_in: Place
    enable_out: Place
    inputs: tuple[tuple[Node, ...], ...]
    outputs: tuple[tuple[Node, ...], ...]
    logic: str
    otherwise: str | None
    prescan: str | None

    @property
    def routines(self) -> tuple[str, ...]:
        """The routines that it may run."""
        return tuple(each for each in (self.logic, self.otherwise, self.prescan) if each)


@dataclass(frozen=True, slots=True)
class LoweredStep:
    """An instruction, ready to run.

    Attributes:
        spec: the instruction.
        operands: resolved; a label or a mode is a str, JSR has one `Call`, an add-on instruction one
            `AddOnCall`, presets are left out.
        site: its number in `LoweredProgram.sites`.
    """

    spec: Spec
    operands: tuple[Any, ...]
    site: int

    @property
    def uses(self) -> tuple[Use, ...]:
        """The use of each operand."""
        return tuple(use for use in self.spec.operands if use is not Use.PRESET)

    @property
    def name(self) -> str:
        """Name of the instruction; `ADD_ON` for a call of an add-on instruction."""
        return self.spec.name

    @property
    def kind(self) -> InstructionKind:
        """When it acts."""
        return self.spec.kind


@dataclass(frozen=True, slots=True)
class Parallel:
    """A branch, ready to run."""

    legs: tuple[tuple[Node, ...], ...]


Node = LoweredStep | Parallel


@dataclass(frozen=True, slots=True)
class LoweredLine:
    """A rung, or a statement of structured text without the blocks in it, ready to run."""

    number: int
    nodes: tuple[Node, ...]
    origin: Origin
    text: str
    comment: str


@dataclass(frozen=True, slots=True)
class Act:
    """A statement that acts: an assignment, an instruction, EXIT, RETURN."""

    line: LoweredLine


@dataclass(frozen=True, slots=True)
class Arms:
    """IF: the body of the first line that is true.

    Attributes:
        arms: lines of IF and ELSIF with their bodies.
        otherwise: the body of ELSE.
    """

    arms: tuple[tuple[LoweredLine, Body], ...]
    otherwise: Body


@dataclass(frozen=True, slots=True)
class Selection:
    """CASE: the body of the first choice with the value of the selector.

    Attributes:
        line: the selector.
        width: in which selector and labels are compared, see `operands.width_of`.
        choices: ranges of values with their bodies.
        otherwise: the body of ELSE.
    """

    line: LoweredLine
    width: int
    choices: tuple[tuple[tuple[tuple[Constant, Constant], ...], Body], ...]
    otherwise: Body


@dataclass(frozen=True, slots=True)
class Loop:
    """FOR, WHILE or REPEAT.

    Attributes:
        start: runs once before.
        test: decides before every pass whether there is one; None = there is.
        body: runs in every pass.
        advance: runs after it.
        until: decides after every pass whether it was the last one; None = it was not.
    """

    start: LoweredLine | None
    test: LoweredLine | None
    body: Body
    advance: LoweredLine | None
    until: LoweredLine | None

    @property
    def condition(self) -> LoweredLine:
        """The line that ends it."""
        line = self.test or self.until
        assert line is not None
        return line

    @property
    def site(self) -> int:
        """Number of the instruction that a fault names if the loop does not end."""
        return steps_of(self.condition.nodes)[0].site


Body = tuple[Act | Arms | Selection | Loop, ...]
"""Statements, ready to run."""


@dataclass(frozen=True, slots=True)
class LoweredRoutine:
    """A routine, ready to run.

    Attributes:
        lines: its rungs; of structured text all lines in the order of the text.
        labels: number of the rung that a label begins, by label in capitals.
        parameters: what SBR takes, None without SBR.
        body: its statements, made of the lines; None in a routine of rungs.
        frame: the add-on instruction whose routine it is, in capitals; "" in a program.
    """

    name: str
    lines: tuple[LoweredLine, ...]
    labels: Mapping[str, int]
    parameters: tuple[Place, ...] | None
    body: Body | None = None
    frame: str = ""

    @property
    def unit(self) -> str:
        """What its lines are called: rung or line."""
        return "rung" if self.body is None else "line"

    def numbered(self, number: int) -> LoweredLine:
        """Return the rung of that number, or the first statement in the line of that number."""
        if self.body is None:
            return self.lines[number]
        return next(line for line in self.lines if line.number == number)


@dataclass(slots=True)
class AddOnFrame:
    """An add-on instruction, ready to run: one for all its instances.

    Attributes:
        layout: where its routines find what they name.
        written: InOuts that its routines write, in capitals.
        bits: InOuts to which a call hands a bit of an integer, in capitals.
        calls: calls of other add-on instructions in its routines.
        presets: initial values of PRE and ACC from its rungs, by path in an instance and index.
    """

    name: str
    layout: FrameLayout
    written: set[str] = field(default_factory=set)
    bits: set[str] = field(default_factory=set)
    calls: list[AddOnCall] = field(default_factory=list)
    presets: dict[tuple[str, int], int | float] = field(default_factory=dict)


@dataclass(slots=True)
class LoweredProgram:
    """A program, ready to run.

    Attributes:
        layout: its memory.
        main: the routine that a scan calls, in capitals; "" if a schedule says what it calls.
        routines: routines of rungs, by name in capitals.
        functions: routines in Python, by name in capitals.
        sites: every instruction, for messages.
        presets: initial values of PRE and ACC from the rungs, by path and index.
        frames: the add-on instructions that are called, by name in capitals.
        flags: whether a rung uses S:V, S:Z, S:N or S:C; otherwise they are not kept.
        override: whether there is an MCR.
        schedule: tasks and programs, None for a program without them.
        recursive: routines that call themselves, directly or through others, in capitals.
        stubs: how messages end, see `stubs`, by name in capitals.
        axes: axes of the rack by their tag in capitals, see `instructions.motion_3601.BoundAxis`.
        opening: called with the engine before each scan, and whether it is the first.
        closing: called with the engine after each scan.
        written_inputs: identifiers of the inputs that the program writes.
    """

    name: str
    layout: Layout
    main: str
    routines: dict[str, LoweredRoutine] = field(default_factory=dict)
    functions: dict[str, Callable[..., Any]] = field(default_factory=dict)
    sites: list[Site] = field(default_factory=list)
    presets: dict[tuple[str, int], int | float] = field(default_factory=dict)
    frames: dict[str, AddOnFrame] = field(default_factory=dict)
    flags: bool = False
    override: bool = False
    schedule: Schedule | None = None
    recursive: frozenset[str] = frozenset()
    stubs: dict[str, Stub] = field(default_factory=dict)
    axes: Mapping[str, Any] = field(default_factory=dict)
    opening: tuple[Callable[[Any, bool], None], ...] = ()
    closing: tuple[Callable[[Any], None], ...] = ()
    written_inputs: set[str] = field(default_factory=set)

    @property
    def roots(self) -> frozenset[str]:
        """Routines that a scan or a fault calls, in capitals."""
        return frozenset((self.main,)) if self.schedule is None else self.schedule.roots

    def is_preempted(self, routine: str) -> bool:
        """Whether another task may run at the end of a routine's rungs.

        Args:
            routine: its full name.
        """
        if self.schedule is None:
            return False
        return program_of(routine).upper() in self.schedule.preempted

    @property
    def defaults(self) -> Mapping[str, Presets]:
        """Initial values that rungs of add-on instructions give, by add-on in capitals, path and index."""
        return {name: frame.presets for name, frame in self.frames.items() if frame.presets}


def steps_of(nodes: tuple[Node, ...], *, copies: bool = True) -> list[LoweredStep]:
    """Return the instructions in the order in which they execute.

    Args:
        nodes: a series.
        copies: whether what copies the parameters of add-on instructions is among them.
    """
    found: list[LoweredStep] = []
    _collect(nodes, copies, found)
    return found


def _collect(nodes: tuple[Node, ...], copies: bool, found: list[LoweredStep]) -> None:
    for node in nodes:
        if isinstance(node, Parallel):
            for leg in node.legs:
                _collect(leg, copies, found)
        elif copies and node.operands and isinstance(node.operands[0], AddOnCall):
            call = node.operands[0]
            for series in call.inputs:
                _collect(series, copies, found)
            found.append(node)
            for series in call.outputs:
                _collect(series, copies, found)
        else:
            found.append(node)
