"""String instructions and conversions between strings and numbers, computed by `state.characters`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any

from ..compiler.rungs import RungWriter
from ..compiler.string_places import StringPlace
from ..interpreter import Interpreter
from ..model.errors import SHORT_STRING_CODE, STRING_CODE
from ..model.operands import Constant, Group, Place, Resolved, StringConstant, is_integer, width_of
from ..model.spec import Spec, Use, action
from ..model.types import DINT
from ..state.characters import check_length, record_long_string


def _capacity(operand: Group) -> int:
    """Return the size of a string's DATA, in characters."""
    return operand.layout.leaf(f"{operand.path}.DATA").dims[-1]


def _read(machine: Interpreter, operand: Resolved) -> bytes | None:
    """Return the characters of a string; fault and return None if LEN exceeds the size of DATA."""
    if isinstance(operand, Group):
        length, capacity = machine.get(operand.length), _capacity(operand)
        if length > capacity:
            record_long_string(machine.fault_log, machine.site, operand.text, machine.whole(length), capacity)
            return None
    return machine.text(operand)


def _value(machine: Interpreter, operand: Resolved, width: int | None) -> Any:
    """Return the operand's characters or its number; None if a string is too long, which is a fault."""
    if isinstance(operand, (Group, StringConstant)):
        return _read(machine, operand)
    return machine.number(operand, width_of(operand) if width is None else width)


def _row(
    name: str,
    *uses: Use,
    width: int | None = DINT.bits,
    code: int = STRING_CODE,
    store_number: Callable[[Interpreter, Place, Any], None] | None = None,
) -> Spec:
    """Return the row of an instruction that stores a string or a number.

    Args:
        width: width of its number arithmetic; None for each number's own width.
        code: code of the fault if the result is too long.
        store_number: stores the number in the interpreter; None if the result is a string.
    """
    converts = store_number is _put_number  # the function of the instruction converts to the target's type

    def run(machine: Interpreter, *operands: Resolved) -> None:
        """Store the result for the sources in the target; after a fault, the target is unchanged."""
        *sources, target = operands
        values = [_value(machine, source, width) for source in sources]
        if any(value is None for value in values):
            return
        kind = [target.type, target.text] if converts and isinstance(target, Place) else []
        result = machine.characters(name)(machine.fault_log, machine.site, *values, *kind)
        if result is None:
            return
        if isinstance(target, Place):
            assert store_number is not None
            store_number(machine, target, result)
        elif isinstance(target, Group):
            machine.string(target)  # a subscript out of range faults first
            if check_length(machine.fault_log, machine.site, target.text, result, _capacity(target), code):
                machine.set_text(target, result)

    def write(rungs: RungWriter, *operands: Resolved) -> None:
        """Write code that does the same as `run`.

        The code calls `run` if a string is not in bytes, or if a converted number sets status flags.
        """
        if not _are_in_bytes(rungs, operands) or (converts and rungs.writer.flags):
            rungs.interpret()
            return
        *sources, target = operands
        texts = {} if rungs.notes.forced else rungs.writer.texts()
        arguments = [_write_value(rungs, source, width, texts) for source in sources]
        may_be_none = [
            text for text, source in zip(arguments, sources, strict=True) if isinstance(source, Group)
        ]
        typed_target = target if converts else None
        call = _call(name, [str(rungs.values.site), *arguments], typed_target)
        if name in _INLINE and _is_inline(name, sources[0], target):
            call = _INLINE[name].format(*arguments, call=call)
        with _if_all(rungs, may_be_none):
            result = rungs.values.keep(call)
            with _if_all(rungs, [] if name in _NEVER_NONE else [result]):
                stored = _write_result(rungs, target, result, code)
        if may_be_none and stored:
            rungs.writer.line(f"else: {result} = None")
        rungs.writer.keep_texts(_texts_after(rungs, texts, target, stored, result))

    return action(name, *uses, run=run, write=write, faults=False)


def _are_in_bytes(rungs: RungWriter, operands: Iterable[Resolved]) -> bool:
    """Return whether the compiled program keeps all strings among the operands in bytes."""
    layout = rungs.writer.layout
    return all(
        layout.byte_spot(operand.path) is not None for operand in operands if isinstance(operand, Group)
    )


def _call(name: str, arguments: list[str], typed: Resolved | None) -> str:
    """Return code that calls a function of `state.characters` and converts its result for `typed`."""
    if isinstance(typed, Place):
        arguments += [f"types[{typed.type.name!r}]", repr(typed.text)]
    return f"string_{name}(faults, {', '.join(arguments)})"


def _is_inline(name: str, source: Resolved, target: Resolved) -> bool:
    """Return whether the code in `_INLINE` implements the instruction for these operands."""
    if name == "STOD":
        return isinstance(target, Place) and target.type.is_integer and target.type.bits >= DINT.bits
    return name != "DTOS" or is_integer(source)


def _if_all(rungs: RungWriter, texts: list[str]) -> AbstractContextManager[None]:
    """Write the condition that none of these variables is None."""
    values = [f"{text} is not None" for text in texts]
    return rungs.writer.block(f"if {' and '.join(values)}:") if values else nullcontext()


