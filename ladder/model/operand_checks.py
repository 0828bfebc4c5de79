"""Check operands by use; each check has a message and a remedy."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from functools import partial

from scanrack.io_images.dataclass import dataclass

from .operands import (
    Calculation,
    Constant,
    Group,
    Place,
    Resolved,
    StringConstant,
    constant,
    is_integer,
    is_number,
    is_truth,
)
from .operators import BITWISE, RELATIONS
from .predefined.block_types import BLOCK_TYPES
from .predefined.motion_types import COORDINATE_SYSTEM, MOTION_GROUP, MOTION_INSTRUCTION, is_axis
from .predefined.safety_types import SAFETY
from .predefined.slc_types import SLC_CONTROL, SLC_COUNTER, SLC_TIMER, SLC_TYPES
from .predefined.structures import HMIBC, SERIAL_PORT_CONTROL
from .spec import Use
from .types import (
    ALARM_ANALOG,
    ALARM_DIGITAL,
    CONTROL,
    COUNTER,
    FBD_COUNTER,
    FBD_ONESHOT,
    FBD_TIMER,
    MESSAGE,
    PID,
    TIMER,
    DataType,
    Elementary,
    Structure,
)

_BLOCKS = (FBD_TIMER, FBD_COUNTER, FBD_ONESHOT, *BLOCK_TYPES.values(), *SAFETY.values())


class OperandError(ValueError):
    """An operand that an instruction does not accept."""

    def __init__(self, text: str, remedy: str) -> None:
        self.remedy = remedy
        super().__init__(text)


def mismatch(operand: object, resolved: Resolved, required: str, remedy: str) -> OperandError:
    """Return the error for an operand that does not match `required`, such as `a tag`."""
    return OperandError(f"{operand} is {described(resolved)}, {required} is needed", remedy)


def described(resolved: Resolved) -> str:
    """Describe an operand, with an article."""
    if isinstance(resolved, Constant):
        return f"the number {resolved.value}"
    if isinstance(resolved, Place):
        return f"{'an' if resolved.type.name in ('INT', 'LREAL') else 'a'} {resolved.type.name}"
    if isinstance(resolved, Group):
        return f"an array of {resolved.type.name}" if resolved.dims else f"a {resolved.type.name}"
    return "a string" if isinstance(resolved, StringConstant) else "an expression"


def require_type(block: Group, kind: Structure) -> None:
    """Raise an OperandError unless a structure is of type `kind`."""
    if block.type != kind:
        raise mismatch(block.text, block, f"a {kind.name}", f"declare it as {kind.name}")


@dataclass(frozen=True, slots=True)
class OperandCheck:
    """The requirement of a use, with its predicate and a remedy."""

    accepts: Callable[[Resolved], bool]
    text: str  # the requirement in words, such as `a number`
    remedy: str


def _is_bit(resolved: Resolved) -> bool:
    return isinstance(resolved, Place) and resolved.type.is_bool


def _is_plain_number(resolved: Resolved) -> bool:
    return isinstance(resolved, (Place, Constant)) and is_number(resolved)


def _is_plain_integer(resolved: Resolved) -> bool:
    return isinstance(resolved, (Place, Constant)) and resolved.type.is_integer


def _is_numeric_tag(resolved: Resolved) -> bool:
    return isinstance(resolved, Place) and is_number(resolved)


def is_string(resolved: Resolved) -> bool:
    """Return whether an operand is a STRING or a string constant."""
    if not isinstance(resolved, Group):
        return isinstance(resolved, StringConstant)
    return not resolved.dims and not isinstance(resolved.type, Elementary) and resolved.type.is_string


def _is_string_tag(resolved: Resolved) -> bool:
    return isinstance(resolved, Group) and is_string(resolved)


def _is_structure(types: Container[DataType], resolved: Resolved) -> bool:
    return isinstance(resolved, Group) and not resolved.dims and resolved.type in types


def _is_axis(resolved: Resolved) -> bool:
    return isinstance(resolved, Group) and not resolved.dims and is_axis(resolved.type)


def is_arithmetic(resolved: Resolved) -> bool:
    """Return whether an operand is an arithmetic expression."""
    if not isinstance(resolved, Calculation):
        return is_number(resolved)
    if is_truth(resolved):  # 1 or 0
        return _is_condition(resolved)
    if resolved.name in BITWISE:
        return all(is_integer(operand) and is_arithmetic(operand) for operand in resolved.operands)
    return all(map(is_arithmetic, resolved.operands))


def is_logical(resolved: Resolved) -> bool:
    """Return whether an operand is a structured text condition of bits, comparisons, 0, 1 and operators."""
    if isinstance(resolved, Constant):
        return resolved.type.is_integer and resolved.value in (0, 1)
    if not isinstance(resolved, Calculation):
        return is_truth(resolved)
    if resolved.name not in RELATIONS:
        return resolved.name in BITWISE and all(map(is_logical, resolved.operands))
    if any(map(is_truth, resolved.operands)):
        return all(map(is_logical, resolved.operands))
    return all(map(is_arithmetic, resolved.operands)) or all(map(is_string, resolved.operands))


def _is_condition(resolved: Resolved) -> bool:
    """Return whether an operand is a comparison of numbers or strings, or a combination of comparisons."""
    if not isinstance(resolved, Calculation):
        return False
    if resolved.name in RELATIONS:
        return all(map(is_arithmetic, resolved.operands)) or all(map(is_string, resolved.operands))
    return resolved.name in BITWISE and all(map(_is_condition, resolved.operands))


def _is_test(resolved: Resolved) -> bool:
    """Return whether an operand is a condition or a number; exports use 0 for never and 1 for always."""
    return isinstance(resolved, Constant) or _is_condition(resolved)


def _is_region(resolved: Resolved) -> bool:
    """Return whether an operand has bytes in memory, unlike a BOOL, a bit or an array of BOOL."""
    if isinstance(resolved, Place):
        return not resolved.type.is_bool
    return isinstance(resolved, Group) and not (
        isinstance(resolved.type, Elementary) and resolved.type.is_bool
    )


def _is_item(resolved: Resolved) -> bool:
    return _is_plain_number(resolved) or (_is_region(resolved) and not _has_dims(resolved))


def _is_array(resolved: Resolved) -> bool:
    return _is_region(resolved) and (_has_dims(resolved) or bool(array_of(resolved)))


def _has_dims(resolved: Resolved) -> bool:
    return isinstance(resolved, Group) and bool(resolved.dims)


def array_of(resolved: Resolved) -> tuple[int, ...]:
    """Return the dimensions of an array, or of the array around an element; () for any other operand."""
    if isinstance(resolved, Group) and resolved.dims:
        return resolved.dims
    return resolved.array if isinstance(resolved, (Place, Group)) else ()


def _is_switch(resolved: Resolved) -> bool:
    return _is_bit(resolved) or resolved in (constant(0), constant(1))


WRITTEN = frozenset(
    {
        Use.COIL,
        Use.LATCH,
        Use.STORAGE,
        Use.TARGET,
        Use.INTEGER_TARGET,
        Use.DESTINATION,
        Use.TEXT_TARGET,
        Use.TEXT_OR_NUMBER_TARGET,
        Use.ITEM_TARGET,
        Use.ARRAY,
        Use.OPTIONAL_TARGET,
    }
)
"""Uses in which an instruction writes its operand."""

_A_BIT = OperandCheck(_is_bit, "a bit", "use a BOOL or a bit of an integer (tag.3), or compare the number")
_A_NUMBER = OperandCheck(_is_plain_number, "a number", "use a numeric tag; CPT takes expressions")
_AN_INTEGER = OperandCheck(_is_plain_integer, "an integer", "use a SINT, INT, DINT or LINT")

_AN_ARRAY = OperandCheck(_is_array, "an array", "name an array or one of its elements")

OPERAND_CHECKS: Mapping[Use, OperandCheck] = {
    Use.BIT: _A_BIT,
    Use.COIL: _A_BIT,
    Use.LATCH: _A_BIT,
    Use.STORAGE: _A_BIT,
    Use.NUMBER: _A_NUMBER,
    Use.TEXT_OR_NUMBER: OperandCheck(
        lambda operand: _is_plain_number(operand) or is_string(operand),
        "a number or a STRING",
        "use a numeric tag or a STRING; XIC reads bits",
    ),
    Use.TEXT: OperandCheck(is_string, "a STRING", "convert numbers with DTOS or RTOS"),
    Use.TEXT_TARGET: OperandCheck(_is_string_tag, "a STRING to write", "declare it as STRING"),
    Use.INTEGER: _AN_INTEGER,
    Use.TARGET: OperandCheck(
        _is_numeric_tag, "a numeric tag to write", "use a numeric tag; write bits with OTE, OTL or OTU"
    ),
    Use.TEXT_OR_NUMBER_TARGET: OperandCheck(
        lambda operand: _is_numeric_tag(operand) or _is_string_tag(operand),
        "a numeric tag or a STRING to write",
        "use a numeric tag; write bits with OTE, OTL or OTU",
    ),
    Use.INTEGER_TARGET: OperandCheck(
        lambda operand: isinstance(operand, Place) and operand.type.is_integer,
        "an integer tag to write",
        "use a SINT, INT, DINT or LINT",
    ),
    Use.EXPRESSION: OperandCheck(
        is_arithmetic, "an arithmetic expression", "compare with CMP; use AND, OR, XOR, NOT with integers"
    ),
    Use.CONDITION: OperandCheck(_is_test, "a comparison", "write a relation such as a>b, or a>b AND c<=d"),
    Use.TRUTH: OperandCheck(is_logical, "a bit or a condition", "compare it, as in count <> 0"),
    Use.BLOCK: OperandCheck(
        partial(_is_structure, _BLOCKS),
        "a structure of its parameters",
        "declare the tag as FBD_TIMER, FBD_COUNTER, FBD_ONESHOT or the type of its block",
    ),
    **{
        use: OperandCheck(
            partial(_is_structure, (kind,)), f"a {kind.name}", f"declare the tag as {kind.name}"
        )
        for use, kind in (
            (Use.TIMER, TIMER),
            (Use.COUNTER, COUNTER),
            (Use.CONTROL, CONTROL),
            (Use.MESSAGE, MESSAGE),
            (Use.PID, PID),
            (Use.SLC_TIMER, SLC_TIMER),
            (Use.SLC_COUNTER, SLC_COUNTER),
            (Use.SLC_CONTROL, SLC_CONTROL),
            (Use.SERIAL, SERIAL_PORT_CONTROL),
            (Use.HMI_BUTTON, HMIBC),
            (Use.MOTION, MOTION_INSTRUCTION),
            (Use.MOTION_GROUP, MOTION_GROUP),
            (Use.COORDINATE_SYSTEM, COORDINATE_SYSTEM),
            (Use.ALARM_DIGITAL, ALARM_DIGITAL),
            (Use.ALARM_ANALOG, ALARM_ANALOG),
        )
    },
    Use.SLC_RESETTABLE: OperandCheck(
        partial(_is_structure, SLC_TYPES.values()),
        "an element of a file T, C or R",
        "clear other tags with CLR or OTU",
    ),
    Use.AXIS: OperandCheck(_is_axis, "an axis", "declare the tag as AXIS_CIP_DRIVE"),
    Use.KEYWORD: OperandCheck(_is_plain_number, "a number or a word", "write a word of its list"),
    Use.SWITCH: OperandCheck(_is_switch, "a bit, 0 or 1", "use a BOOL"),
    Use.OPTIONAL_TARGET: OperandCheck(
        lambda operand: operand == constant(0) or (isinstance(operand, Place) and not operand.type.is_bool),
        "a numeric tag to write, or 0",
        "use a numeric tag",
    ),
    **dict.fromkeys((Use.IGNORED, Use.SHOWN), OperandCheck(lambda _each: True, "an operand", "write 0")),
    Use.RESETTABLE: OperandCheck(
        partial(_is_structure, (TIMER, COUNTER, CONTROL)),
        "a TIMER, COUNTER or CONTROL",
        "clear other tags with CLR or OTU",
    ),
    Use.SOURCE: OperandCheck(_is_region, "a tag with bytes", "copy numbers, structures or arrays of them"),
    Use.DESTINATION: OperandCheck(
        _is_region, "a tag with bytes", "copy to numbers, structures or arrays of them"
    ),
    Use.TABLE: _AN_ARRAY,
    Use.ARRAY: _AN_ARRAY,
    Use.ITEM: OperandCheck(_is_item, "a number or a structure", "name a single tag"),
    Use.ITEM_TARGET: OperandCheck(
        lambda operand: _is_item(operand) and not isinstance(operand, Constant),
        "a tag to write",
        "name a single number or structure",
    ),
    Use.CONSTANT: OperandCheck(
        lambda operand: isinstance(operand, Constant) and operand.type.is_integer,
        "a constant",
        "write a whole number",
    ),
}
