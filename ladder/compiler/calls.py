"""Calls to add-on instructions in Python: instances and InOuts are lists or bytes with an offset.

    addon_MIXER_LOGIC(now, frame, of_Log, of_Log_at, of_Log_left[, of_Log_bit])
    addon_MIXER_LOGIC_at(now, frame, base, ...)

Most instances are separate tags, which begin at the start of their list and need no offset. The second
function is for instances in arrays, structures and other instances; it is written on demand. `left` is the
number of elements to the end of the array. `bit` is the mask of a bit in an integer, or None for whole
values; only InOuts that receive a bit in some call have it.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..model.operands import Constant, Group, Place, first_leaf
from ..model.stretches import row_strides
from ..model.tags import OWN, Leaf
from ..model.types import Structure, count_of
from ..state.lowered import AddOnCall
from ..state.memory import mask_of
from .files import subscripts_kept
from .value_writer import ValueWriter


def parameters_of(values: ValueWriter, inouts: Sequence[str]) -> list[str]:
    """Return the parameters of an add-on routine's function."""
    return ["now", *(argument for root in (OWN, *inouts) for argument in values.writer.handed(root))]


def write_call(values: ValueWriter, routine: str, call: AddOnCall) -> None:
    """Write the call to an add-on routine."""
    writer = values.writer
    bits = writer.lowered.frames[call.name].bits
    frame, base, _, _ = _argument(values, call.instance)
    based = base != "0"
    arguments = ["now", frame, base] if based else ["now", frame]
    for name, operand in call.handed.items():
        argument = _argument(values, operand)
        arguments += argument if name in bits else argument[:3]
    writer.called.add((routine, based))
    writer.line(f"try: {function_name(routine, based=based)}({', '.join(arguments)})")
    writer.line(f"except LadderFault as fault: fault.called_by(site[{values.site}]); raise")


def function_name(routine: str, *, based: bool) -> str:
    """Return the name of an add-on routine's function; if `based`, of the function with an offset."""
    return f"addon_{routine.replace('.', '_')}{'_at' if based else ''}"


def _argument(values: ValueWriter, operand: Place | Group) -> tuple[str, str, str, str]:
    """Return text for an argument's list, offset, remaining elements and bit mask."""
    leaf = first_leaf(operand)
    texts = subscripts_kept(values, operand)
    if isinstance(operand, Group) and isinstance(operand.type, Structure):
        spot = values.writer.layout.byte_spot(operand.path)
        if spot is not None:
            left = _elements_left(values, leaf, texts, operand)
            return spot.ident, values.placed(spot, leaf, texts), left, "None"
    elif values.is_packed(leaf):
        byte, mask = values.byte_of(leaf, texts)
        return values.writer.name(leaf), values.keep(byte), "1", values.keep(mask)
    offset, left = values.offset(leaf, texts), _elements_left(values, leaf, texts, operand)
    return values.writer.name(leaf), offset, left, _mask(values, leaf, operand)


def _elements_left(values: ValueWriter, leaf: Leaf, texts: Sequence[str], operand: Place | Group) -> str:
    """Return text for the number of elements from an operand to the end of its array."""
    if leaf.root not in ("", OWN) and operand.path.upper() == leaf.root:
        length = values.writer.handed(leaf.root)[2]
        return f"{length} - {texts[0]}" if len(texts) == 1 else length
    if operand.dims:
        return str(count_of(operand.dims))
    dims = operand.array
    strides = row_strides(dims, 1)
    last = texts[len(texts) - len(dims) :]
    left, computed = count_of(dims), ""
    for text, stride in zip(last, strides, strict=True):
        if text.isdigit():
            left -= int(text) * stride
        else:
            computed += f" - {text} * {stride}"
    return f"{left}{computed}"


def _mask(values: ValueWriter, leaf: Leaf, operand: Place | Group) -> str:
    """Return text for the mask of a bit, or of an InOut that may be a bit; "None" for a whole value."""
    if isinstance(operand, Place) and operand.bit is not None:
        if isinstance(operand.bit, Constant):
            return str(mask_of(leaf.type, int(operand.bit.value)))
        bit = values.index(operand.bit, leaf.type.bits, operand.text)
        return values.keep(f"mask({bit}, {leaf.type.bits}, {leaf.type.is_signed})")
    return values.writer.mask(leaf) or "None"