def _texts_after(
    rungs: RungWriter, texts: dict[str, str], target: Resolved, stored: StringPlace | None, result: str
) -> dict[str, str]:
    """Return the variables with strings after an instruction, by place; `texts` are those before it."""
    if stored is not None:
        return {**texts, str(stored): result} if stored.byte.isdigit() else {}
    assert isinstance(target, Place)
    return texts if rungs.writer.layout.spot(target.leaf) is None else {}


def _write_value(rungs: RungWriter, operand: Resolved, width: int | None, texts: Mapping[str, str]) -> str:
    """Return code for an operand's value; for a string in `texts`, it uses that variable."""
    values = rungs.values
    if isinstance(operand, Group):
        place = _place(rungs, operand)
        otherwise = f"read_string(faults, {values.site}, {place}, {operand.text!r})"
        read = place.read(rungs.writer.temporary(), otherwise)
        cached = texts.get(str(place))
        return values.keep(f"{cached} if {cached} is not None else {read}" if cached else read)
    if isinstance(operand, StringConstant):
        return values.characters(operand)
    text = values.term(operand, width_of(operand) if width is None else width).text
    return text if isinstance(operand, Constant) else values.keep(text)


def _place(rungs: RungWriter, operand: Group) -> StringPlace:
    """Return a string's place; a computed position is first kept in a variable."""
    place = rungs.values.string(operand)
    assert place is not None
    return place if place.is_fixed else replace(place, byte=rungs.values.keep(place.byte))


def _write_result(rungs: RungWriter, target: Resolved, result: str, code: int) -> StringPlace | None:
    """Write code that stores the result; return the place of a string target, None for a number.

    The code does not set the target if the result is too long.
    """
    values = rungs.values
    if isinstance(target, Group):
        place = _place(rungs, target)
        stored = f"store_string(faults, {values.site}, {place}, {target.text!r}, {result}, {code})"
        length = rungs.writer.temporary()
        rungs.writer.line(
            f"if ({length} := len({result})) <= {place.capacity}: {place.store(result, length)}"
        )
        rungs.writer.line(f"else: {stored}; {result} = None")
        return place
    assert isinstance(target, Place)
    narrow = target.type.is_integer and target.type.bits < DINT.bits
    values.assign(target, f"wrap({result}, {target.type.wraps})" if narrow else result)
    return None


_PART = "1 <= {2} <= len({0}) and 0 <= {1} <= len({0}) - {2} + 1"

_INLINE = {
    "CONCAT": "{} + {}",
    "DTOS": 'b"%d" % {}',
    "MID": "{0}[{2} - 1:{2} - 1 + {1}] if " + _PART + " else {call}",
    "DELETE": "{0}[:{2} - 1] + {0}[{2} - 1 + {1}:] if " + _PART + " else {call}",
    "INSERT": "{0}[:{2} - 1] + {1} + {0}[{2} - 1:] if 1 <= {2} <= len({0}) + 1 else {call}",
    "FIND": "{0}.find({1}, {2} - 1) + 1 if 1 <= {2} <= len({0}) else {call}",
    "UPPER": "{}.upper()",
    "LOWER": "{}.lower()",
    "STOD": "int({0}) if len({0}) < 10 and {0}.isdigit() else {call}",
}
"""Code for instructions that are a single expression: DTOS for integers, STOD to DINT or a longer type.

`call` records the fault for a position out of range, and reads numbers in other formats.
"""

_NEVER_NONE = {"CONCAT", "DTOS", "RTOS", "UPPER", "LOWER"}
"""Instructions that have a result for all operands."""


def _put_position(machine: Interpreter, target: Place, result: int) -> None:
    machine.put(target, machine.converted(target.type, result))


def _put_number(machine: Interpreter, target: Place, result: int | float) -> None:
    """Store a number of the target's type and set the flags; the carry flag is always set."""
    machine.clear_flags()
    if machine.lowered.flags:
        machine.set_status("S:C", True)
    machine.put(target, result)
    machine.set_flags(result)


# --- the rows

CONCAT = _row("CONCAT", Use.TEXT, Use.TEXT, Use.TEXT_TARGET)
DELETE = _row("DELETE", Use.TEXT, Use.INTEGER, Use.INTEGER, Use.TEXT_TARGET)
FIND = _row("FIND", Use.TEXT, Use.TEXT, Use.INTEGER, Use.INTEGER_TARGET, store_number=_put_position)
INSERT = _row("INSERT", Use.TEXT, Use.TEXT, Use.INTEGER, Use.TEXT_TARGET)
MID = _row("MID", Use.TEXT, Use.INTEGER, Use.INTEGER, Use.TEXT_TARGET)
STOD = _row("STOD", Use.TEXT, Use.TARGET, store_number=_put_number)
STOR = _row("STOR", Use.TEXT, Use.TARGET, store_number=_put_number)
DTOS = _row("DTOS", Use.NUMBER, Use.TEXT_TARGET, width=None, code=SHORT_STRING_CODE)
RTOS = _row("RTOS", Use.NUMBER, Use.TEXT_TARGET, width=0, code=SHORT_STRING_CODE)
UPPER = _row("UPPER", Use.TEXT, Use.TEXT_TARGET)
LOWER = _row("LOWER", Use.TEXT, Use.TEXT_TARGET)
