"""One instruction: its name, its operands, and the functions that check, execute and compile it.

A family file in `instructions` holds one `Spec` per instruction. The parser, the Python front end,
the checks, both back ends, the debugger and the drawing read what they need from it, so that an
instruction has one place.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from .errors import LadderError
from .tagref import operand_of
from .tree import Address, Instruction, Unknown


class Use(Enum):
    """How an instruction uses an operand. `operand_checks` says what each use accepts."""

    BIT = auto()
    """Reads a bit."""
    COIL = auto()
    """Writes a bit on a true and a false rung: one rung per bit may."""
    LATCH = auto()
    """Writes a bit when true."""
    STORAGE = auto()
    """Remembers the rung's state of the last scan in a bit of its own."""
    NUMBER = auto()
    """Reads a number."""
    TEXT_OR_NUMBER = auto()
    """Reads a number or a STRING."""
    INTEGER = auto()
    """Reads an integer."""
    TEXT = auto()
    """Reads a string."""
    TEXT_TARGET = auto()
    """Writes a string."""
    TARGET = auto()
    """Writes a number."""
    TEXT_OR_NUMBER_TARGET = auto()
    """Writes a number or a STRING."""
    INTEGER_TARGET = auto()
    """Writes an integer."""
    EXPRESSION = auto()
    """Reads an expression."""
    CONDITION = auto()
    """Reads an expression that is true or false."""
    TRUTH = auto()
    """Reads a bit, or an expression of bits and comparisons."""
    TIMER = auto()
    COUNTER = auto()
    BLOCK = auto()
    """Reads and writes the structure with the parameters of an instruction."""
    CONTROL = auto()
    MESSAGE = auto()
    PID = auto()
    SLC_TIMER = auto()
    SLC_COUNTER = auto()
    SLC_CONTROL = auto()
    SLC_RESETTABLE = auto()
    """A timer, counter or control of an SLC 500."""
    SERIAL = auto()
    """A SERIAL_PORT_CONTROL."""
    HMI_BUTTON = auto()
    """An HMIBC."""
    AXIS = auto()
    MOTION = auto()
    """A MOTION_INSTRUCTION."""
    MOTION_GROUP = auto()
    COORDINATE_SYSTEM = auto()
    ALARM_DIGITAL = auto()
    ALARM_ANALOG = auto()
    SWITCH = auto()
    """Reads a bit, or is 0 or 1."""
    OPTIONAL_TARGET = auto()
    """Writes a number; 0 for none."""
    IGNORED = auto()
    """Is not used here."""
    RESETTABLE = auto()
    """A TIMER, COUNTER or CONTROL."""
    PRESET = auto()
    """Number or `?` in an exported rung: initial value of PRE or ACC, or of LEN or POS of a CONTROL."""
    PASSES = auto()
    """How many elements FAL and FSC operate on in a scan: ALL, INC or a number."""
    SOURCE = auto()
    """First element to copy from."""
    DESTINATION = auto()
    """First element to copy to."""
    TABLE = auto()
    """First of the elements of an array to read."""
    ARRAY = auto()
    """First of the elements of an array to read and write."""
    ITEM = auto()
    """Reads a number or a structure."""
    ITEM_TARGET = auto()
    """Writes a number or a structure."""
    CONSTANT = auto()
    """An integer constant."""
    MODE = auto()
    """Byte order of SWPB."""
    KEYWORD = auto()
    """A word of a list, such as `Units per sec`, or its number."""
    ANYTHING = auto()
    """Any number of operands of any kind: tags, numbers, words."""
    LABEL = auto()
    ROUTINE = auto()
    PARAMETERS = auto()
    """Any number of further operands: values into and out of a routine."""
    INSTANCE = auto()
    """A tag of an add-on instruction's type."""
    ARGUMENT = auto()
    """The argument for a parameter of an add-on instruction."""


WITH_PRESETS = {
    Use.TIMER: ("PRE", "ACC"),
    Use.COUNTER: ("PRE", "ACC"),
    Use.CONTROL: ("LEN", "POS"),
    Use.ALARM_DIGITAL: ("MinDurationPRE", "MinDurationACC"),
    Use.ALARM_ANALOG: ("HHLimit", "HLimit", "LLimit", "LLLimit"),
}
"""Uses of structures whose members exported rungs show, and which members."""


class Kind(Enum):
    """When an instruction acts."""

    INPUT = auto()
    """On a true rung: decides whether the rung stays true."""
    OUTPUT = auto()
    """On a true rung; the rung stays true."""
    BOTH = auto()
    """On a true and a false rung; the rung stays as it is."""


def _always(*_operands: Any) -> bool:
    return True


