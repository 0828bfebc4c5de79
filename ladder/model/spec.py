"""Specification of an instruction: its name, its operands, and the functions that check, run and compile it.

A family file in `instructions` has one `Spec` per instruction. The parser, the Python front end, the checks,
both back ends, the debugger and the drawing all read it, so each instruction is described in one place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from enum import Enum, auto
from functools import cached_property
from typing import Any

from scanrack.io_images.dataclass import dataclass

from .errors import LadderError
from .tagref import operand_of
from .tree import Address, Instruction, Unknown


class Use(Enum):
    """How an instruction uses an operand; `operand_checks` defines which operands it accepts."""

    __hash__ = object.__hash__  # members are singletons, and frequent keys

    BIT = auto()  # reads a bit
    COIL = auto()  # writes a bit on a true and a false rung: should occur once per bit
    LATCH = auto()  # writes a bit when true
    STORAGE = auto()  # remembers the rung condition of the last scan in a bit
    NUMBER = auto()  # reads a number
    TEXT_OR_NUMBER = auto()  # reads a number or a STRING
    INTEGER = auto()  # reads an integer
    TEXT = auto()  # reads a string
    TEXT_TARGET = auto()  # writes a string
    TARGET = auto()  # writes a number
    TEXT_OR_NUMBER_TARGET = auto()  # writes a number or a STRING
    INTEGER_TARGET = auto()  # writes an integer
    EXPRESSION = auto()  # reads an expression
    CONDITION = auto()  # reads an expression that is true or false
    TRUTH = auto()  # reads a bit, or an expression of bits and comparisons
    TIMER = auto()
    COUNTER = auto()
    BLOCK = auto()  # reads and writes an instruction's structure of parameters
    CONTROL = auto()
    MESSAGE = auto()
    PID = auto()
    SLC_TIMER = auto()
    SLC_COUNTER = auto()
    SLC_CONTROL = auto()
    SLC_RESETTABLE = auto()  # a timer, counter or control of an SLC 500
    SERIAL = auto()  # a SERIAL_PORT_CONTROL
    HMI_BUTTON = auto()  # an HMIBC
    AXIS = auto()
    MOTION = auto()  # a MOTION_INSTRUCTION
    MOTION_GROUP = auto()
    COORDINATE_SYSTEM = auto()
    ALARM_DIGITAL = auto()
    ALARM_ANALOG = auto()
    SWITCH = auto()  # reads a bit, or is 0 or 1
    OPTIONAL_TARGET = auto()  # writes a number; 0 for none
    IGNORED = auto()  # has no effect here
    SHOWN = auto()  # a member of a data file's element that an SLC 500's rung shows, see `Spec.members`
    RESETTABLE = auto()  # a TIMER, COUNTER or CONTROL
    PRESET = auto()  # initial value of PRE, ACC, LEN or POS in an exported rung: a number or `?`
    PASSES = auto()  # elements per scan of FAL and FSC: ALL, INC or a number
    SOURCE = auto()  # first element to copy from
    DESTINATION = auto()  # first element to copy to
    TABLE = auto()  # first of the elements of an array to read
    ARRAY = auto()  # first of the elements of an array to read and write
    ITEM = auto()  # reads a number or a structure
    ITEM_TARGET = auto()  # writes a number or a structure
    CONSTANT = auto()  # an integer constant
    MODE = auto()  # byte order of SWPB
    KEYWORD = auto()  # a keyword such as `Units per sec`, or its number
    ANYTHING = auto()  # any number of operands of any kind: tags, numbers, words
    LABEL = auto()
    ROUTINE = auto()
    PARAMETERS = auto()  # any number of additional operands: values into and out of a routine
    INSTANCE = auto()  # a tag of an add-on instruction's type
    ARGUMENT = auto()  # the argument for a parameter of an add-on instruction


WITH_PRESETS = {
    Use.TIMER: ("PRE", "ACC"),
    Use.COUNTER: ("PRE", "ACC"),
    Use.CONTROL: ("LEN", "POS"),
    Use.SLC_TIMER: ("PRE", "ACC"),
    Use.SLC_COUNTER: ("PRE", "ACC"),
    Use.SLC_CONTROL: ("LEN", "POS"),
    Use.ALARM_DIGITAL: ("MinDurationPRE", "MinDurationACC"),
    Use.ALARM_ANALOG: ("HHLimit", "HLimit", "LLimit", "LLLimit"),
}
"""Structures with members that exported rungs show, and the names of these members."""


class InstructionKind(Enum):
    """Rung condition on which an instruction acts."""

    INPUT = auto()  # on a true rung: decides whether the rung stays true
    OUTPUT = auto()  # on a true rung; the rung stays true
    BOTH = auto()  # on a true and a false rung; the rung stays as it is


def _always(*_operands: Any) -> bool:
    return True


def do_nothing(*_parts: Any) -> None:
    """Do nothing: `postscan` of an instruction that keeps its state, or `run` of one without effect."""


@dataclass(frozen=True, repr=False)
class Spec:
    """An instruction.

    A call in Python returns a node of the tree: `TON(fill, 5000)`, `MOV(count.ACC, total)`. Operands are
    tags, numbers, or addresses as text, in the order of the rung text; missing presets become `?`.

    `run` executes the instruction in the interpreter, and `write` writes it as Python. The arguments of both
    are the back end, the rung condition if the table says so, and the resolved operands:

    | kind | called on | condition passed | `run` returns | `write` returns |
    |---|---|---|---|---|
    | INPUT | a true rung | no | whether the rung stays true | the same as Python text |
    | OUTPUT | a true rung | no | nothing | nothing |
    | BOTH | any rung | yes | nothing | nothing |
    | any, `decides` | any rung | yes | the condition after it | the same as Python text |

    Attributes:
        run: executes the instruction; see `interpreter.Interpreter`.
        write: writes it as Python; see `compiler.rungs.RungWriter`. With None, the compiled program calls
            `run`, which is for rare and slow instructions that do not jump, call or leave a routine.
        prove: models `run` for all values at once. Its arguments are the machine, the power before it and the
            operands. It returns the power after it; see `prove.machine`. With None, `run` is executed on
            terms.
        faults: whether it can fault with all subscripts in range; a proof without a model assumes that it
            can.
        partly: whether the compiled program calls `run` in rare cases, by `interpret(site)`.
        fetch: computes, in the interpreter, the value of `fetched(site, ...)` in the compiled program. It is
            called like `run`, with the additional values before the operands.
        prescan: called like `run` without the condition; None if prescan does nothing.
        postscan: called like `prescan` in the last scan of an SFC action with automatic reset. With None, a
            rung runs the instruction with a false condition, and structured text does not run it [1756-PM006,
            automatic reset option].
        check: raises an OperandError for resolved operands that do not match; None without such a rule.
        resolve: resolves all operands; see `lowering.Lowering`. None to resolve each operand by its use.
        inline: whether `write` of these operands returns an expression without writing lines (INPUT).
        optional: number of trailing operands that can be omitted.
        other: its second name, in Studio 5000 revision 36 and later; None if it has none.
        decides: whether it also runs on a false rung, and determines the condition after it.
        alone: whether it can be the only element of a rung although it is an input.
        in_rungs: whether it can be used in rungs, not only in structured text.
        leaves: whether execution can continue elsewhere, so the condition after it does not matter.
        symbol: its contact or coil in a drawing; "" for a box.
        captions: names of the operands in its box, as in Studio 5000.
        instead: its replacement in structured text [1756-RM003N, available languages]; "" if structured text
            has the instruction.
    """

    name: str
    kind: InstructionKind
    operands: tuple[Use, ...] = ()
    run: Callable[..., Any] = field(kw_only=True)
    write: Callable[..., Any] | None = field(default=None, kw_only=True)
    prove: Callable[..., Any] | None = field(default=None, kw_only=True)
    faults: bool = field(default=True, kw_only=True)
    partly: bool = field(default=False, kw_only=True)
    fetch: Callable[..., Any] | None = field(default=None, kw_only=True)
    prescan: Callable[..., None] | None = field(default=None, kw_only=True)
    postscan: Callable[..., None] | None = field(default=None, kw_only=True)
    check: Callable[..., None] | None = field(default=None, kw_only=True)
    resolve: Callable[..., tuple[Any, ...]] | None = field(default=None, kw_only=True)
    inline: Callable[..., bool] = field(default=_always, kw_only=True)
    optional: int = field(default=0, kw_only=True)
    other: str | None = field(default=None, kw_only=True)
    decides: bool = field(default=False, kw_only=True)
    alone: bool = field(default=False, kw_only=True)
    in_rungs: bool = field(default=True, kw_only=True)
    leaves: bool = field(default=False, kw_only=True)
    symbol: str = field(default="", kw_only=True)
    captions: tuple[str, ...] = field(default=(), kw_only=True)
    instead: str = field(default="", kw_only=True)

    @cached_property
    def uses(self) -> tuple[Use, ...]:
        """The use of each operand, without presets."""
        return tuple(use for use in self.operands if use is not Use.PRESET)

    @cached_property
    def members(self) -> dict[int, tuple[int, str]]:
        """For each operand that shows a member of another operand: that operand's index and the member.

        `TON(Fill,5000,0)` shows Fill.PRE and Fill.ACC. On an SLC 500, the time base precedes them.
        """
        members: dict[int, tuple[int, str]] = {}
        structure = 0
        names: Iterator[str] = iter(())
        for index, use in enumerate(self.operands):
            if use in WITH_PRESETS:
                structure, names = index, iter(WITH_PRESETS[use])
            elif use in (Use.PRESET, Use.SHOWN):
                members[index] = structure, next(names)
        return members

    @cached_property
    def variadic(self) -> bool:
        """Whether it accepts any number of additional operands."""
        return Use.PARAMETERS in self.operands or Use.ANYTHING in self.operands

    def use_at(self, index: int) -> Use | None:
        """Return the use of an operand; None if there are no operands. The last use repeats."""
        return self.operands[min(index, len(self.operands) - 1)] if self.operands else None

    def expected_count(self, count: int) -> str:
        """Return the allowed number of operands, such as `2` or `2 to 4`; "" if `count` is allowed."""
        most = len(self.operands)
        least = most - self.optional - self.variadic
        if least <= count and (count <= most or self.variadic):
            return ""
        return str(most) if least == most else f"{least} to {most}"

    def __call__(self, *values: object) -> Instruction:
        """Return the instruction with these operands, or raise a LadderError."""
        operands = [
            Address(str(operand))
            if self._is_name(index) and isinstance(operand, str)
            else operand_of(operand)
            for index, operand in enumerate(values)
        ]
        expected = self.expected_count(len(operands))
        if expected:
            raise LadderError(f"{self.name}: {len(operands)} operands; must be {expected}")
        if Use.PRESET in self.operands:
            operands += [Unknown()] * (len(self.operands) - len(operands))
        return Instruction(self.name, tuple(operands))

    def _is_name(self, index: int) -> bool:
        return index < len(self.operands) and self.operands[index] in (Use.LABEL, Use.MODE, Use.ROUTINE)

    def __repr__(self) -> str:
        return f"<instruction {self.name}({', '.join(use.name for use in self.operands)})>"


def condition(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction that determines whether the rung stays true."""
    if not parts.get("decides"):
        parts.setdefault("instead", "write a condition")
    return _named(name, InstructionKind.INPUT, operands, parts)


def action(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction that acts on a true rung."""
    return _named(name, InstructionKind.OUTPUT, operands, parts)


def always(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction that acts on both true and false rungs."""
    return _named(name, InstructionKind.BOTH, operands, parts)


IN_RUNGS = "write it in a routine of rungs"
"""`Spec.instead` of an instruction that structured text can't replace."""

WITH_CONTROL = (Use.CONTROL, Use.PRESET, Use.PRESET)
"""A CONTROL as exported rungs print it: the tag, LEN and POS. In Python, the numbers can be omitted."""


def on_control(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction as `always` does, with a CONTROL as its last operand."""
    return always(name, *operands, *WITH_CONTROL, optional=2, **parts)


def _named(name: str, kind: InstructionKind, operands: tuple[Use, ...], parts: dict[str, Any]) -> Spec:
    first, _, other = name.partition("/")
    return Spec(first, kind, operands, other=other or None, **parts)


BYTE_ORDERS = ("REVERSE", "WORD", "HIGH/LOW")
"""Modes of SWPB: DCBA, CDAB, BADC [1756-RM003N, SWPB]."""

BYTE_ORDER_OF = {
    **{order: order for order in BYTE_ORDERS},
    **dict(zip("012", BYTE_ORDERS, strict=True)),
    "HIGHLOW": BYTE_ORDERS[2],
}
"""Modes of SWPB by each of their notations, in capitals."""