@dataclass(frozen=True, slots=True, repr=False)
class Spec:
    """An instruction.

    Called in Python it returns a node of the tree: `TON(fill, 5000)`, `MOV(count.ACC, total)`. Operands are
    tags, numbers, or addresses as text, in the order of the rung text; missing presets become `?`.

    `run` executes the instruction in the interpreter, `write` writes it as Python. Both get the back end
    first, then the rung's power where the table says so, then the resolved operands:

    | kind | called on | power passed | `run` returns | `write` returns |
    |---|---|---|---|---|
    | INPUT | a true rung | no | whether the rung stays true | the same as Python text |
    | OUTPUT | a true rung | no | nothing | nothing |
    | BOTH | any rung | yes | nothing | nothing |
    | any, `decides` | any rung | yes | whether the rung is true after it | the same as Python text |

    Attributes:
        name: the name it prints under.
        kind: when it acts.
        operands: the use of each operand.
        run: executes it, see `interpreter.Interpreter`.
        write: writes it as Python, see `compiler.rungs.RungWriter`; None for an instruction that the compiled
            program leaves to `run`: right for rare and slow ones that do not jump, call or leave a routine.
        prescan: what prescan does, called like `run` without power; None if it does nothing.
        check: raises OperandError for resolved operands that do not go together; None if all do.
        resolve: resolves the operands itself, see `lowering.Lowering`; None to resolve each by its use.
        inline: whether `write` of these operands returns an expression without writing lines (INPUT).
        optional: how many of the last operands may be missing.
        other: its second name, the one that Studio 5000 prints from revision 36 on; None if it has none.
        decides: whether it also runs on a false rung, and decides the power after it.
        alone: whether a rung may consist of it alone although it is an input.
        in_rungs: whether rungs have it, not only structured text.
        leaves: whether the program may continue elsewhere, so that the power after it does not count.
    """

    name: str
    kind: Kind
    operands: tuple[Use, ...] = ()
    run: Callable[..., Any] = field(kw_only=True)
    write: Callable[..., Any] | None = field(default=None, kw_only=True)
    prescan: Callable[..., None] | None = field(default=None, kw_only=True)
    check: Callable[..., None] | None = field(default=None, kw_only=True)
    resolve: Callable[..., tuple[Any, ...]] | None = field(default=None, kw_only=True)
    inline: Callable[..., bool] = field(default=_always, kw_only=True)
    optional: int = field(default=0, kw_only=True)
    other: str | None = field(default=None, kw_only=True)
    decides: bool = field(default=False, kw_only=True)
    alone: bool = field(default=False, kw_only=True)
    in_rungs: bool = field(default=True, kw_only=True)
    leaves: bool = field(default=False, kw_only=True)

    @property
    def variadic(self) -> bool:
        """Takes any number of further operands."""
        return Use.PARAMETERS in self.operands or Use.ANYTHING in self.operands

    def __call__(self, *given: object) -> Instruction:
        """Return the instruction with these operands.

        Raises:
            LadderError: it takes another number of operands, or one of them is not an operand.
        """
        operands = [
            Address(str(each)) if self._is_name(place) and isinstance(each, str) else operand_of(each)
            for place, each in enumerate(given)
        ]
        most = len(self.operands)
        least = most - self.optional - self.variadic
        if len(operands) < least or (len(operands) > most and not self.variadic):
            raise LadderError(f"{self.name} takes {most} operands, {len(operands)} are given")
        if Use.PRESET in self.operands:
            operands += [Unknown()] * (most - len(operands))
        return Instruction(self.name, tuple(operands))

    def _is_name(self, place: int) -> bool:
        return place < len(self.operands) and self.operands[place] in (Use.LABEL, Use.MODE, Use.ROUTINE)

    def __repr__(self) -> str:
        return f"<instruction {self.name}({', '.join(use.name for use in self.operands)})>"


def condition(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction that decides whether the rung stays true."""
    return _named(name, Kind.INPUT, operands, parts)


def action(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction that acts on a true rung."""
    return _named(name, Kind.OUTPUT, operands, parts)


def always(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction that acts on a true and a false rung."""
    return _named(name, Kind.BOTH, operands, parts)


WITH_CONTROL = (Use.CONTROL, Use.PRESET, Use.PRESET)
"""A CONTROL as an exported rung writes it: the tag, LEN and POS. Rungs in Python may omit the numbers."""


def on_control(name: str, *operands: Use, **parts: Any) -> Spec:
    """Return an instruction like `always` whose last operand is a CONTROL."""
    return always(name, *operands, *WITH_CONTROL, optional=2, **parts)


def _named(name: str, kind: Kind, operands: tuple[Use, ...], parts: dict[str, Any]) -> Spec:
    first, _, other = name.partition("/")
    return Spec(first, kind, operands, other=other or None, **parts)


BYTE_ORDERS = ("REVERSE", "WORD", "HIGH/LOW")
"""Modes of SWPB: DCBA, CDAB, BADC [1756-RM003N, SWPB]; also written 0, 1, 2 and HIGHLOW."""
